"""Whole games of a player who asks and orders at random: nothing breaks, and what was told is what happened."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from typing import Any

import pytest

from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.errors import HexWarError
from hexwar_sb3.server import messages
from hexwar_sb3.server.delta import changed
from hexwar_sb3.server.messages import Hint, Look, PlanFor, Question, Run, StepTo, Undo
from hexwar_sb3.server.session import Session, resumed_session
from hexwar_sb3.viewer import stories

Json = dict[str, Any]


TIMES: list[Question] = [Run(64), StepTo("decision"), StepTo("event"), StepTo("tick")]


class Fidgety:
    """Looks at a piece, then orders something that it can do, or something that it perhaps cannot."""

    def __init__(self, session: Session, seed: int) -> None:
        self.session, self.rng = session, random.Random(seed)
        self.names = [piece.name for piece in session.game.view(session.camp).own]
        self.n_cells = session.game.world.cells.size
        self.refused = 0

    def act(self) -> None:
        """Give some orders."""
        for _ in range(3):
            self._try(
                PlanFor(piece := self.rng.choice(self.names), self._steps(piece), self.rng.random() < 0.3)
            )
        if self.rng.random() < 0.1:
            self._try(Undo())
        if self.rng.random() < 0.05:
            self._try(Hint(self.rng.choice(self.names)))

    def _steps(self, piece: str) -> tuple[str, ...]:
        told = self._try(Look(piece, self._cell())) or {}
        now = self._try(Look(piece, None)) or {}
        orders = [
            *now.get("orders", ()),
            *(shot["order"] for one in (told, now) for shot in one.get("shots", ())),
        ]
        orders += [order for order, _ in now.get("impossible", ())][:2]
        cells = [cell for group in now.get("mortar", ()) for cell in group["cells"]]
        orders += [f"{piece} indirect-shoot {self._name(self.rng.choice(cells))}"] if cells else []
        goal = self.rng.randrange(self.n_cells)
        way = self._try(messages.Path(piece, goal, None))
        orders += [f"{piece} go {self._name(goal)}"] * 3 if way else []
        return tuple(self.rng.choices(orders or ["x"], k=self.rng.randint(1, 3)))

    def _cell(self) -> int | None:
        return self.rng.randrange(self.n_cells) if self.rng.random() < 0.3 else None

    def _name(self, cell: int) -> str:
        return self.session.game.roster.cell_name(cell)

    def _try(self, question: Any) -> Json | None:
        before = self.session.state()
        try:
            told, _ = self.session.answer(question)
        except HexWarError:
            assert self.session.state() == before
            self.refused += 1
            return None
        json.dumps(told)
        return told


def play(session: Session, seed: int, story: Json, until: int) -> Json:
    """Play to a tick; the story as a page has it."""
    player = Fidgety(session, seed)
    while session.game.tick < until and not session.game.over:
        player.act()
        session.answer(player.rng.choice(TIMES))
        while session.clock.running:
            now = json.loads(json.dumps(session.advance()))
            story = changed(story, now["story"])
    assert player.refused
    return story


def check_whole_game(begin: Callable[..., Session], seed: int, break_at: int = 700, **given: Any) -> Json:
    """Play a game in two parts; the story at its end."""
    session = begin(seed=seed, **given)
    story = play(session, seed, session.hello()["story"], break_at)
    told = state_hash(session.game.state, 0)
    session.close()
    again = resumed_session(session.setup.folder / "game.partial.hwr")
    assert state_hash(again.game.state, 0) == told
    assert again.hello()["story"] == story

    story = play(again, seed + 1, story, 10**6)

    assert again.replay is not None
    again.replay.verify()
    assert story == json.loads(json.dumps(stories(again.replay, (again.camp,))[again.camp]))
    return story


def test_a_fight_at_random_is_told_kept_and_replayed(begin: Callable[..., Session]) -> None:
    scenario = parse_board("""
        map   plain-40x9
        point ford 1204 40
        red   tank 0204
        red   chariot 0206
        red   soldier aboard chariot0
        blue  tank 1804
        blue  chariot 2006
        blue  soldier aboard chariot0
        ticks 400
    """).scenario
    story = check_whole_game(begin, 2, 100, opponent="MA1", scenario=scenario)

    assert {"shot", "loss"} <= {event["kind"] for event in story["events"]}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize("opponent", ["MA1", "HRL0"])
@pytest.mark.parametrize(("side", "scenario"), [("blue", "plain"), ("red", "hills")])
def test_many_games_at_random(
    begin: Callable[..., Session], seed: int, opponent: str, side: str, scenario: str
) -> None:
    check_whole_game(begin, seed, opponent=opponent, side=side, scenario=scenario, hints="HRL0")
