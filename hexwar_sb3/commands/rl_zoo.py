"""`python -m hexwar_sb3.commands.rl_zoo`: RL Baselines3 Zoo with our envs, algorithms and settings of them.

    python -m hexwar_sb3.commands.rl_zoo train --algo masked_dqn --env HexWarRoute-v0
    python -m hexwar_sb3.commands.rl_zoo enjoy --algo masked_dqn --env HexWarRoute-v0 --no-render

Arguments are those of `rl_zoo3`. Where no `--conf-file` is named, the settings are ours (the folder `zoo` beside this file).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
from hexwar_sb3.algorithms.masked_dqn import MaskedDQN, MaskedQRDQN
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.checks import check_choice
from hexwar_sb3.envs.registration import ENVS
from hexwar_sb3.errors import ConfigError, HexWarError

ALGORITHMS: dict[str, Any] = {
    "masked_dqn": MaskedDQN,
    "masked_qrdqn": MaskedQRDQN,
    "qmix": QMIX,
    "hierarchical_qmix": HierarchicalQMIX,
}
"""Ours, by their names in the zoo."""
COMMANDS = ("train", "enjoy")
SETTINGS = Path(__file__).parent / "zoo"  # a file an algorithm, an entry an env


def settings_file(algorithm: str) -> Path:
    """The zoo's hyperparameters of an algorithm for our envs; there need not be any."""
    return SETTINGS / f"{algorithm}.yml"


def completed(arguments: Sequence[str]) -> list[str]:
    """Arguments of the zoo, with our settings where we have some and the caller names none.

    Args:
        arguments: "train", and what follows.
    """
    given = list(arguments)
    named = any(flag in given for flag in ("-conf", "--conf-file"))
    if given[:1] != ["train"] or named or _after(given, "--env") not in ENVS:
        return given
    ours = settings_file(_after(given, "--algo"))
    return [*given, "--conf-file", str(ours)] if ours.exists() else given


def _after(given: Sequence[str], flag: str) -> str:
    """What stands behind a flag, if it is there."""
    return given[given.index(flag) + 1] if flag in given[:-1] else ""


def register() -> None:
    """Tell the zoo our algorithms, beside those of Stable-Baselines3.

    Raises:
        ConfigError: it is not installed.
    """
    try:
        zoo = import_module("rl_zoo3.utils")
    except ModuleNotFoundError as error:
        raise ConfigError(f"RL Baselines3 Zoo is not installed ({error}): pip install rl_zoo3") from error
    zoo.ALGOS.update(ALGORITHMS)


def main() -> None:
    """Run the zoo's own `train` or `enjoy`."""
    command = sys.argv[1] if len(sys.argv) > 1 else ""
    try:
        check_choice("command of the zoo", command, COMMANDS)
        register()
    except HexWarError as error:
        sys.exit(f"rl_zoo: {error}")
    sys.argv[1:] = completed(sys.argv[1:])[1:]
    getattr(import_module(f"rl_zoo3.{command}"), command)()


if __name__ == "__main__":
    main()
