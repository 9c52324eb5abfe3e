"""What was decided in a recorded game (docs/formats/replay.md, line `decision`)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.roster import enemy_of
from hexwar_sb3.engine.score import own_total
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import FrozenLower
from hexwar_sb3.players.player import make_player
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.records import TaskKind

KINDS = {kind.name.lower() for kind in TaskKind}


def decisions(replay: Replay, camp: str) -> list[dict[str, Any]]:
    return [line for line in replay.lines if line["type"] == "decision" and line["camp"] == camp]


@pytest.fixture(scope="module")
def replay() -> Replay:
    return record_game("HRL0", "MA2", seed=3)


def test_a_game_with_its_decisions_plays_again(replay: Replay) -> None:
    replay.verify()


def test_a_policy_decides_for_all_its_living_pieces_every_75_ticks(replay: Replay) -> None:
    for line in decisions(replay, "red"):
        alive = [name for name, _, blood, *_ in state_at(replay, line["tick"])["pieces"] if blood]

        assert [f"red:{choice[0]}" for choice in line["choices"]] == [n for n in alive if n.startswith("red")]
    assert [line["tick"] for line in decisions(replay, "red")] == list(range(0, replay.end["tick"], 75))


def state_at(replay: Replay, tick: int) -> dict[str, Any]:
    return next(state for state in replay.states if state["tick"] == tick)


def test_what_a_policy_chose_is_worth_most_to_it(replay: Replay) -> None:
    for line in decisions(replay, "red"):
        for _, chosen, tasks, values, _ in line["choices"]:
            assert len(values) == len(tasks) == len(set(tasks))
            assert values[chosen] == max(values)
            assert {task.split()[0] for task in tasks} <= KINDS


def test_a_chosen_task_is_what_the_piece_then_does(replay: Replay) -> None:
    """Where a tank of red is told to go, there it goes, or on its way there something else was decided."""
    line = decisions(replay, "red")[0]
    aims = {name: tasks[chosen].split()[-1] for name, chosen, tasks, *_ in line["choices"]}
    orders = next(one for one in replay.lines if one["type"] == "orders" and one["camp"] == "red")["orders"]
    hexmap = replay.scenario().hexmap

    for order in orders:
        piece, verb, *path = order.split()
        if verb == "move":
            start = next(cell for name, cell, *_ in replay.states[0]["pieces"] if name == f"red:{piece}")
            assert apart(hexmap, path[-1], aims[piece]) < apart(hexmap, start, aims[piece])


def apart(hexmap: Any, one: str, other: str) -> float:
    from hexwar_sb3.maps.picture import centres

    where = centres(hexmap)
    return math.dist(where[hexmap.parse_cell(one)], where[hexmap.parse_cell(other)])


@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_the_parts_of_the_reward_add_up_to_what_was_gained(replay: Replay, camp: Camp) -> None:
    gained = 0
    for line in decisions(replay, camp.name.lower()):
        gained += sum(line["reward"].values())
        game = replay.game_at(line["tick"])
        row, pieces, rules = game.state.games[0], game.state.pieces[0], game.world.rules[0]

        assert gained == own_total(row, pieces, camp, rules) - own_total(row, pieces, enemy_of(camp), rules)
    assert gained != 0


def test_of_a_bot_the_pieces_with_another_task_are_written(replay: Replay) -> None:
    now: dict[str, str] = {}
    for line in decisions(replay, "blue"):
        for piece, chosen, tasks, values, _ in line["choices"]:
            assert (chosen, len(tasks), values) == (0, 1, [])
            assert now.get(piece, "stop") != tasks[0]
            now[piece] = tasks[0]
    assert len(now) > 3


class Still:
    """Lets every piece stop, and has no values."""

    def act(self, obs: dict[str, np.ndarray]) -> np.ndarray:
        return np.zeros(obs["action_mask"].shape[:2], np.int64)


def test_a_player_without_values_has_none_in_its_lines() -> None:
    replay = record_game(Still(), "nearest", seed=1)

    choices = [choice for line in decisions(replay, "red") for choice in line["choices"]]
    assert choices
    assert all(tasks[chosen] == "stop" and values == [] for _, chosen, tasks, values, _ in choices)


def test_a_lower_level_outside_the_loop_changes_no_line_of_the_upper_one() -> None:
    policy = make_player("HRL0")
    assert isinstance(policy, FrozenPolicy)
    assert isinstance(policy.lower, FrozenLower)
    outside = policy.led_by(policy.lower.__call__)

    one, other = record_game(policy, "MA1", seed=2), record_game(outside, "MA1", seed=2)

    assert decisions(one, "red") == decisions(other, "red")
    assert one.end["margin"] == other.end["margin"]


def test_directions_are_those_of_the_moves_that_follow(replay: Replay) -> None:
    first = decisions(replay, "red")[0]
    led = {piece for piece, *_, direction in first["choices"] if direction}
    moves = next(line for line in replay.lines if line["type"] == "orders" and line["camp"] == "red")[
        "orders"
    ]

    assert led == {order.split()[0] for order in moves if " move " in order}
