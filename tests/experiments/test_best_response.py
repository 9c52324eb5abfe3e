"""Best responses: kept figures are not trained again, others' are refused, and the same seed gives the same curve."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from hexwar_sb3 import __version__
from hexwar_sb3.cli import parse
from hexwar_sb3.commands.exploit import Exploit, in_words
from hexwar_sb3.errors import ConfigError, FileFormatError, HexWarError
from hexwar_sb3.experiments import best_response
from hexwar_sb3.experiments.best_response import Response, games_until_half, read_figures, responses, summary
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import make_player

SMALL: dict[str, Any] = {"games": 40, "every": 20, "eval_games": 2}


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Response], list[dict[str, Any]]]:
    folder = tmp_path_factory.mktemp("exploit")
    specs = [Response(player="nearest", camp=camp, seed=0, **SMALL) for camp in ("red", "blue")]
    return folder, specs, responses(specs, folder)


def figures(rates: list[float], camp: str = "red", seed: int = 0) -> dict[str, Any]:
    rows = [{"games": 100 * (k + 1), "win_rate": rate, "mean_margin": 0.0} for k, rate in enumerate(rates)]
    return {"head": {"camp": camp, "seed": seed}, "curve": rows}


def test_a_response_is_evaluated_as_often_as_was_asked(trained: Any) -> None:
    _, specs, found = trained
    for spec, its in zip(specs, found, strict=True):
        assert its["head"]["camp"] == spec.camp
        assert its["head"]["player"].startswith("nearest ")
        games = [row["games"] for row in its["curve"]]
        assert games[0] >= 20
        assert 40 <= games[-1] < 40 + 32


def test_the_same_seed_gives_the_same_curve_and_what_is_kept_is_not_trained_again(
    trained: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, specs, found = trained
    again = responses(specs[:1], tmp_path)
    assert again[0]["curve"] == found[0]["curve"]
    monkeypatch.setattr(best_response, "respond", None)
    assert responses(specs, folder) == found


def test_figures_of_another_player_or_other_settings_are_refused(trained: Any) -> None:
    folder, _, _ = trained
    for other in ({"player": "defender"}, {"player": "nearest", "eval_games": 3}):
        with pytest.raises(FileFormatError, match=r"red_0\.json: head"):
            responses([Response(**{"camp": "red", "seed": 0, **SMALL, **other})], folder)


def test_figures_of_an_earlier_version_of_the_program_are_gone_on_with(trained: Any, tmp_path: Path) -> None:
    folder, specs, found = trained
    file = tmp_path / "red_0.json"
    file.write_text(
        (folder / "red_0.json").read_text().replace(f'"software": "{__version__}"', '"software": "0.1.0"')
    )

    assert '"0.1.0"' in file.read_text()
    assert responses(specs[:1], tmp_path)[0]["curve"] == found[0]["curve"]


def test_nothing_but_our_errors_comes_of_bad_figures(trained: Any, tmp_path: Path, bad: Any) -> None:
    folder, specs, _ = trained
    refused = 0
    file = tmp_path / "red_0.json"
    for content in bad(json.loads((folder / "red_0.json").read_text())):
        file.write_bytes(content)
        try:
            found = read_figures(file, specs[0].head())
            summary([found])
        except (HexWarError, OSError):
            refused += 1
    assert refused > 100


def test_games_until_half_are_those_of_the_first_evaluation_that_has_it() -> None:
    assert games_until_half(figures([0.1, 0.5, 0.2])) == 200
    assert games_until_half(figures([0.1, 0.49])) is None


def test_a_response_that_never_wins_half_counts_as_more_than_all() -> None:
    found = [figures([0.6]), figures([0.1, 0.7], seed=1), figures([0.1, 0.2], seed=2)]
    one = summary(found)["red"]
    assert (one["games until half"], one["median"]) == ([100, 200, None], 200)
    assert summary([figures([0.1])])["red"]["median"] is None


def test_the_command_leaves_table_and_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["exploit", "random", "--games", "32", "--every", "32", "--seeds", "1", "--eval-games", "2"]
    assert parse([*command, "--output", str(tmp_path / "x")]).run() == 0
    assert "Best responses to random" in capsys.readouterr().out
    assert {path.name for path in (tmp_path / "x").iterdir()} >= {
        "table.json",
        "table.txt",
        "exploit.png",
        "red_0.json",
    }


@pytest.mark.parametrize(("side", "camps"), [("red", {"blue"}), ("blue", {"red"}), ("both", {"red", "blue"})])
def test_responses_play_against_the_camp_that_a_policy_was_trained_for(
    side: str, camps: set[str], tmp_path: Path
) -> None:
    policy = cast("FrozenPolicy", make_player("HRL0"))
    policy.about["side"] = side
    policy.save(tmp_path / "policy")
    found = Exploit(player=str(tmp_path / "policy"), seeds=2)._responses()
    assert {response.camp for response in found} == camps
    assert len(found) == 2 * len(camps)


def test_a_table_says_who_never_won_half() -> None:
    told = in_words({"player": "P", "games": 40, "camps": summary([figures([0.1])])})
    assert "more than 40" in told


@pytest.mark.parametrize("setting", ["games", "seeds", "every", "eval_games", "jobs"])
def test_numbers_have_their_ranges(setting: str) -> None:
    with pytest.raises(ConfigError, match=f"{setting} must be at least 1"):
        replace(Exploit(player="MA1"), **{setting: 0}).check()  # type: ignore[arg-type]
