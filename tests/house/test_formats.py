"""The pages on file formats: every example loads, and every field of the code stands there with its default."""

from __future__ import annotations

import inspect
import json
import math
import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import pytest

import hexwar_sb3 as hx
from hexwar_sb3 import reading
from hexwar_sb3.algorithms import (
    LOWER_DEFAULTS,
    QMIX,
    MaskedDQN,
    Preset,
    load_preset,
    preset_file,
    save_preset,
)
from hexwar_sb3.algorithms.hierarchical import PLAIN_GAMMA
from hexwar_sb3.algorithms.presets import FALLS, OF_POLICY
from hexwar_sb3.engine import edit, known_events, replay_file, replay_lines, view
from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.orders import ORDERS, verb
from hexwar_sb3.engine.records import PATH_CELLS
from hexwar_sb3.engine.replay import MAX_SEED, PlayerName
from hexwar_sb3.engine.replay_lines import LINES
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.route_settings import RouteSettings
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.errors import FileFormatError, MapFileError, ReplayFileError
from hexwar_sb3.evaluation.opponents import OPPONENTS
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.league import LEARNER, League, LeagueSettings
from hexwar_sb3.league import settings as league_settings
from hexwar_sb3.league.folder import TABLE_KEYS, TableRow
from hexwar_sb3.league.member import MOST_BYTES
from hexwar_sb3.maps import document, geometry, map_file, scenario, scenario_file
from hexwar_sb3.maps.map_file import map_document
from hexwar_sb3.maps.scenario_file import scenario_document
from hexwar_sb3.players import FrozenLower, frozen, frozen_lower, policy_files
from hexwar_sb3.policies import TaskPolicy
from hexwar_sb3.rules.tables import AEROCRAFT
from hexwar_sb3.server import app, clock, messages, partial, room, steps
from hexwar_sb3.tasks import spots_file
from hexwar_sb3.tasks.spots import load_spots
from hexwar_sb3.tasks.spots_file import CampSpots, read_spots
from hexwar_sb3.viewer import events, picture, save_events, stories, story
from hexwar_sb3.viewer import page as viewer_page
from hexwar_sb3.viewer.decisions import told_decisions, told_rewards

ROOT = Path(__file__).parents[2]
INDEX = ROOT / "docs" / "formats.md"
PAGES = sorted(path.stem for path in (ROOT / "docs" / "formats").glob("*.md"))
PARTS = ("env", "route", "learner", "lower_learner")  # of a preset
FREE = ("software", "created")  # what an example says of its making; no loader compares it
Row = dict[str, str]


def page(name: str) -> str:
    return (ROOT / "docs" / "formats" / f"{name}.md").read_text(encoding="utf-8")


def example(name: str) -> str:
    """The block right after the mark of that name; "map.py" stands on the page "map"."""
    text = INDEX.read_text(encoding="utf-8") if name == "refusal" else page(name.partition(".")[0])
    found = re.findall(
        rf"^<!-- example: {re.escape(name)} -->\n```\w+\n(.*?)\n```$", text, re.MULTILINE | re.DOTALL
    )
    assert len(found) == 1, f"one example {name}"
    return str(found[0])


def rows(name: str, heading: str, head: str) -> dict[str, Row]:
    """Rows of the table of a section whose first column is called `head`: by name, the cells by column."""
    section = re.search(rf"^## {re.escape(heading)}\n(.*?)(?=^## |\Z)", page(name), re.MULTILINE | re.DOTALL)
    assert section, f"{name}.md has no section {heading!r}"
    tables = [block.splitlines() for block in re.findall(r"(?:^\|.*\n)+", section[1], re.MULTILINE)]
    table = next(lines for lines in tables if cells(lines[0])[0] == head)
    columns = cells(table[0])
    found = [dict(zip(columns, cells(line), strict=True)) for line in table[2:]]
    return {row[head].strip("`"): row for row in found}


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def replay_examples() -> Iterator[dict[str, Any]]:
    """The lines of the replay's example, which are broken for reading."""
    text, decoder = example("replay"), json.JSONDecoder()
    while text:
        line, end = decoder.raw_decode(text)
        yield line
        text = text[end:].lstrip()


def without(values: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name not in names}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder with the files of the first pages under the names that they use."""
    (tmp_path / "ford.map.json").write_text(example("map"))
    (tmp_path / "duel.scenario.json").write_text(example("scenario"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(name: str) -> None:
    """Run the Python of an example."""
    exec(compile(example(name), name, "exec"), {})  # noqa: S102  # our own page


# --- the index -----------------------------------------------------------------------------------


def test_the_index_leads_to_every_page() -> None:
    linked = re.findall(r"^\|.*\]\(formats/(\w+)\.md\) \|$", INDEX.read_text(encoding="utf-8"), re.MULTILINE)

    assert sorted(linked) == PAGES


@pytest.mark.parametrize("path", [INDEX, *(INDEX.parent / "formats" / f"{name}.md" for name in PAGES)])
def test_every_link_leads_somewhere(path: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)\)", path.read_text(encoding="utf-8"))

    assert [link for link in links if not (path.parent / link).exists()] == []


def test_the_refusal_that_is_shown_is_the_refusal(folder: Path) -> None:
    broken = example("map").replace('".==."', '".==.."')
    (folder / "ford.map.json").write_text(broken)

    with pytest.raises(MapFileError) as caught:
        hx.load_map("ford.map.json")
    assert str(caught.value) == example("refusal")


def test_the_index_names_every_error_of_a_file() -> None:
    kinds = {"FileFormatError", *(kind.__name__ for kind in FileFormatError.__subclasses__())}

    text = INDEX.read_text(encoding="utf-8")
    assert {kind for kind in kinds if f"| `{kind}`" not in text} == set()


# --- examples ------------------------------------------------------------------------------------


def test_the_map_loads_and_is_what_we_write(folder: Path) -> None:
    hexmap = hx.load_map(folder / "ford.map.json")

    assert map_document(hexmap) == json.loads(example("map"))
    run("map.py")


def test_the_scenario_loads_and_is_what_we_write(folder: Path) -> None:
    start = hx.load_scenario(folder / "duel.scenario.json")

    assert scenario_document(start, "ford.map.json") == json.loads(example("scenario"))
    run("scenario.py")


def test_the_hot_spots_load_and_are_what_we_write(folder: Path) -> None:
    world, path = load_world(folder / "duel.scenario.json"), folder / "ford.spots.json"
    path.write_text(example("hot_spots"))

    spots = read_spots(path, world.scenario.hexmap)
    spots.save(folder / "again.json")

    assert (folder / "again.json").read_text() == example("hot_spots") + "\n"
    assert load_spots(world, spots.k, path).shape == (2, spots.k + len(world.scenario.points))


def test_the_replay_loads_and_plays_again(folder: Path) -> None:
    lines = list(replay_examples())
    replay_file.write_lines(folder / "two_tanks.hwr", lines)

    run("replay.py")  # loads it, verifies it, and writes red's own record

    assert {line["type"] for line in lines} == {"head", *LINES} - {"view", "known"}
    new = hx.Replay.of(hx.Game(hx.Replay.load("two_tanks.hwr").scenario()))
    assert new.head.keys() == lines[0].keys()
    own = hx.Replay.load(folder / "red.hwr")
    assert own.camp == "red"
    lines[-2]["hash"] = "0" * 16
    replay_file.write_lines(folder / "changed.hwr", lines)
    with pytest.raises(ReplayFileError, match=r"end\.sha256"):
        hx.Replay.load(folder / "changed.hwr")


@pytest.fixture
def told(folder: Path) -> dict[str, Any]:
    """Stories of the replay of the example."""
    replay_file.write_lines(folder / "two_tanks.hwr", list(replay_examples()))
    return stories(hx.Replay.load("two_tanks.hwr"))


def test_the_stories_are_those_of_the_replay(told: dict[str, Any]) -> None:
    assert json.loads(example("story")) == without(told["red"], "rules")
    common = [key for key, value in told["referee"].items() if told["red"].get(key) == value]
    assert json.loads(example("story.referee")) == without(
        told["referee"], *{*common} - {"format", "version"}
    )


DECIDED = {"type": "decision", "tick": 0, "camp": "red", "reward": {}, "choices": []}


def test_the_page_on_stories_has_every_field_of_them(told: dict[str, Any]) -> None:
    roster = hx.Game("plain").roster
    camp = {*told["red"], *told_decisions([DECIDED], roster)}
    referee = {*told["referee"], *told_rewards([DECIDED])}
    common = {*told["red"]} & {*told["referee"]} - {"events"}
    piece = {field for one in ("red", "blue") for own in told[one]["pieces"].values() for field in own}
    shot = told["referee"]["events"][0].keys() - {*told["red"]["events"][0]} - known_events.DICE

    assert set(rows("story", "Fields of every story", "field")) == common
    assert set(rows("story", "Fields of a camp's story", "field")) == camp - common
    assert set(rows("story", "Fields of the referee's story", "referee")) == referee - common
    assert {field for field in piece if not field.endswith("_ends")} <= set(
        rows("story", "Fields of a piece", "piece")
    )
    assert set(rows("story", "The luck of a shot", "luck")) == shot


def test_the_table_of_events_is_that_of_the_replay(folder: Path) -> None:
    replay_file.write_lines(folder / "two_tanks.hwr", list(replay_examples()))
    save_events(hx.Replay.load("two_tanks.hwr"), "events.csv")

    assert (folder / "events.csv").read_text(encoding="utf-8") == f"{example('events')}\n"
    columns = rows("events", "Columns", "column")
    assert tuple(columns) == events.COLUMNS
    assert {name for name, row in columns.items() if row["in"] == "referee"} == events.SECRET


def test_the_policy_is_made_and_loads(folder: Path) -> None:
    run("policy.py")

    upper, lower = (folder / "policy" / name for name in ("config.json", "lower/config.json"))
    assert json.loads(upper.read_text()) == json.loads(example("policy"))
    assert json.loads(lower.read_text()) == json.loads(example("policy.lower"))
    policy = hx.FrozenPolicy.load(folder / "policy")
    assert isinstance(policy.lower, FrozenLower)


def test_the_preset_loads_and_comes_back(folder: Path) -> None:
    (folder / "small.json").write_text(example("preset"))

    preset = load_preset("small.json")
    save_preset(folder / "again.json", preset, {})

    assert load_preset("again.json") == preset
    assert preset.route["gain_limit"] == math.inf
    assert preset.lower == Preset().lower
    run("preset.py")


def test_the_league_is_made_and_opens(folder: Path) -> None:
    run("league.py")

    left, shown = json.loads((folder / "league" / "league.json").read_text()), json.loads(example("league"))
    assert without(left, *FREE) == without(shown, *FREE)
    (folder / "league" / "league.json").write_text(example("league"))
    league = League.open(folder / "league")
    assert [member.name for member in league.starters("red")] == ["first"]
    began = {"iteration": 0, "kept": {"red": ["first"], "blue": ["first"]}, "standings": {}}
    league.table(0).write_text(json.dumps(began))
    league.iteration(1).mkdir()
    league.table(1).write_text(example("league.table"))
    names = {camp: [member.name for member in members] for camp, members in league.kept(1).items()}
    assert names == json.loads(example("league.table"))["kept"]
    assert [row["parent"] for row in league.standings(1)["red"]] == ["first"]


# --- every field stands on its page, and nothing else --------------------------------------------


def keys(name: str, *path: str) -> Collection[str]:
    """Keys of an example, which is what we write, or of an object in it."""
    found = json.loads(example(name))
    for key in path:
        found = found[key]
    return set(found)


def names_of(kind: Any) -> set[str]:
    """Names of the fields of a dataclass."""
    return {entry.name for entry in fields(kind)}


def keys_of_line(kind: str) -> Collection[str]:
    return {"type"}.union(*LINES[kind])


def keys_of_head(*path: str) -> Collection[str]:
    found = next(replay_examples())
    for key in path:
        found = found[key]
    return set(found)


TABLES: list[tuple[str, str, str, Callable[[], Collection[str]]]] = [
    ("map", "Fields", "field", lambda: keys("map")),
    ("map", "Symbols", "symbol", lambda: map_file.SYMBOLS),
    ("scenario", "Fields", "field", lambda: keys("scenario")),
    ("scenario", "Pieces", "field", lambda: names_of(scenario.PieceStart)),
    ("scenario", "Control points", "field", lambda: names_of(scenario.ControlPoint)),
    ("hot_spots", "Fields", "field", lambda: keys("hot_spots")),
    ("hot_spots", "Fields of a camp", "field", lambda: names_of(CampSpots)),
    ("replay", "The bytes", "type", lambda: {"head", *LINES}),
    ("replay", "Line `head`", "field", lambda: {*keys_of_head(), "camp", "command"}),
    ("replay", "Head: `rules`", "field", lambda: keys_of_head("rules")),
    ("replay", "Head: `players`", "field", lambda: names_of(PlayerName)),
    ("replay", "Line `orders`", "field", lambda: keys_of_line("orders")),
    ("replay", "Line `orders`", "verb", lambda: {verb(action) for action in ORDERS}),
    ("replay", "Line `edit`", "field", lambda: keys_of_line("edit")),
    ("replay", "Line `edit`", "change", lambda: {*edit._PIECE_FIELDS, *edit._POINT_FIELDS}),
    ("replay", "Line `event`", "field", lambda: keys_of_line("event")),
    ("replay", "Line `event`", "event", lambda: {event.name.lower() for event in Event}),
    ("replay", "Line `decision`", "field", lambda: keys_of_line("decision")),
    ("replay", "Line `state`", "field", lambda: keys_of_line("state")),
    ("replay", "Line `known`", "field", lambda: keys_of_line("known")),
    ("replay", "Line `end`", "field", lambda: keys_of_line("end")),
    ("replay", "A camp's own record", "field", lambda: keys_of_line("view")),
    ("policy", "Fields of `config.json`", "field", lambda: keys("policy")),
    ("policy", "Arrays", "array", lambda: frozen.LAYERS),
    ("policy", "The folder `lower`", "field", lambda: keys("policy.lower")),
    ("policy", "The folder `lower`", "name", lambda: keys("policy.lower", "about")),
    ("policy", "The folder `lower`", "array of the lower level", lambda: frozen_lower.FORMAT.layers),
    ("preset", "Fields", "field", lambda: keys("preset")),
    ("preset", "Fields of `preset`", "field", lambda: names_of(Preset)),
    *(("preset", f"Part `{part}`", "field", lambda part=part: preset_file.KNOWN[part]) for part in PARTS),
    ("preset", "`policy_kwargs`", "field", lambda: OF_POLICY),
    ("league", "Fields of `league.json`", "field", lambda: {"format", "settings", *provenance("plain")}),
    ("league", "Fields of `settings`", "field", lambda: names_of(LeagueSettings)),
    ("league", "Fields of `learner`", "field", lambda: league_settings.LEARNS_BY),
    ("league", "Fields of `table.json`", "field", lambda: TABLE_KEYS),
    ("league", "Rows of `standings`", "field", lambda: names_of(TableRow)),
]


@pytest.mark.parametrize(("name", "heading", "head", "expected"), TABLES)
def test_a_table_has_every_field_and_no_other(
    name: str, heading: str, head: str, expected: Callable[[], Collection[str]]
) -> None:
    assert set(rows(name, heading, head)) == set(expected())


def test_what_the_loaders_check_is_what_we_write() -> None:
    """The examples have all keys, so the tables above can be compared with them."""
    assert keys("map") == {*map_file._REQUIRED, *map_file._OPTIONAL}
    assert keys("scenario") == {*scenario_file._REQUIRED, *scenario_file._OPTIONAL}
    assert keys("hot_spots") == set(spots_file._KEYS)
    assert set(PARTS) == set(preset_file.KNOWN)


def test_the_symbols_mean_what_the_page_says() -> None:
    bits = {
        "passable": map_file.PASSABLE,
        "paved": map_file.PAVED,
        "concealed": map_file.CONCEALED,
        "slushy": map_file.SLUSHY,
    }
    for symbol, row in rows("map", "Symbols", "symbol").items():
        assert sum(bit for name, bit in bits.items() if row[name] == "yes") == map_file.SYMBOLS[symbol]


@pytest.mark.parametrize("kind", LINES)
def test_required_keys_of_a_line_are_marked(kind: str) -> None:
    heading = "A camp's own record" if kind == "view" else f"Line `{kind}`"

    marked = {key for key, row in rows("replay", heading, "field").items() if row["required"] == "yes"}

    assert marked == {"type", *LINES[kind][0]}


def test_the_objects_of_a_view_are_told() -> None:
    objects = ("own", "seen", "lost", "unseen", "points", "rounds")
    kinds = (view.OwnPiece, view.SeenEnemy, view.LostEnemy, view.UnseenEnemy, view.PointView, view.RoundView)

    found = rows("replay", "A camp's own record", "list")

    assert {name: re.findall(r"\w+", row["keys"]) for name, row in found.items()} == {
        name: [entry.name for entry in fields(kind)] for name, kind in zip(objects, kinds, strict=True)
    }


def test_the_dice_are_marked() -> None:
    events = rows("replay", "Line `event`", "field")

    assert {name for name, row in events.items() if row["meaning"].endswith("; dice")} == known_events.DICE


def test_the_axes_of_the_arrays_are_told() -> None:
    upper = rows("policy", "Arrays", "array")
    lower = rows("policy", "The folder `lower`", "array of the lower level")

    for found, layers in ((upper, frozen.LAYERS), (lower, frozen_lower.FORMAT.layers)):
        assert {name: tuple(row["axes"].split(", ")) for name, row in found.items()} == layers
    sizes = rows("policy", "The folder `lower`", "field")["sizes"]["range"]
    assert {axis: int(size) for axis, size in re.findall(r"`(\w+)` (\d+)", sizes)} == frozen_lower.SIZES


def test_what_a_policy_says_of_its_training_is_told() -> None:
    assert set(hx.Terms().about()) <= set(rows("policy", "What `about` says", "name"))


# --- defaults and limits -------------------------------------------------------------------------


def written(value: object) -> str:
    """A default as the pages have it."""
    if isinstance(value, str):
        return value
    return json.dumps(list(value) if isinstance(value, tuple) else value)


def defaults_of(kind: Any) -> dict[str, str]:
    """Defaults of a dataclass's fields or a function's arguments."""
    given = {name: one.default for name, one in inspect.signature(kind).parameters.items()}
    made = {
        entry.name: entry.default_factory()
        for entry in (fields(kind) if hasattr(kind, "__dataclass_fields__") else ())
        if entry.default_factory is not MISSING
    }
    plain = (str, int, float, bool, tuple, dict, type(None))
    return {name: written(value) for name, value in {**given, **made}.items() if isinstance(value, plain)}


FALLING = {name: f"{share} of the games" for name, share in FALLS.items()}
DEFAULTS: list[tuple[str, str, dict[str, str]]] = [
    ("preset", "Fields of `preset`", defaults_of(Preset)),
    ("preset", "Part `env`", defaults_of(TaskSettings)),
    ("preset", "Part `route`", defaults_of(RouteSettings)),
    ("preset", "Part `learner`", {**defaults_of(QMIX), **FALLING, "policy_kwargs": "{}"}),
    (
        "preset",
        "Part `lower_learner`",
        {**defaults_of(MaskedDQN), **{name: written(value) for name, value in LOWER_DEFAULTS.items()}},
    ),
    (
        "preset",
        "`policy_kwargs`",
        {**defaults_of(TaskPolicy), "mirrored": "whether the scenario is its own mirror image"},
    ),
    (
        "league",
        "Fields of `settings`",
        {**defaults_of(LeagueSettings), "opponents": "OPPONENTS, below", "learner": "LEARNER, below"},
    ),
]


@pytest.mark.parametrize(("name", "heading", "expected"), DEFAULTS)
def test_defaults_are_those_of_the_code(name: str, heading: str, expected: dict[str, str]) -> None:
    found = {key: row["default"].strip("`") for key, row in rows(name, heading, "field").items()}

    assert found == {key: expected[key] for key in found}


def test_the_learner_and_the_opponents_of_a_league_are_told() -> None:
    found = rows("league", "Fields of `learner`", "field")

    told = {name: row["LEARNER"].strip("`") for name, row in found.items() if row["LEARNER"]}
    assert told == {name: written(value) for name, value in LEARNER.items()}
    assert f"OPPONENTS are {', '.join(f'`{bot}`' for bot in OPPONENTS)};" in page("league")


def test_ranges_are_those_of_the_code() -> None:
    settings = rows("league", "Fields of `settings`", "field")
    assert {name: settings[name]["range"].replace(",", "") for name in league_settings.RANGES} == {
        name: f"{least}..{most}" for name, (least, most) in league_settings.RANGES.items()
    }
    of_preset = ("Fields of `preset`", *(f"Part `{part}`" for part in PARTS), "`policy_kwargs`")
    tables = [(rows("preset", heading, "field"), preset_file.MOST) for heading in of_preset]
    tables.append((rows("league", "Fields of `learner`", "field"), league_settings.MOST))
    for table, limits in tables:
        for name in table.keys() & limits.keys():
            assert table[name]["range"].split()[0] == f"1..{limits[name]:,}", name


LIMITS: dict[str, tuple[int, ...]] = {
    "map": (
        *(document.MAX_FILE_BYTES, map_file.MAX_GRADE_M, map_file.MAX_ALTITUDE_M, map_file.MAX_CONTROLLABLE),
        *(geometry.MIN_SIDE_CELLS, geometry.MAX_SIDE_CELLS, map_file.MAP_VERSION),
    ),
    "scenario": (
        *(document.MAX_FILE_BYTES, scenario.MAX_SIDE_PIECES, 2 * scenario.MAX_SIDE_PIECES),
        *(scenario.MAX_CONTROL_POINTS, scenario.MAX_GAME_TICKS, scenario.MAX_POINT_VALUE),
    ),
    "hot_spots": (
        *(document.MAX_FILE_BYTES, spots_file.SCHEMA, spots_file.SOURCE_CHARACTERS),
        *(spots_file._MAX_VISITS, spots_file._MAX_WALLS),
    ),
    "replay": (
        *(replay_file.MAX_FILE_BYTES, replay_file.MAX_TEXT_BYTES, replay_file.MAX_LINES, MAX_SEED),
        *(replay_file.MAX_LINE_BYTES, replay_lines.MAX_CHANGES, replay_lines.MAX_LOOKS, replay_lines.MOST),
        *(replay_lines.MAX_CHARACTERS, PATH_CELLS, edit.MAX_AMMO, edit.MAX_TIMER_TICKS),
    ),
    "policy": (policy_files.MAX_CONFIG_BYTES, policy_files.MAX_WEIGHTS_BYTES, policy_files.MAX_SIZE),
    "preset": (reading.MAX_JSON_BYTES, preset_file.MOST_WHOLE),
    "league": (reading.MAX_JSON_BYTES, MOST_BYTES),
    "events": (story.NAME_CHARACTERS,),
    "play": (
        *(messages.MOST_BYTES, messages.MOST_SPEED, room.MOST_MESSAGES, app.MOST_BODY, steps.MOST_STEPS),
        *(clock.STEP_SPEED, clock.STEP_BATCH, partial.MOST_BYTES, story.NAME_CHARACTERS),
    ),
    "story": (*(viewer_page.MAX_PAGE_BYTES, picture.MAX_BYTES, story.NAME_CHARACTERS, story.FORMAT_VERSION),),
}


@pytest.mark.parametrize("name", PAGES)
def test_limits_are_those_of_the_code(name: str) -> None:
    text = page(name)

    assert [n for n in LIMITS[name] if not re.search(rf"(?<![\d,]){n:,}(?![\d,]*\d)", text)] == []


def test_the_index_has_the_limits_of_all_json() -> None:
    text = INDEX.read_text(encoding="utf-8")

    for number in (reading.MAX_DIGITS, reading.MAX_DEPTH, reading.MAX_CONTAINERS):
        assert f" {number:,} " in text


def test_other_facts_that_the_pages_repeat() -> None:
    assert all(f"`{profile}`" in page("replay") for profile in AEROCRAFT)
    assert f"the default of `gamma` is another one: {PLAIN_GAMMA}." in page("preset")
