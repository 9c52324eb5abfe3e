"""What a training can be told."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import tyro

from hexwar_sb3.algorithms.preset_file import check_preset, load_preset
from hexwar_sb3.algorithms.presets import OF_POLICY, PARTS, Preset
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.settings import ConstantPlans, Json, ScenarioName, Seed, check_name
from hexwar_sb3.errors import ConfigError, FileFormatError, HexWarError, UnknownNameError
from hexwar_sb3.evaluation.opponents import broad_mixture, named, sizes, with_weights
from hexwar_sb3.evaluation.seeds import Purpose
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.maps.spec import STANDARD

LOWER_SCENARIOS = (*STANDARD, "hills@1", "hills@2", "hills@3", "hills@4", "hills@5")
"""Maps that the lower level learns on, so that it finds its way on those that it never saw."""
LEARNED = "learned"  # `lower`: the model's own
LOWERS = (LEARNED, "heuristic")
if TYPE_CHECKING:
    from hexwar_sb3.evaluation.matches import Evaluation
    from hexwar_sb3.players.terms import Terms

Steps = Annotated[
    int, tyro.conf.arg(aliases=("-n",), help="env steps: decisions of the camp, 24 make a game")
]
T = TypeVar("T")
OfPreset = Annotated[T | None, tyro.conf.arg(help_behavior_hint="(default: the preset's)")]
StartFrom = Annotated[
    Path | None,
    tyro.conf.arg(aliases=("-i",), help="model.zip to start from, with its own learner settings"),
]


@dataclass(frozen=True, kw_only=True)
class TrainSettings:
    """Settings of a training; those without a value are the preset's."""

    n_timesteps: Steps = 240_000
    seed: Seed = 0
    scenario: ScenarioName = "plain"
    side: Literal["red", "blue", "both"] = "both"  # camp of the commander; both: in turn
    # bots' names or policy folders, NAME=WEIGHT; each game draws one; "self": copies of this commander as it was before;
    # else a broad mixture: MA1=6 MA2=6 drawn=3 drawn-plan=3 nearest defender all-main half-half, and HRL0=2 where it fits
    opponents: tuple[str, ...] | None = None
    self_freq: int = 24_000  # env steps between two copies of itself, where "self" is an opponent
    # "default", a file of `hexwar tune export`, or "paper": the numbers of section IV to the letter; its learning rate
    # of 0.1 learns nothing with Adam
    preset: str = "default"
    decision_ticks: OfPreset[int] = None  # Delta-t, ticks between two decisions
    n_envs: OfPreset[int] = None  # games side by side
    reward: OfPreset[Literal["paper", "net"]] = None  # margin by eq. (1), or own minus enemy
    decisions: OfPreset[Literal["fixed", "event"]] = None  # event: also after an own loss or an ended task
    # k of G^L(k), the number of cells that tasks lead to beside the control points
    spots: OfPreset[int] = None
    # share of the games in which each piece first goes to a random cell of G^B; it falls to 0 by half of the training
    warm_start: OfPreset[float] = None
    demo_share: OfPreset[float] = None  # share of the first games in which somebody shows how to play
    demo_games: OfPreset[int] = None  # number of those first games
    # who plays these demonstrations: bots, replays of people or others (*.hwr), or folders of them, NAME or NAME=WEIGHT
    demo: tuple[str, ...] = ("MA2",)

    lower: OfPreset[str] = None  # who leads the pieces: "learned", "heuristic", or the folder of a policy
    phase_ticks: OfPreset[tuple[int, int]] = None  # game ticks of the upper, of the lower level, in turn
    # maps that the lower level learns on; else the scenario, the built-in ones and more hills
    lower_scenarios: tuple[str, ...] = ()
    tie: OfPreset[float] = None  # share of beta: answers of the lower level whose values are nearer are equal
    alpha: OfPreset[float] = None  # weight of the camp's reward in r_L, eq. (5)
    beta: OfPreset[float] = None  # cost of a step in r_L, eq. (5)
    # what a step is in eq. (5): the time of a hop on open ground, or a hop
    beta_per: OfPreset[Literal["base_hop", "hop"]] = None
    ways: OfPreset[bool] = None  # the lower level's state holds the fastest ways, or the six neighbours alone
    lower_gamma: OfPreset[float] = None  # discount of the lower level for the time of a hop on open ground

    # joins the pieces' values into the camp's
    mixer: OfPreset[Literal["qmix", "vdn", "iql", "qplex", "ow-qmix"]] = None
    hidden: OfPreset[int] = None  # width of the networks
    embed: OfPreset[int] = None  # width of a task's embedding
    # the networks do not see which camp they play; where the preset says nothing: if the map is its own mirror image
    mirrored: OfPreset[bool] = None
    learning_rate: OfPreset[float] = None  # of Adam, at the start
    final_learning_rate: OfPreset[float] = None  # learning rate at the end
    batch_size: OfPreset[int] = None  # transitions of an update
    # share of the network that an update adds to its mean, which is evaluated and shared
    ema_tau: OfPreset[float] = None
    gamma: OfPreset[float] = None  # discount of 75 ticks
    n_steps: OfPreset[int] = None  # env steps of a transition
    td_lambda: OfPreset[float] = None  # of lambda-returns over n_steps; else n-step returns
    double_q: OfPreset[bool] = None  # the online network picks the next tasks
    gradient_steps: OfPreset[int] = None  # updates a finished game
    buffer_size: OfPreset[int] = None  # env steps that the replay keeps, 9 KB each with seven against seven
    stickiness: OfPreset[float] = None  # probability that an exploring piece keeps its random task
    exploration_initial_eps: OfPreset[float] = None  # probability of a random task at the start
    exploration_final_eps: OfPreset[float] = None  # probability of a random task in the end
    # games until epsilon is at its last value; 40 % of the training, where the preset says nothing
    exploration_episodes: OfPreset[int] = None
    # share of the games, at the start, in which a squad holds a spot together
    squad_initial_share: OfPreset[float] = None
    squad_final_share: OfPreset[float] = None  # share of such games in the end
    # games until then; 70 % of the training, where the preset says nothing
    squad_episodes: OfPreset[int] = None
    # exponent by which opponents that beat the learner are met more often; 0: all alike
    priority: OfPreset[float] = None
    trained_agent: StartFrom = None
    device: str = "auto"  # "cpu", "cuda", or what there is

    eval_freq: int = 24_000  # env steps between two evaluations
    eval_games: int = 16  # games an opponent and colour in each of them
    save_freq: int = 120_000  # env steps of both levels between two checkpoints
    final_games: int = 500  # games an opponent and colour on the page at the end
    constant_plans: ConstantPlans = True

    name: str = "commander"  # the run folder is RUNS/NAME_k
    runs: Path = Path("runs")  # folder of the run folders
    resume: Path | None = None  # run folder to go on with; all other settings are read from it
    progress: Annotated[bool, tyro.conf.arg(aliases=("-P",))] = False  # show a progress bar
    json: Json = False

    @property
    def terms(self) -> Terms:
        """How its games are played."""
        return self.chosen.terms(self.scenario)

    def evaluation(self, games: int | None = None, purpose: Purpose = Purpose.REPORT) -> Evaluation:
        """Say how this commander is measured: by default as on the page at the end."""
        from hexwar_sb3.evaluation.matches import CAMPS, Evaluation

        return Evaluation(
            terms=self.terms,
            games=games or self.final_games,
            seed=self.seed,
            purpose=purpose,
            camps=CAMPS if self.side == "both" else (self.side,),
        )

    def check(self) -> None:
        """Check everything that can be checked before games are made.

        Raises:
            HexWarError: a setting is out of its range, or names what does not exist.
        """
        for name in ("n_timesteps", "self_freq", "eval_freq", "eval_games", "save_freq", "final_games"):
            if getattr(self, name) < 1:
                raise ConfigError(f"{name} must be at least 1, got {getattr(self, name)}")
        for games in (self.eval_games, self.final_games):
            self.evaluation(games)  # which checks the seed, too
        check_name("name", self.name)
        self._check_lower()
        check_preset(self.chosen)
        if not self.named_opponents:
            raise ConfigError("name at least one opponent beside itself")

    @property
    def named_opponents(self) -> list[str]:
        """Opponents that are there before the training: all but itself."""
        return named(self.met)

    @property
    def met(self) -> tuple[str, ...]:
        """Opponents, as they were given, or the broad mixture."""
        return broad_mixture(self.scenario) if self.opponents is None else self.opponents

    def _check_lower(self) -> None:
        """Check what the lower level's phases will need, before the first one comes."""
        lower = self.value("lower")
        if lower not in LOWERS and not Path(lower).exists():
            raise UnknownNameError("lower", lower, LOWERS)
        for name in self.lower_scenarios:
            if sizes(name) != sizes(self.scenario):
                raise ConfigError(
                    f"lower_scenarios: {name} has {sizes(name)} pieces in its larger camp, and control points,"
                    f" {self.scenario} has {sizes(self.scenario)}: one upper level gives the tasks in all of them"
                )

    @property
    def games(self) -> int:
        """Games that the env steps make."""
        return self.terms.games(self.n_timesteps)

    def value(self, name: str) -> Any:
        """A setting of the preset itself, unless it was given."""
        return getattr(self.chosen, name)

    @property
    def chosen(self) -> Preset:
        """The preset, and what was given instead.

        Raises:
            UnknownNameError: there is no such preset, nor such a file.
            FileFormatError: its file is broken.
        """
        given = {name: getattr(self, name) for name in OF_PRESET}
        return self.loaded.changed({name: one for name, one in given.items() if one is not None})

    @cached_property
    def loaded(self) -> Preset:
        """The preset as it was read, once: a file may change."""
        return load_preset(self.preset)

    @property
    def env(self) -> dict[str, Any]:
        """Settings of the task env, apart from who plays."""
        own = {"side": self.side, "demo": list(with_weights(self.demo, "demonstration").items())}
        return {**self.chosen.env_for(self.scenario), **own}

    @property
    def learns_from_replays(self) -> bool:
        """Whether recorded games are among the demonstrations."""
        from hexwar_sb3.play.shows import is_replays

        return any(map(is_replays, with_weights(self.demo, "demonstration")))

    @property
    def route(self) -> dict[str, Any]:
        """Settings of the route env."""
        others = (name for name in LOWER_SCENARIOS if sizes(name) == sizes(self.scenario))
        scenarios = self.lower_scenarios or dict.fromkeys((self.scenario, *others))
        return {"scenario": list(scenarios), **self.chosen.route}

    @property
    def learner(self) -> dict[str, Any]:
        """Arguments of QMIX."""
        learner = self.chosen.learner_for(self.games, self.scenario)
        return learner if self.buffer_size is None else {**learner, "buffer_size": self.buffer_size}

    @property
    def lower_learner(self) -> dict[str, Any]:
        """Arguments of `MaskedDQN`."""
        return self.chosen.lower_learner


OF_PRESET = tuple(
    name
    for name, field in TrainSettings.__dataclass_fields__.items()
    if field.default is None and (name in PARTS or name in OF_POLICY or hasattr(Preset, name))
)
"""Settings whose values are the preset's where none is given."""


def settings_from(folder: RunFolder) -> TrainSettings:
    """Read the settings of a run folder.

    Raises:
        FileFormatError: they are missing or broken.
    """
    values = read_fields(TrainSettings, folder.read_config(), folder.config)
    if folder.preset.exists():  # its file may lie elsewhere by now
        values["preset"] = str(folder.preset)
    settings = TrainSettings(**values)
    try:
        settings.check()
    except FileFormatError:
        raise
    except HexWarError as error:
        expected = "settings of `hexwar train`"
        raise FileFormatError(folder.config, "settings", found=str(error), expected=expected) from error
    return settings
