"""QMIX as a Stable-Baselines3 algorithm: what it plays, when it updates, what it works with."""

from __future__ import annotations

import csv
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from jaxtyping import Float
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import CheckpointCallback, EvalCallback
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.logger import configure
from stable_baselines3.common.type_aliases import TrainFreq, TrainFrequencyUnit
from stable_baselines3.common.vec_env import VecCheckNan, VecFrameStack, VecMonitor, VecNormalize
from torch import Tensor

from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.algorithms.qmix import QMIX, chunk_sizes
from hexwar_sb3.errors import CheckpointError, ConfigError, TrainingError, UnknownNameError
from hexwar_sb3.policies.mixers import MIXERS, Choices, Mixer

MakeEnv = Callable[..., VecMonitor]
MakeModel = Callable[..., QMIX]


def first_look(env: VecMonitor) -> dict[str, NDArray[Any]]:
    return cast("dict[str, NDArray[Any]]", env.reset())


def weights(model: QMIX) -> torch.Tensor:
    return torch.cat([parameter.detach().flatten() for parameter in model.policy.trained])


@pytest.mark.parametrize("mixer", MIXERS)
def test_it_plays_valid_tasks_only_and_changes_its_weights(make_model: MakeModel, mixer: str) -> None:
    """The toy env fails at a masked task; piece 2 dies, decisions have uneven lengths."""
    model = make_model(mixer=mixer)
    before = weights(model)

    model.learn(200)

    assert not torch.equal(weights(model), before)
    assert torch.isfinite(weights(model)).all()


class Mean(Mixer):
    """A mixer of somebody's own."""

    def mix(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        choices: Choices | None = None,
    ) -> Float[Tensor, "batch 1"]:
        return agent_q.mean(dim=1, keepdim=True)


def test_a_mixer_of_your_own_learns_and_is_given_again_when_loaded(
    make_model: MakeModel, tmp_path: Path
) -> None:
    """No file holds a class."""
    model = make_model(mixer=Mean).learn(60)
    with pytest.warns(UserWarning, match="policy_kwargs cannot be saved as plain values"):
        model.save(tmp_path / "model.zip")

    with pytest.raises(CheckpointError, match="custom_objects"):
        QMIX.load(tmp_path / "model.zip")
    again = QMIX.load(tmp_path / "model.zip", custom_objects={"policy_kwargs": model.policy_kwargs})

    assert isinstance(again.policy.mixer, Mean)
    assert torch.equal(weights(again), weights(model))


def test_a_memory_is_empty_where_games_begin(make_model: MakeModel, make_env: MakeEnv) -> None:
    model = make_model(memory="gru", n_steps=6).learn(60)
    obs = first_look(make_env())

    _, first = model.predict(obs, deterministic=True)
    _, second = model.predict(obs, first, deterministic=True)
    _, begun = model.predict(obs, second, np.array([True, False, False, False]), deterministic=True)

    assert first is not None
    assert second is not None
    assert begun is not None
    pieces = len(first[0]) // 4
    np.testing.assert_array_equal(begun[0][:pieces], first[0][:pieces])
    assert not np.array_equal(begun[0][pieces:], first[0][pieces:])


def test_a_policy_with_a_memory_is_not_frozen(make_model: MakeModel) -> None:
    with pytest.raises(ConfigError, match="without memory"):
        make_model(memory="gru", n_steps=6).policy.freeze()
    with pytest.raises(UnknownNameError, match="unknown memory 'lstm'"):
        make_model(memory="lstm")


def test_a_policy_of_separate_networks_is_kept_and_not_frozen(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    model = make_model(share_parameters=False).learn(60)
    model.save(tmp_path / "model.zip")
    loaded, obs = QMIX.load(tmp_path / "model.zip"), first_look(make_env())

    np.testing.assert_array_equal(
        loaded.predict(obs, deterministic=True)[0], model.predict(obs, deterministic=True)[0]
    )
    with pytest.raises(ConfigError, match="share_parameters=True"):
        model.policy.freeze()


def test_rewards_of_ones_own_are_for_agents_that_learn_alone(make_model: MakeModel) -> None:
    with pytest.raises(ConfigError, match="needs mixer='iql'"):
        make_model(individual_rewards=True)


def test_exploration_may_follow_env_steps(make_model: MakeModel) -> None:
    model = make_model(exploration_initial_eps=1.0, exploration_final_eps=0.5, exploration_steps=80)
    assert model.exploration_rate == 1.0
    assert model.learn(40).exploration_rate == 0.75
    assert model.learn(80, reset_num_timesteps=False).exploration_rate == 0.5


def test_the_scale_of_rewards_is_found_and_saved(make_model: MakeModel, tmp_path: Path) -> None:
    """What is learned is of the size 1, whatever the game pays; with a scale of its own nothing is counted."""
    model = make_model(reward_scale=None)
    assert model.scale == 1.0

    model.learn(200).save(tmp_path / "model.zip")

    assert 0.3 < model.scale < 3.0  # of some 0.75 points a step, of six steps
    assert QMIX.load(tmp_path / "model.zip").scale == model.scale
    assert make_model(reward_scale=2.0).learn(60).return_figures == make_model().return_figures


def test_the_replay_is_filled_and_nothing_learns(make_model: MakeModel) -> None:
    model = make_model()
    before = weights(model)

    model.fill_replay(200)

    assert torch.equal(weights(model), before)
    assert len(model.replay_buffer) >= 200
    assert not torch.equal(weights(model.learn(60)), before)


def test_the_mixer_learns_alone(make_model: MakeModel) -> None:
    model = make_model()
    agent, mixer = (
        torch.cat([value.flatten() for value in part.state_dict().values()]).clone()
        for part in (model.policy.agent, model.policy.mixer)
    )

    model.refit_mixer(200)

    found = (
        torch.cat([v.flatten() for v in part.state_dict().values()])
        for part in (model.policy.agent, model.policy.mixer)
    )
    assert [torch.equal(old, new) for old, new in zip((agent, mixer), found, strict=True)] == [True, False]


@pytest.mark.parametrize(
    "options", [{"td_lambda": 0.8}, {"n_steps": 1}, {"double_q": False}, {"loss": "squared"}]
)
def test_its_options_run(make_model: MakeModel, options: dict[str, Any]) -> None:
    make_model(**options).learn(100)


@pytest.mark.parametrize("preset", PRESETS)
def test_the_presets_are_arguments_of_it(make_model: MakeModel, preset: str) -> None:
    of_the_game = {"squad_initial_share": 0.0, "squad_final_share": 0.0}
    make_model(**{**PRESETS[preset].learner, **of_the_game}).learn(60)


def test_without_a_state_the_mixer_sees_all_observations(make_model: MakeModel, make_env: MakeEnv) -> None:
    model = make_model(env=make_env(with_state=False)).learn(60)

    assert model.policy.state_dim == 3 * 5


def test_one_update_is_made_for_every_finished_game(make_model: MakeModel) -> None:
    """Games of 6 decisions, 4 at a time: 40 vector steps end 24 games."""
    model = make_model().learn(160)

    assert model._episode_num == 24
    assert model._n_updates == 24


def test_updates_may_follow_vector_steps_instead(make_model: MakeModel) -> None:
    """Learning begins after the sixth vector step of forty; what came before is not made up for."""
    model = make_model(train_freq=(2, "step"), gradient_steps=3).learn(160)

    assert model._n_updates == 18 * 3


def test_updates_do_not_pile_up(make_model: MakeModel, make_env: MakeEnv, tmp_path: Path) -> None:
    """Before learning starts, or where a model goes on with fewer games: at most those of one vector step are made."""
    for train_freq in ((1, "episode"), (3, "episode"), (1, "step"), (5, "step")):
        model = make_model(train_freq=train_freq, learning_starts=200).learn(208)
        assert 0 <= model._n_updates <= 4
        model.save(tmp_path / "model.zip")
        fewer = QMIX.load(tmp_path / "model.zip", env=make_env(1))
        before = fewer._n_updates
        fewer.learn(2, reset_num_timesteps=False)
        assert fewer._n_updates - before <= 2


def test_all_games_that_ended_while_learning_began_are_learned_from(make_model: MakeModel) -> None:
    """Games of one length end together, and learning may begin a little later."""
    assert make_model(learning_starts=30).learn(32)._n_updates == 4


def test_epsilon_follows_the_number_of_games_and_survives_a_second_learn(make_model: MakeModel) -> None:
    """SB3's progress would let it jump up again."""
    model = make_model(exploration_episodes=48).learn(160)
    assert model.exploration_rate == pytest.approx(0.5 - 0.48 / 2)

    model.learn(80, reset_num_timesteps=False)
    assert model.exploration_rate == pytest.approx(0.5 - 0.48 * 40 / 48)


def test_a_learn_that_starts_anew_ends_the_running_games_in_the_replay(make_model: MakeModel) -> None:
    model = make_model().learn(40)
    model.learn(40)

    replay = model.replay_buffer
    assert replay.done[:, 9].all()
    assert not replay.is_step[:, 10].any()
    assert len(replay) == 80


def test_two_runs_of_one_seed_are_equal(make_model: MakeModel) -> None:
    first, second = (make_model().learn(160) for _ in range(2))

    assert torch.equal(weights(first), weights(second))


def test_a_batch_in_chunks_gives_the_same_mean_gradient(make_model: MakeModel) -> None:
    assert chunk_sizes(600, 256) == [256, 256, 88]
    model = make_model(chunk_size=5).learn(160)
    assert torch.isfinite(weights(model)).all()


def test_the_targets_follow_softly_or_at_once(make_model: MakeModel) -> None:
    soft = make_model().learn(160)
    hard = make_model(tau=1.0, target_update_interval=24).learn(160)

    assert not torch.equal(soft.policy.targets[0], soft.policy.trained[0])
    assert torch.equal(hard.policy.targets[0], hard.policy.trained[0])


def test_what_is_shared_is_the_mean_over_the_last_updates(make_model: MakeModel) -> None:
    model = make_model(ema_tau=0.3)
    seen = [model.policy.agent.piece.weight.detach().clone()]
    step = model.learner.step

    def watch(number: int) -> None:
        step(number)
        seen.append(model.policy.agent.piece.weight.detach().clone())

    object.__setattr__(model.learner, "step", watch)
    model.learn(160)

    mean = seen[0]
    for number, weight in enumerate(seen[1:], start=1):
        share = max(0.3, 10.0 / (number + 10))
        mean = (1.0 - share) * mean + share * weight
    assert len(seen) > 10
    shared = torch.from_numpy(model.policy.freeze().weights["piece.weight"])
    torch.testing.assert_close(shared, mean)
    assert not torch.equal(shared, seen[-1])


def test_predict_takes_one_observation_or_a_batch_and_needs_no_state(
    make_model: MakeModel, make_env: MakeEnv
) -> None:
    env = make_env()
    model = make_model(env=env)
    observation = first_look(env)
    observation.pop("state")

    batch, _ = model.predict(observation, deterministic=True)
    single, _ = model.predict({key: value[0] for key, value in observation.items()}, deterministic=True)

    assert batch.shape == (4, 3)
    assert (single == batch[0]).all()


def test_predict_explores_among_valid_tasks_unless_deterministic(
    make_model: MakeModel, make_env: MakeEnv
) -> None:
    env = make_env()
    model = make_model(env=env, exploration_initial_eps=1.0, exploration_final_eps=1.0)
    observation = first_look(env)

    drawn = [model.predict(observation)[0] for _ in range(50)]

    for tasks in drawn:
        assert np.take_along_axis(observation["action_mask"], tasks[..., None], axis=-1).all()
    assert len({tasks.tobytes() for tasks in drawn}) > 10


@pytest.mark.filterwarnings("ignore:rich is experimental")  # tqdm's own word on SB3's progress bar
def test_stock_callbacks_and_evaluation_work(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    """An env for evaluation has no privileged state."""
    eval_env = make_env(2, with_state=False)
    callbacks = [
        EvalCallback(
            eval_env, n_eval_episodes=2, eval_freq=20, best_model_save_path=str(tmp_path), verbose=0
        ),
        CheckpointCallback(save_freq=20, save_path=str(tmp_path), save_replay_buffer=True),
    ]

    model = make_model().learn(160, callback=callbacks, progress_bar=True)

    assert (tmp_path / "best_model.zip").exists()
    assert (tmp_path / "rl_model_80_steps.zip").exists()
    mean, _ = evaluate_policy(model, eval_env, n_eval_episodes=2)
    assert np.isfinite(mean)


def test_it_logs_what_tells_a_plateau_early(make_model: MakeModel, tmp_path: Path) -> None:
    model = make_model()
    model.set_logger(configure(str(tmp_path), ["csv"]))

    model.learn(300, log_interval=8)
    model.logger.close()

    with (tmp_path / "progress.csv").open() as file:
        values = {name: float(value) for name, value in list(csv.DictReader(file))[-1].items()}
    for name in ("stop_share", "task_changes", "exploration_rate", "predicted_return", "discounted_return"):
        assert np.isfinite(values[f"rollout/{name}"])
    assert values["rollout/discounted_return"] > 1.0
    assert np.isfinite(values["train/loss"])


def test_a_loss_that_is_not_finite_stops_before_the_weights_are_touched(make_model: MakeModel) -> None:
    model = make_model().learn(60)
    before = weights(model)
    model.replay_buffer.reward[:] = np.nan

    with pytest.raises(TrainingError, match="the weights are those before it"):
        next(model.updates(1, 16))

    assert torch.equal(weights(model), before)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"mixer": "qmax"}, "unknown mixer 'qmax'; did you mean 'qmix'?"),
        ({"loss": "hubert"}, "did you mean 'huber'?"),
        ({"reward_scale": 0.0}, "reward_scale must be above 0"),
        ({"n_steps": 0}, "n_steps must be at least 1, got 0"),
        ({"gamma": 2.0}, r"gamma must be in \[0, 1\], got 2.0"),
        ({"gamma": float("nan")}, "gamma must be in"),
        ({"tau": 0.0}, r"tau must be in \(0, 1\], got 0.0"),
        ({"learning_rate": -1e-3}, "learning_rate must be above 0 and finite, got -0.001"),
        ({"batch_size": 0}, "batch_size must be at least 1"),
        ({"exploration_final_eps": 1.5}, "exploration_final_eps must be in"),
        ({"td_lambda": 2.0}, r"td_lambda must be in \[0, 1\], got 2.0"),
        *(
            ({"train_freq": wrong}, r"train_freq must be \(n, 'episode'\) or")
            for wrong in (
                (1, "game"),
                ("step", 4),
                0,
                (0, "step"),
                True,
                "step",
                None,
                (1,),
                (1.5, "step"),
                [4],
            )
        ),
        (
            {"learning_rate": lambda left: left, "final_learning_rate": 1e-5},
            "final_learning_rate needs a number",
        ),
        ({"batch_size": 16.5}, "batch_size must be a whole number"),
        ({"batch_size": True}, "batch_size must be a whole number"),
        ({"buffer_size": 10**12}, "buffer_size must be at most"),
        ({"double_q": 1}, "double_q must be True or False"),
        ({"gamma": "x"}, r"gamma must be in \[0, 1\], got 'x'"),
        ({"learning_rate": float("nan")}, "learning_rate must be above 0 and finite"),
        ({"policy_kwargs": "x"}, "policy_kwargs must be names and values"),
        ({"policy_kwargs": {"hiden": 3}}, "unexpected keyword argument 'hiden'.*did you mean 'hidden'"),
        *(({"seed": seed}, "seed must be") for seed in (2**32, 2**63, 2**200, -1, "x", 0.5)),
        ({"stickiness": -1.0}, r"stickiness must be in \[0, 1\)"),
        ({"policy_kwargs": {"network": "deep"}}, "unknown network 'deep'"),
        (
            {"policy_kwargs": {"net_arch": [64]}},
            r"policy_kwargs.net_arch must be two widths, \[hidden, embed\]",
        ),
        ({"policy_kwargs": {"net_arch": [64, 0]}}, r"policy_kwargs.net_arch must be two widths"),
        (
            {"policy_kwargs": {"net_arch": [8, 4], "embed": 4}},
            r"net_arch is \[hidden, embed\], leave it or \['embed'\] out",
        ),
        (
            {"policy_kwargs": {"activation_fn": torch.nn.Tanh}},
            "policy_kwargs.activation_fn must be torch.nn.ReLU",
        ),
        ({"policy_kwargs": {"activation_fn": "tanh"}}, "policy_kwargs.activation_fn must be torch.nn.ReLU"),
    ],
)
def test_settings_out_of_range_are_refused_with_the_range(
    make_model: MakeModel, options: dict[str, Any], message: str
) -> None:
    with pytest.raises((ConfigError, UnknownNameError), match=message):
        make_model(**options)


def test_layers_may_be_said_as_sb3_says_them(make_model: MakeModel, tmp_path: Path) -> None:
    """`net_arch` of two widths, and the function between them that there is; the zip and the frozen copy have them."""
    model = make_model(policy_kwargs={"net_arch": (16, np.int64(8)), "activation_fn": torch.nn.ReLU})
    model.save(tmp_path / "model.zip")
    for one in (model, QMIX.load(tmp_path / "model.zip")):
        assert one.policy.sizes == {"hidden": 16, "embed": 8}
        assert {"hidden": 16, "embed": 8}.items() <= one.policy_kwargs.items()
    weights = model.policy.freeze().weights
    assert (len(weights["piece.weight"]), len(weights["embed.weight"])) == (16, 8)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (4, (4, "step")),
        ((4, "step"), (4, "step")),
        ([2, "episode"], (2, "episode")),
        (TrainFreq(4, TrainFrequencyUnit.STEP), (4, "step")),
        (np.int64(4), (4, "step")),
        ((4.0, "step"), (4, "step")),
    ],
)
def test_the_forms_of_train_freq_that_sb3_knows(
    make_model: MakeModel, given: Any, expected: tuple[int, str]
) -> None:
    model = make_model(train_freq=given).learn(40)

    assert model.update_every == expected


def test_an_env_without_task_sets_is_refused_with_the_way_out() -> None:
    with pytest.raises(ConfigError, match="JointActionEnv makes them of a PettingZoo parallel env"):
        QMIX("TaskPolicy", "CartPole-v1")


@pytest.mark.parametrize(
    "wrap",
    [
        VecNormalize,
        partial(VecNormalize, norm_obs_keys=["obs", "tasks"]),
        partial(VecNormalize, norm_obs=False),
        partial(VecFrameStack, n_stack=1),
        partial(VecFrameStack, n_stack=4),
        lambda env: VecMonitor(VecCheckNan(VecNormalize(env))),
    ],
)
def test_an_env_whose_observations_or_rewards_are_changed_is_refused(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path, wrap: Callable[[Any], Any]
) -> None:
    """It would act on what the wrapper gives and learn from what the env gives."""
    model = make_model()
    model.save(tmp_path / "model.zip")
    for use in (
        lambda env: make_model(env=env),
        model.set_env,
        lambda env: QMIX.load(tmp_path / "model.zip", env=env),
    ):
        with pytest.raises(ConfigError):
            use(wrap(make_env()))
    assert model.env is not None
    make_model(env=VecCheckNan(make_env())).learn(40)


def test_masks_that_are_none_are_refused(make_model: MakeModel, make_env: MakeEnv) -> None:
    """An env of one's own may be normalised where nobody looks."""
    observation = first_look(make_env())
    observation["action_mask"] = observation["action_mask"] - 0.5

    for deterministic in (True, False):
        with pytest.raises(TrainingError, match="a wrapper changed them"):
            make_model().predict(observation, deterministic=deterministic)


def test_a_seed_that_is_set_later_reaches_exploration(make_model: MakeModel) -> None:
    models = [make_model(exploration_initial_eps=1.0, exploration_final_eps=1.0, seed=None) for _ in range(2)]
    for model in models:
        model.policy.load_state_dict(models[0].policy.state_dict())
        model.set_random_seed(5)

    first, second = (weights(model.learn(160)) for model in models)

    assert torch.equal(first, second)
    with pytest.raises(ConfigError, match="seed must be"):
        model.set_random_seed(2**32)


def test_another_number_of_games_is_taken_while_the_replay_is_empty(
    make_model: MakeModel, make_env: MakeEnv, tmp_path: Path
) -> None:
    model = make_model()
    model.save(tmp_path / "model.zip")
    for fresh in (model, QMIX.load(tmp_path / "model.zip")):
        fresh.set_env(make_env(2))
        assert fresh.learn(60).replay_buffer.rows == 200
        with pytest.raises(ConfigError, match="steps of 2 games at a time, got an env of 3"):
            fresh.set_env(make_env(3))
