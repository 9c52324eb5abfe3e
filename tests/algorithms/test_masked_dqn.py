"""DQN and QR-DQN with action masks: exploration, targets, discounts, files, resuming, learning."""

from __future__ import annotations

import copy
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
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecCheckNan, VecEnv, VecNormalize

from hexwar_sb3.algorithms.masked_dqn import MaskedDQN, MaskedQRDQN
from hexwar_sb3.envs.registration import make_vec_env as make_routes
from hexwar_sb3.errors import (
    CheckpointError,
    ConfigError,
    TrainingError,
    UnknownNameError,
    UnknownSettingError,
)
from hexwar_sb3.policies.masked import MaskedDQNPolicy, MaskedExtractor, freeze_lower

LEFT, RIGHT, TRAP = range(3)
GOAL, LIMIT = 4, 12  # cell and steps of the corridor
Obs = dict[str, NDArray[Any]]
Model = MaskedDQN | MaskedQRDQN
MakeModel = Callable[..., Model]


class Corridor(gymnasium.Env[Obs, np.int64]):
    """Walk right to the goal; a masked action fails the test; a step to the left takes twice the time."""

    def __init__(self) -> None:
        cell, mask = spaces.Box(0.0, 1.0, (GOAL + 1,)), spaces.Box(0, 1, (3,), np.int8)
        self.observation_space = spaces.Dict({"cell": cell, "action_mask": mask})  # type: ignore[assignment]
        self.action_space = spaces.Discrete(3)
        self.cell, self.moment = 0, 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        super().reset(seed=seed)
        self.cell, self.moment = int(self.np_random.integers(GOAL)), 0
        return self.observe(), {}

    def step(self, action: np.int64) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        assert self.observe()["action_mask"][action], "a masked action was taken"
        self.cell += 1 if action == RIGHT else -1
        self.moment += 1
        there = self.cell == GOAL
        steps = 1.0 if action == RIGHT else 2.0
        return self.observe(), 1.0 if there else -0.1, there, self.moment == LIMIT, {"steps": steps}

    def observe(self) -> Obs:
        cell = np.zeros(GOAL + 1, np.float32)
        cell[self.cell] = 1.0
        return {"cell": cell, "action_mask": np.array([self.cell > 0, 1, 0], np.int8)}


def corridors(n_envs: int = 4) -> VecEnv:
    return make_vec_env(Corridor, n_envs, seed=0)


SMALL: dict[str, Any] = {
    "buffer_size": 400,
    "learning_starts": 40,
    "batch_size": 16,
    "target_update_interval": 40,
    "seed": 0,
    "device": "cpu",
}


def options_of(algorithm: type[Model], **options: Any) -> dict[str, Any]:
    kwargs = {"n_quantiles": 8} if algorithm is MaskedQRDQN else {}
    return {**SMALL, "policy_kwargs": kwargs, **options}


@pytest.fixture(params=[MaskedDQN, MaskedQRDQN])
def algorithm(request: pytest.FixtureRequest) -> type[Model]:
    return request.param


@pytest.fixture
def make_model(algorithm: type[Model]) -> MakeModel:
    """Maker of a small model of both algorithms: (env, and any argument)."""

    def make(**options: Any) -> Model:
        env = options.pop("env", None) or corridors()
        return algorithm("MaskedPolicy", env, **options_of(algorithm, **options))

    return make


def prefer(model: Model, *values: float) -> None:
    """Make the values of the actions what they are told to be, everywhere, in network and target."""
    if isinstance(model, MaskedDQN):
        layers, n_quantiles = [model.policy.q_net.q_net, model.policy.q_net_target.q_net], 1
    else:
        layers = [model.policy.quantile_net.quantile_net, model.policy.quantile_net_target.quantile_net]
        n_quantiles = model.policy.n_quantiles
    for last in (cast("torch.nn.Linear", net[-1]) for net in layers):
        torch.nn.init.zeros_(last.weight)
        last.bias.data = torch.tensor(values).repeat(n_quantiles)


def observations(*masks: list[int]) -> Obs:
    return {"cell": np.zeros((len(masks), GOAL + 1), np.float32), "action_mask": np.array(masks, np.int8)}


@pytest.mark.parametrize(
    "options",
    [
        {"learning_starts": 10_000},
        {"exploration_final_eps": 1.0},
        {"exploration_initial_eps": 0.0, "exploration_final_eps": 0.0},
    ],
    ids=["warm-up", "exploring", "greedy"],
)
def test_a_masked_action_is_never_taken(make_model: MakeModel, options: dict[str, Any]) -> None:
    """The corridor fails on one; the network likes the trap best."""
    model = make_model(**{"learning_starts": 0, **options})
    prefer(model, 0.0, 0.0, 9.0)

    model.learn(200)


def test_a_random_action_is_uniform_over_the_valid_ones(make_model: MakeModel) -> None:
    drawn = make_model().random_actions(observations(*[[1, 0, 1]] * 4_000))

    assert set(drawn.tolist()) == {0, 2}
    assert np.mean(drawn == 2) == pytest.approx(0.5, abs=0.04)


def test_every_env_draws_its_own_coin(make_model: MakeModel) -> None:
    """SB3 draws one for the whole batch."""
    model = make_model(exploration_initial_eps=0.5, exploration_final_eps=0.5)
    prefer(model, 9.0, 0.0, 0.0)

    actions, _ = model.predict(observations(*[[1, 1, 0]] * 4_000))

    assert np.mean(actions == RIGHT) == pytest.approx(0.25, abs=0.03)


def test_one_observation_or_a_batch_gives_one_action_or_a_batch(make_model: MakeModel) -> None:
    model = make_model(exploration_final_eps=1.0)
    one = {key: values[0] for key, values in observations([0, 1, 0]).items()}

    for deterministic in (True, False):
        action, _ = model.predict(one, deterministic=deterministic)
        assert (action.shape, int(action)) == ((), RIGHT)
        assert model.predict(observations([0, 1, 0]), deterministic=deterministic)[0].tolist() == [RIGHT]


def test_where_no_action_is_valid_any_is_drawn(make_model: MakeModel) -> None:
    assert set(make_model().random_actions(observations(*[[0, 0, 0]] * 100)).tolist()) == {0, 1, 2}


@pytest.mark.parametrize("wrap", [VecNormalize, lambda env: VecCheckNan(VecNormalize(env))])
def test_a_normalised_mask_is_refused(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path, wrap: Callable[[VecEnv], VecEnv]
) -> None:
    model = make_model()
    model.save(tmp_path / "model.zip")
    for use in (
        lambda env: make_model(env=env),
        model.set_env,
        lambda env: algorithm.load(tmp_path / "model.zip", env=env),
    ):
        with pytest.raises(ConfigError, match="norm_obs_keys without 'action_mask'"):
            use(wrap(corridors()))


def test_masks_that_are_none_are_refused(make_model: MakeModel) -> None:
    """An env of one's own may be normalised where nobody looks."""
    observation = observations([1, 1, 0])
    observation["action_mask"] = observation["action_mask"] - 0.5

    for deterministic in (True, False):
        with pytest.raises(TrainingError, match="a wrapper changed them"):
            make_model().predict(observation, deterministic=deterministic)


def test_what_acts_and_what_learns_see_the_same_normalised_features(make_model: MakeModel) -> None:
    """The replay keeps what the env gave, and normalises when it is drawn; masks stay."""
    env = VecNormalize(corridors(), norm_obs_keys=["cell"], training=False)
    env.obs_rms["cell"].mean[:], env.obs_rms["cell"].var[:] = 0.3, 0.25
    model = make_model(env=env).learn(40)
    assert model._last_obs is not None
    seen = cast("Obs", model._last_obs)
    drawn = model.replay_buffer._get_samples(np.arange(4), env=env)

    expected = [round((x - 0.3) / (0.25 + 1e-8) ** 0.5, 5) for x in (0.0, 1.0)]
    for features in (seen["cell"], drawn.observations["cell"].numpy()):
        assert np.unique(features) == pytest.approx(expected, abs=1e-4)
    assert set(drawn.observations["action_mask"].flatten().tolist()) <= {0.0, 1.0}


def test_a_network_that_saw_normalised_features_is_not_frozen() -> None:
    routes = make_routes("HexWarRoute-v0", n_envs=2, scenario=["plain"])
    model = MaskedDQN("MaskedPolicy", VecNormalize(routes, norm_obs_keys=["obs"]), buffer_size=10)
    file = io.BytesIO()
    model.save(file)

    for one in (model, MaskedDQN.load(file)):
        with pytest.raises(ConfigError, match="what VecNormalize made of the observations"):
            freeze_lower(cast("MaskedDQNPolicy", one.policy), ways=True)


def test_epsilon_is_a_function_of_the_step_count(make_model: MakeModel) -> None:
    """SB3's would be back at the start of its schedule with every call of learn."""
    model = make_model(exploration_initial_eps=0.8, exploration_final_eps=0.2, exploration_steps=480)

    seen = []
    for _ in range(4):
        model.learn(160, reset_num_timesteps=False)
        seen.append(model.exploration_rate)

    assert seen == pytest.approx([0.6, 0.4, 0.2, 0.2])
    assert model.learn(80).exploration_rate == pytest.approx(0.7)


def fill(model: Model, steps: float, *, done: bool, truncated: bool) -> None:
    """Put one transition of every env into the replay: reward 1, only action 0 taken and valid afterwards."""
    now, then = observations(*[[1, 1, 0]] * 4), observations(*[[1, 0, 0]] * 4)
    info = {"steps": steps, "TimeLimit.truncated": truncated}
    ones = np.ones(4, np.float32)
    model.replay_buffer.add(now, then, np.zeros((4, 1)), ones, ones * done, [info] * 4)


@pytest.mark.parametrize(
    ("steps", "done", "truncated", "target"),
    [
        (1.0, False, False, 1.0 + 0.5 * 0.4),
        (2.0, False, False, 1.0 + 0.25 * 0.4),
        (0.0, False, False, 1.0 + 0.4),
        (2.0, True, False, 1.0),
        (2.0, True, True, 1.0 + 0.25 * 0.4),
    ],
    ids=["one unit", "two units", "no time", "terminated", "truncated"],
)
def test_targets_by_hand(
    make_model: MakeModel, steps: float, done: bool, truncated: bool, target: float
) -> None:
    """The target is r + gamma^steps (1 - terminated) max Q over valid actions; action 0 is worth 0.4, the masked ones more."""
    model = make_model(gamma=0.5).learn(4)
    model.replay_buffer.reset()
    prefer(model, 0.4, 50.0, 90.0)
    fill(model, steps, done=done, truncated=truncated)

    model.train(gradient_steps=1, batch_size=8)

    error = target - 0.4
    huber = error**2 / 2 if error < 1.0 else error - 0.5
    weight = sum((k + 0.5) / 8 for k in range(8)) if isinstance(model, MaskedQRDQN) else 1.0
    assert model.logger.name_to_value["train/loss"] == pytest.approx(weight * huber, rel=1e-5)


def test_it_learns_the_corridor(make_model: MakeModel) -> None:
    """Straight to the goal from every cell; plain `evaluate_policy` masks by the observation."""
    model = make_model(learning_rate=5e-3, exploration_steps=800, train_freq=1, batch_size=32)

    model.learn(1_400)

    best = float(np.mean([1.0 - 0.1 * k for k in range(GOAL)]))
    returns, lengths = evaluate_policy(model, corridors(1), n_eval_episodes=40, return_episode_rewards=True)
    assert max(cast("list[int]", lengths)) <= GOAL
    assert np.mean(cast("list[float]", returns)) == pytest.approx(best, abs=0.12)


def test_a_model_made_before_its_env_learns_the_same(make_model: MakeModel, algorithm: type[Model]) -> None:
    """`HierarchicalQMIX` makes its lower level before there is a route env."""
    env = corridors()
    early = algorithm.for_spaces(env.observation_space, env.action_space, **options_of(algorithm))

    with pytest.raises(ConfigError, match=r"no env to learn in: Masked\w+.load"):
        early.learn(8)
    early.predict(observations([1, 1, 0]))
    early = algorithm.for_spaces(env.observation_space, env.action_space, **options_of(algorithm))
    early.set_env(env)
    early.learn(200)

    assert_same_weights(early, make_model().learn(200))


def test_the_number_of_envs_is_free_while_the_replay_is_empty(make_model: MakeModel) -> None:
    model = make_model().learn(80)

    with pytest.raises(ConfigError, match=r"transitions of 4 envs, got 2 envs; replay_buffer.reset\(\)"):
        model.set_env(corridors(2))
    model.replay_buffer.reset()
    model.set_env(corridors(2))
    model.learn(80, reset_num_timesteps=False)

    assert model.num_timesteps == 160
    assert model.replay_buffer.rewards.shape == (200, 2)


def test_a_loaded_model_predicts_the_same(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    model = make_model(train_freq=3, exploration_steps=900, gamma=0.9).learn(201)
    model.save(tmp_path / "model")
    observation: Obs = observations(*[[1, 1, 1]] * (GOAL + 1))
    observation["cell"] = np.eye(GOAL + 1, dtype=np.float32)

    loaded = algorithm.load(tmp_path / "model.zip")

    assert (
        loaded.predict(observation, deterministic=True)[0]
        == model.predict(observation, deterministic=True)[0]
    ).all()
    assert (loaded.exploration_rate, loaded.update_every, loaded.gamma) == (model.exploration_rate, 3, 0.9)
    assert (loaded.observation_space, loaded.action_space) == (model.observation_space, model.action_space)
    assert_same_weights(loaded, model)
    loaded.set_env(corridors(2))
    loaded.learn(40, reset_num_timesteps=False)


WRONG: list[Any] = [{"x": 1}, [[1]], "x", -5, -0.5, 10**18, None, True, {":type:": "x", ":serialized:": "x"}]


def test_every_value_of_a_zip_is_of_its_kind_and_in_its_range(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    """Whatever one of them is changed to, it is refused by name, or it is a value that a user may give, too."""
    path = tmp_path / "model.zip"
    make_model().save(path)
    names = [name for name in parts_of(path)[1] if name != "left_out"]
    taken = set()
    for name in [*names, "predict", "tensorboard_log"]:
        for value in WRONG:
            file = io.BytesIO(changed(path, **{name: value}))
            try:
                loaded = algorithm.load(file)
            except CheckpointError as error:
                assert "data" in error.place  # noqa: PT017  # of many, one by one
            else:
                assert getattr(loaded, algorithm.attributes.get(name, name)) == value
                taken.add(name)
    assert taken <= {"seed", "final_learning_rate", "is_normalised", "learning_rate", "max_grad_norm"}


def test_spaces_of_a_zip_are_boxes_that_a_file_can_hold(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    path = tmp_path / "model.zip"
    make_model().save(path)
    boxes = parts_of(path)[1]["boxes"]
    cell = boxes["cell"]
    for wrong in (
        *({**cell, "shape": shape} for shape in ([10**9], [10**5, 10**5], [-1], [4], "x", [], [[5]], [5.5])),
        *({**cell, "dtype": dtype} for dtype in ("O", "object", "S9", "complex64", 5, None)),
        *({**cell, "low": low} for low in (["x"], [], [0, 0], [2.0], "x", 0, [10**400])),
        *({**cell, "high": high} for high in ([-1.0], ["-inf"], [None])),
        {},
        [],
    ):
        with pytest.raises(CheckpointError, match=r"model: (data|policy)"):
            algorithm.load(io.BytesIO(changed(path, boxes={**boxes, "cell": wrong})))
    for wrong in ({}, {"cell": cell}, {"action_mask": boxes["action_mask"]}, {**boxes, "more": cell}):
        with pytest.raises(CheckpointError):
            algorithm.load(io.BytesIO(changed(path, boxes=wrong)))


def test_layers_are_those_of_the_weights_before_memory_is_taken(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    path = tmp_path / "model.zip"
    make_model().save(path)
    for net_arch in ([4096] * 16, [10**9], [64], [64, 64, 64], [], ["x"], [64] * 10_000, "x"):
        with pytest.raises(CheckpointError):
            algorithm.load(io.BytesIO(changed(path, policy_kwargs={"net_arch": net_arch})))


def test_a_zip_of_an_earlier_version_is_read_with_trust_alone(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    """As SB3's own `save` writes it."""
    model = make_model(train_freq=3).learn(80)
    again = ["lr_schedule", "train_freq", "rng", "replay_buffer_class", "exploration_schedule", "_last_obs"]
    stats = ["batch_norm_stats", "batch_norm_stats_target", "_last_episode_starts"]
    OffPolicyAlgorithm.save(model, tmp_path / "old.zip", exclude=[*again, *stats])

    with pytest.raises(CheckpointError, match=r"of an earlier version.*trust=True"):
        algorithm.load(tmp_path / "old.zip")
    loaded = algorithm.load(tmp_path / "old.zip", env=corridors(), trust=True)

    assert_same_weights(loaded, model)
    assert (loaded.update_every, loaded.num_timesteps) == (3, model.num_timesteps)
    loaded.learn(40, reset_num_timesteps=False)


def test_a_learning_rate_that_is_a_function_is_left_out_and_wanted_back(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    with pytest.warns(UserWarning, match="learning_rate cannot be saved"):
        make_model(learning_rate=lambda left: 1e-3 * left).save(tmp_path / "model.zip")

    with pytest.raises(CheckpointError, match="data: learning_rate: found nothing"):
        algorithm.load(tmp_path / "model.zip")
    again = algorithm.load(tmp_path / "model.zip", learning_rate=lambda left: 1e-3 * left)
    assert again.lr_schedule(0.5) == pytest.approx(5e-4)


@pytest.mark.parametrize("activation", [torch.nn.Tanh, "tanh"])
def test_layers_and_functions_of_torch_are_saved_by_name(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path, activation: object
) -> None:
    model = make_model(policy_kwargs={"net_arch": [8, 4], "activation_fn": activation})
    model.save(tmp_path / "model.zip")
    loaded = algorithm.load(tmp_path / "model.zip")

    assert_same_weights(loaded, model)
    for one in (model, loaded):
        network: Any = one.q_net.q_net if isinstance(one, MaskedDQN) else one.quantile_net.quantile_net
        assert [type(layer).__name__ for layer in network] == ["Linear", "Tanh", "Linear", "Tanh", "Linear"]
        assert [network[0].out_features, network[2].out_features] == [8, 4]


def test_a_function_that_is_none_is_refused(make_model: MakeModel) -> None:
    with pytest.raises(UnknownNameError, match="unknown activation_fn 'tanhh'; did you mean 'tanh'"):
        make_model(policy_kwargs={"activation_fn": "tanhh"})
    with pytest.raises(
        ConfigError, match=r"policy_kwargs.activation_fn must be a class of torch.nn, or one of"
    ):
        make_model(policy_kwargs={"activation_fn": np.tanh})


@pytest.mark.parametrize(
    "wrong", [{"activation_fn": torch.nn.Tanh}, {"net_arch": [32, 16]}, {"net_arch": [64]}]
)
def test_what_the_drive_loop_cannot_compute_is_not_frozen(wrong: dict[str, Any]) -> None:
    """Rather than playing otherwise than it was trained."""
    model = MaskedDQN(
        "MaskedPolicy", make_routes("HexWarRoute-v0", seed=0), policy_kwargs=wrong, buffer_size=9
    )
    with pytest.raises(
        ConfigError, match=r"ReLU between its layers, got Tanh|expected \(64, 73\)|two hidden layers"
    ):
        freeze_lower(cast("MaskedDQNPolicy", model.policy), ways=True)


class Halved(MaskedExtractor):
    """Features of one's own, as wide as the stock ones."""

    def forward(self, observations: Any) -> torch.Tensor:
        return super().forward(observations) / 2


def test_features_of_ones_own_are_not_frozen() -> None:
    kwargs = {"features_extractor_class": Halved}
    model = MaskedDQN(
        "MaskedPolicy", make_routes("HexWarRoute-v0", seed=0), policy_kwargs=kwargs, buffer_size=9
    )
    with pytest.raises(ConfigError, match="reads the features as they are"):
        freeze_lower(cast("MaskedDQNPolicy", model.policy), ways=True)


class Cubed(torch.nn.Module):
    """A function of one's own."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return x**3


def test_classes_of_the_policy_are_left_out_and_wanted_back(tmp_path: Path) -> None:
    kwargs = {"activation_fn": Cubed}
    model = MaskedDQN("MaskedPolicy", corridors(), **{**SMALL, "policy_kwargs": kwargs})
    with pytest.warns(UserWarning, match="policy_kwargs cannot be saved"):
        model.save(tmp_path / "model.zip")

    with pytest.raises(CheckpointError, match="data: policy_kwargs: found nothing"):
        MaskedDQN.load(tmp_path / "model.zip")
    loaded = MaskedDQN.load(tmp_path / "model.zip", policy_kwargs=kwargs)
    assert_same_weights(loaded, model)


def test_what_can_be_trained_with_can_be_saved_and_loaded(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    """Plain values are made of those of numpy when the model is made."""
    given: dict[str, Any] = {
        "batch_size": np.int64(16),
        "buffer_size": 400.0,
        "gamma": np.float32(0.5),
        "train_freq": [np.int8(4), "step"],
        "gradient_steps": np.int64(-1),
        "exploration_steps": np.float64(300),
        "policy_kwargs": {"net_arch": (np.int64(8),)},
    }
    model = make_model(**given).learn(60)
    model.save(tmp_path / "model.zip")
    loaded = algorithm.load(tmp_path / "model.zip")

    for one in (model, loaded):
        assert (one.batch_size, one.buffer_size, one.gamma, one.update_every) == (16, 400, 0.5, 4)
        assert (one.gradient_steps, one.exploration_steps, type(one.exploration_steps)) == (-1, 300, int)
        assert one.policy_kwargs["net_arch"] == [8]


def test_a_seed_that_is_set_later_reaches_exploration(make_model: MakeModel) -> None:
    models = [make_model(seed=None) for _ in range(2)]
    start = copy.deepcopy(models[0].policy.state_dict())
    for model in models:
        model.policy.load_state_dict(start)
        model.set_random_seed(5)
        model.learn(120)

    assert_same_weights(*models)


def test_updates_of_every_step_do_not_pile_up(make_model: MakeModel) -> None:
    """As many updates as steps: those of the last round, not of all before learning began."""
    model = make_model(gradient_steps=-1, learning_starts=100, train_freq=2).learn(104)

    assert model._n_updates == 8


def test_an_env_of_other_spaces_is_refused(make_model: MakeModel, algorithm: type[Model]) -> None:
    file, model = io.BytesIO(), make_model()
    model.save(file)
    other = Corridor()
    other.action_space = spaces.Discrete(4)

    with pytest.raises(ConfigError, match=r"made for .*Discrete\(3\).*the env has .*Discrete\(4\)"):
        algorithm.load(file, env=other)
    with pytest.raises(ConfigError, match=r"the env has .*Discrete\(4\)"):
        model.set_env(other)


def test_a_replay_file_is_read_without_pickle(make_model: MakeModel, tmp_path: Path) -> None:
    model, other = make_model().learn(80), make_model()
    model.save_replay_buffer(tmp_path / "replay.npz")

    other.load_replay_buffer(tmp_path / "replay.npz")

    np.testing.assert_array_equal(other.replay_buffer.rewards, model.replay_buffer.rewards)


class KeepAt(BaseCallback):
    """Keeps what a checkpoint would hold, at a vector-step boundary."""

    def __init__(self, step: int) -> None:
        super().__init__()
        self.step, self.kept = step, {}  # type: ignore[var-annotated]

    def _on_rollout_start(self) -> None:
        if self.model.num_timesteps == self.step:
            model, parts, file = cast("Model", self.model), io.BytesIO(), io.BytesIO()
            np.savez(parts, **model.snapshot())  # type: ignore[arg-type]
            model.save(file)
            self.kept = {
                "parts": parts,
                "file": file,
                "env": copy.deepcopy(model.env),
                "last_obs": copy.deepcopy(model._last_obs),
                "torch": torch.get_rng_state(),
                "numpy": np.random.get_state(),  # noqa: NPY002
            }

    def _on_step(self) -> bool:
        return True


@pytest.mark.parametrize("buffer_size", [120, 1_000], ids=["full", "filling"])
def test_resumed_is_unbroken(make_model: MakeModel, algorithm: type[Model], buffer_size: int) -> None:
    options = {"buffer_size": buffer_size, "exploration_steps": 300, "train_freq": 1}
    keep = KeepAt(200)
    unbroken = make_model(**options).learn(400, callback=keep)

    keep.kept["parts"].seek(0)
    resumed = algorithm.load(keep.kept["file"], env=keep.kept["env"])
    resumed._last_obs = keep.kept["last_obs"]
    with np.load(keep.kept["parts"], allow_pickle=False) as parts:
        resumed.restore(dict(parts))
    torch.set_rng_state(keep.kept["torch"])
    np.random.set_state(keep.kept["numpy"])  # noqa: NPY002
    assert resumed.num_timesteps == 200
    resumed.learn(200, reset_num_timesteps=False)

    assert resumed.num_timesteps == unbroken.num_timesteps
    assert_same_weights(resumed, unbroken)


def test_many_short_phases_are_one_long_run(make_model: MakeModel) -> None:
    """`HierarchicalQMIX` calls learn again and again."""
    phases = make_model(exploration_steps=300)
    for _ in range(5):
        phases.learn(80, reset_num_timesteps=False)

    assert_same_weights(phases, make_model(exploration_steps=300).learn(400))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gamma": 1.5}, r"gamma must be in \[0, 1\], got 1.5"),
        ({"learning_rate": -1.0}, "learning_rate must be above 0 and finite, got -1.0"),
        ({"exploration_steps": 0}, "exploration_steps must be at least 1, got 0"),
        ({"exploration_final_eps": 2.0}, r"exploration_final_eps must be in \[0, 1\], got 2.0"),
        ({"train_freq": 0}, "train_freq must be a number of VecEnv steps, got 0"),
        ({"train_freq": 10**9}, "train_freq must be a number of VecEnv steps, got 1000000000"),
        ({"train_freq": ("step", 4)}, "train_freq must be a number of VecEnv steps"),
        ({"batch_size": 0}, "batch_size must be at least 1, got 0"),
        ({"buffer_size": 10**12}, "buffer_size must be at most"),
        ({"seed": 2**63}, "seed must be at most"),
        (
            {"learning_rate": lambda left: left, "final_learning_rate": 1e-5},
            "needs a number as learning_rate",
        ),
        ({"policy_kwargs": {"net_arc": [8]}}, "did you mean 'net_arch'"),
        ({"train_freq": (1, "episode")}, "train_freq must be a number of VecEnv steps, got"),
        ({"gradient_steps": 0}, "gradient_steps must be at least 1, got 0"),
    ],
)
def test_a_setting_out_of_range_is_refused(
    make_model: MakeModel, options: dict[str, Any], message: str
) -> None:
    with pytest.raises((ConfigError, UnknownSettingError), match=message):
        make_model(**options)


def test_as_many_updates_as_steps_can_be_asked_for(make_model: MakeModel) -> None:
    assert make_model(gradient_steps=-1, learning_starts=0, train_freq=2).learn(80)._n_updates == 80


@pytest.mark.parametrize("env", ["CartPole-v1", "Pendulum-v1"])
def test_an_env_without_masks_is_refused(algorithm: type[Model], env: str) -> None:
    with pytest.raises(ConfigError, match=r"must be a Dict with the key 'action_mask'|must be Discrete"):
        algorithm("MaskedPolicy", env)


def test_a_part_that_is_no_box_is_refused(algorithm: type[Model]) -> None:
    parts = {"kind": spaces.Discrete(3), "action_mask": spaces.Box(0, 1, (3,), np.int8)}

    with pytest.raises(ConfigError, match=r"must be a Box, got 'kind': Discrete\(3\)"):
        algorithm.for_spaces(spaces.Dict(parts), spaces.Discrete(3))


def assert_same_weights(one: Model, other: Model) -> None:
    """Networks, targets and the optimiser's moments, to the bit."""
    torch.testing.assert_close(one.policy.state_dict(), other.policy.state_dict(), rtol=0, atol=0)
    moments, expected = (model.policy.optimizer.state_dict()["state"] for model in (one, other))
    torch.testing.assert_close(moments, expected, rtol=0, atol=0)


def parts_of(path: Path) -> tuple[dict[str, bytes], dict[str, Any]]:
    """Entries of a zip, and the values among them."""
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    return parts, json.loads(parts["data"])


def changed(path: Path, **values: Any) -> bytes:
    """The zip with other values."""
    parts, data = parts_of(path)
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in {**parts, "data": json.dumps({**data, **values}).encode()}.items():
            archive.writestr(name, content)
    return file.getvalue()


class Poisoned(Corridor):
    """From some step on its rewards are no numbers."""

    def step(self, action: np.int64) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        obs, _, there, cut, info = super().step(action)
        return obs, float("nan"), there, cut, info


@pytest.mark.parametrize("algorithm", [MaskedDQN, MaskedQRDQN])
def test_weights_that_are_not_finite_stop_the_training(algorithm: type[Model]) -> None:
    """A NaN loss: SB3 would go on with it."""
    model = algorithm("MaskedPolicy", make_vec_env(Poisoned, 4, seed=0), **SMALL)

    with pytest.raises(TrainingError, match="the network's weights are not finite"):
        model.learn(400)


def test_the_learning_rate_falls_by_a_saved_count() -> None:
    """Not by the progress of one call of learn, which begins anew with each phase."""
    model = MaskedDQN(
        "MaskedPolicy",
        corridors(),
        **{**SMALL, "learning_rate": 1e-2},
        final_learning_rate=1e-3,
        learning_rate_steps=400,
    )
    rates = []
    for _ in range(3):
        model.learn(200, reset_num_timesteps=False)
        rates.append(model.policy.optimizer.param_groups[0]["lr"])

    assert rates == pytest.approx([5.5e-3, 1e-3, 1e-3], rel=0.1)


def test_transitions_over_several_steps_end_with_the_episode() -> None:
    """With n_steps 3: the first reward, then each later one discounted by the time before it."""
    model = MaskedDQN("MaskedPolicy", corridors(1), **SMALL, n_steps=3, gamma=0.5)
    model.learn(60)
    replay = model.replay_buffer
    for row in range(20):
        end = next(k for k in range(row, row + 3) if replay.dones[k, 0] or k == row + 2)
        factor, total = 1.0, 0.0
        for k in range(row, end + 1):
            total += factor * replay.rewards[k, 0]
            factor *= 0.5 ** replay.steps[k, 0]
        batch = replay._get_samples(np.array([row]))
        assert batch.rewards.item() == pytest.approx(total, abs=1e-6)
        assert batch.discounts is not None
        assert batch.discounts.item() == pytest.approx(factor)
        assert torch.equal(
            batch.next_observations["cell"][0], torch.as_tensor(replay.next_observations["cell"][end, 0])
        )
