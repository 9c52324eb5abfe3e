"""Models that are saved and loaded without pickle: what is in their zips, and how it is checked."""

from __future__ import annotations

import io
import pathlib
import warnings
from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Self

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.base_class import maybe_make_env
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import GymEnv, TensorDict

from hexwar_sb3.algorithms.checkpoint_arrays import read_replay, write_arrays
from hexwar_sb3.algorithms.model_zip import (
    File,
    ModelZip,
    has_pickles,
    print_system,
    read_file,
    read_zip,
    write_zip,
    zip_path,
)
from hexwar_sb3.algorithms.ranges import SEED, Kind, Misfit, Table, is_plain, mended, options, setting
from hexwar_sb3.algorithms.tensors import (
    check_forms,
    checked_state,
    checked_weights,
    forms_of,
    pack,
    state_of,
)
from hexwar_sb3.envs.snapshots import placed
from hexwar_sb3.errors import CheckpointError, ConfigError, HexWarError, UnknownSettingError
from hexwar_sb3.files import replacing

ATTRIBUTES = {"stats_window_size": "_stats_window_size"}  # of SB3, where it differs from the argument's name
OF_THE_CALLER = ("verbose", "tensorboard_log")  # settings that no file decides
WITHOUT_MEANING = ("optimize_memory_usage",)  # arguments of SB3's that loaders pass on
ZIP_NAMES = ("QMIX", "HierarchicalQMIX", "MaskedDQN", "MaskedQRDQN")


class PlainZip(OffPolicyAlgorithm):
    """An algorithm of Stable-Baselines3 whose model zips hold plain values and tensors, and nothing to unpickle.

    A subclass says in tables what a zip holds: `settings` by the constructor's names, `state` by attributes, and
    `sizes`, of which its spaces are made again. The same tables check and mend the settings at construction.
    """

    replay_buffer: Any  # has snapshot() and restore()
    settings: ClassVar[Table]
    state: ClassVar[Table]
    sizes: ClassVar[Table]
    attributes: ClassVar[Mapping[str, str]] = ATTRIBUTES
    places: ClassVar[tuple[str, ...]] = OF_THE_CALLER  # further arguments of `load`
    zip_name: ClassVar[str]  # of the class, in a zip

    @classmethod
    @abstractmethod
    def made_spaces(cls, values: dict[str, Any]) -> tuple[spaces.Space[Any], spaces.Space[Any]]:
        """Make the observation and action space again, of the sizes in a zip.

        Raises:
            Misfit: they do not fit together.
        """

    @abstractmethod
    def check_env(self, env: GymEnv) -> None:
        """Check that the model can act in an env, and learn from what its wrappers make of it.

        Raises:
            ConfigError: it cannot.
        """

    def _mend_settings(self) -> None:
        """Check the settings, and make plain what can be: then all that can be learned with can be saved.

        Raises:
            ConfigError: one is of another kind or out of its range.
        """
        for name, kind in self._tables(self.policy_class).items():
            attribute = self.attributes.get(name, name)
            setattr(self, attribute, setting(name, getattr(self, attribute), kind))
        if callable(self.learning_rate) and getattr(self, "final_learning_rate", None) is not None:
            raise ConfigError(
                "final_learning_rate needs a number as learning_rate, got a function: leave one out"
            )

    @classmethod
    def _tables(cls, policy: object) -> Table:
        """Kinds of the settings; a policy of one's own takes arguments of its own."""
        own = {} if policy is cls._stock_policy() else {"policy_kwargs": options}
        return {**cls.settings, **own}

    def save(
        self, path: File, exclude: Iterable[str] | None = None, include: Iterable[str] | None = None
    ) -> None:
        """Write a model zip, at once or not at all: the settings and counters that loading needs, and the weights.

        A setting that is no plain value (a function as learning rate, a network class of your own) is left out with a
        warning; `load` then wants it back.

        Args:
            path: of the zip, or an open binary file.
            exclude: settings that are left out, too.
            include: without meaning here: what a zip holds is fixed.
        """
        data = self._data(frozenset(exclude or ()))
        if left_out := data["left_out"]:
            again = ", ".join(f"{name!r}: ..." for name in left_out)
            warnings.warn(
                f"{', '.join(left_out)} cannot be saved as plain values; loading this model needs them again:"
                f" {type(self).__name__}.load(path, custom_objects={{{again}}})",
                stacklevel=2,
            )
        zipped = write_zip(data, self._packed())
        if isinstance(path, str | pathlib.Path):
            with replacing(zip_path(path)) as temporary:
                temporary.write_bytes(zipped)
        else:
            path.write(zipped)

    def _data(self, exclude: frozenset[str]) -> dict[str, Any]:
        """Everything but the weights."""
        values = {name: getattr(self, self.attributes.get(name, name)) for name in self.settings}
        own = {} if self.policy_class is self._stock_policy() else {"policy_class": self.policy_class}
        left_out = [name for name, one in {**values, **own}.items() if name in exclude or not is_plain(one)]
        return {
            "algorithm": self.zip_name,
            "left_out": left_out,
            **{name: one for name, one in values.items() if name not in left_out},
            **{name: getattr(self, name) for name in (*self.state, *self.sizes)},
        }

    def _packed(self) -> dict[str, bytes]:
        """Weights, by the part of the model."""
        packed = {}
        for part in self._get_torch_save_params()[0]:
            owner = self._part(part)
            tensors = state_of(owner) if isinstance(owner, torch.optim.Optimizer) else owner.state_dict()
            packed[part] = pack(tensors)
        return packed

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy", "policy.optimizer"], []

    def _part(self, name: str) -> Any:
        owner: Any = self
        for step in name.split("."):
            owner = getattr(owner, step)
        return owner

    @classmethod
    def load(
        cls,
        path: File,
        env: GymEnv | None = None,
        device: torch.device | str = "auto",
        custom_objects: dict[str, Any] | None = None,
        print_system_info: bool = False,
        force_reset: bool = True,  # noqa: ARG003  # SB3's
        trust: bool = False,
        **kwargs: Any,
    ) -> Self:
        """Read a model zip; nothing in it is unpickled, unless it is of SB3's own kind and you trust it.

        Args:
            path: of the zip, with or without the suffix, or an open binary file. It is read once.
            env: to go on in.
            device: "auto" takes a GPU where there is one.
            custom_objects: values that are taken instead of the zip's; names that mean nothing here are ignored.
            print_system_info: print on what it was saved.
            force_reset: without meaning: the env is reset when learning begins, as the zip holds no running games.
            trust: unpickle the zips that earlier versions wrote; that can run code.
            kwargs: settings and counters that are taken instead of the zip's; verbose, tensorboard_log.

        Raises:
            CheckpointError: it is broken, of another class, or pickled and not trusted.
            ConfigError: its sizes are not the env's, or a value that you give is out of its range.
            UnknownSettingError: no such argument.
        """
        name, content = read_file(path)
        given = cls._given(custom_objects or {}, kwargs)
        if trust and has_pickles(name, content):
            return cls._load_pickled(name, content, env, device, given)
        zipped = read_zip(name, content)
        if print_system_info:
            print_system(zipped)
        values = cls._checked(zipped, given)
        model = cls._made(zipped, values, given, env, device)
        model._take(zipped)  # noqa: SLF001  # a class method of its own
        return model

    @classmethod
    def _given(cls, custom: Mapping[str, Any], kwargs: Mapping[str, Any]) -> dict[str, Any]:
        """What the caller wants instead of the zip's values."""
        policy = {**custom, **kwargs}.get("policy_class", cls._stock_policy())
        tables: dict[str, Kind | None] = {**cls._tables(policy), **cls.state, **dict.fromkeys(cls.places)}
        tables["policy_class"] = None
        for name in kwargs:
            if name not in tables and name not in WITHOUT_MEANING:
                raise UnknownSettingError("argument", name, tables)
        given = {name: one for name, one in {**custom, **kwargs}.items() if name in tables}
        if callable(given.get("learning_rate")):
            given.setdefault("final_learning_rate", None)
        kinds = {name: tables[name] for name in given}
        return {
            name: one if (kind := kinds[name]) is None else setting(name, one, kind)
            for name, one in given.items()
        }

    @classmethod
    def _checked(cls, zipped: ModelZip, given: dict[str, Any]) -> dict[str, Any]:
        """Values of a zip, each of its kind and in its range, and those that the caller gives.

        Raises:
            CheckpointError: one is not, is missing or has no meaning.
        """
        data = dict(zipped.data)
        algorithm, left_out = data.pop("algorithm", None), data.pop("left_out", None)
        if algorithm != cls.zip_name:
            expected = (
                f"{cls.zip_name}: {algorithm}.load reads it" if algorithm in ZIP_NAMES else cls.zip_name
            )
            raise CheckpointError(zipped.name, "data: algorithm", found=repr(algorithm), expected=expected)
        tables = {**cls._tables(given.get("policy_class", cls._stock_policy())), **cls.state, **cls.sizes}
        if not isinstance(left_out, list) or not all(one in (*tables, "policy_class") for one in left_out):
            raise CheckpointError(zipped.name, "data: left_out", found=repr(left_out), expected="names")
        for name in left_out:
            if name not in given:
                expected = f"custom_objects={{{name!r}: ...}}, as it could not be saved"
                raise CheckpointError(zipped.name, f"data: {name}", found="nothing", expected=expected)
        for name in data:
            if name not in tables:
                raise CheckpointError(zipped.name, f"data: {name}", found="an unknown name", expected="none")
        return {
            name: given[name] if name in given else cls._value(zipped.name, data, name, kind)
            for name, kind in tables.items()
        }

    @classmethod
    def _value(cls, source: str, data: Mapping[str, Any], name: str, kind: Kind) -> Any:
        if name not in data:
            raise CheckpointError(source, f"data: {name}", found="nothing", expected="all of a model")
        try:
            return mended(name, data[name], kind)
        except Misfit as misfit:
            raise CheckpointError(
                source, f"data: {misfit.place}", found=misfit.found, expected=misfit.expected
            ) from None
        except HexWarError as error:
            raise CheckpointError(
                source, f"data: {name}", found=str(error), expected="a known one"
            ) from error

    @classmethod
    def _made(
        cls,
        zipped: ModelZip,
        values: dict[str, Any],
        given: Mapping[str, Any],
        env: GymEnv | None,
        device: torch.device | str,
    ) -> Self:
        """Build the model, after a look at what its networks would need."""
        policy = given.get("policy_class", cls._stock_policy())
        try:
            observation_space, action_space = cls.made_spaces(values)
            if policy is cls._stock_policy():
                cls._check_networks(zipped, values, observation_space, action_space)
        except Misfit as misfit:
            raise CheckpointError(
                zipped.name, f"data: {misfit.place or 'sizes'}", found=misfit.found, expected=misfit.expected
            ) from None
        if env is not None:
            env = cls._wrap_env(maybe_make_env(env, 0))
            cls._check_spaces(observation_space, action_space, env)
        made: Any = cls  # whose constructor takes more than that of SB3's base
        model: Self = made(policy=policy, env=env, device=device, _init_setup_model=False)
        for name, one in values.items():
            setattr(model, cls.attributes.get(name, name), one)
        for name in cls.places:
            if name in given:
                setattr(model, name, given[name])
        if env is None:
            model.observation_space, model.action_space, model.n_envs = observation_space, action_space, 1
        else:
            model.check_env(env)
        try:
            model._setup_model()
        except HexWarError as error:
            if given:
                raise
            raise CheckpointError(
                zipped.name, "data", found=str(error), expected="settings that fit"
            ) from error
        return model

    @classmethod
    @abstractmethod
    def _check_spaces(
        cls, observation_space: spaces.Space[Any], action_space: spaces.Space[Any], env: GymEnv
    ) -> None:
        """Check that an env fits the spaces of a zip.

        Raises:
            ConfigError: it does not.
        """

    @classmethod
    def _check_networks(
        cls,
        zipped: ModelZip,
        values: dict[str, Any],
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
    ) -> None:
        """Check that the weights in a zip are those of its settings, before memory is taken."""
        check_part(
            zipped, "policy", cls._stock_policy(), observation_space, action_space, values["policy_kwargs"]
        )

    @classmethod
    def _stock_policy(cls) -> type[BasePolicy]:
        return cls.policy_aliases["MultiInputPolicy"]

    def _take(self, zipped: ModelZip) -> None:
        """Take the weights of a zip.

        Raises:
            CheckpointError: they are others than this model's.
        """
        parts = self._get_torch_save_params()[0]
        for part in (*parts, *zipped.weights):
            if part not in parts or part not in zipped.weights:
                found = "nothing" if part in parts else "an unknown part"
                raise CheckpointError(
                    zipped.name, part, found=found, expected=f"weights of {', '.join(parts)}"
                )
        checked = []
        for part in parts:
            owner, tensors = self._part(part), zipped.weights[part]
            check = checked_state if isinstance(owner, torch.optim.Optimizer) else checked_weights
            checked.append((owner, check(owner, tensors, zipped.name, part)))
        for owner, state in checked:
            owner.load_state_dict(state)

    @classmethod
    def _load_pickled(
        cls,
        name: str,
        content: bytes,
        env: GymEnv | None,
        device: torch.device | str,
        given: Mapping[str, Any],
    ) -> Self:
        """Let SB3 unpickle a zip that is trusted.

        Raises:
            CheckpointError: it is no model of this class.
        """
        attributes = {cls.attributes.get(key, key): one for key, one in given.items()}
        objects = {"policy_class": cls._stock_policy(), "tensorboard_log": None, "verbose": 0, **attributes}
        if env is not None:
            env = cls._wrap_env(maybe_make_env(env, 0))
            objects |= {"observation_space": env.observation_space, "action_space": env.action_space}
        try:
            return super().load(io.BytesIO(content), env, device, objects, **attributes)
        except HexWarError:
            raise
        except Exception as error:  # unpickling somebody's file can raise anything
            found = str(error) or type(error).__name__
            raise CheckpointError(name, "file", found=found, expected=f"a zip of {cls.__name__}") from error

    def set_parameters(
        self,
        load_path_or_dict: TensorDict | File,  # as SB3's, and open files
        exact_match: bool = True,
        device: torch.device | str = "auto",
    ) -> None:
        """Take over weights, of a model zip or as `get_parameters` gives them.

        Raises:
            CheckpointError: the zip is broken, or its weights are those of other sizes.
        """
        if isinstance(load_path_or_dict, dict):
            super().set_parameters(load_path_or_dict, exact_match, device)
        else:
            zipped, parts = read_zip(*read_file(load_path_or_dict)), self._get_torch_save_params()[0]
            own = {part: weights for part, weights in zipped.weights.items() if part in parts}
            PlainZip._take(self, ModelZip(zipped.name, zipped.data, own))

    def set_random_seed(self, seed: int | None = None) -> None:
        """Seed torch, numpy, the env, and the model's own generator.

        Raises:
            ConfigError: it is no whole number in 0..2**32 - 1.
        """
        seed = setting("seed", seed, SEED)
        super().set_random_seed(seed)
        if seed is not None:
            self.seed, self.rng = seed, np.random.default_rng(seed)

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
        source = path if isinstance(path, str | pathlib.Path) else "replay"
        steps = read_replay(path)
        if self.env is None:
            self._give_room(full=True)
        with placed(source=source):
            self.replay_buffer.restore(steps)

    @abstractmethod
    def _make_replay(self, buffer_size: int) -> Any:
        """Make a replay of so many steps."""

    def _give_room(self, *, full: bool = False) -> None:
        """Make the replay: a small one as long as there is no env to learn in, unless it is to be filled from a file.

        Raises:
            ConfigError: there is no memory for it.
        """
        small = self.env is None and not full
        try:
            self.replay_buffer = self._make_replay(self.n_envs if small else self.buffer_size)
        except MemoryError as error:
            raise ConfigError(f"buffer_size {self.buffer_size}: there is no memory for it") from error


def check_part(
    zipped: ModelZip,
    part: str,
    policy: type[BasePolicy],
    observation_space: spaces.Space[Any],
    action_space: spaces.Space[Any],
    arguments: Mapping[str, Any],
) -> None:
    """Check that the weights of a part are those of a policy with these options, before memory is taken.

    Raises:
        CheckpointError: they are not.
    """
    plain_optimizer = {"optimizer_class": torch.optim.SGD, "optimizer_kwargs": {}}
    try:
        with torch.device("meta"):  # shapes without memory
            made: Any = policy(
                observation_space, action_space, lambda _: 0.0, **{**arguments, **plain_optimizer}
            )
    except (HexWarError, RuntimeError, TypeError, ValueError, AssertionError) as error:
        raise CheckpointError(zipped.name, part, found=str(error), expected="settings of a policy") from error
    check_forms(zipped.weights.get(part, {}), forms_of(made), zipped.name, part)
