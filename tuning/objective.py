"""One trial: the lower level learns with the trial's alpha and beta, then the upper level over it (learning.md, section 6)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import optuna
from optuna.trial import BaseTrial
from stable_baselines3.common.callbacks import CallbackList

from hexwar_sb3.algorithms.hierarchical import LOWER_DEFAULTS, HierarchicalQMIX
from hexwar_sb3.algorithms.presets import Preset
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.callbacks.shares import shares_of
from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.evaluation.panel import Terms, play_panel
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.league.work import one_thread
from hexwar_sb3.play.frozen import FrozenPolicy

FORCE = 134  # points that the pieces of a camp are worth: a margin of it counts as 1
LOWER_TICKS = 7_500_000  # game ticks that the lower level's schedules are made for


@dataclass(frozen=True, kw_only=True)
class Common:
    """What all trials of a study have in common."""

    scenario: str = "plain"
    opponents: tuple[str, ...] = ("MA1", "MA2")  # of the training
    panel: tuple[str, ...] = ("MA1", "MA2", "HRL0")  # that judges
    lower_ticks: int = 2_500_000  # game ticks that the lower level learns, of all games together
    upper_ticks: int = 9_000_000  # and then the upper level; a game has 1,800
    reports: int = 5  # evaluations on the way; after half of them a trial may be pruned
    report_games: int = 40  # of each of them against each opponent and in each colour
    final_games: int = 200  # and of the last one, the objective
    seed: int = 0  # of every trial: points differ, games and first weights do not

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ConfigError: one is out of its range.
        """
        for name in ("lower_ticks", "upper_ticks", "reports", "report_games", "final_games"):
            check_whole(name, getattr(self, name), least=1)
        seed_for(Purpose.TUNING, self.seed)

    @property
    def warm_up(self) -> int:
        """Game ticks before any trial is pruned: the first reports say little (the best may begin as the worst)."""
        return self.lower_ticks + self.upper_ticks * 2 // 5

    @property
    def games(self) -> int:
        """That the upper level's ticks make."""
        return self.upper_ticks // load_world(self.scenario).scenario.game_ticks

    def terms(self, preset: Preset, games: int) -> Terms:
        """Of games that judge."""
        return Terms(
            scenario=self.scenario,
            games=games,
            seed=self.seed,
            purpose=Purpose.TUNING,
            decision_ticks=preset.decision_ticks,
            spots=preset.env.get("spots", Terms.spots),
            early=preset.env.get("decisions") == "event",
        )

    def judge(self, policy: FrozenPolicy, preset: Preset, games: int) -> CampResult:
        """Play the panel in both colours."""
        return play_panel(policy, self.panel, self.terms(preset, games), name="trial").total


def objective(trial: BaseTrial, preset: Preset, common: Common, folder: Path) -> float:
    """Train and judge a point: mean margin over the panel, in forces.

    Args:
        trial: whose suggestions `preset` holds; hears of every evaluation.
        preset: with the trial's point.
        common: what all trials share.
        folder: gets the policy, also of a pruned trial.

    Raises:
        TrialPruned: it is not worth going on.
        TrainingError: weights or gradients are not finite.
    """
    with one_thread():
        model, report = new_model(preset, common), _Report(trial, preset, common)
        shares = shares_of(preset, common.games)
        try:
            model.learn(common.upper_ticks // preset.decision_ticks, callback=CallbackList([*shares, report]))
        except optuna.TrialPruned:
            report.policy().save(folder)
            raise
        finally:
            trial.set_user_attr("ticks", model.game_ticks)
        policy = report.policy()
        policy.save(folder)
        result = common.judge(policy, preset, common.final_games)
    trial.set_user_attr("win_rate", result.win_rate.value)
    trial.set_user_attr("points_held", float(result.points_held.mean()))
    trial.set_user_attr("agreement", model.leader_agreement)
    return result.mean_margin.value / FORCE


def check(preset: Preset, common: Common) -> None:
    """Make what a trial needs, and let all players look at the first position: before the first trial.

    Raises:
        ConfigError: a setting is out of its range, or a player does not fit the scenario; and as `make_player`.
    """
    new_model(preset, common)
    common.terms(preset, 1).check_fit((*common.opponents, *common.panel))


def new_model(preset: Preset, common: Common) -> HierarchicalQMIX:
    """A beginner whose lower level learns first, and leads whatever it has learned."""
    env = make_vec_env(
        TASK_ENV,
        n_envs=preset.n_envs,
        seed=seed_for(Purpose.TRAINING, common.seed),
        scenario=common.scenario,
        side="both",
        opponent=list(common.opponents),
        decision_ticks=preset.decision_ticks,
        demo_bot="MA2",
        privileged_state=True,
        **preset.env,
    )
    shorter = common.lower_ticks / LOWER_TICKS
    schedules = {
        name: max(1, int(LOWER_DEFAULTS[name] * shorter))
        for name in ("learning_rate_steps", "exploration_steps")
    }
    return HierarchicalQMIX(
        "HierarchicalPolicy",
        env,
        seed=common.seed,
        phase_ticks=(common.upper_ticks, common.lower_ticks),
        lower_first=True,
        takeover=0.0,
        tie=preset.tie,
        route_kwargs={"scenario": [common.scenario], **preset.route},
        lower_kwargs={**schedules, **preset.lower_learner},
        **preset.learner_for(common.games, common.scenario),
    )


class _Report(EverySteps):
    """Judges the model now and then, tells the trial, and ends it if it is pruned."""

    def __init__(self, trial: BaseTrial, preset: Preset, common: Common) -> None:
        super().__init__(max(1, common.upper_ticks // preset.decision_ticks // (common.reports + 1)))
        self.trial, self.preset, self.common = trial, preset, common
        self.reported = 0

    def policy(self) -> FrozenPolicy:
        """What plays for the model now."""
        rules = load_world(self.common.scenario).ruleset.hash
        about = {**self.common.terms(self.preset, 1).about(), "rules": rules, "side": "both"}
        return cast("HierarchicalQMIX", self.model).policy.freeze(**about)

    def fire(self) -> None:
        if self.reported == self.common.reports:  # the end: the objective's own games come
            return
        self.reported += 1
        result = self.common.judge(self.policy(), self.preset, self.common.report_games)
        upper = self.common.upper_ticks * self.reported // (self.common.reports + 1)
        self.trial.report(result.mean_margin.value / FORCE, self.common.lower_ticks + upper)
        if self.trial.should_prune():
            raise optuna.TrialPruned
