"""The feature table and the kernels that write it agree; frames and fog hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.engine.score import known_margin, margin
from hexwar_sb3.rules.enums import Camp, PieceType
from hexwar_sb3.tasks import features
from hexwar_sb3.tasks.features import VECTORS, feature_index, markdown, sizes
from hexwar_sb3.tasks.observe import global_state
from hexwar_sb3.tasks.records import STAYING, TaskKind
from hexwar_sb3.tasks.travel import travel_ticks

if TYPE_CHECKING:
    from tests.tasks.conftest import Board

N = 7
K = TaskKind


def test_sizes_of_the_built_in_scenarios() -> None:
    assert sizes(7, 7, 2) == features.Sizes(obs=257, row=36, state=133, route=73)


@pytest.mark.parametrize("counts", [(7, 7, 2), (1, 1, 1), (3, 5, 8)])
@pytest.mark.parametrize("vector", VECTORS)
def test_the_index_covers_every_number_once(vector: str, counts: tuple[int, int, int]) -> None:
    places = list(feature_index(vector, *counts).values())

    assert [place.start for place in places] == [0, *(place.stop for place in places[:-1])]
    assert places[-1].stop == getattr(sizes(*counts), vector)


def test_every_feature_has_a_source() -> None:
    rows = [line for line in markdown().splitlines() if line.startswith("|") and "---" not in line]

    assert all(cell.strip() for row in rows for cell in row.strip("|").split("|"))


def test_the_first_and_the_last_feature_stand_where_the_table_says(middle: Callable[[int], Board]) -> None:
    """If any block had another width than its row in the table, the last ones would be off."""
    board = middle(2)
    for camp in (Camp.RED, Camp.BLUE):
        seen, places = board.observation(camp), feature_index("obs", N, N, 2)
        alive = seen["alive"] == 1
        kinds = board.pieces.kind[camp * N : camp * N + N]
        known = known_margin(board.game, board.pieces, board.memory, camp, board.rules)
        assert (seen["obs"][alive, places["self: type"]].argmax(axis=1) == kinds[alive]).all()
        assert seen["obs"][alive, -1].tolist() == [float(camp)] * alive.sum()
        np.testing.assert_allclose(seen["obs"][alive, -2], known * features.PER_MARGIN, rtol=1e-6)


def test_everything_is_written_and_of_moderate_size(middle: Callable[[int], Board]) -> None:
    for seed in range(8):
        seen = middle(seed).observation()
        for key in ("obs", "rows", "alive"):
            assert np.isfinite(seen[key]).all()
            assert np.abs(seen[key]).max() <= 5.0
        assert (seen["rows"][seen["mask"] == 0] == 0.0).all()


def test_the_dead_observe_nothing(board: Board) -> None:
    board.put("tank0", board.cell(10, 34), blood=0)
    seen = board.observation()

    assert seen["alive"].tolist() == [0, 1, 1, 1, 1, 1, 1]
    assert (seen["obs"][0] == 0.0).all()


def test_own_features(field: Board) -> None:
    field.put("tank0", field.cell(20, 10), blood=2, hidden=1, cool_ends=30)
    field.look()
    mission = field.task("tank0", K.HOLD, cell=field.cell(20, 16))
    mission.state, mission.goal = STAYING, mission.cell

    assert field.feature("tank0", "self: blood") == pytest.approx([2 / 3])
    assert field.feature("tank0", "self: hidden, suppressed") == [1.0, 0.0]
    assert field.feature("tank0", "self: cool, stop, hide, board, decompress, keep, mortar")[
        0
    ] == pytest.approx(0.4)
    assert field.feature("tank0", "self: on control point, concealed") == [1.0, 0.0]
    assert np.argmax(field.feature("tank0", "self: task kind")) == K.HOLD
    assert field.feature("tank0", "self: walking, staying, ended") == [0.0, 1.0, 0.0]
    assert field.feature("tank0", "self: goal dx, dy, distance") == pytest.approx([0.0, 6 / 35, 6 / 35])
    assert field.feature("chariot0", "self: has passenger") == [1.0]
    assert field.feature("tank0", "own piece 4: alive, aboard") == [1.0, 1.0]
    assert field.feature("tank0", "point 1: dx, dy, distance") == pytest.approx([0.0, 6 / 35, 6 / 35])
    assert field.feature("tank0", "neighbour 3: ease") == [1.0]


def test_an_enemy_is_observed_as_last_seen(field: Board) -> None:
    """u(sigma, t): never seen, seen now, then with its age (III-A)."""
    assert field.feature("tank0", "enemy 0: never seen, destroyed, seen, seen by this piece") == [1, 0, 0, 0]
    field.put("tank0", field.cell(20, 2))
    field.put("blue:tank0", field.cell(25, 2))
    field.look()
    assert field.feature("tank0", "enemy 0: never seen, destroyed, seen, seen by this piece") == [0, 0, 1, 1]
    assert field.feature("tank0", "enemy 0: dx, dy, distance") == pytest.approx([5 / 35, 0.0, 5 / 35])

    field.put("tank0", field.cell(3, 10))
    field.put("tank1", field.cell(3, 14))
    field.put("blue:tank0", field.cell(37, 10), blood=1)
    field.game.tick = 181
    field.look()

    assert field.feature("tank0", "enemy 0: never seen, destroyed, seen, seen by this piece") == [0, 0, 0, 0]
    assert field.feature("tank0", "enemy 0: age") == pytest.approx([1 / 1800])
    assert field.feature("tank0", "enemy 0: blood") == [1.0]
    field.memory[0, N].blood = 0
    assert field.feature("tank0", "enemy 0: never seen, destroyed, seen, seen by this piece") == [0, 1, 0, 0]


def test_task_features(field: Board) -> None:
    field.put("tank0", field.cell(20, 2))
    field.put("blue:chariot0", field.cell(25, 2), blood=2)
    field.look()
    j, main = field.i("blue:chariot0"), field.cell(20, 10)
    field.task("tank1", K.ATTACK, target=j)
    way = travel_ticks(PieceType.TANK, field.cell(20, 2), main, field.rules, field.cells, field.eta)

    assert field.row_feature("tank0", K.HOLD, "dx, dy, distance") == pytest.approx([0.0, 8 / 35, 8 / 35])
    assert field.row_feature("tank0", K.HOLD, "way") == pytest.approx([way / 900])
    assert field.row_feature("tank0", K.HOLD, "value of the point") == [1.0]
    assert field.row_feature("tank0", K.HOLD, "possible now") == [0.0]
    assert field.row_feature("tank0", K.ATTACK, "possible now", j) == [1.0]
    assert field.row_feature("tank0", K.ATTACK, "others on it", j) == pytest.approx([1 / 7])
    assert field.row_feature("tank0", K.ATTACK, "target type", j) == [0, 1, 0, 0]
    assert field.row_feature("tank0", K.ATTACK, "target's worth", j) == pytest.approx([14 / 30])
    assert field.row_feature("tank0", K.ATTACK, "level", j) == pytest.approx([0.9])
    assert field.row_feature("tank0", K.ATTACK, "value of the action", j)[0] > 0.5
    assert field.row_feature("tank0", K.ATTACK, "threat", j) == pytest.approx([0.8])  # its heavy missile
    assert field.row_feature("tank1", K.ATTACK, "under way", j) == [1.0]


def scramble_unseen(board: Board, camp: int, rng: np.random.Generator) -> None:
    """Change every field of the other camp that this camp cannot know."""
    for j in range(N * (1 - camp), N * (1 - camp) + N):
        piece, seen = board.pieces[j], board.memory[camp, j].seen
        piece.ammo[:] = rng.integers(0, 9, 4)
        piece.sees = rng.integers(0, 2**7)
        for timer in ("cool_ends", "mortar_ends", "keep_ends", "hide_ends"):
            piece[timer] = board.game.tick + rng.integers(1, 75)
        if not seen:
            piece.cell = rng.choice(np.flatnonzero(board.cells.passable))
            piece.blood, piece.hidden, piece.suppressed = rng.integers(0, 3), 1, 1
            piece.path_len = rng.integers(0, 2)
        board.missions[j].kind, board.missions[j].target = K.ATTACK, 0
        board.memory[1 - camp, j - N * (1 - 2 * camp)].cell = rng.integers(0, 100)
    board.game.loss_tick[1 - camp] = board.game.contact_tick[1 - camp] = 3
    board.game.seed += np.uint64(1)


@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_the_unseen_changes_no_byte(middle: Callable[[int], Board], camp: Camp) -> None:
    """Fog of war: rule book, section 6."""
    rng = np.random.default_rng(0)
    for seed in range(8):
        board = middle(seed)
        before = board.observation(camp)
        scramble_unseen(board, camp, rng)
        after = board.observation(camp)
        assert all(before[key].tobytes() == after[key].tobytes() for key in before)


def state_of(board: Board, camp: int) -> Any:
    state = np.full(sizes(N, N, 2).state, np.nan, np.float32)
    global_state(Camp(camp), board.game, board.pieces, board.rules, board.cells, state)
    return state


def test_the_mixers_state_is_the_true_state(field: Board) -> None:
    field.put("blue:tank0", field.cell(25, 10), blood=1)
    places = feature_index("state", N, N, 2)
    state = state_of(field, Camp.RED)

    assert np.isfinite(state).all()
    assert state[places["piece 7: blood"]] == pytest.approx([1 / 3])
    assert state[places["piece 7: place x, y"]] == pytest.approx([25 / 35 - 1, 10 / 35 - 1])
    assert state[places["game: margin"]] == pytest.approx(
        [margin(field.game, field.pieces, Camp.RED, field.rules) / 100]
    )
    assert state[places["game: blue"]] == [0.0]


def test_an_unreachable_or_unknown_place_keeps_rows_finite(field: Board) -> None:
    mission = field.task("tank0", K.ATTACK, target=N)
    assert (mission.goal, mission.cell, field.memory[0, N].cell) == (NO_CELL, NO_CELL, NO_CELL)
    assert np.isfinite(field.observation()["obs"]).all()
    assert mission.target != NO_PIECE
