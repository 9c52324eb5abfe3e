"""Presets and run folders: how they are loaded, and what must then be right."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from tests.attack import valid
from tests.attack.oracle import Attempt, check, check_said, learn, said
from tests.attack.tricks import Case, Trick, Tricks, byte_tricks, of_file, place_cases
from tests.attack.tricks_json import VALUES, Place, json_tricks, with_value
from tests.attack.valid import CHECKPOINT


def preset_cases(folder: Path) -> Iterator[Case]:
    file = "preset.json"
    yield from of_file(file, byte_tricks, folder)
    yield from of_file(file, json_tricks, folder)
    yield from of_file(file, _more_settings, folder)
    yield from place_cases(file)


def _more_settings(data: bytes) -> Tricks:
    """Settings that the valid file does not have, with values that cost."""
    from hexwar_sb3.algorithms.preset_file import KNOWN

    document = json.loads(data)
    for part, names in KNOWN.items():
        for name in names:
            if name not in document["preset"].get(part, {}):
                spoilt = {
                    **document,
                    "preset": {**document["preset"], part: {**document["preset"].get(part, {}), name: 0}},
                }
                for kind in ("10^9", "10^12", "-1", "0", "x", "null", "true", "1e308", "list"):
                    make = partial(_set_setting, spoilt, ("preset", part, name), VALUES[kind])
                    yield Trick("json more", f"preset/{part}/{name} = {kind}", make)


def _set_setting(document: Any, place: Place, value: str, _: bytes) -> bytes:
    return with_value(place, value, json.dumps(document).encode())


def _without_inf(preset: Any) -> Any:
    """As JSON says it, which has no infinite number."""
    return json.loads(json.dumps(preset), parse_constant=lambda _: None)


def preset_attempt(_: Path) -> Attempt:
    caught = catch_trainings()

    def attempt(folder: Path) -> None:
        from hexwar_sb3.algorithms.preset_file import load_preset

        path = folder / "preset.json"
        preset = load_preset(str(path))
        check_said(said(path.read_bytes())["preset"], _without_inf(asdict(preset)))
        caught.clear()
        how = ("--scenario", valid.SCENARIO, "--opponents", "MA1", "--device", "cpu", "-n", "24")
        command("train", "--preset", str(path), *how, "--runs", str(folder / "runs"))
        check(len(caught) == 1, "it ended well, and no training began")
        learn(caught[0][1], 4)

    return attempt


def run_cases(folder: Path) -> Iterator[Case]:
    yield from of_file("config.json", byte_tricks, folder)
    yield from of_file("config.json", json_tricks, folder)
    yield from place_cases("config.json")
    yield from place_cases("preset.json")
    yield from place_cases(CHECKPOINT)
    for name in ("progress_1.csv", "progress_2.csv"):
        yield Case("place", f"{name} is binary", partial(_write_binary, name))


def _write_binary(name: str, folder: Path) -> None:
    (folder / name).write_bytes(bytes(range(256)))


class Trainings(list[tuple[Any, Any]]):
    """Takes the place of the training itself: keeps settings and model of every one that would begin."""

    def __call__(self, settings: Any, model: Any, _: Any) -> int:
        self.append((settings, model))
        return 0


def catch_trainings() -> Trainings:
    """Let `hexwar train` load all that it needs, and then not train."""
    from hexwar_sb3.commands import training

    vars(training)["train"] = caught = Trainings()
    return caught


def command(*arguments: str) -> None:
    """Run `hexwar`; a refusal is an error of ours again."""
    from hexwar_sb3.cli import main
    from hexwar_sb3.errors import HexWarError

    out, err = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main(arguments)
    except SystemExit as end:
        if end.code:
            raise HexWarError(err.getvalue().strip()) from None


ELSEWHERE = ("preset", "runs", "resume", "progress", "json", "trained_agent")
"""Settings that a resumed run does not take from its file."""


def run_attempt(root: Path) -> Attempt:
    from hexwar_sb3.commands import training

    caught, good = catch_trainings(), json.loads((root / "run" / "config.json").read_bytes())

    def attempt(folder: Path) -> None:
        caught.clear()
        command("train", "--resume", str(folder))
        check(len(caught) == 1, "it ended well, and no training began")
        settings, model = caught[0]
        for name, value in said((folder / "config.json").read_bytes()).items():
            taken = getattr(settings, name)
            if name not in ELSEWHERE:
                plain = isinstance(good[name], int | float | str)
                check(not plain or type(taken) is type(good[name]), f"{name} was taken as {taken!r:.60}")
                check_said(value, json.loads(json.dumps(taken, default=str)), f"{name}.")
        for name in ("n_timesteps", "eval_freq", "eval_games", "save_freq", "final_games"):
            check(getattr(settings, name) >= 1, f"{name} is {getattr(settings, name)}")
        settings.evaluation()
        training.watchers(settings, _run_folder(folder))
        learn(model, 2)

    return attempt


def _run_folder(folder: Path) -> Any:
    from hexwar_sb3.commands.run_folder import RunFolder

    run = RunFolder(folder)
    run.minutes_before()
    return run
