"""Both levels in one model: phases, one zip, resume in each phase (III-C, "Alternate Training")."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import gymnasium
import numpy as np
import pytest
import torch
from stable_baselines3.common.callbacks import BaseCallback, CallbackList, EvalCallback, EveryNTimesteps
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from hexwar_sb3.algorithms import hierarchical
from hexwar_sb3.algorithms.checkpoint import load_checkpoint, save_checkpoint
from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.trial_eval import TrialEvalCallback
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.evaluation.routes import RouteResult
from hexwar_sb3.play.match import play_games
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, FrozenLower, fastest_way_network
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

    with pytest.raises(CheckpointError, match=r"found 'HierarchicalQMIX'; .*HierarchicalQMIX\.load reads it"):
        QMIX.load(tmp_path / "two")
    with pytest.raises(CheckpointError, match=r"found 'QMIX'; .*QMIX\.load reads it"):
        HierarchicalQMIX.load(tmp_path / "one")


def task_env(n_envs: int = 2, **settings: Any) -> VecEnv:
    return make_vec_env(n_envs=n_envs, privileged_state=True, **settings)


def led_by(env: Any) -> Any:
    return env.get_attr("lower_level")[0] if isinstance(env, VecEnv) else env.unwrapped.lower_level


def leading() -> HierarchicalQMIX:
    """A model whose own lower level leads."""
    owner = HierarchicalQMIX("HierarchicalPolicy", task_env(), buffer_size=100, seed=0)
    owner.lead_with(fastest_way_network())
    return owner


def test_evaluations_are_led_as_the_model_is() -> None:
    """`EvalCallback`s with envs of their own, wherever they lie among the callbacks; later leaders, too."""
    envs = [task_env(1) for _ in range(4)]
    inner = EvalCallback(envs[1], eval_freq=100, verbose=0)
    callbacks = [
        EvalCallback(envs[0], eval_freq=100, verbose=0),
        CallbackList([EveryNTimesteps(50, inner)]),
        TrialEvalCallback(envs[2], Trial(), eval_freq=100),
        EvalCallback(
            task_env(1), eval_freq=100, callback_after_eval=EvalCallback(envs[3], verbose=0), verbose=0
        ),
    ]
    over_network = QMIX("TaskPolicy", task_env(lower=fastest_way_network()), buffer_size=100)
    for owner in (leading(), over_network):
        for env in envs:
            env.env_method("set_lower", HEURISTIC_LOWER)
        owner.learn(2, callback=callbacks)
        assert all(led_by(env) is owner.policy.lower for env in envs)
    owner = leading()
    owner.learn(2, callback=callbacks)
    owner.lead_with(fastest_way_network())
    assert all(led_by(env) is owner.policy.lower for env in envs)


class Trial:
    def report(self, value: float, step: int) -> None:
        """Hear of an evaluation."""

    def should_prune(self) -> bool:
        return False


def test_a_loop_of_ones_own_is_led_or_warned_of(tmp_path: Path) -> None:
    """The heuristic leads in a new env, whatever a model's lower level would do."""
    leading().save(tmp_path / "model")
    with_env = HierarchicalQMIX.load(tmp_path / "model", env=(own := task_env()))
    assert led_by(own) is with_env.policy.lower

    loaded = HierarchicalQMIX.load(tmp_path / "model")
    env = task_env()
    observation = cast("dict[str, np.ndarray]", env.reset())
    with pytest.warns(UserWarning, match=r"the heuristic leads the pieces: model.lead\(env\)"):
        loaded.predict(observation, deterministic=True)
    loaded.predict(observation, deterministic=True)  # once

    loaded = HierarchicalQMIX.load(tmp_path / "model")
    single = gymnasium.make("HexWarTask-v0", scenario="plain")
    assert loaded.lead(env) is env
    assert loaded.lead(single) is single
    assert led_by(env) is led_by(single) is loaded.policy.lower
    loaded.predict(observation, deterministic=True)  # without a warning
    for wrong in (gymnasium.make("CartPole-v1"), "env", None):
        with pytest.raises(ConfigError, match="nobody leads pieces in"):
            loaded.lead(wrong)


def test_a_model_over_anothers_network_keeps_it_in_its_zip(tmp_path: Path) -> None:
    network = fastest_way_network()
    QMIX("TaskPolicy", task_env(lower=network), buffer_size=100).save(tmp_path / "model")

    frozen = QMIX.load(tmp_path / "model").policy.freeze()

    assert isinstance(frozen.lower, FrozenLower)
    assert all(np.array_equal(frozen.lower.weights[name], one) for name, one in network.weights.items())
    with pytest.warns(UserWarning, match="the heuristic leads the pieces of its env now"):
        QMIX.load(tmp_path / "model", env=task_env())
    assert QMIX.load(tmp_path / "model", env=task_env(lower=network)).policy.lower is network


def test_a_leader_comes_back_as_it_was(tmp_path: Path) -> None:
    """One that was taken over may read another state, and have other ties, than the model's own."""
    owner = leading()
    owner.lead_with(FrozenLower(fastest_way_network().weights, ways=False, tie=0.125))
    owner.save(tmp_path / "model")

    lower = HierarchicalQMIX.load(tmp_path / "model").policy.lower

    assert isinstance(lower, FrozenLower)
    assert (lower.ways, lower.tie) == (False, 0.125)


WRONG: list[Any] = [{"x": 1}, [[1]], "x", -5, 10**18, None, True, {":type:": "x", ":serialized:": "x"}]


def test_every_value_of_both_levels_is_of_its_kind_and_in_its_range(tmp_path: Path) -> None:
    path = tmp_path / "model.zip"
    leading().save(path)
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    data = json.loads(parts["data"])
    nested = {
        "lower_counters": {**data["lower_counters"], "x": 1},
        "lower_kwargs": {"policy_kwargs": {"net_arch": [4096] * 16}},
        "route_kwargs": {"n_envs": 10**9},
        "leading": {"ways": True, "tie": float("1e999")},
        "leads": None,
    }
    names = set(HierarchicalQMIX.settings) - set(QMIX.settings) | set(HierarchicalQMIX.state) - set(
        QMIX.state
    )
    changes = [{name: value} for name in sorted(names) for value in WRONG] + [
        {name: one} for name, one in nested.items()
    ]
    changes += [
        {"route_kwargs": {name: value}}
        for name, value in (
            ("lower", {}),
            ("scenario", {}),
            ("spots", 10**9),
            ("beta", "x"),
            ("x", 1),
            ("side", "up"),
        )
    ]
    changes += [
        {"lower_kwargs": {name: value}} for name, value in (("seed", 1), ("device", "x"), ("gamma", "x"))
    ]
    kept = []
    for change in changes:
        file = io.BytesIO()
        with zipfile.ZipFile(file, "w") as archive:
            for name, content in {**parts, "data": json.dumps({**data, **change}).encode()}.items():
                archive.writestr(name, content)
        try:
            HierarchicalQMIX.load(file)
        except CheckpointError:
            continue
        kept.append(change)
    assert kept == [{"leads": True}, {"lower_first": True}, {"tie": 10**18}]


@pytest.mark.parametrize("missing", ["leader", "lower.policy", "lower.policy.optimizer"])
def test_a_zip_without_a_part_of_the_lower_level_is_refused(tmp_path: Path, missing: str) -> None:
    """It would play by the heuristic, and say nothing."""
    path = tmp_path / "model.zip"
    leading().save(path)
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist() if name != f"{missing}.safetensors"}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in parts.items():
            archive.writestr(name, content)

    with pytest.raises(CheckpointError, match=f"{missing}.*found nothing"):
        HierarchicalQMIX.load(path)


def test_a_zip_of_an_earlier_version_is_read_with_trust_alone(tmp_path: Path) -> None:
    """As SB3's own `save` writes it, with the weights of the leader among the plain values."""
    owner = leading()
    owner.leader = {name: one.tolist() for name, one in fastest_way_network().weights.items()}  # type: ignore[attr-defined]
    owner.lower_counters = dict.fromkeys(("num_timesteps", "_n_calls", "_n_updates", "_episode_num"), 3)
    again = (
        "lr_schedule",
        "train_freq",
        "rng",
        "explorer",
        "current",
        "game_log",
        "learner",
        "lower",
        "lower_env",
        "leads",
    )
    OffPolicyAlgorithm.save(owner, tmp_path / "old.zip", exclude=again)

    with pytest.raises(CheckpointError, match="of an earlier version"):
        HierarchicalQMIX.load(tmp_path / "old.zip")
    loaded = HierarchicalQMIX.load(tmp_path / "old.zip", env=(env := task_env()), trust=True)

    assert sha256(loaded) == sha256(owner)
    assert loaded.lower.num_timesteps == 3
    assert loaded.leads
    assert led_by(env) is loaded.policy.lower


def test_what_can_be_trained_with_can_be_saved_and_loaded(tmp_path: Path) -> None:
    options = {
        "phase_ticks": [np.int64(9_000), 4_000.0],
        "tie": np.float32(0.5),
        "lower_first": np.bool_(False),
        "lower_kwargs": {"batch_size": np.int64(16), "buffer_size": 500},
        "route_kwargs": {
            "scenario": [Path("plain")],
            "beta": np.float64(0.1),
            "gain_limit": np.inf,
            "n_envs": np.int8(4),
        },
    }
    owner = HierarchicalQMIX("HierarchicalPolicy", task_env(), buffer_size=100, **options)  # type: ignore[arg-type]
    owner.save(tmp_path / "model")

    loaded = HierarchicalQMIX.load(tmp_path / "model")

    for one in (owner, loaded):
        assert (one.phase_ticks, one.tie, one.lower_first) == ((9_000, 4_000), 0.5, False)
        assert one.lower.batch_size == 16
        assert one.route_kwargs == {"scenario": ["plain"], "beta": 0.1, "gain_limit": np.inf, "n_envs": 4}


def test_a_normalised_route_env_is_refused() -> None:
    routes = make_vec_env("HexWarRoute-v0", n_envs=2)

    with pytest.raises(ConfigError, match="lower_env is a route env as it is, got one in VecNormalize"):
        model(lower_env=VecNormalize(routes, norm_obs_keys=["obs"]), route_kwargs={}, lower_kwargs={})


def test_a_seed_that_is_set_later_reaches_both_levels() -> None:
    """Two models of the same weights, each with a generator of its own, learn the same."""
    trained = []
    start = model(seed=None)
    for _ in range(2):
        owner = model(seed=None)
        owner.policy.load_state_dict(start.policy.state_dict())
        owner.lower.policy.load_state_dict(start.lower.policy.state_dict())
        owner.set_random_seed(7)
        trained.append(sha256(owner.learn(STEPS // 2)))

    assert trained[0] == trained[1]
