"""Before a page opens, what its questions need is compiled or read."""

from __future__ import annotations

import subprocess
import sys

import pytest

ASK = """
import sys
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.kernels import counts
from hexwar_sb3.server import messages
from hexwar_sb3.server.session import Session, Setup
from hexwar_sb3.server.warm import warm_up

def ask_all(session):
    cell = session.game.roster.cell
    for own in session.game.view("red").own:
        session.answer(messages.Look(own.name, None))
        session.answer(messages.Look(own.name, cell("2030")))
        if own.aboard is None:
            session.answer(messages.Path(own.name, cell("2030"), None))
            session.answer(messages.Path(own.name, cell("2030"), cell("2131")))
            session.answer(messages.PlanFor(own.name, (f"{own.name} go 2030", f"{own.name} hide"), False))
        if session.adviser is not None:
            session.answer(messages.Hint(own.name))
    session.answer(messages.StepTo("decision"))
    while session.clock.running:
        session.advance()

BOARD = "map plain-40x40\\npoint ford 1212 40\\nred tank 1010\\nred chariot 1011\\nred soldier 1110\\nblue tank 1414\\nblue soldier 1312\\nticks 300"
games = Setup(hints="HRL0"), Setup(scenario=parse_board(BOARD).scenario, opponent="MA1")
sessions = [Session(setup) for setup in games]
if sys.argv[1] == "warm":
    warm_up(games[0])
before = counts.total()
for session in sessions:
    ask_all(session)
print(counts.total() - before)
"""


@pytest.mark.parametrize("first", ["cold", "warm"])
def test_no_question_waits_for_a_kernel_once_it_was_asked(first: str) -> None:
    """Neither compiled nor read from the cache: here on "plain", and where enemies are in sight."""
    found = subprocess.run([sys.executable, "-c", ASK, first], capture_output=True, text=True, check=True)

    assert (int(found.stdout) == 0) == (first == "warm"), found.stdout
