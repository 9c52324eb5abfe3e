"""A player against a panel of opponents, in both colours: one cell a pairing and colour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hexwar_sb3.evaluation.matches import play_match
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.evaluation.seeds import Purpose
from hexwar_sb3.maps.scenario import Scenario

CAMPS = ("red", "blue")
CONSTANT_PLANS = ("all-main", "half-half", "two-hold")
"""Players that follow one fixed plan; every table shows them beside a learned one."""

Cell = tuple[str, str]  # opponent, camp of the player


@dataclass(frozen=True, eq=False)
class Panel:
    """What one player reached, by opponent and by the camp that it played."""

    player: str
    cells: Mapping[Cell, CampResult]

    @property
    def total(self) -> CampResult:
        """All games together."""
        return CampResult.joined(self.cells.values())

    def against(self, opponent: str) -> CampResult:
        """The games against one opponent, both colours together."""
        return CampResult.joined(result for (name, _), result in self.cells.items() if name == opponent)

    def summary(self) -> list[dict[str, Any]]:
        """One JSON object a cell."""
        return [
            {"player": self.player, "opponent": opponent, "camp": camp, **result.summary()}
            for (opponent, camp), result in self.cells.items()
        ]


def play_panel(
    player: object,
    opponents: Sequence[str],
    *,
    name: str,
    games: int,
    scenario: str | Scenario,
    seed: int = 0,
    purpose: Purpose = Purpose.REPORT,
    camps: Sequence[str] = CAMPS,
) -> Panel:
    """Play `games` games a cell: every opponent, every camp of the player, the same seeds each time.

    Args:
        player: a name, a folder, a policy or a model (as in `play_match`).
        opponents: names or folders.
        name: what the player is called in tables.
        games: games a cell.
        scenario: a scenario, its name or its path.
        seed: the user's seed, shifted into the range of the purpose.
        purpose: what the games are for.
        camps: the camps that the player takes.
    """
    cells: dict[Cell, CampResult] = {}
    for opponent in opponents:
        for camp in camps:
            red, blue = (player, opponent) if camp == "red" else (opponent, player)
            match = play_match(red, blue, games=games, scenario=scenario, seed=seed, purpose=purpose)
            cells[opponent, camp] = match.red if camp == "red" else match.blue
    return Panel(name, cells)
