"""Legality against an independent slow reading of the rule book (section 4): who may do what, counted.

This page was written from the rule book, not from the kernels: distances by walking, state by names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.order_rows import clear_order
from hexwar_sb3.engine.records import NEVER, NO_PIECE, ORDER
from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row
from hexwar_sb3.rules.enums import Action, Weapon
from hexwar_sb3.rules.indices import PieceIndex
from hexwar_sb3.rules.tables import ATTACKS, DIRECT_FIRE

Play = Callable[..., State]

TANK, CHARIOT, SOLDIER, AEROCRAFT = range(4)
ARMS = {
    TANK: "GUN LIGHT",
    CHARIOT: "CANNON LIGHT HEAVY MORTAR",
    SOLDIER: "SMALL ROCKET PORT",
    AEROCRAFT: "AIRM",
}
POOLS = {
    "GUN": 0,
    "LIGHT": 0,
    "CANNON": 0,
    "HEAVY": 1,
    "MORTAR": 2,
    "SMALL": 0,
    "ROCKET": 0,
    "PORT": 1,
    "AIRM": 0,
}
HEIGHT = next(table for table in DIRECT_FIRE if table.name == "height").cells


class Referee:
    """One state, asked by a person with the rule book."""

    def __init__(self, state: State, world: World) -> None:
        self.game, self.pieces, _, self.paths, *_ = state.game(0)
        self.hexmap = world.scenario.hexmap
        self.width = self.hexmap.width

    # --- geometry by hand ------------------------------------------------------------------------

    def xy(self, cell: int) -> tuple[int, int]:
        return cell % self.width, cell // self.width

    def apart(self, a: int, b: int) -> int:
        (ax, ay), (bx, by) = self.xy(a), self.xy(b)
        dq = (bx - (by - by % 2) // 2) - (ax - (ay - ay % 2) // 2)
        dr = by - ay
        return int((abs(dq) + abs(dr) + abs(dq + dr)) // 2)

    def beside(self, cell: int, direction: int) -> int | None:
        x, y = self.xy(cell)
        even = [(-1, 0), (-1, 1), (0, 1), (1, 0), (0, -1), (-1, -1)]
        odd = [(-1, 0), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1)]
        dx, dy = (odd if y % 2 else even)[direction]
        x, y = x + dx, y + dy
        inside = 0 <= y < self.hexmap.height and 0 <= x < self.width - y % 2
        return y * self.width + x if inside else None

    def at(self, layer: str, cell: int) -> int:
        return int(getattr(self.hexmap, layer).flat[cell])

    def hop(self, kind: int, a: int, direction: int) -> int | None:
        b = self.beside(a, direction)
        if b is None:
            return None
        if kind == AEROCRAFT:
            return 8
        if not self.at("passable", b):
            return None
        rise = abs(self.at("elev_m", b) - self.at("elev_m", a))
        if kind == SOLDIER:
            return 288 if rise > 60 else 144
        if self.at("paved", a) and self.at("paved", b):
            return 20
        steps = -(-rise // self.hexmap.grade_m)
        factor = 4 if self.at("slushy", b) else 2 if self.at("concealed", b) else 1
        return None if steps > 5 else 20 * max(1, steps) * factor

    # --- words of section 3 ----------------------------------------------------------------------

    def out(self, p: Row) -> bool:
        return bool(p.blood > 0 and p.carrier == NO_PIECE)

    def ground_in(self, camp: int, cell: int | None) -> int:
        ground = [p for p in self.pieces if self.out(p) and p.kind != AEROCRAFT]
        return sum(p.camp == camp and p.cell == cell for p in ground)

    def fights(self, p: Row) -> bool:
        return bool(p.kind != AEROCRAFT and self.out(p) and self.ground_in(1 - p.camp, p.cell))

    def path(self, p: Row) -> bool:
        return bool(p.path_pos < p.path_len)

    def settled(self, p: Row) -> bool:
        timers = (p.stop_ends, p.hide_ends, p.board_ends, p.decompress_ends)
        return not self.path(p) and all(timer == NEVER for timer in timers)

    def busy(self, p: Row) -> bool:
        timers = (p.hide_ends, p.board_ends, p.decompress_ends)
        forced = p.stop_forced and p.stop_ends != NEVER and not self.path(p)
        return bool(forced or any(timer != NEVER for timer in timers))

    def progress(self, p: Row) -> int:
        return 0 if p.arrives_at == NEVER else int(p.hop_need - (p.arrives_at - self.game.tick))

    def sees(self, i: int, t: int) -> bool:
        own, other = self.pieces[i], self.pieces[t]
        return bool(own.camp != other.camp and int(own.sees) >> int(other.slot) & 1)

    def armed(self, p: Row, weapon: str) -> bool:
        return weapon in ARMS[int(p.kind)].split() and p.ammo[POOLS[weapon]] > 0

    def level(self, weapon: str, shooter: Row, target: Row) -> int:
        klass = {TANK: 0, CHARIOT: 0, SOLDIER: 1, AEROCRAFT: 2}[int(target.kind)]
        apart = self.apart(int(shooter.cell), int(target.cell))
        rows = [row for row in ATTACKS if (row.weapon.name, int(row.target)) == (weapon, klass)]
        if not rows:
            return 0
        levels, k = rows[0].of_blood(int(shooter.blood)), apart - rows[0].first_cells
        level = levels[k] if 0 <= k < len(levels) else 0
        rise = self.at("elev_m", int(target.cell)) - self.at("elev_m", int(shooter.cell))
        uphill = rise // self.hexmap.grade_m
        if AEROCRAFT not in {int(shooter.kind), int(target.kind)} and uphill > 0 and 1 <= apart <= 12:
            level += HEIGHT[min(uphill, 8) - 1][apart - 1]  # type: ignore[index, operator]
        return level

    # --- section 4, column "Legal when" ----------------------------------------------------------

    def legal(self, i: int, order: Row) -> bool:
        p = self.pieces[i]
        if order.kind == Action.NULL:
            return True
        if self.game.over or not self.out(p):
            return False
        if self.fights(p) and order.kind != Action.MOVE:
            return False
        rule = {
            Action.MOVE: self.may_move,
            Action.STOP: lambda *_: self.path(p),
            Action.HIDE: self.may_hide,
            Action.OCCUPY: self.may_occupy,
            Action.SHOOT: self.may_shoot,
            Action.GUIDE_SHOOT: self.may_guide,
            Action.INDIRECT_SHOOT: self.may_bombard,
            Action.GET_ON: self.may_get_on,
            Action.GET_OFF: self.may_get_off,
            Action.DECOMPRESS: self.may_decompress,
        }[Action(order.kind)]
        return bool(rule(i, order))

    def may_move(self, i: int, order: Row) -> bool:
        p = self.pieces[i]
        if self.busy(p) or self.path(p) or (p.kind == SOLDIER and p.suppressed):
            return False
        cell: int | None = int(p.cell)
        for direction in order.path[: order.path_len]:
            if cell is None or self.hop(int(p.kind), cell, int(direction)) is None:
                return False
            cell = self.beside(cell, int(direction))
        first = self.beside(int(p.cell), int(order.path[0]))
        return bool(order.path_len) and not (self.fights(p) and self.ground_in(1 - p.camp, first))

    def may_hide(self, i: int, order: Row) -> bool:
        p = self.pieces[i]
        stands = p.kind != AEROCRAFT and not self.path(p) and not self.busy(p)
        return bool(stands and not p.suppressed and not p.hidden)

    def may_occupy(self, i: int, order: Row) -> bool:
        p, game = self.pieces[i], self.game
        points = range(game.n_points)
        others = [k for k in points if game.point_cell[k] == p.cell and game.point_owner[k] != p.camp]
        return bool(p.kind != AEROCRAFT and self.progress(p) == 0 and others)

    def may_shoot(self, i: int, order: Row) -> bool:
        p, t = self.pieces[i], self.pieces[order.target]
        weapon = Weapon(order.weapon).name
        if not self.armed(p, weapon) or p.cool_ends != NEVER or not self.sees(i, int(order.target)):
            return False
        if not self.out(t) or t.camp == p.camp or self.fights(t) or (p.kind == SOLDIER and p.suppressed):
            return False
        natural = p.stop_ends != NEVER and not p.stop_forced
        under_way = p.kind == TANK and weapon == "GUN" and (self.path(p) or natural or p.hide_ends != NEVER)
        idle = p.decompress_ends == NEVER and p.board_ends == NEVER
        return (self.settled(p) or (under_way and idle)) and self.level(weapon, p, t) >= 1

    def may_guide(self, i: int, order: Row) -> bool:
        p, t, c = self.pieces[i], self.pieces[order.target], self.pieces[order.partner]
        if p.kind not in {SOLDIER, AEROCRAFT} or c.camp != p.camp or c.kind != CHARIOT:
            return False
        if p.kind == SOLDIER and p.home != order.partner:
            return False
        actor = self.settled(p) and not p.suppressed and p.cool_ends == NEVER
        target = (
            self.sees(i, int(order.target)) and self.out(t) and t.camp != p.camp and t.kind in {TANK, CHARIOT}
        )
        chariot = self.out(c) and self.settled(c) and c.cool_ends == NEVER and self.armed(c, "HEAVY")
        if not (actor and target and chariot) or self.fights(c) or self.fights(t):
            return False
        return 2 <= self.apart(int(c.cell), int(t.cell)) <= 20 and self.level("HEAVY", c, t) >= 1

    def may_bombard(self, i: int, order: Row) -> bool:
        p = self.pieces[i]
        if p.kind != CHARIOT or not self.settled(p) or p.suppressed or not self.armed(p, "MORTAR"):
            return False
        in_range = 4 <= self.apart(int(p.cell), int(order.cell)) <= 20
        return bool(p.mortar_ends == NEVER and in_range and self.at("playable", int(order.cell)))

    def may_get_on(self, i: int, order: Row) -> bool:
        p, c = self.pieces[i], self.pieces[order.target]
        pair = (
            p.kind == SOLDIER and c.kind == CHARIOT and c.camp == p.camp and self.out(c) and c.cell == p.cell
        )
        free = not p.suppressed and not c.suppressed and self.settled(p) and self.settled(c)
        return bool(pair and free and c.passenger == NO_PIECE)

    def may_get_off(self, i: int, order: Row) -> bool:
        p = self.pieces[i]
        room = self.ground_in(int(p.camp), int(p.cell)) <= 3
        carries = p.kind == CHARIOT and self.pieces[order.target].carrier == i
        return bool(carries and self.settled(p) and not p.suppressed and room)

    def may_decompress(self, i: int, order: Row) -> bool:
        p = self.pieces[i]
        in_cell = not self.path(p) or self.progress(p) == 0
        late = p.keep_ends - self.game.tick <= 75
        return bool(p.suppressed and not late and in_cell and p.stop_ends == NEVER and not self.busy(p))


def candidates(state: State, rng: np.random.Generator) -> Iterator[tuple[int, Row]]:
    """Every order of few parameters, and a sample of the others."""
    n = state.pieces.shape[1]
    row = np.zeros(1, ORDER).view(np.recarray)[0]
    n_cells = 13 * 9
    for i in range(n):
        for kind in Action:
            targets = (
                range(n)
                if kind in {Action.SHOOT, Action.GUIDE_SHOOT, Action.GET_ON, Action.GET_OFF}
                else range(1)
            )
            tries = 6 if kind in {Action.MOVE, Action.INDIRECT_SHOOT} else 1
            for target in targets:
                for k in range(tries):
                    carried = [Weapon[name] for name in ARMS[int(state.pieces[0, i].kind)].split()]
                    for weapon in (
                        (*carried, Weapon(int(rng.integers(0, len(Weapon)))))
                        if kind is Action.SHOOT
                        else (Weapon.HEAVY,)
                    ):
                        clear_order(row)
                        row.kind, row.weapon, row.target = kind, weapon, target
                        row.partner, row.cell = rng.choice([2, 3, 9, 10]), rng.integers(0, n_cells)
                        row.path_len = rng.integers(0, 4) if k == 5 else 1
                        row.path[:3] = (k, *rng.integers(0, 6, 2))
                        yield i, row


FEW = range(6)
MANY = [range(first, first + 20) for first in (100, 120, 140)]
SEEDS = [
    pytest.param(FEW, id="few"),
    *(pytest.param(seeds, id=f"from-{seeds.start}", marks=pytest.mark.slow) for seeds in MANY),
]


@pytest.mark.parametrize("seeds", SEEDS)
def test_legality_is_what_the_rule_book_says(seeds: range, small_world: World, play_randomly: Play) -> None:
    """Section 4, for every piece and action in positions of random play."""
    rng = np.random.default_rng(seeds.start)
    found: set[tuple[Action, bool]] = set()

    def compare(state: State) -> None:
        if rng.random() > 0.05:
            return
        game, pieces, *_ = state.game(0)
        referee = Referee(state, small_world)
        for i, row in candidates(state, rng):
            code = order_code(PieceIndex(i), row, game, pieces, *small_world.tables[:2])
            assert (code == Code.OK) == referee.legal(i, row), (
                Action(row.kind),
                i,
                Code(code),
                int(game.tick),
            )
            found.add((Action(row.kind), code == Code.OK))

    for seed in seeds:
        play_randomly(small_world, seed, until=1200, each=compare)
    assert len(found) >= 2 * len(Action) - 2, "null is never illegal, guiding is seldom legal"
