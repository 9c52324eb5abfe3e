"""DQN and QR-DQN with action masks: exploration, targets, discounts, files, resuming, learning."""

from __future__ import annotations

import base64
import copy
import io
import json
import pickle
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
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from hexwar_sb3.algorithms.masked_dqn import MaskedDQN, MaskedQRDQN
from hexwar_sb3.errors import CheckpointError, ConfigError, TrainingError

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


def test_a_normalised_mask_is_refused(make_model: MakeModel) -> None:
    with pytest.raises(TrainingError, match="the masks hold more than 0 and 1"):
        make_model(env=VecNormalize(corridors())).learn(8)


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


class Bomb:
    """Leaves a mark when it is unpickled."""

    exploded = False

    def __reduce__(self) -> tuple[object, tuple[type[Bomb], str, bool]]:
        return setattr, (Bomb, "exploded", True)


@pytest.mark.parametrize("name", ["policy_class", "observation_space", "action_space"])
def test_what_is_made_again_is_not_unpickled(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path, name: str
) -> None:
    swap(make_model(), tmp_path / "model.zip", name, Bomb())

    algorithm.load(tmp_path / "model.zip", env=corridors())

    assert not Bomb.exploded


def test_nothing_is_unpickled_without_trust(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    swap(make_model(), tmp_path / "model.zip", "gamma", Bomb())

    with pytest.raises(CheckpointError, match=r"pickled values \['gamma'\].*trust=True"):
        algorithm.load(tmp_path / "model.zip")
    assert not Bomb.exploded


def test_a_learning_rate_that_is_a_function_needs_trust(
    make_model: MakeModel, algorithm: type[Model], tmp_path: Path
) -> None:
    make_model(learning_rate=lambda left: 1e-3 * left).save(tmp_path / "model.zip")

    with pytest.raises(CheckpointError, match=r"pickled values \['learning_rate'\]"):
        algorithm.load(tmp_path / "model.zip")
    assert algorithm.load(tmp_path / "model.zip", trust=True).lr_schedule(0.5) == pytest.approx(5e-4)


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
        ({"train_freq": 0}, "update_every must be at least 1, got 0"),
        ({"train_freq": (1, "episode")}, "train_freq must be a number of VecEnv steps, got"),
        ({"gradient_steps": 0}, "gradient_steps must be at least 1, got 0"),
    ],
)
def test_a_setting_out_of_range_is_refused(
    make_model: MakeModel, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
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


def swap(model: Model, path: Path, name: str, value: object) -> None:
    """Save a model with a pickled value in its zip."""
    model.save(path)
    with zipfile.ZipFile(path) as archive:
        parts = {part: archive.read(part) for part in archive.namelist()}
    data = json.loads(parts["data"])
    data[name] = {":type:": "x", ":serialized:": base64.b64encode(pickle.dumps(value)).decode()}
    parts["data"] = json.dumps(data).encode()
    with zipfile.ZipFile(path, "w") as archive:
        for part, content in parts.items():
            archive.writestr(part, content)


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
