"""What nobody is to wait for in a game: each kind of question is asked once before it, and its kernels are compiled or read then."""

from __future__ import annotations

from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.server.messages import Finish, Hint, Look, Path, PlanFor
from hexwar_sb3.server.session import Session, Setup

BOARD = """
    map   plain-20x9
    point ford 0604 40
    red   tank 0204
    red   chariot 0206
    red   soldier 0207
    red   aerocraft 0205
    blue  tank 0804
    blue  chariot 0806
    ticks 80
"""  # they see each other, so that there are shots


def warm_up(setup: Setup) -> None:
    """Ask each kind of question once, in games beside the one of the setup; they are written nowhere.

    Raises:
        HexWarError: the setup is of no game.
    """
    beside = Session(Setup(scenario=parse_board(BOARD).scenario))
    for own in beside.game.view(beside.camp).own:
        beside.answer(Look(own.name, None))
        beside.answer(Look(own.name, beside.game.roster.cell("0304")))
        beside.answer(Path(own.name, beside.game.roster.cell("0505"), None))
        beside.answer(PlanFor(own.name, (f"{own.name} go 0505", f"{own.name} hide"), False))
    beside.answer(Finish())
    while beside.clock.running:
        beside.advance()
    if setup.hints is not None:
        policy = Session(setup)
        policy.answer(Hint(policy.game.view(policy.camp).own[0].name))
