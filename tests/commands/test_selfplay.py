"""`hexwar selfplay` and `hexwar distill`: from policies to champions, on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.cli import main
from hexwar_sb3.commands.selfplay import SelfPlay
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.league.member import as_member
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.players.frozen import FrozenPolicy

FEW = (
    *("--keep", "1", "--iterations", "1", "--games", "2", "--match-games", "1", "--warm-up-games", "2"),
    *("--opponents", "MA1", "drawn"),
)


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    return int(str(stopped.value.code))


@pytest.fixture(scope="module")
def starters(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Two run folders with policies."""
    folder, env = tmp_path_factory.mktemp("runs"), make_vec_env(n_envs=1, privileged_state=True, seed=0)
    for seed in (1, 2):
        model = QMIX("TaskPolicy", env, seed=seed, buffer_size=10)
        as_member(model, side="both", scenario="plain").save(folder / f"run_{seed}" / "policy")
    return [str(folder / "run_1"), str(folder / "run_2")]


def test_a_league_is_begun_and_gone_on_with(
    starters: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("selfplay", *starters, *FEW, "--output", str(tmp_path / "league"))
    assert run(*words) == 0
    capsys.readouterr()
    assert (
        run("selfplay", *FEW, "--output", str(tmp_path / "league"), "--json") == 0
    )  # no starters: it has them
    kept = json.loads(capsys.readouterr().out)["kept"]

    assert [Path(path).parent.name for path in kept["red"]] == ["1-m0"]
    assert FrozenPolicy.load(kept["blue"][0]).about["side"] == "both"
    assert run("selfplay", *starters, *FEW, "--split", "--output", str(tmp_path / "split"), "--json") == 0
    kept = json.loads(capsys.readouterr().out)["kept"]
    assert FrozenPolicy.load(kept["blue"][0]).about["side"] == "blue"


def test_teachers_become_one_policy(
    starters: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("distill", *starters, "--games", "2", "--updates", "3", "--output", str(tmp_path / "student"))
    assert run(*words, "--json") == 0
    figures = json.loads(capsys.readouterr().out)

    assert figures["loss"] > 0
    assert FrozenPolicy.load(tmp_path / "student").about["teachers"] == "run_1, run_2"


def test_teachers_of_different_camps_need_a_word(
    starters: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    env = make_vec_env(n_envs=1, privileged_state=True, seed=0)
    model = QMIX("TaskPolicy", env, seed=3, buffer_size=10)
    as_member(model, side="red", scenario="plain").save(tmp_path / "red")
    words = ("distill", str(tmp_path / "red"), "--games", "2", "--updates", "3")

    assert run(*words, "--output", str(tmp_path / "one")) == 0
    assert FrozenPolicy.load(tmp_path / "one").about["side"] == "red"
    both = ("distill", starters[0], *words[1:])
    assert run(*both, "--output", str(tmp_path / "two")) == 2
    assert "trained as different camps" in capsys.readouterr().err
    assert run(*both, "--side", "red", "--output", str(tmp_path / "two")) == 0
    assert FrozenPolicy.load(tmp_path / "two").about["side"] == "red"


MISTAKES: dict[str, tuple[tuple[str, ...], str]] = {
    "nobody to learn from": (("distill",), "name a teacher"),
    "a teacher's seed": (("distill", "--seed", "-1", "x"), "seed must be in 0..999999"),
    "nobody": (("selfplay",), "no model to begin with for red"),
    "a folder without a policy": (("selfplay", "here=."), "config.json"),
    "shares": (("selfplay", "--partner-share", "0.9", "--past-share", "0.9"), "must add up to at most 1"),
    "jobs": (("selfplay", "--jobs", "0"), "jobs must be at least 1"),
    "no teacher": (("distill", "nobody"), "config.json"),
    "temperature": (("distill", "nobody", "--tau", "-1"), "tau must be finite and above 0"),
}


@pytest.mark.parametrize("what", MISTAKES)
def test_a_mistake_is_one_line(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words, message = MISTAKES[what]
    assert run(*words, "--output", str(tmp_path / "out")) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_the_command_has_the_leagues_own_defaults() -> None:
    own, mine = vars(LeagueSettings()), vars(SelfPlay())
    shared = own.keys() & mine.keys()

    assert shared >= {
        "iterations",
        "games",
        "split",
        "priority",
        "embed",
        "match_games",
        "partner_share",
        "past_share",
        "hidden",
    }
    assert {name for name in shared if mine[name] != own[name]} == {
        "opponents"
    }  # the command adds HRL0 where it fits
