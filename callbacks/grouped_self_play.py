"""Grouped self-play as a callback of one model: it is a league's first model, and in the end its champion."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.opponents import broad_mixture
from hexwar_sb3.folders import holding
from hexwar_sb3.league.league import League
from hexwar_sb3.league.member import BOTH, CAMPS, as_member
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.players.frozen import FrozenPolicy


class GroupedSelfPlayCallback(BaseCallback):
    """Plays a league before the model learns on (III-C, Fig. 6): groups, round robin, selection, iteration by iteration.

    The model as it is when `learn` begins is one of the models that the league begins with; further ones may be given,
    as the paper has several from "different random processes". When the league is over, the model has the weights of
    the best model of its camp (of red's, where its env plays both), and `champions` has the best of both. The env
    steps of the league count as the model's: `learn(1)` returns after it, a larger number learns on. The mixer stays
    the model's own, which knows nothing of the champion: fit it again (`QMIX.refit_mixer`) before learning on.

    The folder is the state: the same call goes on where a league was stopped, and ends the same. Each `learn` with this
    callback takes the champion over anew, whatever the model has learned since.

    Args:
        folder: of the league.
        settings: of the league; the scenario must be the env's, the widths the model's. Else the usual ones, with the
            model's widths: split, if it plays one camp.
        starters: further models to begin with, policy folders by name.
        jobs: groups, then matches, side by side: processes of joblib.

    Raises:
        BusyError: another process works on the league (from `learn`).

    Example:
        >>> from hexwar_sb3.league import LeagueSettings
        >>> callback = GroupedSelfPlayCallback("league", LeagueSettings(iterations=2))

        `model.learn(1, callback=callback, reset_num_timesteps=False)` plays the league; then `callback.champions` are there.
    """

    def __init__(
        self,
        folder: str | Path,
        settings: LeagueSettings | None = None,
        *,
        starters: Mapping[str, Path] | None = None,
        jobs: int = 1,
    ) -> None:
        super().__init__()
        self.folder, self.given, self.jobs = Path(folder), settings, jobs
        self.starters = dict(starters or {})
        self.champions: dict[str, FrozenPolicy] = {}

    def _on_training_start(self) -> None:
        model = self._model()
        played = cast("TaskSettings", cast("VecEnv", model.get_env()).get_attr("games")[0].settings)
        own: dict[str, Any] = {"split": played.side != BOTH, **model.policy.sizes}
        met = broad_mixture(played.scenario)
        self.settings = self.given or LeagueSettings(opponents=met, **own)
        if played.scenario != self.settings.scenario:
            raise ConfigError(f"the league plays {self.settings.scenario}, the model's env {played.scenario}")
        widths = {"hidden": self.settings.hidden, "embed": self.settings.embed}
        if model.policy.sizes != widths:
            raise ConfigError(
                f"the league's models have {widths}, the model {model.policy.sizes}: make them alike"
            )
        with holding(self.folder, "league"):
            self._play(model, played)

    def _play(self, model: QMIX, played: TaskSettings) -> None:
        own = self.folder / "learner"
        if not (self.folder / "league.json").exists():  # else it has begun, with the learner as it was then
            as_member(model, side=played.side, **played.about()).save(own)
        league = League.create(self.folder, self.settings, {"learner": own, **self.starters})
        league.run(self.jobs, after=lambda k: self._log(league, k))
        last = league.kept(self.settings.iterations)
        self.champions = {camp: last[camp][0].policy() for camp in CAMPS}
        camp = "blue" if played.side == "blue" else "red"
        model.take_over(self.champions[camp])
        model.num_timesteps += league.env_steps

    def _model(self) -> QMIX:
        if not isinstance(self.model, QMIX):
            raise ConfigError(
                f"grouped self-play is for QMIX and HierarchicalQMIX, got {type(self.model).__name__}"
            )
        return self.model

    def _log(self, league: League, k: int) -> None:
        found = league.standings(k)
        for camp in CAMPS:
            self.logger.record(f"league/{camp}_win_rate", found[camp][0]["win_rate"])
            self.logger.record(f"league/{camp}_margin", found[camp][0]["mean_margin"])
        self.logger.record("league/iteration", k)
        self.logger.dump(k)

    def _on_step(self) -> bool:
        return True
