"""Tournaments: every pairing once a colour, files that are gone on from, and whose file it is."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import FileFormatError, HexWarError, PolicyFileError
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.matches import Evaluation, play_match
from hexwar_sb3.evaluation.tournament import (
    Match,
    Meeting,
    fingerprint,
    median_game,
    pack,
    play_meetings,
    record_medians,
    single_round_robin,
    unpack,
)
from hexwar_sb3.players.frozen import FrozenPolicy

PLAYERS: dict[str, object] = {"MA1": "MA1", "near": "nearest", "any": "random"}
HOW = Evaluation(games=4)


def test_a_single_round_robin_has_every_pairing_once_a_colour_and_map() -> None:
    meetings = single_round_robin(["a", "b", "c"], ["plain", "hills"])

    assert len(meetings) == len(set(meetings)) == 3 * 2 * 2
    assert all(meeting.red != meeting.blue for meeting in meetings)
    assert len(single_round_robin(["a", "b"], ["plain"], mirror=True)) == 4


def test_rows_are_those_of_the_matches(tmp_path: Path) -> None:
    meetings = single_round_robin(list(PLAYERS), ["plain"])
    table = play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path)

    alone = play_match("nearest", "MA1", games=4)
    row = table.rows[Meeting(red="near", blue="MA1", scenario="plain")]
    assert row["red"] == {"player": "near", **alone.red.summary()}
    assert [letter == "W" for letter in row["red_games"]] == list(alone.red.scores == 1.0)
    assert (
        table.win_rate("any", "red").value
        == (
            play_match("random", "MA1", games=4).win_rate.value
            + play_match("random", "nearest", games=4).win_rate.value
        )
        / 2
    )


def test_a_packed_table_comes_apart_into_the_matches_that_are_missing(tmp_path: Path) -> None:
    meetings = single_round_robin(list(PLAYERS), ["plain"])
    table = play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path / "first")
    pack(table, tmp_path / "matches.json")
    unpack(tmp_path / "matches.json", tmp_path / "second")

    paths = [tmp_path / "second" / meeting.file for meeting in meetings]
    times = [path.stat().st_mtime_ns for path in paths]
    again = play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path / "second")
    assert again.rows == table.rows
    assert [path.stat().st_mtime_ns for path in paths] == times
    assert len((tmp_path / "matches.json").read_text().splitlines()) == 2 + len(meetings)


@pytest.mark.parametrize("name", ["../m.json", "/m.json", "m.txt", "", "..", "a\\b/m.json"])
def test_a_packed_match_stays_in_its_folder(name: str, tmp_path: Path) -> None:
    (tmp_path / "matches.json").write_text(json.dumps({name: {}}))
    with pytest.raises(FileFormatError, match=r"matches\.json"):
        unpack(tmp_path / "matches.json", tmp_path / "folder" / "in")
    assert not (tmp_path / "folder").exists()


def test_what_was_played_is_not_played_again(tmp_path: Path) -> None:
    meetings = single_round_robin(list(PLAYERS), ["plain"])
    play_meetings(meetings[:2], PLAYERS, PLAYERS, HOW, tmp_path)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.json")}
    table = play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path)

    assert len(before) == 2
    assert all(path.stat().st_mtime_ns == time for path, time in before.items())
    assert len(table.rows) == len(list(tmp_path.glob("*.json"))) == 6


def test_two_processes_play_the_same_games_as_one(tmp_path: Path) -> None:
    meetings = single_round_robin(list(PLAYERS), ["plain"])
    one = play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path / "one")
    two = play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path / "two", jobs=2)

    assert one.rows == two.rows


def test_a_file_of_other_games_is_refused(tmp_path: Path) -> None:
    meetings = [Meeting(red="near", blue="any", scenario="plain")]
    play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path)
    with pytest.raises(FileFormatError, match=r"plain~near~any\.json: terms: .* choose another folder"):
        play_meetings(meetings, PLAYERS, PLAYERS, Evaluation(games=5), tmp_path)
    other = {**PLAYERS, "near": "MA2"}
    with pytest.raises(FileFormatError, match=r"players: found .*nearest.*; expected .*MA2"):
        play_meetings(meetings, other, PLAYERS, HOW, tmp_path)


def test_another_version_of_the_program_goes_on(tmp_path: Path) -> None:
    """Rules, bots, scenario and players must be equal."""
    meetings = [Meeting(red="near", blue="any", scenario="plain")]
    before = play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path)
    path = tmp_path / meetings[0].file
    path.write_text(json.dumps({**json.loads(path.read_text()), "software": "0.0.1"}))
    after = play_meetings(meetings, PLAYERS, PLAYERS, HOW, tmp_path)

    assert after.rows[meetings[0]]["red_games"] == before.rows[meetings[0]]["red_games"]


@pytest.mark.parametrize(("ticks", "message"), [("0", "at least 1"), ("40000", "at most 30000")])
def test_a_policy_that_would_never_decide_is_refused(ticks: str, message: str, tmp_path: Path) -> None:
    model = QMIX("TaskPolicy", make_vec_env(n_envs=1, privileged_state=True, seed=0), seed=0, buffer_size=10)
    model.policy.freeze(decision_ticks=ticks).save(tmp_path / "policy")
    players = {"stranger": str(tmp_path / "policy"), "near": "nearest"}
    meetings = [Meeting(red="stranger", blue="near", scenario="plain")]
    with pytest.raises(HexWarError, match=message):
        play_meetings(meetings, players, players, HOW, tmp_path / "matches")


def test_a_broken_policy_is_named_from_another_process(tmp_path: Path) -> None:
    model = QMIX("TaskPolicy", make_vec_env(n_envs=1, privileged_state=True, seed=0), seed=0, buffer_size=10)
    model.policy.freeze().save(tmp_path / "policy")
    (tmp_path / "policy" / "weights.safetensors").write_bytes(b"")
    with pytest.raises(PolicyFileError, match=r"weights\.safetensors: sha256: found other weights"):
        run_jobs(FrozenPolicy.load, [tmp_path / "policy"] * 2, 2, "policy")


@pytest.mark.parametrize(
    ("text", "found"),
    [("{", "Expecting"), ("[]", "found list; expected a match"), ('{"format": 7}', "found 7")],
)
def test_a_broken_file_is_named(tmp_path: Path, text: str, found: str) -> None:
    meeting = Meeting(red="near", blue="any", scenario="plain")
    (tmp_path / meeting.file).write_text(text)
    with pytest.raises(FileFormatError, match=rf"plain~near~any\.json: .*{found}"):
        play_meetings([meeting], PLAYERS, PLAYERS, HOW, tmp_path)


def test_a_player_is_known_by_what_it_is() -> None:
    assert fingerprint("MA1") != fingerprint("MA2")
    assert json.dumps(fingerprint("MA1"))


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> Match:
    """A match with its file."""
    folder = tmp_path_factory.mktemp("matches")
    meeting = Meeting(red="near", blue="any", scenario="plain")
    play_meetings([meeting], PLAYERS, PLAYERS, HOW, folder)
    return Match(meeting, PLAYERS["near"], PLAYERS["any"], HOW, folder)


def test_nothing_but_our_errors_comes_of_a_bad_match_file(played: Match, bad: Any, tmp_path: Path) -> None:
    match, refused = replace(played, folder=tmp_path), 0
    for content in islice(bad(json.loads(played.path.read_text())), 0, None, 5):
        match.path.write_bytes(content)
        try:
            match.read()
        except (HexWarError, OSError):
            refused += 1
    assert refused > 80


CHANGES: dict[str, tuple[dict[str, Any], str]] = {
    "another seed": ({"seed": 1}, r"seed: found 1; expected 0"),
    "a seed that is true": ({"seed": False}, "seed: found False"),
    "no games": ({"red_games": ""}, "red_games"),
    "another scenario": ({"scenario": "hills"}, "scenario: found hills"),
    "another player": ({"players": {"red": "x", "blue": "y"}}, "players: found"),
    "no red": ({"red": None}, "red: found NoneType; expected names and values"),
    "games of another letter": ({"red_games": "XXXX"}, "red_games: found 'XXXX'"),
}


@pytest.mark.parametrize("what", CHANGES)
def test_a_match_file_that_was_changed_is_noticed(what: str, played: Match, tmp_path: Path) -> None:
    match, row = replace(played, folder=tmp_path), json.loads(played.path.read_text())
    changes, message = CHANGES[what]
    match.path.write_text(json.dumps({**row, **changes}))
    with pytest.raises(FileFormatError, match=message):
        match.read()


def test_terms_are_of_their_types(played: Match, tmp_path: Path) -> None:
    """In Python 0 equals False."""
    match, row = replace(played, folder=tmp_path), json.loads(played.path.read_text())
    row["terms"] |= {"early": 0}
    match.path.write_text(json.dumps(row))
    with pytest.raises(FileFormatError, match="terms: found"):
        match.read()


@pytest.mark.parametrize("camp", ["red", "blue"])
@pytest.mark.parametrize(
    "name",
    [
        "player",
        "games",
        "wins",
        "draws",
        "losses",
        "win_rate",
        "win_rate_interval",
        "mean_margin",
        "points_held",
    ],
)
def test_figures_that_do_not_add_up_are_noticed(name: str, camp: str, played: Match, tmp_path: Path) -> None:
    match, row = replace(played, folder=tmp_path), json.loads(played.path.read_text())
    other = {"player": "x", "win_rate_interval": [0.1, 0.2], "mean_margin": 1e6, "points_held": [0.5, 0.1]}
    row[camp][name] = other[name] if name in other else row[camp][name] + 1
    match.path.write_text(json.dumps(row))
    with pytest.raises(FileFormatError, match=rf"{camp}"):
        match.read()
    del row[camp][name]
    match.path.write_text(json.dumps(row))
    with pytest.raises(FileFormatError, match=rf"{camp}\.{name}: found nothing"):
        match.read()


def test_the_median_game_is_the_first_of_equals() -> None:
    assert median_game(np.array([5.0, 5.0, 5.0])) == 0
    assert median_game(np.array([9.0, 5.0, 1.0, 5.0])) == 1


def test_a_median_game_of_another_match_is_written_anew(tmp_path: Path) -> None:
    players, meeting = {"a": "MA1", "b": "nearest"}, Meeting(red="a", blue="b", scenario="plain")
    seeds, times = [], []
    for seed in (0, 1, 1):
        how = Evaluation(games=1, seed=seed)
        table = play_meetings([meeting], players, players, how, tmp_path / f"matches_{seed}")
        record_medians(table, players, players, how, tmp_path / "games")
        path = tmp_path / "games" / "plain~a~b.hwr"
        seeds.append(Replay.load(path).seed)
        times.append(path.stat().st_mtime_ns)

    assert seeds[0] != seeds[1] == seeds[2]
    assert times[0] != times[1] == times[2]
