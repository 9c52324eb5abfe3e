"""Maps, scenarios, hot spots, replays: how they are loaded, and what must then be right."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from tests.attack import valid
from tests.attack.oracle import Attempt, Wrong, act, check, check_said, play, said
from tests.attack.tricks import Case, Trick, Tricks, byte_tricks, of_file, place_cases, rewrite
from tests.attack.tricks_json import json_tricks, unhashed_tricks, with_value
from tests.attack.tricks_replay import lines_of, replay_tricks, zstd_tricks


def map_cases(folder: Path) -> Iterator[Case]:
    file = "small.map.json"
    yield from of_file(file, byte_tricks, folder)
    yield from of_file(file, json_tricks, folder)
    yield from of_file(file, unhashed_tricks, folder)
    yield from place_cases(file)


def map_attempt(_: Path) -> Attempt:
    def attempt(folder: Path) -> None:
        from hexwar_sb3.maps.files import load_map, save_map
        from hexwar_sb3.maps.map_file import map_document

        path = folder / "small.map.json"
        hexmap = load_map(path)
        check_said(_tidy(said(path.read_bytes())), _tidy(map_document(hexmap)))
        save_map(hexmap, path)
        check(load_map(path).hash == hexmap.hash, "saved and loaded again it is another")

    return attempt


def _tidy(document: dict[str, Any]) -> dict[str, Any]:
    """A map or a scenario without the freedom that its writer has."""
    tidy = dict(document)
    if "levels" in tidy:
        tidy["levels"] = [" ".join(row.split()) for row in tidy["levels"]]
        tidy["controllable"] = sorted(set(tidy["controllable"]))
    if isinstance(tidy.get("map"), dict):
        tidy["map"] = _tidy(tidy["map"])
    if isinstance(tidy.get("pieces"), list):
        pieces = [{"home": None, "aboard": False, **piece} for piece in tidy["pieces"]]
        tidy["pieces"] = sorted(pieces, key=lambda piece: (piece["camp"], piece["name"]))
    return tidy


def scenario_cases(folder: Path) -> Iterator[Case]:
    file = valid.SCENARIO
    yield from of_file(file, byte_tricks, folder)
    yield from of_file(file, json_tricks, folder)
    yield from of_file(file, unhashed_tricks, folder)
    yield from place_cases(file)


def named_cases(folder: Path) -> Iterator[Case]:
    yield from of_file(valid.SCENARIO, unhashed_tricks, folder)
    yield from of_file("small.map.json", unhashed_tricks, folder)
    yield from place_cases("small.map.json")
    for name in (
        "../small.map.json",
        "/etc/passwd.json",
        "a\\u0000.json",
        ".json",
        "..",
        "small.scenario.json",
    ):
        make = partial(with_value, ("map",), f'"{name}"')
        yield Case("place", f"its map is {name}", partial(rewrite, valid.SCENARIO, make))


def scenario_attempt(_: Path) -> Attempt:
    def attempt(folder: Path) -> None:
        from hexwar_sb3.engine.game import Game
        from hexwar_sb3.maps.files import load_scenario
        from hexwar_sb3.maps.scenario_file import scenario_document

        path = folder / valid.SCENARIO
        scenario = load_scenario(path)
        values = said(path.read_bytes())
        named = values["map"] if isinstance(values["map"], str) else None
        check_said(_tidy(values), _tidy(scenario_document(scenario, named)))
        Game(scenario, seed=1).advance(20)
        play(valid.new_games(1, scenario=path, side="both"))

    return attempt


def spots_cases(folder: Path) -> Iterator[Case]:
    yield from of_file("spots.json", byte_tricks, folder)
    yield from of_file("spots.json", json_tricks, folder)
    yield from of_file("spots.json", _long_spots, folder)
    yield from place_cases("spots.json")


def _long_spots(_: bytes) -> Tricks:
    cells = json.dumps(["0705"] * 100_000)
    visits = "{" + ", ".join(f'"{k:06}": 1' for k in range(100_000)) + "}"
    for key, text in (("cells", cells), ("hull", cells), ("visits", visits)):
        yield Trick("json value", f"red/{key} of 100,000", partial(with_value, ("red", key), text))
    walls = json.dumps(["0705-0706"] * 29_000)
    for name, text in (
        ("29,000", walls),
        ("far apart", '["0101-1309"]'),
        ("itself", '["0705-0705"]'),
        ("one", '["0705"]'),
    ):
        yield Trick("json value", f"walls {name}", partial(with_value, ("walls",), text))


def spots_attempt(root: Path) -> Attempt:
    def attempt(folder: Path) -> None:
        from hexwar_sb3.engine.world import load_world
        from hexwar_sb3.tasks.spots import load_spots
        from hexwar_sb3.tasks.spots_file import read_spots

        path, world = folder / "spots.json", load_world(root / valid.SCENARIO)
        spots = read_spots(path, world.scenario.hexmap)
        check_said({**said(path.read_bytes()), "map": world.scenario.hexmap.name}, spots.document())
        for a, b in spots.walls:
            check(
                b in world.cells.neighbour[a].tolist(),
                f"a wall between cells {a} and {b}, which are no neighbours",
            )
        taken = load_spots(world, 2, path)
        check(bool((taken >= 0).all() and (taken < world.cells.size).all()), "a spot off the map")
        check(bool(world.cells.playable[taken].all()), "a spot where nobody can be")

    return attempt


def replay_cases(file: str, folder: Path) -> Iterator[Case]:
    for tricks in (byte_tricks, zstd_tricks, replay_tricks):
        yield from of_file(file, tricks, folder)
    yield from place_cases(file)


def replay_attempt(root: Path) -> Attempt:
    from hexwar_sb3.engine.replay import Replay

    real = Replay.load(root / "replay" / "game.hwr")
    states = {json.dumps(one) for one in real.states}

    def attempt(folder: Path) -> None:
        path = folder / "game.hwr"
        replay = act(lambda: Replay.load(path))
        check_lines(path)
        problem = show(replay)
        try:
            act(replay.verify)
        except Exception as error:
            error.__context__ = None
            raise
        if problem is not None:
            raise problem
        check(json.dumps(replay.events) == json.dumps(real.events), "verified, with other events")
        check(all(json.dumps(one) in states for one in replay.states), "verified, with other states")
        check(_no_sum(replay.end) == _no_sum(real.end), "verified, with another end")

    return attempt


def _no_sum(line: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in line.items() if key != "sha256"}


def check_lines(path: Path) -> None:
    """No line says two things."""
    for line in lines_of(path.read_bytes()):
        said(line)


def show(replay: Any) -> Exception | None:
    """All that is made of a replay that nobody verified; one of our errors is given back."""
    from hexwar_sb3.commands.watch import event_lines, figures, result_line
    from hexwar_sb3.engine.picture import save_game_picture
    from hexwar_sb3.errors import HexWarError
    from hexwar_sb3.tasks.hotspots import count_visits

    problem: Exception | None = None
    picture = Path(os.environ["TMPDIR"]) / "picture.png"
    of_the_whole = (
        lambda: replay.game_at(150),
        lambda: replay.for_camp("red"),
        lambda: count_visits(replay, valid_world()),
    )
    for use in (
        lambda: json.dumps(figures(replay)).encode(),
        lambda: "\n".join([*event_lines(replay), result_line(replay)]).encode(),
        *(() if replay.camp else of_the_whole),
        lambda: save_game_picture(replay, picture),
    ):
        try:
            act(use)
        except (HexWarError, OSError) as error:
            problem = problem or error
    return problem


def valid_world() -> Any:
    """The small scenario's."""
    from hexwar_sb3.engine.world import load_world

    return load_world(Path(valid.SCENARIO))


def camp_attempt(_: Path) -> Attempt:
    def attempt(folder: Path) -> None:
        from hexwar_sb3.engine.replay import Replay
        from hexwar_sb3.errors import ReplayFileError

        replay = act(lambda: Replay.load(folder / "red.hwr"))
        check_lines(folder / "red.hwr")
        try:
            act(replay.verify)
        except ReplayFileError:
            show(replay)
            return
        raise Wrong("verified, with one camp's record")

    return attempt
