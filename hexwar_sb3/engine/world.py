"""Everything about a game that does not change while it is played."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, Generic, TypeVar
from weakref import finalize

import numpy as np
import numpy.typing as npt

from hexwar_sb3.kernels import Rows
from hexwar_sb3.maps.cells import TravelTimes
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.maps.scenario import Scenario, ScenarioLike
from hexwar_sb3.maps.terrain import Terrain
from hexwar_sb3.maps.travel import no_times
from hexwar_sb3.rules import RuleSet, default_rules
from hexwar_sb3.rules.enums import Camp

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class World:
    """A scenario under a rule set, with the tables that kernels read."""

    scenario: Scenario
    ruleset: RuleSet
    terrain: Terrain
    _here: threading.local = field(default_factory=threading.local, init=False, repr=False)
    _spare: list[TravelTimes] = field(default_factory=list, init=False, repr=False)  # of threads that ended

    def __reduce__(self) -> tuple[Callable[..., World], tuple[Scenario, RuleSet]]:
        return load_world, (self.scenario, self.ruleset)  # tables are shared, and read-only, where it arrives

    def __copy__(self) -> World:
        return self  # nothing in it ever changes

    def __deepcopy__(self, memo: dict[int, object]) -> World:
        return self

    @cached_property
    def rules(self) -> Rows:
        """Compiled rules, one record [1]."""
        return self.ruleset.compiled()

    @cached_property
    def cells(self) -> Rows:
        """Records CELL [NC]."""
        return self.terrain.cells

    @cached_property
    def los(self) -> Any:
        """Line-of-sight bits [airborne ends, a, b // 8]."""
        return self.terrain.los

    @property
    def eta(self) -> TravelTimes:
        """Travel times of this thread; kernels fill them as they ask."""
        lent: Lent[TravelTimes] | None = getattr(self._here, "eta", None)
        if lent is None:
            lent = self._here.eta = Lent(self._spare, lambda: no_times(self.cells.size))
        return lent.one

    @cached_property
    def tables(self) -> tuple[Any, ...]:
        """(rules, cells, los): the last arguments of the engine's kernels."""
        return self.rules[0], self.cells, self.los

    @property
    def n_pieces(self) -> int:
        """Pieces of both camps."""
        return len(self.scenario.pieces)

    def side(self, camp: int) -> slice:
        """Indices of a camp's pieces; red's come first."""
        n_red = sum(piece.camp == Camp.RED for piece in self.scenario.pieces)
        return slice(0, n_red) if camp == Camp.RED else slice(n_red, self.n_pieces)

    @cached_property
    def sides(self) -> npt.NDArray[np.int64]:
        """Index of the first piece and behind the last, of red and of blue [2, 2]."""
        return np.array([(side.start, side.stop) for side in map(self.side, (Camp.RED, Camp.BLUE))])

    def piece_names(self, camp: int) -> tuple[str, ...]:
        """Names of a camp's pieces in slot order: "tank0", ..."""
        return tuple(piece.name for piece in self.scenario.pieces[self.side(camp)])

    @property
    def n_slots(self) -> int:
        """Slots that a camp's players see: pieces of the larger camp; the last ones of the smaller camp are empty."""
        return max(len(self.piece_names(camp)) for camp in (Camp.RED, Camp.BLUE))

    def force(self, camp: int) -> int:
        """What the pieces of a camp are worth at the start, points."""
        rows = (self.ruleset.pieces[piece.kind] for piece in self.scenario.pieces[self.side(camp)])
        return sum(row.value * row.blood for row in rows)


class Lent(Generic[T]):
    """One of a heap of things, or a new one; back on the heap when nobody holds this any more."""

    def __init__(self, heap: list[T], new: Callable[[], T]) -> None:
        try:
            self.one = heap.pop()
        except IndexError:
            self.one = new()
        finalize(self, heap.append, self.one)


def load_world(scenario: ScenarioLike, ruleset: RuleSet | None = None) -> World:
    """The world of a scenario by name, file or object.

    Raises:
        UnknownNameError: no such scenario.
        ScenarioFileError: a broken file.
    """
    if not isinstance(scenario, Scenario):
        is_file = str(scenario).endswith(".json")  # may change while we run
        scenario = load_scenario(scenario) if is_file else _builtin(str(scenario))
    return _world(_Content.of(scenario, ruleset or default_rules()))


@lru_cache(maxsize=16)
def _builtin(name: str) -> Scenario:
    return load_scenario(name)


@dataclass(frozen=True)
class _Content:
    """A scenario under rules, equal where everything that matters is equal."""

    names: tuple[str, str]
    hashes: tuple[str, str]
    scenario: Scenario = field(compare=False)
    ruleset: RuleSet = field(compare=False)

    @classmethod
    def of(cls, scenario: Scenario, ruleset: RuleSet) -> _Content:
        names = scenario.name, scenario.hexmap.name
        return cls(names, (scenario.hash, ruleset.hash), scenario, ruleset)


@lru_cache(maxsize=16)
def _world(content: _Content) -> World:
    scenario, ruleset = content.scenario, content.ruleset
    return World(scenario, ruleset, Terrain(scenario.hexmap, ruleset))
