"""One trial: several short trainings of both levels, one a seed, in a race with the other trials (learning.md, section 6)."""

from __future__ import annotations

import gc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import optuna
from optuna.trial import BaseTrial

from hexwar_sb3.algorithms.hierarchical import LOWER_DEFAULTS, HierarchicalQMIX
from hexwar_sb3.algorithms.presets import Preset
from hexwar_sb3.callbacks.shares import shares_of
from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.roster import SIDES
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import TASK_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.opponents import broad_mixture, with_weights
from hexwar_sb3.evaluation.panel import play_panel
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.league.work import one_thread
from hexwar_sb3.players.frozen import FrozenPolicy

LOWER_TICKS = 7_500_000  # game ticks that the lower level's schedules are made for
PANEL = ("MA1", "MA2", "nearest", "two-hold", "drawn", "HRL0")


@dataclass(frozen=True, kw_only=True)
class Common:
    """What all trials of a study have in common."""

    scenario: str = "plain"
    opponents: tuple[str, ...] = ()  # of the trainings, NAME or NAME=WEIGHT; none: the broad mixture
    panel: tuple[str, ...] = PANEL  # that judges
    trainings: int = 4  # of a trial, one a seed
    lower_ticks: int = (
        1_250_000  # game ticks that the lower level learns in a training, of all games together
    )
    upper_ticks: int = 4_500_000  # and then the upper level; a game has 1,800
    final_games: int = 100  # that judge a training, against each of the panel and in each colour
    seed: int = 0  # of the first training of every trial: points differ, games and first weights do not

    def __post_init__(self) -> None:
        """Check numbers and weights; write the opponents out, for a study to be known by them.

        Raises:
            ConfigError: a number is out of its range, an opponent is not written as one, or nobody judges.
        """
        for name in ("trainings", "lower_ticks", "upper_ticks", "final_games"):
            check_whole(name, getattr(self, name), least=1)
        for seed in (self.seed, self.seed + self.trainings - 1):
            seed_for(Purpose.TUNING, seed)
        if not self.opponents:
            object.__setattr__(self, "opponents", broad_mixture(self.scenario))
        with_weights(self.opponents)
        if not self.panel:
            raise ConfigError("name at least one player of the panel")

    @property
    def seeds(self) -> range:
        """Of the trainings of every trial."""
        return range(self.seed, self.seed + self.trainings)

    @property
    def fresh_seeds(self) -> range:
        """As many that no trial was judged by: those that follow."""
        return range(self.seeds.stop, self.seeds.stop + self.trainings)

    @property
    def ticks(self) -> int:
        """Game ticks of a trial that is completed."""
        return self.trainings * (self.lower_ticks + self.upper_ticks)

    @property
    def force(self) -> float:
        """Points that the pieces of a camp are worth, mean of both: a margin of it counts as 1."""
        world = load_world(self.scenario)
        return fmean(world.force(camp) for camp in SIDES)

    @property
    def games(self) -> int:
        """That the upper level's ticks make in a training."""
        return self.upper_ticks // load_world(self.scenario).scenario.game_ticks

    def evaluation(self, preset: Preset, games: int, seed: int) -> Evaluation:
        """Games that judge."""
        return Evaluation(terms=preset.terms(self.scenario), games=games, seed=seed, purpose=Purpose.TUNING)

    def judge(self, policy: FrozenPolicy, preset: Preset, seed: int) -> CampResult:
        """Play the panel in both colours."""
        return play_panel(
            policy, self.panel, self.evaluation(preset, self.final_games, seed), name="training"
        ).total


@dataclass(frozen=True, kw_only=True)
class Training:
    """What a training came to, over all games of the panel."""

    margin: float  # mean, in forces
    win_rate: float  # 0..1
    points_held: float  # mean number of control points at the end of a game
    agreement: float  # share of the lower level's moves that lie on a fastest way


def objective(trial: BaseTrial, preset: Preset, common: Common, folder: Path) -> float:
    """Train and judge a point, seed by seed: mean margin over its trainings, in forces.

    A race: all trials have the same seeds in the same order, and each reports the mean of its trainings so far at step
    1, 2, ..., their number. So a pruner compares trials over equal seeds, and what it breaks off has trained less, not
    shorter: trainings of one point spread by more than points differ, and a part of a training says little of its end.

    Args:
        trial: whose suggestions `preset` holds; hears of every training.
        preset: with the trial's point.
        common: what all trials share.
        folder: gets a policy for each training, by its seed, also of a pruned trial.

    Raises:
        TrialPruned: it is not worth going on.
        TrainingError: weights or gradients are not finite.
    """
    done, ticks = list[Training](), list[int]()
    try:
        for seed in common.seeds:
            done.append(train_once(preset, common, seed, folder / str(seed), ticks.append))
            _report(trial, done)
            if len(done) < common.trainings and trial.should_prune():  # else there is nothing left to save
                raise optuna.TrialPruned
    finally:
        trial.set_user_attr("ticks", sum(ticks))
    return fmean(one.margin for one in done)


def train_once(
    preset: Preset, common: Common, seed: int, folder: Path, spent: Callable[[int], object] = lambda _: None
) -> Training:
    """Train both levels with one seed, leave the policy, and let it play the panel.

    Args:
        preset: with the point.
        common: budget, opponents and panel.
        seed: of weights and games.
        folder: gets the policy.
        spent: told the game ticks of both levels, also of a training that fails.

    Raises:
        TrainingError: weights or gradients are not finite.
    """
    gc.collect()  # the model of the training before and its replay, which hold each other
    with one_thread():
        model = new_model(preset, common, seed)
        try:
            model.learn(common.upper_ticks // preset.decision_ticks, callback=shares_of(preset, common.games))
        finally:
            spent(model.game_ticks)
        rules = load_world(common.scenario).ruleset.hash
        about = preset.terms(common.scenario).about()
        policy = model.policy.freeze(**about, rules=rules, side="both", seed=str(seed))
        policy.save(folder)
        result = common.judge(policy, preset, seed)
    return Training(
        margin=result.mean_margin.value / common.force,
        win_rate=result.win_rate.value,
        points_held=float(result.points_held.mean()),
        agreement=model.leader_agreement,
    )


def check(preset: Preset, common: Common) -> None:
    """Make what a trial needs, and let all players look at the first position: before the first trial.

    Raises:
        ConfigError: a setting is out of its range, or a player does not fit the scenario; and as `make_player`.
    """
    new_model(preset, common, common.seed)
    common.evaluation(preset, 1, common.seed).check_fit((*with_weights(common.opponents), *common.panel))


def new_model(preset: Preset, common: Common, seed: int) -> HierarchicalQMIX:
    """A beginner whose lower level learns first, and leads whatever it has learned."""
    env = make_vec_env(
        TASK_ENV,
        seed=seed_for(Purpose.TRAINING, seed),
        side="both",
        opponent=list(with_weights(common.opponents).items()),
        **preset.env_for(common.scenario),
    )
    shorter = common.lower_ticks / LOWER_TICKS
    schedules = {
        name: max(1, int(LOWER_DEFAULTS[name] * shorter))
        for name in ("learning_rate_steps", "exploration_steps")
    }
    return HierarchicalQMIX(
        "HierarchicalPolicy",
        env,
        seed=seed,
        phase_ticks=(common.upper_ticks, common.lower_ticks),
        lower_first=True,
        takeover=0.0,
        tie=preset.tie,
        route_kwargs={"scenario": [common.scenario], **preset.route},
        lower_kwargs={**schedules, **preset.lower_learner},
        **preset.learner_for(common.games, common.scenario),
    )


def _report(trial: BaseTrial, done: Sequence[Training]) -> None:
    """Tell a trial of its trainings so far."""
    for name in ("win_rate", "points_held", "agreement"):
        trial.set_user_attr(name, fmean(getattr(one, name) for one in done))
    margins = [one.margin for one in done]
    trial.set_user_attr("trainings", margins)
    trial.report(fmean(margins), len(done))
