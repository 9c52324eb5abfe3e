"""What an iteration of a league does: who learns with whom against whom, and which games select (III-C, Fig. 6)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from hexwar_sb3.algorithms.presets import FALLS
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.parcels import at_hand
from hexwar_sb3.evaluation.seeds import Purpose
from hexwar_sb3.league.folder import LeagueFolder, group_name
from hexwar_sb3.league.group import GroupSpec
from hexwar_sb3.league.member import CAMPS, Member
from hexwar_sb3.league.work import Opponents, env_settings, env_steps, job_seed
from hexwar_sb3.players.terms import Terms, trained_terms
from hexwar_sb3.tasks.hotspots import is_mirrored


@dataclass(frozen=True)
class Agenda(LeagueFolder):
    """What follows from a league's settings and from the iterations that are done."""

    def specs(self, k: int) -> list[GroupSpec]:
        """What the groups of an iteration depend on: the models that were kept, and those before them."""
        kept, settings = self.kept(k - 1), self.settings
        others = {camp: self.others(k, camp) for camp in CAMPS}
        return [
            GroupSpec(
                members={camp: kept[camp][places[n % len(places)]] for n, camp in enumerate(CAMPS)},
                partners=() if settings.split else tuple(kept["red"]),
                others=others,
                partner_share=settings.partner_share,
                split=settings.split,
                games=settings.games,
                fill_games=settings.fill_games,
                refit_games=settings.refit_games,
                seed=(settings.seed, k, *places),
                folder=self.group(k, group_name(k, *places)),
                env=self.env(),
                learner=self.learner(settings.games),
                about=self.terms.about(),
            )
            for places in self.groups
        ]

    def learner(self, games: int) -> dict[str, Any]:
        """Arguments of QMIX for so many games."""
        falls = {name: max(1, int(share * games)) for name, share in FALLS.items()}
        widths = {"hidden": self.settings.hidden, "embed": self.settings.embed}
        return {**falls, **self.settings.learner, "policy_kwargs": {**widths, "mirrored": self._is_mirrored}}

    @property
    def _is_mirrored(self) -> bool:
        """Whether models do not see which camp they play."""
        return is_mirrored(load_world(self.settings.scenario).scenario)

    def others(self, k: int, camp: str) -> Opponents:
        """Whom models of a colour meet beside their partners: the best of the iterations before, and opponents."""
        settings = self.settings
        past = dict.fromkeys((member.folder for member in self._best_before(k, camp)), 1.0)
        found: list[tuple[object, float]] = []
        for players, share in ((past, settings.past_share), (settings.weights, settings.opponents_share)):
            total = sum(players.values())
            found += [(player, share * weight / total) for player, weight in players.items() if share > 0]
        return found

    def _best_before(self, k: int, camp: str) -> list[Member]:
        """The best of the other colour, of each iteration before k."""
        enemy = CAMPS[1 - CAMPS.index(camp)]
        return [self.kept(before)[enemy][0] for before in range(k)]

    @property
    def terms(self) -> Terms:
        """Of all games: as the first models were trained."""
        return replace(trained_terms(self.starters("red")[0].folder), scenario=self.settings.scenario)

    def evaluation(self, k: int, games: int) -> Evaluation:
        """Games that select in iteration k."""
        seed = job_seed(self.settings.seed, k)
        return Evaluation(terms=self.terms, games=games, seed=seed, purpose=Purpose.SELECTION)

    @property
    def env_steps(self) -> int:
        """Env steps of all groups together, mixers that were refitted apart."""
        groups = len(self.groups) * self.settings.iterations
        return (1 + self.settings.split) * groups * env_steps(self.env(), self.settings.games)

    def env(self) -> dict[str, Any]:
        """Settings of the task env."""
        return {
            **env_settings(
                replace(self.terms, scenario=at_hand(self.settings.scenario)), self.settings.n_envs
            ),
            "priority": self.settings.priority,
        }
