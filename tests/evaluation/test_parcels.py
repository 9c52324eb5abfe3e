"""Jobs that travel: what they read goes along, what they leave comes back, wherever they are done."""

from __future__ import annotations

import os
import pickle
from dataclasses import dataclass, replace
from pathlib import Path

import joblib
import pytest

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ClusterError, ConfigError, PolicyFileError
from hexwar_sb3.evaluation import parcels
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.parcels import as_place, at_hand, files_of, leave, pack, program, work
from hexwar_sb3.evaluation.tournament import play_meetings, record_medians, single_round_robin
from hexwar_sb3.folders import holding
from hexwar_sb3.maps.files import load_scenario, save_scenario
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import make_player


@dataclass(frozen=True)
class Spec:
    """A job that adds a line to a text."""

    text: Path
    copy: Path


def add_line(spec: Spec) -> int:
    """Write what it reads and a line more; its process."""
    assert spec.copy.name == "copy.txt"
    spec.copy.parent.mkdir(parents=True, exist_ok=True)
    spec.copy.write_text(f"{spec.text.read_text()}one more\n")
    return os.getpid()


def leaves(spec: Spec) -> list[Path]:
    """The copy."""
    return [spec.copy]


@pytest.fixture
def spec(tmp_path: Path) -> Spec:
    """A text of one line."""
    (tmp_path / "text.txt").write_text("one\n")
    return Spec(tmp_path / "text.txt", tmp_path / "made" / "copy.txt")


@pytest.mark.usefixtures("elsewhere")
def test_what_a_job_reads_goes_along_and_what_it_leaves_comes_back(spec: Spec) -> None:
    found = run_jobs(add_line, [spec], 2, "text", leaves=leaves)

    assert found == [os.getpid()]
    assert spec.copy.read_text() == "one\none more\n"


def test_a_worker_sees_no_file_of_the_sender(spec: Spec) -> None:
    parcel = pack(add_line, spec, leaves)
    spec.text.unlink()
    result = work(parcel)

    assert result.error is None
    assert result.files == [{"": b"one\none more\n"}]
    assert not spec.copy.exists()


def test_files_travel_as_often_as_a_spec_names_them_and_a_text_stays_a_text(spec: Spec) -> None:
    twice, text = work(pack(_read, (spec.text, [spec.text], str(spec.text)))).made

    assert twice == "one\none\n"
    assert text == str(spec.text)


def _read(spec: tuple[Path, list[Path], str]) -> tuple[str, str]:
    return spec[0].read_text() + spec[1][0].read_text(), spec[2]


def test_of_the_folder_that_a_job_leaves_something_in_nothing_travels(tmp_path: Path) -> None:
    (tmp_path / "other.txt").write_text("much")

    assert work(pack(_count, (tmp_path, tmp_path / "new.txt"), lambda spec: [spec[1]])).made == 0
    assert work(pack(_count, (tmp_path, tmp_path / "new.txt"))).made == 1


def _count(spec: tuple[Path, Path]) -> int:
    return len(list(spec[0].rglob("*.txt")))


def test_of_a_run_its_policy_travels(tmp_path: Path) -> None:
    policy = make_player("HRL0")
    assert isinstance(policy, FrozenPolicy)
    policy.save(tmp_path / "run" / "policy")
    (tmp_path / "run" / "checkpoint.npz").write_bytes(bytes(1000))
    assert pack(_hash, tmp_path / "run").call.find(bytes(1000)) == -1

    assert work(pack(_hash, tmp_path / "run")).made == policy.sha256


def _hash(run: Path) -> str:
    return str(getattr(make_player(run), "sha256", None))


def test_locks_and_half_written_files_stay(tmp_path: Path) -> None:
    for name in (".lock", ".new-x.json", "x.json", ".new-y/z"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(name)

    assert files_of(tmp_path) == {"x.json": b"x.json"}
    assert files_of(tmp_path / "none") is None


def test_what_is_too_large_does_not_travel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parcels, "MOST_BYTES", 1 << 20)
    (tmp_path / "large").write_bytes(bytes((1 << 20) + 1))

    with pytest.raises(ConfigError, match=r"large has more than 1 MB: too much to travel with a job"):
        pack(_hash, tmp_path / "large")


@pytest.mark.usefixtures("elsewhere")
def test_what_cannot_be_packed_later_is_an_error_too(
    spec: Spec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Jobs before it are done: joblib asks for the others in a thread, whose errors nobody sees."""
    monkeypatch.setattr(parcels, "MOST_BYTES", 1 << 20)
    (tmp_path / "large").write_bytes(bytes((1 << 20) + 1))
    copies = [replace(spec, copy=tmp_path / str(n) / "copy.txt") for n in range(4)]

    with pytest.raises(ConfigError, match="too much to travel"):
        run_jobs(add_line, [*copies, replace(spec, text=tmp_path / "large")], 2, "text", leaves=leaves)
    assert all(one.copy.exists() for one in copies)


@pytest.mark.parametrize("name", ["../outside", "/etc/outside", "a/../../outside", "..\\outside"])
def test_what_comes_back_is_written_nowhere_else(name: str, tmp_path: Path) -> None:
    with pytest.raises(ClusterError, match="expected files of this folder"):
        leave({"inside": b"", name: b"x"}, tmp_path / "one" / "folder")

    assert not list(tmp_path.rglob("*side"))


@pytest.mark.parametrize("what", ["hexwar_sb3", "rules", "sources", "torch"])
def test_a_worker_that_is_another_program_does_nothing(what: str, spec: Spec) -> None:
    parcel = pack(add_line, spec, leaves)
    other = replace(parcel, program={**parcel.program, what: "0"}, call=b"not even read")

    result = work(other)

    assert isinstance(result.error, ClusterError)
    assert f"found {what} {program()[what]}; expected 0, as here" in str(result.error)
    assert not result.files


@pytest.mark.usefixtures("elsewhere")
def test_errors_of_ours_come_back_with_the_paths_that_the_user_knows(tmp_path: Path) -> None:
    (tmp_path / "policy").mkdir()
    (tmp_path / "policy" / "config.json").write_text("{")

    with pytest.raises(PolicyFileError) as caught:
        run_jobs(_hash, [tmp_path / "policy"], 1, "policy")
    assert str(caught.value).startswith(f"{tmp_path}/policy/config.json: ")


@pytest.mark.usefixtures("elsewhere")
def test_other_errors_come_back_as_one_line(tmp_path: Path) -> None:
    with pytest.raises(ClusterError, match=r"^[^ ]+: ZeroDivisionError: first line$"):
        run_jobs(_fail, [tmp_path], 1, "failure")


def _fail(_: Path) -> None:
    raise ZeroDivisionError("first line\nsecond line")


@pytest.mark.usefixtures("elsewhere")
def test_what_has_ended_before_an_error_is_kept(spec: Spec) -> None:
    wrong = replace(spec, copy=spec.copy.parent / "other name")

    with pytest.raises(ClusterError, match="AssertionError"):
        run_jobs(add_line, [spec, wrong], 1, "text", leaves=leaves)
    assert spec.copy.exists()


@pytest.mark.usefixtures("elsewhere")
def test_a_held_folder_that_is_gone_is_not_made_anew(spec: Spec) -> None:
    with holding(spec.copy.parent, "text"):
        (spec.copy.parent / ".lock").unlink()
        spec.copy.parent.rmdir()
        with pytest.raises(FileNotFoundError, match="removed while it was in use"):
            run_jobs(add_line, [spec], 1, "text", leaves=leaves)


def test_errors_and_results_can_be_pickled(spec: Spec) -> None:
    result = work(pack(add_line, spec, leaves))

    assert pickle.loads(pickle.dumps(result)) == result  # noqa: S301  our own


def test_players_and_scenarios_of_files_are_told_from_names(tmp_path: Path) -> None:
    save_scenario(load_scenario("plain"), tmp_path / "valley.scenario.json")

    assert [as_place(one) for one in ("MA1", "drawn:3", "HRL0", "runs/one")] == [
        "MA1",
        "drawn:3",
        "HRL0",
        Path("runs/one"),
    ]
    assert at_hand("hills@7") == "hills@7"
    assert (
        getattr(at_hand(str(tmp_path / "valley.scenario.json")), "hash", None) == load_scenario("plain").hash
    )


@pytest.mark.usefixtures("elsewhere")
def test_matches_elsewhere_leave_the_same_files(tmp_path: Path) -> None:
    policy = make_player("HRL0")
    assert isinstance(policy, FrozenPolicy)
    policy.save(tmp_path / "run" / "policy")
    save_scenario(load_scenario("hills"), tmp_path / "valley.scenario.json")
    players: dict[str, object] = {"MA1": "MA1", "own": str(tmp_path / "run")}
    meetings = single_round_robin(list(players), [str(tmp_path / "valley.scenario.json")])
    for name, backend in (("here", "sequential"), ("there", "elsewhere")):
        with joblib.parallel_config(backend):
            how, folder = Evaluation(games=2), tmp_path / name
            table = play_meetings(meetings, players, players, how, folder)
            record_medians(table, players, players, how, folder, command="hexwar tournament")

    here, there = (contents(tmp_path / name) for name in ("here", "there"))
    assert len(here) == 4
    assert here == there


def contents(folder: Path) -> dict[str, object]:
    """What a tournament's files say, but for when games were written down."""
    found: dict[str, object] = {path.name: path.read_bytes() for path in folder.glob("*.json")}
    for path in folder.glob("*.hwr"):
        head, *lines = Replay.load(path).lines
        found[path.name] = [{**head, "created": None}, *lines[:-1]]  # the last is the hash of all
    return found
