"""Both levels in one model: QMIX picks tasks, a DQN leads the pieces there; they are trained in turn (III-C)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self, cast

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import GymEnv, RolloutReturn
from stable_baselines3.common.vec_env import VecEnv, VecFrameStack, VecNormalize

from hexwar_sb3.algorithms.checkpoint_arrays import check_observation, env_snapshot, part, restore_env, under
from hexwar_sb3.algorithms.masked_dqn import MaskedDQN
from hexwar_sb3.algorithms.model_file import check_part
from hexwar_sb3.algorithms.model_zip import File, ModelZip
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.algorithms.ranges import (
    COUNTER,
    MOST_TICKS,
    NOT_NEGATIVE,
    SHARE,
    Parts,
    Table,
    Whole,
    anything,
    flag,
    pair,
    text,
    unlimited,
)
from hexwar_sb3.algorithms.task_model import wrappers
from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.fields import check_names
from hexwar_sb3.envs.registration import ROUTE_ENV, make_vec_env
from hexwar_sb3.envs.route_settings import RouteSettings, route_settings
from hexwar_sb3.envs.route_vec_env import RouteVecEnv, route_spaces
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.envs.snapshots import placed
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.evaluation.routes import measure_routes
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, FrozenLower, Lower
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.policies.masked import MaskedDQNPolicy, freeze_lower
from hexwar_sb3.policies.task_policy import TaskPolicy

LOWER_DEFAULTS: dict[str, Any] = {
    "gamma": 0.9,  # of a base hop; short: with the potential each hop pays at once (without it: PLAIN_GAMMA)
    "learning_rate": 2e-3,
    "final_learning_rate": 2e-5,
    "learning_rate_steps": 240_000,  # three phases of 2.5 million ticks
    "buffer_size": 200_000,
    "batch_size": 1024,  # large, and few updates: the camp's reward is louder than a hop lost
    "train_freq": 1,
    "gradient_steps": 2,
    "tau": 0.02,
    "target_update_interval": 1,
    "exploration_final_eps": 0.1,
    "exploration_steps": 40_000,
}
"""Arguments of `MaskedDQN` for the route env that differ from its own defaults."""

PLAIN_GAMMA = 0.98  # where the reward has no potential, a far goal must be worth something from the start
LOWER_ENVS = 384  # games of the route env side by side, over its maps: many, for a map's step costs Python
TEST_ROUTES = 50  # of each piece, to see whether the lower level may lead
SHARED_SETTINGS = (
    *Terms.__dataclass_fields__,
    *("side", "opponent", "reward"),
)
ROUTE_KWARGS = Parts(
    {
        **dict.fromkeys(("side", "beta_per", "reward", "decisions"), text),
        **dict.fromkeys(("scenario", "opponent", "upper", "lower"), anything),
        **dict.fromkeys(("keep_task", "wander", "beta", "shaping"), SHARE),
        **dict.fromkeys(("ways", "fog"), flag),
        "decision_ticks": Whole(1, 1_000_000),
        "alpha": NOT_NEGATIVE,
        "gain_limit": unlimited,
        "spots": Whole(0, 1_024),
        "n_envs": Whole(1, 4_096),
    }
)
"""Settings of the route env; what they must be beside that, it says itself."""
LOWER_KWARGS = Parts({name: kind for name, kind in MaskedDQN.settings.items() if name != "seed"})
LOWER_COUNTERS = Parts({name: kind for name, kind in MaskedDQN.state.items() if kind is COUNTER})


class HierarchicalQMIX(QMIX):
    """QMIX over tasks and one DQN for the ways of all pieces, trained in turn, one level frozen meanwhile.

    The model is itself the upper level and owns `.lower`. The heuristic leads the pieces until the lower level
    finishes enough of its test routes; then it leads, in training and in play. The phase is a function of the
    saved counters, so a resumed run goes on in the right one. `learn` counts the upper level's env steps;
    phases are counted in ticks of game time, which compare across Delta-t.

    Args:
        policy: "HierarchicalPolicy".
        env: the task env, native or single.
        args: further arguments of `QMIX`.
        lower_env: a route env; None makes one from the task env's own settings. What its reward is made of is the model's too.
        phase_ticks: game ticks of the upper level between two phases of the lower level, and of such a phase, of
            all games together; a game has 1,800. 0 for the second trains the upper level alone.
        lower_first: a phase of the lower level comes before the upper level's first.
        lower_kwargs: arguments of `MaskedDQN` that differ from `LOWER_DEFAULTS`.
        route_kwargs: settings of the route env that differ from the task env's (alpha, beta, ways, scenario ...),
            and n_envs.
        takeover: share of test routes that the lower level must finish to lead; a later version must keep to the
            fastest ways more often than the one that leads: every change costs the upper level something.
        tie: values of two answers of the lower level that differ by at most this share of beta, the cost of a base
            hop, are equal: the first answer is taken (assumption A34). 0 takes the best by however little.
        kwargs: further arguments of `QMIX`, by keyword.
    """

    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = {
        "HierarchicalPolicy": TaskPolicy,
        **QMIX.policy_aliases,
    }
    zip_name: ClassVar[str] = "HierarchicalQMIX"
    settings: ClassVar[Table] = {
        **QMIX.settings,
        "phase_ticks": pair(Whole(1, MOST_TICKS), Whole(0, MOST_TICKS), "at least (1, 0)"),
        "takeover": SHARE,
        "tie": NOT_NEGATIVE,
        "lower_first": flag,
        "lower_kwargs": LOWER_KWARGS,
        "route_kwargs": ROUTE_KWARGS,
    }
    state: ClassVar[Table] = {
        **QMIX.state,
        "upper_ticks": COUNTER,
        "lower_ticks": COUNTER,
        "leads": flag,
        "leader_agreement": SHARE,
        "lower_counters": LOWER_COUNTERS,
    }
    places: ClassVar[tuple[str, ...]] = (*QMIX.places, "lower_env")

    lower: MaskedDQN
    leads: bool  # whether the learned lower level leads the pieces

    def __init__(
        self,
        policy: str | type[BasePolicy],
        env: GymEnv | str | None,
        *args: Any,
        lower_env: VecEnv | None = None,
        phase_ticks: tuple[int, int] = (3_000_000, 2_500_000),
        lower_kwargs: dict[str, Any] | None = None,
        route_kwargs: dict[str, Any] | None = None,
        lower_first: bool = False,
        takeover: float = 0.97,
        tie: float = 0.4,
        _init_setup_model: bool = True,
        **kwargs: Any,
    ) -> None:
        super().__init__(policy, env, *args, _init_setup_model=False, **kwargs)
        self.phase_ticks, self.takeover, self.tie = phase_ticks, takeover, tie
        self.lower_first = lower_first
        self.lower_kwargs, self.route_kwargs = lower_kwargs or {}, route_kwargs or {}
        self.lower_env = lower_env
        self.upper_ticks, self.lower_ticks = 0, 0  # game ticks trained so far
        self.leads = False
        self.leader_agreement = 0.0  # share of the moves on a fastest way, of the version that leads
        self.lower_counters: dict[str, int] = {}
        if _init_setup_model:
            self._setup_model()

    def _setup_model(self) -> None:
        """Build both levels; the lower one needs no env yet."""
        super()._setup_model()
        if self.policy.memory is not None:
            raise ConfigError(
                "HierarchicalQMIX plays by frozen policies, which remember nothing: leave memory out"
            )
        if self.lower_env is not None:
            self.route_kwargs |= _reward_settings(self.lower_env)
        gamma = {} if self._own_route().is_shaped else {"gamma": PLAIN_GAMMA}
        options = {**LOWER_DEFAULTS, **gamma, **self.lower_kwargs}
        self.lower = MaskedDQN.for_spaces(*route_spaces(), seed=self.seed, device=self.device, **options)
        self.frozen_lower()  # other layers than the drive loop's show here, not after the first phase
        self.lower.set_logger(Logger(folder=None, output_formats=[]))
        vars(self.lower).update(self.lower_counters)
        if self.lower_env is not None:
            self.lower.set_env(self.lower_env)

    def _own_route(self) -> RouteSettings:
        """Settings of the route env, as far as `route_kwargs` says them.

        Raises:
            ConfigError: one is out of its range, or there are fewer games than scenarios.
        """
        options = {"n_envs": LOWER_ENVS, **self.route_kwargs}
        n_envs = options.pop("n_envs")
        settings = route_settings(options)
        check_whole("n_envs of the route env", n_envs, least=len(settings.fields))
        return settings

    def frozen_lower(self) -> FrozenLower:
        """Copy the learned lower level as it is now: the target network, a mean over the last updates."""
        policy = cast("MaskedDQNPolicy", self.lower.policy)
        return freeze_lower(policy, ways=self.ways, tie=self.lower_tie, network=policy.q_net_target)

    @property
    def ways(self) -> bool:
        """Whether the fastest ways are part of the lower level's state."""
        return bool(self.route_kwargs.get("ways", True))

    @property
    def lower_tie(self) -> float:
        """Values of two answers that differ by no more are equal, in the units of r_L."""
        return self.tie * float(self.route_kwargs.get("beta", RouteSettings.beta))

    @property
    def lower_is_due(self) -> bool:
        """The phase: whether the lower level is behind its share (III-C, "Alternate Training")."""
        upper, lower = self.phase_ticks
        return self.lower_ticks < (self.upper_ticks // upper + self.lower_first) * lower

    def collect_rollouts(
        self, env: VecEnv, callback: BaseCallback, *args: Any, **kwargs: Any
    ) -> RolloutReturn:
        """Train the lower level first if its phase has come; then play a step of the upper level."""
        if self.lower_is_due:
            self.train_lower(callback)
        return super().collect_rollouts(env, callback, *args, **kwargs)

    def train_lower(self, callback: BaseCallback | None = None) -> None:
        """Train the lower level until its phase is over, with the upper level frozen.

        Args:
            callback: its `on_rollout_start` is called between two vector steps, for checkpoints.
        """
        env = self._route_env()
        env.env_method("set_upper", self.policy.freeze())
        if isinstance(env.unwrapped, RouteVecEnv):
            env.unwrapped.beside = self.beside
        step = env.num_envs * self.lower.update_every
        while self.lower_is_due:
            self.lower.learn(step, callback=_LowerPhase(self, callback), reset_num_timesteps=False)
        self._log_lower()
        self._let_lead(self.frozen_lower())

    def _let_lead(self, lower: FrozenLower) -> None:
        """Let the lower level lead if it finds its ways, and better than the version that leads; else all stays as it is."""
        scenario = self._task_settings().scenario
        found = measure_routes(lower, scenario, TEST_ROUTES)[-1]
        self.logger.record("lower/routes_finished", found.finished)
        self.logger.record("lower/agreement", found.agreement)
        if found.finished >= self.takeover and found.agreement > self.leader_agreement:
            self.leader_agreement = found.agreement
            self.lead_with(lower)

    def lead_with(self, lower: Lower) -> None:
        """Let a lower level lead, until a version of this model's own is better; in both envs, if it is a network."""
        self.leads = isinstance(lower, FrozenLower)
        super().lead_with(lower)

    def follow_lower(self) -> None:
        """Keep the version that leads; else as the env's pieces are led."""
        if not self.leads:
            super().follow_lower()

    def set_env(self, env: GymEnv, force_reset: bool = True) -> None:
        """Go on in another env of the same sizes; the version that leads, leads there."""
        super().set_env(env, force_reset)
        self.lead_envs()

    def lead_envs(self) -> None:
        """Let the learned lower level lead in all envs of the model, if its time has come."""
        if self.leads:
            self._lead_own()

    def _lead_own(self) -> None:
        super()._lead_own()
        if self.lower.env is not None and self.leads:
            self.lower.env.env_method("set_lower", self.policy.lower)

    def _log_lower(self) -> None:
        ended = [episode for episode in self.lower.ep_info_buffer or () if "finished" in episode]
        for name, key in (("finished", "finished"), ("return", "r"), ("hops", "l")):
            if ended:
                self.logger.record(
                    f"lower/{name}", float(np.mean([float(episode[key]) for episode in ended]))
                )
        self.logger.record("lower/env_steps", self.lower.num_timesteps)

    def _route_env(self) -> VecEnv:
        """The env of the lower level; made when it is first needed."""
        if self.lower.env is None:
            options = {"n_envs": LOWER_ENVS, **self._shared_settings(), **self.route_kwargs}
            lower = self.policy.lower if isinstance(self.policy.lower, FrozenLower) else HEURISTIC_LOWER
            self.lower_env = make_vec_env(ROUTE_ENV, seed=self.seed, lower=lower, **options)
            self.lower.set_env(self.lower_env)
        return cast("VecEnv", self.lower.env)

    def _task_settings(self) -> TaskSettings:
        return cast("TaskSettings", cast("VecEnv", self.env).get_attr("games")[0].settings)

    def _shared_settings(self) -> dict[str, Any]:
        settings = self._task_settings()
        return {name: getattr(settings, name) for name in SHARED_SETTINGS}

    def _setup_learn(self, *args: Any, **kwargs: Any) -> tuple[int, BaseCallback]:
        self.lead_envs()
        return super()._setup_learn(*args, **kwargs)

    def _store_transition(self, *args: Any, **kwargs: Any) -> None:
        """Store a step, and count its ticks."""
        super()._store_transition(*args, **kwargs)
        self.upper_ticks += sum(int(info["ticks"]) for info in (kwargs.get("infos") or args[-1]))

    @property
    def env_steps(self) -> int:
        """Env steps of both levels together."""
        return int(self.num_timesteps + self.lower.num_timesteps)

    @property
    def game_ticks(self) -> int:
        """Ticks of game time that both levels together have played."""
        return self.upper_ticks + self.lower_ticks

    def save(self, path: File, *args: Any, **kwargs: Any) -> None:
        """Write one model zip for both levels."""
        self.lower_counters = {name: int(getattr(self.lower, name)) for name in LOWER_COUNTERS.table}
        super().save(path, *args, **kwargs)

    def _take(self, zipped: ModelZip) -> None:
        """Take the weights of a zip.

        Raises:
            CheckpointError: they are others than this model's, or the network that leads is missing.
        """
        if self.leads and self._leading is None:
            raise CheckpointError(
                zipped.name, "data: leading", found="nothing", expected="the network that leads"
            )
        super()._take(zipped)

    def _take_leader(self, lower: FrozenLower) -> None:
        if self.leads:
            self.lead_with(lower)
        else:
            super()._take_leader(lower)

    @classmethod
    def _load_pickled(cls, *args: Any) -> Self:
        model = super()._load_pickled(*args)
        leader: dict[str, Any] = vars(model).pop("leader", None) or {}  # as earlier versions kept it
        if leader:
            weights = {name: np.array(values, np.float32) for name, values in leader.items()}
            model.lead_with(FrozenLower(weights, ways=model.ways, tie=model.lower_tie))
        return model

    @classmethod
    def _check_networks(
        cls,
        zipped: ModelZip,
        values: dict[str, Any],
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
    ) -> None:
        super()._check_networks(zipped, values, observation_space, action_space)
        lower_options = values["lower_kwargs"].get("policy_kwargs", {})
        check_part(zipped, "lower.policy", MaskedDQNPolicy, *route_spaces(), lower_options)

    def set_random_seed(self, seed: int | None = None) -> None:
        """Seed both levels."""
        super().set_random_seed(seed)
        if hasattr(self, "lower"):
            self.lower.set_random_seed(seed)

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy", "policy.optimizer", "lower.policy", "lower.policy.optimizer"], []

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """What a model zip leaves out of the lower level: its replay, its running games."""
        if self.lower.env is None or self.lower._last_obs is None:  # noqa: SLF001
            return {}
        return {
            **under("replay", self.lower.snapshot()),
            **under("games", env_snapshot(self.lower.env)),
            **under("last_obs", cast("dict[str, NDArray[Any]]", self.lower._last_obs)),  # noqa: SLF001
        }

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Take over what `snapshot` gave.

        Raises:
            CheckpointError: it is broken.
        """
        if not parts:
            return
        check_names({name.partition("/")[0]: None for name in parts}, ("replay", "games", "last_obs"))
        env, last_obs = self._route_env(), part("last_obs", parts)
        env.env_method("set_upper", self.policy.freeze())
        with placed("replay"):
            self.lower.restore(part("replay", parts))
        check_observation("last_obs", last_obs, env)
        with placed("games"):
            restore_env(env, part("games", parts))
        self.lower._last_obs = last_obs  # noqa: SLF001


def _reward_settings(env: VecEnv) -> dict[str, Any]:
    """Settings of a route env that the model needs to know, too: what its state holds, and its reward's potential.

    Raises:
        ConfigError: it is no route env, or in a wrapper that changes what is learned from.
    """
    for wrapper in wrappers(env):
        if isinstance(wrapper, VecNormalize | VecFrameStack):
            raise ConfigError(f"lower_env is a route env as it is, got one in {type(wrapper).__name__}")
    if not env.has_attr("settings") or not isinstance(settings := env.get_attr("settings")[0], RouteSettings):
        raise ConfigError(f'lower_env is a VecEnv of "{ROUTE_ENV}", got {env}')
    return {name: getattr(settings, name) for name in ("ways", "beta", "beta_per", "shaping")}


class _LowerPhase(BaseCallback):
    """Counts the ticks of a lower phase, and lets the outer callbacks save between two vector steps."""

    def __init__(self, owner: HierarchicalQMIX, outer: BaseCallback | None) -> None:
        super().__init__()
        self.owner, self.outer = owner, outer

    def _on_rollout_start(self) -> None:
        if self.outer is not None:
            self.outer.on_rollout_start()

    def _on_step(self) -> bool:
        self.owner.lower_ticks += sum(int(info["ticks"]) for info in self.locals["infos"])
        return True
