"""Both levels in one model: phases, one zip, resume in each phase (III-C, "Alternate Training")."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import VecEnv

from hexwar_sb3.algorithms import hierarchical
from hexwar_sb3.algorithms.checkpoint import load_checkpoint, save_checkpoint
from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.play.lower_policy import HEURISTIC_LOWER, FrozenLower, fastest_way_network
from hexwar_sb3.play.match import play_games
from hexwar_sb3.play.routes import RouteResult
from hexwar_sb3.policies.masked import MaskedDQNPolicy
from hexwar_sb3.tasks.features import ROUTE_WIDTH
from hexwar_sb3.tasks.route import N_ANSWERS

STEPS = 384  # env steps of the upper level: 16 games of 24 decisions
UPPER: dict[str, Any] = {"seed": 1, "learning_starts": 48, "buffer_size": 400, "batch_size": 16}
LEVELS: dict[str, Any] = {
    "phase_ticks": (9_000, 4_000),
    "lower_kwargs": {"learning_starts": 50, "buffer_size": 500, "batch_size": 16, "gradient_steps": 1},
    "route_kwargs": {"n_envs": 4, "scenario": ["plain"]},
}
BREAKS: dict[str, Callable[[HierarchicalQMIX], bool]] = {
    "upper": lambda owner: owner.num_timesteps >= 60,
    "lower": lambda owner: owner.lower_ticks >= 2_000,
    "upper again": lambda owner: owner.num_timesteps >= 180,
    "lower again": lambda owner: owner.lower_ticks >= 6_000,
}


def games() -> VecEnv:
    return make_vec_env(n_envs=4, opponent=["MA1", "MA2"], side="both", seed=5, privileged_state=True)


def model(takeover: float = 0.0, **options: Any) -> HierarchicalQMIX:
    return HierarchicalQMIX(
        "HierarchicalPolicy", games(), **{**UPPER, **LEVELS, "takeover": takeover, **options}
    )


def sha256(trained: HierarchicalQMIX) -> str:
    digest = hashlib.sha256()
    for part in (trained.policy, trained.lower.policy):
        for tensor in part.state_dict().values():
            digest.update(tensor.numpy().tobytes())
    return digest.hexdigest()


class Watch(BaseCallback):
    """Saves at some moments, and notes in which phase that was."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.folder = folder
        self.phases: dict[str, bool] = {}

    def _on_rollout_start(self) -> None:
        owner = self.model
        assert isinstance(owner, HierarchicalQMIX)
        for name, has_come in BREAKS.items():
            if name not in self.phases and has_come(owner):
                self.phases[name] = owner.lower_is_due
                save_checkpoint(owner, self.folder / name)

    def _on_step(self) -> bool:
        return True


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> tuple[HierarchicalQMIX, Watch]:
    """A whole training, and checkpoints of it in every phase."""
    watch = Watch(tmp_path_factory.mktemp("checkpoints"))
    trained = model()
    trained.learn(STEPS, callback=watch)
    return trained, watch


def test_the_levels_are_trained_in_turn(unbroken: tuple[HierarchicalQMIX, Watch]) -> None:
    """The upper level first; each phase of the lower one lasts its ticks, and a vector step at most longer."""
    trained, watch = unbroken

    assert watch.phases == {"upper": False, "lower": True, "upper again": False, "lower again": True}
    assert trained.num_timesteps == STEPS
    assert trained.upper_ticks == STEPS * 75
    assert 3 * 4_000 <= trained.lower_ticks < 3 * 4_000 + 4 * 400
    assert trained.lower.num_timesteps > 0


@pytest.mark.parametrize("phase", BREAKS)
def test_resumed_in_any_phase_is_unbroken(unbroken: tuple[HierarchicalQMIX, Watch], phase: str) -> None:
    trained, watch = unbroken
    np.random.seed(99)  # noqa: NPY002  # another process has other random numbers
    torch.manual_seed(99)

    resumed = load_checkpoint(watch.folder / phase, games(), HierarchicalQMIX)
    assert isinstance(resumed, HierarchicalQMIX)
    assert resumed.lower_is_due == watch.phases[phase]
    resumed.learn(STEPS - resumed.num_timesteps, reset_num_timesteps=False)

    assert sha256(resumed) == sha256(trained)
    assert resumed.lower_ticks == trained.lower_ticks


def test_the_target_network_leads(unbroken: tuple[HierarchicalQMIX, Watch]) -> None:
    policy = cast("MaskedDQNPolicy", unbroken[0].lower.policy)
    states = np.random.default_rng(0).normal(size=(20, ROUTE_WIDTH)).astype(np.float32)
    obs = {"obs": torch.tensor(states), "action_mask": torch.ones(20, N_ANSWERS, dtype=torch.int8)}
    with torch.no_grad():
        target, online = policy.q_net_target(obs).numpy(), policy.q_net(obs).numpy()

    values = unbroken[0].frozen_lower().q_values(states)

    np.testing.assert_allclose(values, target, atol=1e-5)
    assert np.abs(target - online).max() > 1e-3


def test_one_zip_holds_both_levels(unbroken: tuple[HierarchicalQMIX, Watch], tmp_path: Path) -> None:
    trained, _ = unbroken
    trained.save(tmp_path / "model")
    loaded = HierarchicalQMIX.load(tmp_path / "model")

    assert sha256(loaded) == sha256(trained)
    assert loaded.leads
    assert isinstance(loaded.policy.lower, FrozenLower)
    assert isinstance(trained.policy.lower, FrozenLower)
    for name, weights in trained.policy.lower.weights.items():
        assert np.array_equal(loaded.policy.lower.weights[name], weights)


def test_the_frozen_policy_has_the_lower_level(
    unbroken: tuple[HierarchicalQMIX, Watch], tmp_path: Path
) -> None:
    """The model, its frozen copy and the folder play the same games."""
    trained, _ = unbroken
    frozen = trained.policy.freeze()
    frozen.save(tmp_path / "policy")

    margins = [
        play_games(player, "MA1", 2).margins.tolist() for player in (trained, frozen, tmp_path / "policy")
    ]

    assert margins[0] == margins[1] == margins[2]
    assert isinstance(frozen.lower, FrozenLower)


def test_the_heuristic_leads_until_the_lower_level_finds_its_ways() -> None:
    """With takeover 1 it would have to finish every test route; after so little training it does not."""
    trained = model(takeover=1.0)
    trained.learn(STEPS // 2)

    assert trained.lower_ticks > 0
    assert not trained.leads
    assert trained.policy.lower == HEURISTIC_LOWER
    assert trained.env is not None
    assert trained.env.get_attr("games")[0].lower == HEURISTIC_LOWER


@pytest.mark.parametrize(
    ("agreements", "leads"), [((0.5, 0.4, 0.6), 2), ((0.5, 0.6, 0.6), 1), ((0.5, 0.4, 0.4), 0)]
)
def test_a_version_leads_until_one_is_better(
    monkeypatch: pytest.MonkeyPatch, agreements: tuple[float, ...], leads: int
) -> None:
    versions: list[FrozenLower] = []

    def measured(lower: FrozenLower, *_: object) -> list[RouteResult]:
        versions.append(lower)
        return [RouteResult("all", 50, 1.0, agreements[len(versions) - 1], 1.0)]

    monkeypatch.setattr(hierarchical, "measure_routes", measured)
    trained = model().learn(STEPS)

    assert len(versions) == len(agreements)
    assert trained.policy.lower is versions[leads]


def test_a_tie_is_a_share_of_what_a_base_hop_costs() -> None:
    route = {**LEVELS["route_kwargs"], "beta": 0.2}

    assert model(tie=0.5, route_kwargs=route).frozen_lower().tie == pytest.approx(0.1)
    assert model(tie=0.0).frozen_lower().tie == 0.0
    assert PRESETS["paper"].tie == 0.0


def test_without_lower_phases_it_is_qmix() -> None:
    both = model(phase_ticks=(1, 0))
    both.learn(STEPS // 2)
    alone = QMIX("TaskPolicy", games(), **UPPER).learn(STEPS // 2)

    assert both.lower_ticks == 0
    for mine, its in zip(both.policy.parameters(), alone.policy.parameters(), strict=True):
        assert torch.equal(mine, its)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"phase_ticks": (0, 1)}, r"phase_ticks must be at least \(1, 0\), got \(0, 1\)"),
        ({"tie": -1.0}, r"tie must be finite and at least 0, got -1.0"),
        ({"takeover": 1.5}, r"takeover must be in \[0, 1\], got 1.5"),
        ({"lower_kwargs": {"gamma": 1.5}}, r"gamma must be in \[0, 1\], got 1.5"),
        ({"route_kwargs": {"alpha": -1.0}}, "alpha must be finite and at least 0"),
        ({"route_kwargs": {"beta": 1.0}}, r"beta must be in \[0, 1\)"),
        ({"route_kwargs": {"n_envs": 2, "scenario": ["plain", "hills", "paddy"]}}, "n_envs of the route env"),
        ({"lower_kwargs": {"policy_kwargs": {"net_arch": [32, 32]}}}, "no network for the drive loop"),
        ({"lower_kwargs": {"policy_kwargs": {"activation_fn": torch.nn.Tanh}}}, "ReLU .* got Tanh"),
    ],
)
def test_settings_out_of_range_are_refused_at_once(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        model(**options)


def test_a_policy_is_led_as_its_games_were() -> None:
    """Trained over another's lower level, the frozen copy plays over that one; a model that has its own keeps it."""
    network = fastest_way_network()
    env = make_vec_env(n_envs=1, lower=network, privileged_state=True, seed=0)

    for trained in (
        QMIX("TaskPolicy", env, buffer_size=10),
        HierarchicalQMIX("HierarchicalPolicy", env, buffer_size=10, phase_ticks=(1, 0)),
    ):
        assert trained.policy.freeze().lower is network
        trained.set_env(make_vec_env(n_envs=1, privileged_state=True, seed=0))
        assert trained.policy.freeze().lower == HEURISTIC_LOWER

    leading = HierarchicalQMIX("HierarchicalPolicy", env, buffer_size=10, takeover=0.0)
    leading.set_logger(Logger(folder=None, output_formats=[]))
    leading._let_lead(network)
    leading.set_env(make_vec_env(n_envs=1, privileged_state=True, seed=0))
    assert leading.policy.freeze().lower is network


def test_the_route_env_has_the_task_envs_settings() -> None:
    env = make_vec_env(
        n_envs=1, spots=3, decisions="event", decision_ticks=150, privileged_state=True, seed=0
    )
    owner = HierarchicalQMIX("HierarchicalPolicy", env, buffer_size=10)

    route = owner._route_env().get_attr("settings")[0]

    assert (route.spots, route.decisions, route.decision_ticks) == (3, "event", 150)


def test_a_route_env_of_your_own_says_what_the_lower_level_reads() -> None:
    own = make_vec_env("HexWarRoute-v0", n_envs=2, ways=False, beta=0.2, seed=0)

    owner = model(lower_env=own, route_kwargs={}, lower_kwargs={})

    assert not owner.frozen_lower().ways
    assert owner.frozen_lower().tie == pytest.approx(0.4 * 0.2)
    assert owner.lower.gamma == 0.98  # there is no potential without ways
    assert (
        model(lower_env=make_vec_env("HexWarRoute-v0", shaping=0.0, seed=0), lower_kwargs={}).lower.gamma
        == 0.98
    )


def test_a_lower_env_that_is_no_route_env_is_refused() -> None:
    with pytest.raises(ConfigError, match='lower_env is a VecEnv of "HexWarRoute-v0"'):
        model(lower_env=games())


def test_without_a_potential_the_lower_level_looks_farther() -> None:
    assert model(lower_kwargs={}).lower.gamma == 0.9
    assert model(lower_kwargs={}, route_kwargs={**LEVELS["route_kwargs"], "ways": False}).lower.gamma == 0.98


def test_a_zip_of_other_levels_says_who_reads_it(tmp_path: Path) -> None:
    model().save(tmp_path / "two")
    QMIX("TaskPolicy", games(), **UPPER).save(tmp_path / "one")

    with pytest.raises(CheckpointError, match=r"found two levels; expected HierarchicalQMIX\.load"):
        QMIX.load(tmp_path / "two")
    with pytest.raises(CheckpointError, match=r"found one level; expected QMIX\.load"):
        HierarchicalQMIX.load(tmp_path / "one")
