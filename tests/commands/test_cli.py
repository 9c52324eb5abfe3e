from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

from hexwar_sb3 import __version__
from hexwar_sb3 import cache as cache_module
from hexwar_sb3.cli import COMMANDS, parse
from hexwar_sb3.kernels import COMPILED, counts
from hexwar_sb3.maps.files import load_scenario

Command = Callable[..., tuple[int, str, str]]


def test_help_lists_every_command(hexwar: Command) -> None:
    code, out, _ = hexwar("--help")

    assert code == 0
    assert all(name in out for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_itself(hexwar: Command, name: str) -> None:
    code, out, _ = hexwar(name, "--help")

    assert code == 0
    assert f"usage: hexwar {name}" in out


@pytest.mark.parametrize("name", COMMANDS)
def test_every_flag_says_what_it_is(hexwar: Command, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A flag without help shows its default right behind the kind of its value."""
    monkeypatch.setenv("COLUMNS", "200")
    _, out, _ = hexwar(name, "--help")

    text = " ".join(re.sub("[│╭╮╰╯─]", " ", out).split())

    assert re.findall(r"--[a-z-]+ \S*(?:INT|STR|FLOAT|PATH|[\]}]) \(default", text) == []


def test_the_version_is_that_of_the_package(hexwar: Command) -> None:
    assert hexwar("--version") == (0, f"hexwar {__version__}\n", "")


@pytest.mark.parametrize(
    ("arguments", "heavy"),
    [
        (["--version"], ()),
        (["--help"], ()),
        (["trian"], ()),
        (["maps", "--help"], ("hexwar_sb3.commands.maps",)),
        (["doctor", "--help"], ("hexwar_sb3.commands.doctor",)),
    ],
    ids=" ".join,
)
def test_a_command_line_imports_the_command_that_is_asked_for_alone(
    arguments: list[str], heavy: tuple[str, ...]
) -> None:
    code = f"""
import atexit, sys
from hexwar_sb3.cli import COMMANDS, main
places = [f"hexwar_sb3.commands.{{place.partition(':')[0]}}" for place in COMMANDS.values()]
names = sorted({{*places, "torch", "numba", "matplotlib"}})
atexit.register(lambda: print([name for name in names if name in sys.modules]))
main({arguments})
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.stdout.splitlines()[-1] == str([*heavy])


def test_a_misspelt_flag_is_met_with_the_right_one(hexwar: Command) -> None:
    code, _, err = hexwar("train", "--eval-frec", "9")

    assert code == 2
    assert "--eval-freq" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("match", "MA1", "MA3"), "hexwar: unknown player 'MA3'; did you mean "),
        (
            ("match", "MA1", "MA2", "--scenario", "plian"),
            "hexwar: unknown scenario 'plian'; did you mean 'plain'?",
        ),
        (("match", "MA1", "MA2", "--games", "0"), "hexwar: games must be at least 1, got 0"),
        (("match", "MA1", "MA2", "--seed", "-1"), "hexwar: seed must be in 0..999999, got -1"),
        (("train", "--n-envs", "0"), "hexwar: n_envs must be an integer >= 1, got 0"),
        (("train", "--resume", "no/such/run"), "hexwar: no/such/run/config.json: file: found No such file"),
        (("watch", "no.hwr"), "hexwar: no.hwr"),
        (("maps", "--new", "mine"), "hexwar: --new needs --output"),
        (("maps", "--new", "plain", "--output", "pics"), "hexwar: 'plain' is a built-in map"),
        (("maps", "--new", "a/../b", "--output", "pics"), "hexwar: new must be of letters, digits, - and _"),
        (
            ("maps", "--new", "mine", "--output", "pics", "--seed", "-4"),
            "hexwar: seed must be an integer >= 0",
        ),
        (("bench", "--rounds", "0"), "hexwar: rounds must be an integer >= 1, got 0"),
        (("train", "--name", "../x"), "hexwar: name must be of letters, digits, - and _"),
        (("train", "--device", "cudda"), "hexwar: device 'cudda' cannot be used: "),
        (("train", "--gamma", "2"), "hexwar: gamma must be in [0, 1], got 2.0"),
        (("match", "ma1", "MA2"), "hexwar: unknown player 'ma1'; did you mean 'MA1'?"),
        (("match", "MA1", "MA2", "--decision-ticks", "0"), "hexwar: decision_ticks must be an integer >= 1"),
        (
            ("match", "MA1", "MA2", "--record", "a.hwr", "--record-games", "0", "1"),
            "hexwar: --record a.hwr is a file for one game; name a folder for several",
        ),
        (
            ("match", "MA1", "MA2", "--games", "3", "--record", ".", "--record-games", "3"),
            "hexwar: record_games must be at most 2, got 3",
        ),
        (("evaluate", "tests"), "hexwar: tests: config.json: found nothing; expected a policy folder"),
    ],
)
def test_a_mistake_is_one_line_and_no_traceback(
    hexwar: Command, arguments: tuple[str, ...], message: str
) -> None:
    code, out, err = hexwar(*arguments)

    assert (code, out) == (2, "")
    assert err.startswith(message)
    assert err.count("\n") == 1


def test_a_match_prints_both_camps(hexwar: Command) -> None:
    _, out, _ = hexwar("match", "MA1", "MA2", "--games", "4")

    assert out.splitlines()[0].split()[:3] == ["camp", "player", "games"]
    assert [line.split()[:3] for line in out.splitlines()[2:]] == [["red", "MA1", "4"], ["blue", "MA2", "4"]]


@pytest.mark.parametrize(
    "arguments", [["match", "MA1", "MA2"], ["evaluate", "MA1"], ["tournament", "MA1", "MA2"]]
)
def test_n_is_the_number_of_games(arguments: list[str]) -> None:
    assert parse([*arguments, "-n", "20"]) == parse([*arguments, "--games", "20"])


def test_a_match_as_json_is_the_same_match_each_time(hexwar: Command) -> None:
    first, second = (json.loads(hexwar("match", "MA1", "MA2", "--games", "4", "--json")[1]) for _ in range(2))

    assert first == second
    assert first["red"]["wins"] + first["red"]["draws"] + first["red"]["losses"] == 4
    assert first["red"]["wins"] == first["blue"]["losses"]


def test_a_recorded_game_is_the_first_of_the_match_and_can_be_verified(
    hexwar: Command, tmp_path: Path
) -> None:
    game = str(tmp_path / "game.hwr")

    match = json.loads(hexwar("match", "MA1", "MA2", "--games", "1", "--record", game, "--json")[1])
    watched = json.loads(hexwar("watch", game, "--verify", "--json")[1])

    assert watched["verified"]
    assert watched["margin"]["red"] == match["red"]["mean_margin"]
    assert [watched["players"][camp]["name"] for camp in ("red", "blue")] == ["MA1", "MA2"]


def test_a_recorded_game_reads_as_events_and_a_picture(hexwar: Command, tmp_path: Path) -> None:
    game, picture = tmp_path / "game.hwr", tmp_path / "game.png"
    hexwar("match", "MA1", "MA2", "--games", "1", "--record", str(game))

    _, events, _ = hexwar("watch", str(game))
    _, result, _ = hexwar("watch", str(game), "--output", str(picture))

    assert "first_contact" in events or "arrived" in events
    assert events.splitlines()[-1].startswith("tick 1800: ")
    assert result == events.splitlines()[-1] + "\n"  # beside a picture no events
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_an_evaluation_has_a_row_for_each_player_opponent_and_camp(hexwar: Command) -> None:
    _, out, _ = hexwar("evaluate", "nearest", "--opponents", "MA1", "--games", "2", "--json")

    rows = json.loads(out)["rows"]

    players = ("nearest", "all-main", "half-half", "two-hold")
    assert [(row["player"], row["camp"]) for row in rows] == [
        (p, c) for p in players for c in ("red", "blue")
    ]


def test_maps_lists_the_built_in_ones(hexwar: Command) -> None:
    rows = json.loads(hexwar("maps", "--json")[1])["maps"]

    assert [(row["map"], row["cells"], row["pieces"]) for row in rows] == [
        ("assault", 3025, "9 against 5"),
        ("battalion", 14340, "30 against 30"),
        *((name, 4935, "7 against 7") for name in ("hills", "paddy", "plain")),
        ("skirmish", 308, "3 against 3"),
    ]


def test_a_map_of_another_size_and_line_up_is_made(hexwar: Command, tmp_path: Path) -> None:
    new = (
        "maps",
        "--new",
        "mine",
        "--like",
        "hills",
        "--width",
        "30",
        "--height",
        "20",
        "--output",
        str(tmp_path),
    )
    code, out, _ = hexwar(*new, "--pieces", "12", "5", "--mirror", "no", "--json")
    assert (code, [(row["cells"], row["pieces"]) for row in json.loads(out)["maps"]]) == (
        0,
        [(590, "12 against 5")],
    )
    assert not load_scenario(tmp_path / "mine.scenario.json").hexmap.is_symmetric()
    for wrong in (("--pieces", "1", "2", "3"), ("--pieces", "65"), ("--width", "14"), ("--height", "251")):
        assert hexwar(*new, *wrong)[0] == 2


def test_a_new_map_can_be_made_listed_and_drawn(hexwar: Command, tmp_path: Path) -> None:
    code, out, _ = hexwar(
        "maps", "--new", "mine", "--like", "paddy", "--seed", "7", "--output", str(tmp_path)
    )

    assert code == 0
    assert "mine" in out
    assert {path.name for path in tmp_path.iterdir()} == {"mine.map.json", "mine.scenario.json", "mine.png"}


def test_doctor_plays_a_game(hexwar: Command) -> None:
    findings = json.loads(hexwar("doctor", "--json")[1])

    assert findings["hexwar-sb3"] == __version__
    assert findings["games"].endswith("MA1 against MA2")
    assert findings["first game"].endswith("(reads the compiled kernels)")


def test_doctor_tells_what_the_first_game_compiled(hexwar: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def play(*_: object, **__: object) -> None:
        counts[COMPILED] += 3

    monkeypatch.setattr("hexwar_sb3.evaluation.matches.play_match", play)
    findings = json.loads(hexwar("doctor", "--json")[1])

    assert findings["first game"].endswith("(compiled 3 kernels, which were not in the cache)")


def test_doctor_tells_that_the_cache_cannot_be_used(
    hexwar: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("HEXWAR_CACHE", str(tmp_path / "file"))
    monkeypatch.setattr("hexwar_sb3.commands.doctor.compile_first", lambda: None)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    cache_module._temporary.cache_clear()
    try:
        findings = json.loads(hexwar("doctor", "--json")[1])
    finally:
        cache_module._temporary.cache_clear()

    assert "NOT usable: it is not a folder; instead" in findings["cache"]
