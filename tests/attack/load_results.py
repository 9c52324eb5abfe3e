"""Evaluations, matches, leagues, studies, cached tables: how they are loaded, and what must then be right."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tests.attack import valid
from tests.attack.archives import object_array, to_npy
from tests.attack.oracle import Attempt, act, arrays_of, check, check_alike, check_said, finite, said
from tests.attack.tricks import (
    Case,
    Lens,
    Trick,
    Tricks,
    byte_tricks,
    copied_over,
    flipped,
    instead,
    of_file,
    place_cases,
    rewrite,
    swapped,
)
from tests.attack.tricks_json import json_tricks, with_value
from tests.attack.valid import WEIGHTS


def curve_attempt(root: Path) -> Attempt:
    good = arrays_of(root / "curve" / "evaluations.npz")

    def attempt(folder: Path) -> None:
        from hexwar_sb3.evaluation.history import History

        path = folder / "evaluations.npz"
        history = History.load(path)
        check_alike(arrays_of(path), good, strict=False)
        check(all(step >= 0 for step in (*history.timesteps, *history.game_ticks)), "steps below 0")
        check(history.timesteps == sorted(history.timesteps), "steps that fall")
        for result in history.results:
            check(bool(np.isin(result.scores, (0.0, 0.5, 1.0)).all()), f"scores {result.scores}")
            check(
                finite(result.margins) and bool((abs(result.margins) < 1e5).all()),
                f"margins {result.margins}",
            )
            check(
                bool(((result.points_held >= 0) & (result.points_held < 9)).all()),
                f"points held {result.points_held}",
            )
            result.summary()
        until = History.load(path, until=24)
        until.save(folder / "again.npz")

    return attempt


def tournament_cases(folder: Path) -> Iterator[Case]:
    files = sorted(path.name for path in folder.glob("*.json"))
    yield from of_file(files[0], byte_tricks, folder)
    yield from of_file(files[0], json_tricks, folder)
    yield from place_cases(files[0])
    yield swapped("two matches in each other's place", *files[:2])
    for name in ("red_games", "seed", "red/wins", "blue/losses", "red/games"):
        place = tuple(name.split("/"))
        for value in ('"WWWW"', "4", "3", "[1]", '"LLLLL"'):
            make = partial(with_value, place, value)
            yield Case("json value", f"{name} = {value}", partial(rewrite, files[0], make))


LOOSE = ("mean_margin", "mean_margin_interval", "points_held")
"""Figures that no other figure of a match's file gives again."""


def tournament_attempt(root: Path) -> Attempt:
    good = [dict(row) for row in valid.play_tournament(root / "tournament").rows.values()]

    def attempt(folder: Path) -> None:
        from hexwar_sb3.commands.tournament import in_words
        from hexwar_sb3.evaluation.played import read_matches

        table = valid.play_tournament(folder)
        for path in folder.glob("*.json"):
            said(path.read_bytes())
        for row, known in zip(table.rows.values(), good, strict=True):
            for key, value in known.items():
                if key in ("red", "blue"):
                    for name in set(value) - set(LOOSE):
                        check_said(_rounded(value[name]), _rounded(row[key][name]), f"{key}.{name}.")
                    low, high = row[key]["mean_margin_interval"]
                    check(
                        -math.inf < low <= row[key]["mean_margin"] <= high < math.inf,
                        f"margins {low}, {high}",
                    )
                    check(
                        finite(row[key]["points_held"]), f"shares of points {row[key]['points_held']!r:.80}"
                    )
                elif key != "software":
                    check_said(value, row[key], f"{key}.")
        for meeting, row in read_matches(folder).rows.items():
            for camp in ("red", "blue"):
                check_said(
                    row[camp], {name: table.rows[meeting][camp][name] for name in row[camp]}, f"{camp}."
                )
        table.ratings()
        in_words(table, ["MA1", "MA2"]).encode()

    return attempt


def _rounded(value: Any) -> Any:
    """Without the last digits, which follow from how a figure was computed."""
    if isinstance(value, list):
        return [_rounded(one) for one in value]
    return round(value, 9) if isinstance(value, float) else value


def league_cases(folder: Path) -> Iterator[Case]:
    networks = "iteration_01/groups/1-m0/both/networks.safetensors"
    tables = ("iteration_00/table.json", "iteration_01/table.json")
    for file in ("league.json", *tables, "iteration_01/cost.json"):
        yield from of_file(file, json_tricks, folder)
        yield from place_cases(file)
        if file != "iteration_01/cost.json":
            yield from of_file(file, byte_tricks, folder)
    yield from place_cases(networks)
    yield from of_file(networks, byte_tricks, folder)
    yield copied_over(
        "a model is another",
        folder.parent / "others" / "policy" / WEIGHTS,
        f"iteration_00/models/one/{WEIGHTS}",
    )


def league_attempt(root: Path) -> Attempt:
    from hexwar_sb3.league.league import League

    known = League.open(root / "league")
    good = {k: {camp: [one.name for one in known.kept(k)[camp]] for camp in ("red", "blue")} for k in (0, 1)}

    def attempt(folder: Path) -> None:
        from dataclasses import asdict, replace

        from hexwar_sb3.commands.selfplay import in_words
        from hexwar_sb3.league.cost import added, read_cost
        from hexwar_sb3.league.picture import draw_league
        from hexwar_sb3.league.work import begin

        league = act(lambda: League.open(folder))
        values = said((folder / "league.json").read_bytes())
        check_said(values["settings"], json.loads(json.dumps(asdict(league.settings))))
        for k in (0, 1):
            kept = act(partial(league.kept, k))
            said(league.table(k).read_bytes())
            check({camp: [one.name for one in kept[camp]] for camp in kept} == good[k], "others were kept")
            act(partial(in_words, league, k)).encode()
            rates = act(partial(league.red_win_rates, k))
            check(all(0.0 <= rate <= 1.0 for rate in rates.values()), f"rates {rates!r:.80}")
            for members in league.models(k).values():
                for member in members:
                    member.policy()
        spec = replace(league, settings=replace(league.settings, iterations=2)).specs(2)[0]
        env = {**spec.env, "side": "both", "opponent": "MA1"}
        act(lambda: begin(spec.members["red"], env, spec.learner, 0))
        added([read_cost(folder / "iteration_01"), read_cost(folder / "iteration_01")])
        act(lambda: league.specs(1))
        act(lambda: draw_league(league, {}, folder / "league.png"))

    return attempt


def study_cases(folder: Path) -> Iterator[Case]:
    file = "study.journal"
    yield from of_file(file, byte_tricks, folder)
    yield from place_cases(file)
    data = (folder / file).read_bytes()
    lines = [json.loads(line)["op_code"] for line in data.splitlines()]
    for number in dict.fromkeys([*range(4), *(lines.index(code) for code in lines), len(lines) - 1]):
        yield from of_file(file, partial(_journal_lens(number).lifted, json_tricks), folder)
    for number, line in enumerate(
        (b"", b"null", b"[]", b"{}", b"x", b"[" * 100_000, b'{"op_code":4}', b'{"op_code":99}', b"\xff\xfe")
    ):
        for at in (0, 5, len(lines)):
            yield Case(
                "lines",
                f"{line[:20]!r} ({number}) before line {at + 1}",
                partial(rewrite, file, partial(_put_entry, at, line)),
            )


def _journal_lens(number: int) -> Lens:
    def put(data: bytes, line: bytes) -> bytes:
        lines = data.splitlines()
        lines[number] = line.replace(b"\n", b" ")
        return b"\n".join(lines) + b"\n"

    return Lens(f"line {number + 1}", lambda data: data.splitlines()[number], put)


def _put_entry(at: int, line: bytes, data: bytes) -> bytes:
    lines = data.splitlines()
    return b"\n".join([*lines[:at], line, *lines[at:]]) + b"\n"


def study_attempt(_: Path) -> Attempt:
    def attempt(folder: Path) -> None:
        from hexwar_sb3.algorithms.preset_file import load_preset, save_preset
        from hexwar_sb3.commands.output import table
        from hexwar_sb3.tuning.study import begin, completed, known_spec
        from hexwar_sb3.tuning.summary import in_words, summary

        spec = known_spec(folder)
        study = begin(spec)
        figures = {**summary(study, spec), "pictures": []}
        in_words(figures, table).encode()
        json.dumps(figures)
        for trial in completed(study, ()):
            check(trial.value is not None and math.isfinite(trial.value), f"a trial reached {trial.value}")
            save_preset(folder / "found.json", load_preset(spec.preset).changed(trial.params), {})
            load_preset(str(folder / "found.json"))
            for name, value in trial.params.items():
                check(name in spec.space, f"the setting {name!r:.40} is not searched")
                inside = spec.space[name]._contains(spec.space[name].to_internal_repr(value))
                check(inside, f"{name} = {value!r:.40} lies outside of what is searched")

    return attempt


def terrain_cases(folder: Path) -> Iterator[Case]:
    names = sorted(f"cache/terrain/{path.name}" for path in (folder / "cache" / "terrain").glob("*-*"))
    for name in names:
        yield from of_file(name, byte_tricks, folder)
        yield from of_file(name, _flip_tricks, folder)
        yield from place_cases(name)
        for array in (np.zeros(0, np.uint8), np.zeros((2, 650, 650), np.int8), np.zeros(())):
            yield Case(
                "array",
                f"{name}: a .npy of {array.shape}",
                partial(rewrite, name, partial(instead, to_npy(array))),
            )
        yield Case(
            "array", f"{name}: a .npy of objects", partial(rewrite, name, partial(instead, object_array()))
        )
    yield swapped("tables of two maps in each other's place", *names)


def _flip_tricks(data: bytes) -> Tricks:
    """Bits all over the table, and all over its head."""
    for end in (len(data), 256):
        for k in range(40):
            at = end * (2 * k + 1) // 80
            yield Trick(
                "head" if end == 256 else "flip", f"bit {k % 8} of byte {at}", partial(flipped, at, k % 8)
            )


def terrain_attempt(_: Path) -> Attempt:
    hexmap = valid.terrain_map()
    good = [np.array(table) for table in valid.tables(hexmap)]

    def attempt(folder: Path) -> None:
        with valid.cache_at(folder / "cache"):
            found = valid.tables(hexmap)
        for table, known in zip(found, good, strict=True):
            check(
                table.dtype == known.dtype and table.shape == known.shape,
                f"a table of {table.dtype}, {table.shape}",
            )
            check(bool((np.asarray(table) == known).all()), "a table of other content")

    return attempt
