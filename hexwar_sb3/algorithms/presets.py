"""Named settings of a training with both levels: games, task env, route env, learner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.players.terms import DECISION_TICKS, Terms
from hexwar_sb3.tasks.features import world_sizes
from hexwar_sb3.tasks.hotspots import is_mirrored
from hexwar_sb3.tasks.records import MAX_TASKS

Settings = dict[str, Any]
LEARNER = (
    *("mixer", "learning_rate", "final_learning_rate", "batch_size", "tau", "ema_tau", "gamma", "n_steps"),
    "td_lambda",
    *("double_q", "gradient_steps", "buffer_size", "stickiness"),
    *("exploration_initial_eps", "exploration_final_eps", "exploration_episodes"),
    *("squad_initial_share", "squad_final_share", "squad_episodes"),
)
"""Settings that are arguments of QMIX."""
FALLS = {"exploration_episodes": 0.4, "squad_episodes": 0.7}
"""Arguments of QMIX that are numbers of games: their share of a training, where the preset says nothing."""
REPLAY_BYTES = 2 << 30
"""Of a replay, unless more steps were asked for."""
OF_POLICY = {"hidden": "int", "embed": "int", "mirrored": "bool"}  # of its networks, with their kinds
PARTS = {
    **{name: ("env", name) for name in ("reward", "decisions", "spots", "priority")},
    **{name: ("route", name) for name in ("alpha", "beta", "beta_per", "ways")},
    **{name: ("learner", name) for name in LEARNER},
    "lower_gamma": ("lower_learner", "gamma"),
}
"""Where in a preset a setting lies: part and key; what is not here is a field of its own."""


@dataclass(frozen=True, kw_only=True)
class Preset:
    """What `hexwar train` takes where nothing is said."""

    decision_ticks: int = DECISION_TICKS  # Delta-t, ticks between two decisions
    n_envs: int = 32  # games side by side
    lower: str = "learned"  # who leads the pieces; or "heuristic", or a folder
    phase_ticks: tuple[int, int] = (
        4_500_000,
        2_500_000,
    )  # game ticks of the upper, of the lower level in turn
    tie: float = 0.4  # of beta: values of two answers of the lower level that are nearer count as equal
    demo_share: float = 0.25  # of the first games: a bot plays the learner's seat, and the learner watches
    demo_games: int = 500
    warm_start: float = 0.0  # share of the games at first; it falls to 0 by half of the training (III-C)
    env: Settings = field(default_factory=dict)  # of `TaskSettings`
    route: Settings = field(default_factory=dict)  # of `RouteSettings`
    learner: Settings = field(default_factory=dict)  # of `QMIX`
    # of `MaskedDQN`, where it differs from LOWER_DEFAULTS
    lower_learner: Settings = field(default_factory=dict)

    def changed(self, settings: Mapping[str, Any]) -> Preset:
        """The same preset with other values.

        Args:
            settings: values by name, those of `hexwar train`'s flags.
        """
        new: Settings = {}
        for name, value in settings.items():
            if name in OF_POLICY:
                learner = new.get("learner", self.learner)
                new["learner"] = {
                    **learner,
                    "policy_kwargs": {**learner.get("policy_kwargs", {}), name: value},
                }
            elif name in PARTS:
                part, key = PARTS[name]
                new[part] = {**new.get(part, getattr(self, part)), key: value}
            else:
                new[name] = value
        return replace(self, **new)

    def terms(self, scenario: ScenarioLike) -> Terms:
        """How games of this preset are played on a map."""
        own = {name: value for name, value in self.env.items() if name in Terms.__dataclass_fields__}
        return Terms(scenario=scenario, decision_ticks=self.decision_ticks, **own)

    def env_for(self, scenario: ScenarioLike) -> Settings:
        """Settings of the task env on a map, for a learner that a bot may show how it plays."""
        own = {"demo": "MA2", "privileged_state": True}
        return {"n_envs": self.n_envs, **own, **self.env, **self.terms(scenario).settings}

    def learner_for(self, games: int, scenario: ScenarioLike) -> Settings:
        """Arguments of QMIX for a training of so many games on a map.

        On a map that is its own mirror image the networks do not see which camp they play, unless the preset says so.
        Where steps are larger the replay keeps fewer of them: `replay_room`.
        """
        learner = dict(self.learner)
        if "buffer_size" in learner:
            learner["buffer_size"] = min(learner["buffer_size"], replay_room(scenario))
        falls = {name: max(1, int(share * games)) for name, share in FALLS.items()}
        policy = {
            "mirrored": is_mirrored(load_world(scenario).scenario),
            **self.learner.get("policy_kwargs", {}),
        }
        return {**falls, **learner, "policy_kwargs": policy}

    def lower_ticks(self, upper_ticks: int) -> int:
        """Game ticks of the lower level in a training with so many of the upper one."""
        upper, lower = self.phase_ticks
        return (upper_ticks - 1) // upper * lower  # a phase that is due at the end does not begin


def replay_room(scenario: ScenarioLike) -> int:
    """Steps of a scenario that `REPLAY_BYTES` have room for, with half of each task set valid."""
    world = load_world(scenario)
    width = world_sizes(world)
    numbers = world.n_slots * (width.obs + MAX_TASKS // 2 * width.row) + width.state  # float16 each
    return REPLAY_BYTES // (2 * numbers + world.n_slots * MAX_TASKS)


PRESETS = {
    "default": Preset(
        env={"reward": "net", "priority": 1.0},
        learner={
            "learning_rate": 1e-3,
            "final_learning_rate": 5e-5,
            "batch_size": 64,
            "gradient_steps": 2,  # more and smaller updates
            "buffer_size": 100_000,  # four thousand games: rare opponents are not forgotten; 0.9 GB
            "exploration_final_eps": 0.005,  # of seven pieces, each for five decisions on average
            "squad_initial_share": 0.3,
            "squad_final_share": 0.03,
            "policy_kwargs": {"hidden": 128},
        },
    ),
    # Section IV to the letter: 16 games at a time, learning rate 0.1, a = 0.1, epsilon 0.5 minus 0.01 every 100
    # episodes down to 0.05, eq. (3) of eq. (1) without discount (eq. (4)), alpha 0.01 and beta 0.05 for every hop, the
    # six neighbours as the state of the lower level, tasks from the upper level alone, warm start from G^B. No n-step
    # returns, no sticky exploration, no demonstrations, no ties. With Adam such a learning rate learns nothing.
    # The paper is silent about the lower level's discount and batch: those are the default's.
    "paper": Preset(
        n_envs=16,
        tie=0.0,
        demo_share=0.0,
        warm_start=1.0,
        env={"reward": "paper"},
        route={
            "alpha": 0.01,
            "beta": 0.05,
            "beta_per": "hop",
            "ways": False,
            "gain_limit": float("inf"),
            "keep_task": 0.0,
            "wander": 0.0,
        },
        lower_learner={
            "learning_rate": 0.1,
            "final_learning_rate": None,
            "tau": 0.1,
            "exploration_initial_eps": 0.5,
            "exploration_final_eps": 0.05,
        },
        learner={
            "learning_rate": 0.1,
            "tau": 0.1,
            "gamma": 1.0,
            "n_steps": 1,
            "double_q": False,
            "loss": "squared",
            "stickiness": 0.0,
            "exploration_initial_eps": 0.5,
            "exploration_final_eps": 0.05,
            "exploration_episodes": 4_500,
            "exploration_every": 100,
            "policy_kwargs": {"mirrored": False},
        },
    ),
}
"""Presets by name: "default" is what `hexwar train` takes, "paper" the numbers of section IV."""
