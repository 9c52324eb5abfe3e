"""Model zips: read without unpickling, so that a stranger's file runs nothing."""

from __future__ import annotations

import io
import json
import pathlib
import zipfile
from abc import abstractmethod
from collections.abc import Iterable
from typing import Any, BinaryIO, ClassVar, Self

import torch
from gymnasium import spaces
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.type_aliases import GymEnv

from hexwar_sb3.algorithms.parts import read_replay, write_arrays
from hexwar_sb3.algorithms.replay import StepReplay
from hexwar_sb3.envs.snapshots import placed
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.files import replacing
from hexwar_sb3.policies.shapes import TaskShapes
from hexwar_sb3.policies.task_policy import TaskPolicy

File = str | pathlib.Path | io.BufferedIOBase
_PICKLED = ":serialized:"  # SB3's mark of a pickled value in a zip's JSON


class PlainZip(OffPolicyAlgorithm):
    """An algorithm of Stable-Baselines3 whose model zips are read without unpickling.

    A subclass keeps plain values; those under `sizes_key` are what its spaces are made of again. What it
    makes again in `_setup_model` is named in `made_again`.
    """

    replay_buffer: Any  # has snapshot() and restore()
    sizes_key: ClassVar[str]
    made_again: ClassVar[tuple[str, ...]] = ("lr_schedule", "train_freq")
    of_the_run: ClassVar[tuple[str, ...]] = (
        "_last_obs",
        "_last_original_obs",
        "_last_episode_starts",
        "ep_info_buffer",
        "ep_success_buffer",
    )

    @classmethod
    @abstractmethod
    def made_spaces(cls, data: dict[str, Any], env: GymEnv | None) -> dict[str, spaces.Space[Any]]:
        """Make `observation_space` and `action_space` of the plain values in a zip, and check that the env fits.

        Raises:
            ConfigError: the env's spaces are not the model's.
        """

    def save(
        self, path: File, exclude: Iterable[str] | None = None, include: Iterable[str] | None = None
    ) -> None:
        """Write a model zip, at once or not at all."""
        if not isinstance(path, str | pathlib.Path):
            super().save(path, exclude, include)
            return
        zipped = io.BytesIO()
        super().save(zipped, exclude, include)
        with replacing(zip_path(path)) as temporary:
            temporary.write_bytes(zipped.getvalue())

    @classmethod
    def load(
        cls,
        path: File,
        env: GymEnv | None = None,
        device: torch.device | str = "auto",
        custom_objects: dict[str, Any] | None = None,
        print_system_info: bool = False,
        force_reset: bool = True,
        trust: bool = False,
        **kwargs: Any,
    ) -> Self:
        """Read a model zip; nothing in it is unpickled unless you trust it.

        Raises:
            CheckpointError: it is broken, or not ours and not trusted.
            ConfigError: its sizes are not the env's.
        """
        objects = {**plain_objects(cls, path, env, trust), **(custom_objects or {})}
        return super().load(path, env, device, objects, print_system_info, force_reset, **kwargs)

    def save_replay_buffer(self, path: File) -> None:
        """Write the steps of the replay as arrays, without pickle."""
        steps = io.BytesIO()
        write_arrays(steps, self.replay_buffer.snapshot())
        if isinstance(path, str | pathlib.Path):
            with replacing(pathlib.Path(path)) as temporary:
                temporary.write_bytes(steps.getvalue())
        else:
            path.write(steps.getvalue())

    def load_replay_buffer(self, path: File, truncate_last_traj: bool = True) -> None:
        """Read what `save_replay_buffer` wrote.

        Raises:
            CheckpointError: it is broken, or no replay.
            ConfigError: it is of another number of games, or larger than this model's.
        """
        with placed(source=_name(path)):
            self.replay_buffer.restore(read_replay(path))

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), *self.made_again, *self.of_the_run]

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy", "policy.optimizer"], []


class PlainZipAlgorithm(PlainZip):
    """The same in a task env: its sizes, `task_sizes`, are what the spaces are made of."""

    policy: TaskPolicy
    replay_buffer: StepReplay  # has SB3's add(), and its own sample()
    sizes_key: ClassVar[str] = "task_sizes"

    @classmethod
    def made_spaces(cls, data: dict[str, Any], env: GymEnv | None) -> dict[str, spaces.Space[Any]]:
        """Take the env's spaces, with or without the mixer's state; without an env make the model's.

        Raises:
            CheckpointError: the zip holds two levels and this class has one, or the other way round.
        """
        has_lower = "lower_counters" in data
        if has_lower != ("lower" in cls.made_again):
            found, expected = (
                ("two levels", "HierarchicalQMIX.load") if has_lower else ("one level", "QMIX.load")
            )
            raise CheckpointError("model", "data", found=found, expected=expected)
        shapes = TaskShapes(**data["task_sizes"])
        if env is None:
            return {"observation_space": shapes.observation_space(), "action_space": shapes.action_space()}
        check_alike(shapes, env)
        return {"observation_space": env.observation_space, "action_space": env.action_space}

    def set_env(self, env: GymEnv, force_reset: bool = True) -> None:
        """Go on in another env of the same sizes; to train, it must give the mixer the same state."""
        check_alike(self.policy.shapes, env)
        self.observation_space, self.action_space = env.observation_space, env.action_space
        super().set_env(env, force_reset)

    def load_replay_buffer(self, path: File, truncate_last_traj: bool = True) -> None:
        """Read what `save_replay_buffer` wrote; the games that were running then end there."""
        super().load_replay_buffer(path, truncate_last_traj)
        self.replay_buffer.cut_short()


def plain_objects(algorithm: type[PlainZip], path: File, env: GymEnv | None, trust: bool) -> dict[str, Any]:
    """Values for everything in a model zip that SB3 would unpickle.

    Args:
        algorithm: that will read it.
        path: of the zip, or the open file.
        env: the env to go on with.
        trust: let SB3 unpickle what is not ours.

    Raises:
        CheckpointError: no model zip, or it holds pickled values that are not ours and is not trusted.
        ConfigError: the env's sizes are not the model's.
    """
    data, key = _read_data(path), algorithm.sizes_key
    if key not in data and not trust:
        raise CheckpointError(_name(path), "data", found=f"no {key}", expected="a zip of ours, or trust=True")
    objects: dict[str, Any] = {"policy_class": algorithm.policy_aliases["MultiInputPolicy"]}
    if key in data:
        objects |= algorithm.made_spaces(data, env)
    pickled = {name for name, value in data.items() if isinstance(value, dict) and _PICKLED in value}
    if pickled - set(objects) and not trust:
        found = f"pickled values {sorted(pickled - set(objects))}"
        raise CheckpointError(
            _name(path), "data", found=found, expected="plain values, or trust=True: unpickling runs code"
        )
    return objects


def check_alike(shapes: TaskShapes, env: GymEnv) -> None:
    """Check that a model of these sizes can act in an env.

    Raises:
        ConfigError: it cannot.
    """
    found = TaskShapes.of(env.observation_space, env.action_space)
    if not shapes.acting_alike(found):
        raise ConfigError(f"the model was made for {shapes}, the env has {found}")


def _read_data(path: File) -> dict[str, Any]:
    try:
        with zipfile.ZipFile(_with_suffix(path)) as archive:
            data = json.loads(archive.read("data"))
    except (zipfile.BadZipFile, KeyError, OSError, ValueError, RecursionError) as error:
        raise CheckpointError(_name(path), "file", found=str(error), expected="a model zip") from error
    if not isinstance(data, dict):
        raise CheckpointError(_name(path), "data", found=type(data).__name__, expected="names and values")
    return data


def _with_suffix(path: File) -> pathlib.Path | BinaryIO:
    """Add `.zip` as SB3 does."""
    if isinstance(path, io.IOBase):
        path.seek(0)
        return path  # type: ignore[return-value]
    return zip_path(path)


def zip_path(path: str | pathlib.Path) -> pathlib.Path:
    """Path of a model zip; the suffix may be left out."""
    path = pathlib.Path(path)
    return path if path.suffix else path.with_suffix(".zip")


def _name(path: File) -> str:
    return str(path) if isinstance(path, str | pathlib.Path) else "model"
