"""How a player of a family is drawn: every number is a hash of a key and of the number's place."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.drawn_records import SQUADS, STAGES, CharacterRecord
from hexwar_sb3.bots.records import BANDS, POSTS
from hexwar_sb3.bots.registry import Bot, Duty, Event, Pilot
from hexwar_sb3.engine.dice import splitmix64
from hexwar_sb3.engine.records import GameRecord, Pieces
from hexwar_sb3.kernels import Row, kernel
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, SlotIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece

LAST_DUTY, LAST_EVENT, LAST_PILOT = max(Duty).value, max(Event).value, max(Pilot).value
_S11, _UNIT = np.uint64(11), 2.0**-53
_STYLE, _CONDUCT, _SQUAD, _STAGE, _SLOT, _PLAN = 0, 100, 200, 300, 400, 600  # places of the numbers
_PLANNED = (Duty.TAKE.value, Duty.TAKE.value, Duty.KEEP.value, Duty.CHASE.value, Duty.CHASE.value)


@kernel
def part(key: np.uint64, place: int) -> float:
    """Number in [0, 1) at a place of a key's sequence."""
    return float(splitmix64(key ^ splitmix64(np.uint64(place))) >> _S11) * _UNIT


@kernel
def between(low: float, high: float, key: np.uint64, place: int) -> float:
    """Number in [low, high)."""
    return low + (high - low) * part(key, place)


@kernel
def whole(low: int, high: int, key: np.uint64, place: int) -> int:
    """Whole number in low..high."""
    return low + int(part(key, place) * (high - low + 1))


@kernel
def one_in(share: float, key: np.uint64, place: int) -> int:
    """1 in this share of the cases, else 0."""
    return 1 if part(key, place) < share else 0


@kernel
def draw_player(bot: int, camp: CampIndex, game: GameRecord, pieces: Pieces, drawn: CharacterRecord) -> None:
    """Draw the member `drawn.member` of a family; member 0 stands for one that the game's seed picks.

    Args:
        drawn: out, CHARACTER; all but its `member` is written.
    """
    origin = (
        game.seed ^ splitmix64(game.salt[camp]) if drawn.member == 0 else splitmix64(np.uint64(drawn.member))
    )
    key = splitmix64(origin ^ np.uint64(bot))
    draw_style(key, drawn.style)
    draw_squads(key, camp, game, pieces, drawn)
    if bot == Bot.DRAWN:
        draw_conduct(key, game, drawn)
    elif bot == Bot.DRAWN_PLAN:
        draw_plan(key, camp, game, pieces, drawn)
    else:
        draw_timetable(key, game, drawn)


@kernel
def draw_style(key: np.uint64, style: Row) -> None:
    """Thresholds between and beyond those of MA1 and MA2 (config.py)."""
    style.gain_weight = between(0.3, 1.5, key, _STYLE)
    style.threat_weight = between(0.1, 1.6, key, _STYLE + 1)
    style.cover_weight = between(0.0, 6.0, key, _STYLE + 2)
    style.reach_weight = between(0.1, 1.0, key, _STYLE + 3)
    style.risk_weight = between(0.0, 0.4, key, _STYLE + 4)
    style.eta_ticks = between(60.0, 220.0, key, _STYLE + 5)
    style.move_gain = between(1.0, 8.0, key, _STYLE + 6)
    style.patience_ticks = between(50.0, 250.0, key, _STYLE + 7)
    style.around_cells = whole(8, 18, key, _STYLE + 8)
    style.own_cells = whole(6, 18, key, _STYLE + 9)
    style.enter_ratio = 0.3 * 12.0 ** part(key, _STYLE + 10)  # 0.3 to 3.6, most of them low
    style.fire_value = between(0.2, 1.2, key, _STYLE + 11)
    style.ambush_value = between(0.3, 2.5, key, _STYLE + 12)
    style.stop_value = between(1.0, 5.0, key, _STYLE + 13)
    style.guide_value = between(0.5, 3.0, key, _STYLE + 14)
    style.mortar_value = between(0.02, 0.3, key, _STYLE + 15)
    style.hunt = one_in(0.5, key, _STYLE + 16)
    style.covered = one_in(0.4, key, _STYLE + 17)
    style.always_hide = one_in(0.4, key, _STYLE + 18)
    style.drop_cells = whole(3, 18, key, _STYLE + 19)
    style.walk_ticks = whole(150, 700, key, _STYLE + 20)
    style.keep_vehicles = one_in(0.3, key, _STYLE + 21)
    for kind in range(PieceType.AEROCRAFT):
        late = one_in(0.5, key, _STYLE + 30 + kind)
        style.take_delay[kind] = late * between(0.0, 500.0, key, _STYLE + 40 + kind)
    style.carry_delay = between(0.0, 600.0, key, _STYLE + 22)


@kernel
def draw_squads(
    key: np.uint64, camp: CampIndex, game: GameRecord, pieces: Pieces, drawn: CharacterRecord
) -> None:
    """Deal the pieces out to squads; most soldiers go with their chariot."""
    first = first_piece(camp, game)
    squads = whole(1, SQUADS, key, _SQUAD)
    for i in piece_range(first, end_piece(camp, game)):
        drawn.squad[SlotIndex(i - first)] = whole(0, squads - 1, key, _SQUAD + 1 + i - first)
        drawn.post[SlotIndex(i - first)] = whole(0, BANDS * POSTS - 1, key, _SLOT + i - first)
    for i in piece_range(first, end_piece(camp, game)):
        home = int(pieces[i].home)
        if home >= 0 and one_in(0.8, key, _SQUAD + 50 + i - first):
            drawn.squad[SlotIndex(i - first)] = drawn.squad[SlotIndex(home - first)]
    last_point = max(0, int(game.n_points) - 1)
    for s in range(SQUADS):
        drawn.point[s] = whole(0, last_point, key, _SQUAD + 100 + s)
        late = one_in(0.3, key, _SQUAD + 110 + s)
        drawn.start[s] = late * whole(1, game.end_tick // 2, key, _SQUAD + 120 + s)


@kernel
def draw_conduct(key: np.uint64, game: GameRecord, drawn: CharacterRecord) -> None:
    """What a member of "drawn" does in its own way."""
    end, last_point = int(game.end_tick), max(0, int(game.n_points) - 1)
    for s in range(SQUADS):
        feints = one_in(0.25, key, _CONDUCT + s)
        drawn.feint[s] = whole(0, last_point, key, _CONDUCT + 10 + s)
        drawn.turn[s] = feints * whole(end // 6, end * 2 // 3, key, _CONDUCT + 20 + s)
        hunts = one_in(0.3, key, _CONDUCT + 30 + s)
        drawn.hunt[s] = whole(0, end, key, _CONDUCT + 40 + s) if hunts else end
    drawn.staged = one_in(0.5, key, _CONDUCT + 50)
    drawn.stubborn = one_in(0.3, key, _CONDUCT + 51)
    drawn.dealt = one_in(0.4, key, _CONDUCT + 52)
    drawn.pilot = whole(0, LAST_PILOT, key, _CONDUCT + 53)
    drawn.rush = whole(end // 2, end, key, _CONDUCT + 54)
    drawn.reckless = one_in(0.3, key, _CONDUCT + 55)
    drawn.retreat_blood = one_in(0.4, key, _CONDUCT + 56) * whole(1, 3, key, _CONDUCT + 57)
    drawn.retreat_threat = between(1.0, 8.0, key, _CONDUCT + 58)


@kernel
def draw_plan(
    key: np.uint64, camp: CampIndex, game: GameRecord, pieces: Pieces, drawn: CharacterRecord
) -> None:
    """What the squads of a member of "drawn-plan" do all along: hold a point, hold it hidden, or hunt."""
    first = first_piece(camp, game)
    if one_in(0.5, key, _PLAN):  # squads of types of pieces, whole or in two halves
        halves = whole(1, 2, key, _PLAN + 1)
        for i in piece_range(first, end_piece(camp, game)):
            place = _PLAN + 10 + 2 * int(pieces[i].kind) + (i - first) % halves
            drawn.squad[SlotIndex(i - first)] = whole(0, SQUADS - 1, key, place)
    for s in range(SQUADS):
        drawn.what[s, 0] = _PLANNED[whole(0, len(_PLANNED) - 1, key, _PLAN + 2 + s)]


@kernel
def draw_timetable(key: np.uint64, game: GameRecord, drawn: CharacterRecord) -> None:
    """What the squads of a member of "drawn-unseen" do one after the other."""
    end, last_point = int(game.end_tick), max(0, int(game.n_points) - 1)
    for s in range(SQUADS):
        tick = int(drawn.start[s])
        for n in range(STAGES):
            place = _STAGE + 10 * (STAGES * s + n)
            drawn.what[s, n] = max(0, whole(-2, LAST_DUTY, key, place))  # TAKE more often than the others
            drawn.where[s, n] = whole(0, last_point, key, place + 1)
            tick = min(end, tick + whole(end // 18, end // 2, key, place + 2))
            drawn.until[s, n] = end if n == STAGES - 1 else tick
            drawn.ends_by[s, n] = whole(0, LAST_EVENT, key, place + 3)
        drawn.what[s, STAGES - 1] = whole(
            0, Duty.CHASE, key, _STAGE + 150 + s
        )  # whoever ends elsewhere has no points
    drawn.quiet = one_in(0.2, key, _CONDUCT) * whole(1, end // 3, key, _CONDUCT + 1)
    drawn.rides = one_in(0.6, key, _CONDUCT + 2)
