"""A player against a panel of opponents, in both colours: one cell a pairing and colour."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.results import CampResult

BOTS = ("MA1", "MA2")  # that every player is measured against
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
    evaluation: Evaluation,
    *,
    name: str,
    threads: int = 1,
    progress: Callable[[int], object] | None = None,
) -> Panel:
    """Play every opponent in every camp of the player, on the same seeds each time.

    Args:
        player: a name, a folder, a policy or a model (as in `play_match`).
        opponents: names or folders.
        evaluation: terms, games a cell, seed, and so on.
        name: what the player is called in tables.
        threads: cells side by side; more than 1 for players that keep nothing from decision to decision.
        progress: called with the number of games of each part that was played.
    """
    cells = [(opponent, camp) for opponent in opponents for camp in evaluation.camps]
    played: dict[Cell, CampResult] = {}
    with _side_by_side(threads) as each:
        results = each(lambda cell: evaluation.play_as(cell[1], player, cell[0]), cells)
        for cell, result in zip(cells, results, strict=True):
            played[cell] = result
            if progress is not None:
                progress(result.games)
    return Panel(name, played)


@contextmanager
def _side_by_side(threads: int) -> Iterator[Callable[..., Iterable[CampResult]]]:
    """`map` in so many threads; if the block ends early, by Ctrl-C for example, what has not begun never does."""
    if threads == 1:
        yield map
        return
    pool = ThreadPoolExecutor(threads)
    try:
        yield pool.map
    finally:
        pool.shutdown(cancel_futures=True)
