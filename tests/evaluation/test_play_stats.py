"""Statistics of play: counts of games that can be followed by hand."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.errors import ReplayFileError
from hexwar_sb3.evaluation.play_stats import GRID, PIECE, PlayStats, group_of
from hexwar_sb3.play.recording import record_game

BOARD = """
map   plain-20x7
point main 0504 80
red   tank 0304
red   chariot 0102
blue  tank 0704 blood 2
blue  chariot 0804
ticks 400
seed  3
"""


def decision(tick: int, **tasks: str) -> dict[str, Any]:
    choices = [[piece, 0, [task], [], ""] for piece, task in tasks.items()]
    reward = {"points": 0, "own": 0, "enemy": 0}
    return {"type": "decision", "tick": tick, "camp": "red", "reward": reward, "choices": choices}


@pytest.fixture(scope="module")
def replay() -> Replay:
    """Red sees both enemies at once, goes back and on, takes the point and fires at the tank of less blood."""
    game = Game.from_text(BOARD)
    game.recorder.note_line(game.state, 0, decision(0, tank0="hold 0504", chariot0="stop"))
    game.submit("red", "tank0 move W")
    game.advance(20)
    game.submit("red", "tank0 move E")
    game.advance(40)
    game.submit("red", "tank0 move E")
    game.advance(40)
    game.submit("red", "tank0 move 0504")
    game.advance(60)
    game.submit("red", "tank0 occupy")
    game.advance(1)
    game.recorder.note_line(game.state, 0, decision(161, tank0="attack blue:tank0"))
    game.submit("red", "tank0 shoot blue:tank0 GUN")
    game.advance(150)
    return Replay.of(game, PlayerName(name="Ann"), PlayerName(name="Ben"))


def test_tasks_are_counted_by_phase_and_piece(replay: Replay) -> None:
    stats = PlayStats()
    stats.add(replay, "red")

    assert stats.tasks == Counter(
        {
            ("preemption", "tank", "hold"): 1,
            ("preemption", "chariot", "stop"): 1,
            ("endgame", "tank", "attack"): 1,
        }
    )
    assert stats.decisions("preemption") == Counter({GRID: 1, "stop": 1})
    assert stats.decisions("endgame", "tank") == Counter({PIECE: 1})


def test_a_shot_stands_beside_all_that_could_have_been(replay: Replay) -> None:
    """Blood 2 of 2 and 3, a tank's value 10 beside 10 and 7."""
    stats = PlayStats()
    stats.add(replay, "red")

    assert stats.targets == Counter({("tank", "tank"): 1})
    assert stats.available == {("tank", "tank"): 0.5, ("tank", "chariot"): 0.5}
    assert (stats.blood, stats.value) == ([-0.5], [1.5])


def test_hops_are_compared_with_the_heuristics(replay: Replay) -> None:
    stats = PlayStats()
    stats.add(replay, "red")

    assert (stats.moves, stats.agreeing) == (Counter({"tank": 4}), Counter({"tank": 3}))
    assert stats.visits == Counter({"0204": 1, "0304": 1, "0404": 1, "0504": 1})


def test_parts_that_were_counted_apart_are_the_whole() -> None:
    games = [record_game("HRL0", "MA2", seed=5, episode=k) for k in range(2)]
    whole, merged = PlayStats(), PlayStats()
    for game in games:
        whole.add(game, "red")
        part = PlayStats()
        part.add(game, "red")
        merged.merge(part)

    assert str(merged.as_dict()) == str(whole.as_dict())
    assert whole.games == 2
    assert whole.agreeing.total() > 0.9 * whole.moves.total()  # what leads HRL0 is nearly the heuristic
    assert sum(whole.targets.values()) == pytest.approx(sum(whole.available.values()))


def test_a_replay_without_decisions_is_refused() -> None:
    old = Path(__file__).parent.parent / "engine" / "replays_of_version_1" / "plain.hwr"

    with pytest.raises(ReplayFileError, match="no decisions of red; expected a replay of version 2"):
        PlayStats().add(Replay.load(old), "red")


def test_kinds_of_tasks_are_of_cells_or_of_pieces() -> None:
    kinds = (
        "hold 0101",
        "hide 0101",
        "drop 0101",
        "attack blue:tank0",
        "board red:chariot0",
        "recover",
        "stop",
    )

    assert [group_of(kind) for kind in kinds] == [GRID] * 3 + [PIECE] * 3 + ["stop"]


def test_a_claim_is_judged_over_games_and_only_by_enough_of_them(replay: Replay) -> None:
    few, many = PlayStats(), PlayStats()
    for k in range(20):
        many.add(replay, "red")
        if k < 19:
            few.add(replay, "red")

    words = "blood of targets, less the mean of the available ones"
    told = {name: (found.value, holds) for name, found, holds in many.claims()}
    assert told[words] == (-0.5, True)
    assert told["moves as the heuristic's"] == (0.75, False)
    assert {holds for _, _, holds in few.claims()} == {None}


def test_a_player_whose_tasks_lead_nowhere_is_counted() -> None:
    stats = PlayStats()
    stats.add(record_game("random", "MA2", seed=1), "red")

    assert stats.games == 1


def test_events_that_lack_what_is_counted_are_refused(replay: Replay) -> None:
    lines = [dict(line) for line in replay.lines]
    del next(line for line in lines if line.get("kind") == "arrived")["cell"]

    with pytest.raises(ReplayFileError, match="KeyError: 'cell'; expected events and tasks"):
        PlayStats().add(Replay(tuple(lines)), "red")
