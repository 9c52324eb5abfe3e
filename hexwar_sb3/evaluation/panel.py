"""A player against a panel of opponents, in both colours: one cell a pairing and colour."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError, PolicyFileError
from hexwar_sb3.evaluation.matches import check_games, play_match, player_name
from hexwar_sb3.evaluation.results import CampResult, MatchResult
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.play.arena import Arena, Setup
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.play.records import DECISION_TICKS
from hexwar_sb3.players.player import Player, make_player
from hexwar_sb3.tasks.spots import SPOTS

CAMPS = ("red", "blue")
BOTS = ("MA1", "MA2")  # that every player is measured against
CONSTANT_PLANS = ("all-main", "half-half", "two-hold")
"""Players that follow one fixed plan; every table shows them beside a learned one."""

MAX_DIGITS = 6  # of a number in a policy's folder
Cell = tuple[str, str]  # opponent, camp of the player


@dataclass(frozen=True, kw_only=True)
class Terms:
    """What all cells of a table have in common."""

    scenario: str = "plain"  # its name or its path
    games: int = 2000  # a cell
    seed: int = 0  # the user's, shifted into the range of the purpose
    purpose: Purpose = Purpose.REPORT
    decision_ticks: int = DECISION_TICKS  # between two decisions of a policy
    spots: int = SPOTS  # k of G^L(k)
    early: bool = False  # policies also decide after an own loss or an ended task
    camps: tuple[str, ...] = CAMPS  # that the player takes

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ConfigError: one is out of its range.
        """
        check_games(self.games)
        check_whole("decision_ticks", self.decision_ticks, least=1)
        seed_for(self.purpose, self.seed)

    def about(self) -> dict[str, str]:
        """What a policy's folder says of how it was trained, so that `trained_terms` finds it."""
        early = "yes" if self.early else "no"
        numbers = {"decision_ticks": str(self.decision_ticks), "spots": str(self.spots)}
        return {"scenario": self.scenario, **numbers, "early": early}

    def play(self, red: object, blue: object, decision_ticks: tuple[int, int] | None = None) -> MatchResult:
        """Play one cell; where red and blue decide at other times than these terms say, as they do."""
        return play_match(
            red,
            blue,
            self.games,
            self.scenario,
            self.seed,
            purpose=self.purpose,
            decision_ticks=decision_ticks or self.decision_ticks,
            spots=self.spots,
            early=self.early,
        )

    def play_as(self, camp: str, player: object, opponent: object) -> CampResult:
        """Play one cell, and return what the player of this camp reached; the opponent decides as it was trained."""
        its = trained_terms(opponent).get("decision_ticks", self.decision_ticks)
        if camp == "red":
            return self.play(player, opponent, (self.decision_ticks, its)).red
        return self.play(opponent, player, (its, self.decision_ticks)).blue

    def check_opponents(self, opponents: Iterable[object]) -> None:
        """Let opponents look at the first position, before games are played that would only lead there.

        Raises:
            ConfigError: one does not fit the scenario or these terms; and as `make_player`.
        """
        self.check_fit(opponents, [CAMPS[1 - CAMPS.index(camp)] for camp in self.camps])

    def check_fit(self, players: Iterable[object], camps: Iterable[str] = CAMPS) -> None:
        """Let players look at the first position of each of these camps.

        Raises:
            ConfigError: one does not fit; and as `make_player`.
        """
        ticks = self.decision_ticks, self.decision_ticks
        setup = Setup(decision_ticks=ticks, spots=self.spots, early=self.early)
        arena = Arena(load_world(self.scenario), 1, setup)
        for player in players:
            seat = make_player(player)
            for camp in camps:
                if isinstance(seat, Player):
                    seat.reset()
                try:
                    arena.begin(0, 0, *(seat if one == camp else None for one in CAMPS))
                    arena.ask([0])
                except ConfigError as error:
                    raise ConfigError(
                        f"{player_name(player)} as {camp} on {self.scenario}: {error}"
                    ) from error

    def record(self, red: object, blue: object) -> Replay:
        """Play the first game of a cell and write it down."""
        seed = seed_for(self.purpose, self.seed)
        how: dict[str, Any] = {
            "decision_ticks": self.decision_ticks,
            "spots": self.spots,
            "early": self.early,
        }
        return record_game(red, blue, self.scenario, seed, **how)


def trained_terms(player: object) -> dict[str, Any]:
    """Scenario, decision ticks, spots and early decisions of a policy's training, as far as its folder says.

    Raises:
        PolicyFileError: a number of it is none; and as `make_player`.
    """
    about = getattr(make_player(player), "about", {})
    terms: dict[str, Any] = {"scenario": about["scenario"]} if "scenario" in about else {}
    for name in ("decision_ticks", "spots"):
        if name in about:
            terms[name] = _whole(str(player), name, about[name])
    return {**terms, "early": about.get("early") == "yes"}


def _whole(folder: str, name: str, text: str) -> int:
    if not text.isdecimal() or len(text) > MAX_DIGITS or int(text) < 1:
        expected = f"a whole number, at least 1, of at most {MAX_DIGITS} digits"
        raise PolicyFileError(folder, f"about.{name}", found=repr(text[:40]), expected=expected)
    return int(text)


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
    terms: Terms,
    *,
    name: str,
    threads: int = 1,
    progress: Callable[[int], object] | None = None,
) -> Panel:
    """Play every opponent in every camp of the player, on the same seeds each time.

    Args:
        player: a name, a folder, a policy or a model (as in `play_match`).
        opponents: names or folders.
        terms: scenario, games a cell, seed, and so on.
        name: what the player is called in tables.
        threads: cells side by side; more than 1 for players that keep nothing from decision to decision.
        progress: called with the number of games of each part that was played.
    """
    cells = [(opponent, camp) for opponent in opponents for camp in terms.camps]
    played: dict[Cell, CampResult] = {}
    with _side_by_side(threads) as each:
        results = each(lambda cell: terms.play_as(cell[1], player, cell[0]), cells)
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
