"""How a scripted player weighs what it knows: trust, threat, gain, power (bots.md, section 1).

Enemies are read through the camp's memory only. `trust` is the brain's [P], renewed at each thought.
"""

from __future__ import annotations

from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.known import end_piece, first_piece, has_line_from, is_known, reach_of_sight


@kernel
def renew_trust(camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row, config: Row) -> None:
    """How much each enemy's last known place still says: 1 seen now, 0 after `trust_ticks` or never seen."""
    for j in range(first_piece(1 - camp, game), end_piece(1 - camp, game)):
        known = memory[camp, j]
        brain.trust[j] = 0.0
        if is_known(known):
            age = 0.0 if known.seen else float(game.tick - known.tick)
            brain.trust[j] = max(0.0, 1.0 - age / config.trust_ticks)


@kernel
def exposed_reach(kind: int, target_kind: int, cell: int, rules: Row, cells: Rows) -> int:
    """Greatest distance at which a type of piece sees an unhidden piece standing in a cell."""
    reach = int(rules.sight[kind, target_kind])
    if cells[cell].concealed and target_kind != PieceType.AEROCRAFT:
        reach = max(1, reach // int(rules.concealed_sight_divisor))
    return reach


@kernel
def threat_at(
    kind: int, cell: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, atlas: Row,
) -> float:  # fmt: skip
    """Points that known enemies may be expected to cost an unhidden piece in a cell, one round of shots."""
    total = 0.0
    for j in range(first_piece(1 - camp, game), end_piece(1 - camp, game)):
        trust = brain.trust[j]
        if trust <= 0.0:
            continue
        known = memory[camp, j]
        enemy = pieces[j].kind
        apart = cells_apart(cells, cell, known.cell)
        if apart >= atlas.danger.shape[2] or apart > exposed_reach(enemy, kind, cell, rules, cells):
            continue
        danger = atlas.danger[enemy, kind, apart]
        if danger > 0.0 and has_line_from(enemy, known.cell, kind, cell, los):
            total += trust * danger * known.blood / float(rules.blood[enemy])
    return total


@kernel
def gain_at(
    kind: int, cell: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row,
    rules: Row, cells: Rows, los: Rows, atlas: Row,
) -> float:  # fmt: skip
    """Expected points of the best shot from a cell at a known enemy, plus a share of the second best."""
    best, second = 0.0, 0.0
    for j in range(first_piece(1 - camp, game), end_piece(1 - camp, game)):
        trust = brain.trust[j]
        if trust <= 0.0:
            continue
        known = memory[camp, j]
        target = pieces[j].kind
        apart = cells_apart(cells, cell, known.cell)
        if apart >= atlas.danger.shape[2] or apart > reach_of_sight(kind, cell, target, known, rules, cells):
            continue
        value = trust * atlas.danger[kind, target, apart]
        if value > second and has_line_from(kind, cell, target, known.cell, los):
            if value > best:
                best, second = value, best
            else:
                second = value
    return best + 0.3 * second


@kernel
def weight_of(piece_kind: int, blood: int, rules: Row) -> float:
    """Fighting power of a piece: its value in points."""
    return float(rules.value[piece_kind]) * blood


@kernel
def own_power(cell: int, within: int, camp: int, game: Row, pieces: Rows, rules: Row, cells: Rows) -> float:
    """Power of own pieces within some cells of a cell, passengers included."""
    total = 0.0
    for i in range(first_piece(camp, game), end_piece(camp, game)):
        if pieces[i].blood > 0 and cells_apart(cells, pieces[i].cell, cell) <= within:
            total += weight_of(pieces[i].kind, pieces[i].blood, rules)
    return total


@kernel
def known_power(
    cell: int,
    within: int,
    camp: int,
    game: Row,
    pieces: Rows,
    memory: Rows,
    brain: Row,
    rules: Row,
    cells: Rows,
) -> float:
    """Power of known enemies within some cells of a cell, weighted by trust."""
    total = 0.0
    for j in range(first_piece(1 - camp, game), end_piece(1 - camp, game)):
        known = memory[camp, j]
        if brain.trust[j] > 0.0 and cells_apart(cells, known.cell, cell) <= within:
            total += brain.trust[j] * weight_of(pieces[j].kind, known.blood, rules)
    return total


@kernel
def enemy_near(
    cell: int, within: int, camp: int, game: Row, pieces: Rows, memory: Rows, brain: Row, cells: Rows
) -> bool:
    """A known enemy ground piece is within some cells of a cell."""
    for j in range(first_piece(1 - camp, game), end_piece(1 - camp, game)):
        if brain.trust[j] <= 0.0 or pieces[j].kind == PieceType.AEROCRAFT:
            continue
        if cells_apart(cells, memory[camp, j].cell, cell) <= within:
            return True
    return False
