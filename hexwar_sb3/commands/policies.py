"""`hexwar export` and `hexwar import`: a policy as one file, or as ONNX graphs, and back into a folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from hexwar_sb3.commands.output import print_json
from hexwar_sb3.commands.settings import Json
from hexwar_sb3.errors import ConfigError


@dataclass(frozen=True, kw_only=True)
class Export:
    """Write a policy as one file that can be sent and imported, or as ONNX for programs in other languages."""

    policy: Annotated[
        str, tyro.conf.Positional
    ]  # run folder, policy folder, or the name of a built-in policy
    # NAME.safetensors, one file for both levels; or NAME.onnx, and NAME.lower.onnx for the lower level
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    json: Json = False

    def run(self) -> int:
        """Read it, and write what was asked for."""
        from hexwar_sb3.players.frozen import FrozenPolicy
        from hexwar_sb3.players.onnx_graphs import SUFFIX as ONNX
        from hexwar_sb3.players.onnx_graphs import save_onnx
        from hexwar_sb3.players.player import make_player
        from hexwar_sb3.players.policy_file import SUFFIX as ONE_FILE
        from hexwar_sb3.players.policy_file import save_policy_file

        if self.output.suffix not in (ONE_FILE, ONNX) or self.output.is_dir():
            raise ConfigError(f"--output must end in {ONE_FILE} or {ONNX}, got {self.output}")
        policy = make_player(self.policy)
        if not isinstance(policy, FrozenPolicy):
            raise ConfigError(
                f"{self.policy} is a scripted player: only a policy that was trained has weights to export"
            )
        if self.output.suffix == ONNX:
            return told(save_onnx(policy, self.output), json=self.json)
        save_policy_file(policy, self.output)
        return told([self.output], json=self.json)


@dataclass(frozen=True, kw_only=True)
class Import:
    """Unpack a policy that is one file into a folder; nothing in it is run."""

    file: Annotated[Path, tyro.conf.Positional]  # NAME.safetensors
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None  # folder; else NAME
    json: Json = False

    def run(self) -> int:
        """Check it, then write the folder."""
        from hexwar_sb3.folders import holding
        from hexwar_sb3.players.policy_file import load_policy_file

        folder = self.output or self.file.with_suffix("")
        policy = load_policy_file(self.file)
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise ConfigError(f"{folder} is there already: name another folder by --output")
        with holding(folder, "policy"):
            policy.save(folder)
        return told([folder], json=self.json)


def told(paths: Sequence[Path], *, json: bool) -> int:
    """Say what was written."""
    if json:
        print_json({"written": [str(path) for path in paths]})
    else:
        print("\n".join(map(str, paths)))
    return 0
