"""Grouped self-play (III-C, Fig. 6): the folder is the state, a league that was killed ends as an unbroken one."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.errors import ConfigError, FileFormatError, PolicyFileError, UnknownNameError
from hexwar_sb3.league import group
from hexwar_sb3.league.group import train_group
from hexwar_sb3.league.judge import Rivals
from hexwar_sb3.league.league import League, group_name, parent_of
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.play.frozen import FrozenPolicy
from tests.league.test_judge import Rigged

BOTS = LeagueSettings().bots


def contents(folder: Path) -> dict[str, str]:
    """Hash of every file that a result depends on."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "cost.json"
    }


def distinct(league: League, k: int, camp: str) -> set[str]:
    """Hashes of the models of an iteration."""
    return {member.policy().sha256 for member in league.models(k)[camp]}


def test_every_red_model_trains_with_every_blue_one(whole: League) -> None:
    specs = whole.specs(2)

    pairs = [(spec.members["red"].name, spec.members["blue"].name) for spec in specs]
    kept = whole.kept(1)
    assert pairs == [(red.name, blue.name) for red in kept["red"] for blue in kept["blue"]]


def test_models_meet_their_partner_the_past_and_the_bots(whole: League) -> None:
    others = whole.specs(2)[0].others["red"]

    assert [str(player) for player, _ in others] == [
        str(whole.kept(0)["blue"][0].folder),
        str(whole.kept(1)["blue"][0].folder),
        "MA1",
        "MA2",
        "all-main",
    ]
    assert [weight for _, weight in others] == pytest.approx([0.15, 0.15, *[0.5 / 3] * 3])


def test_half_of_the_past_is_the_very_first_best(whole: League) -> None:
    first, second, third, *_ = (weight for _, weight in whole.others(3, "red"))

    assert (first, second, third) == pytest.approx((0.15, 0.075, 0.075))


def test_versions_are_judged_by_the_first_and_the_latest_best_and_by_bots(whole: League) -> None:
    first, latest = (str(whole.kept(k)["red"][0].folder) for k in (0, 1))

    assert whole.specs(2)[0].rivals["blue"] == Rivals((first, latest), ("MA1", "MA2", "all-main"), 0.5)
    assert len(whole.rivals(1, "blue").models) == 1  # the first best is the latest


def test_models_that_were_kept_go_to_school_against_all_that_they_will_meet(schooled: League) -> None:
    for pupil, camp, enemy in zip(schooled.pupils(2), ("red", "blue"), ("blue", "red"), strict=True):
        first, latest = (str(schooled.kept(k)[enemy][0].folder) for k in (0, 1))
        members = [schooled.kept(1)[camp][0], schooled.kept(0)[camp][0]]
        assert [one.policy for one in pupil.searches] == members
        for one in pupil.searches:
            assert [player for player, _ in one.opponents] == [latest, first, "MA1", "MA2", "all-main"]
            assert one.weights() == pytest.approx([0.35, 0.15, *[0.5 / 3] * 3])


def test_groups_begin_with_what_was_learned_at_school(schooled: League) -> None:
    spec = schooled.specs(2)[0]
    for pupil, camp in zip(schooled.pupils(2), ("red", "blue"), strict=True):
        assert spec.members[camp].folder == pupil.folder
        assert spec.members[camp].policy().sha256 not in {
            one.policy.policy().sha256 for one in pupil.searches
        }


def test_every_model_has_a_plan_and_the_very_first_best_of_its_colour(schooled: League) -> None:
    found = schooled.searches(2)
    names = {
        f"{camp}/{name}.json"
        for camp in ("red", "blue")
        for name in (schooled.kept(1)[camp][0].name, ".first")
    }

    assert {"/".join(one.file.parts[-2:]) for searches in found.values() for one in searches} == names
    assert all(one.file.is_file() for searches in found.values() for one in searches)
    costs = json.loads((schooled.iteration(2) / "cost.json").read_text())
    assert {"school", "groups", "round robin"} <= costs.keys()


def test_a_league_with_school_goes_on_where_it_was_stopped(schooled: League, tmp_path: Path) -> None:
    shutil.copytree(schooled.folder, tmp_path / "copy")
    league, again = League.open(tmp_path / "copy"), schooled.iteration(2).name
    shutil.rmtree(tmp_path / "copy" / again / "groups")
    (tmp_path / "copy" / again / "table.json").unlink()
    shutil.rmtree(tmp_path / "copy" / again / "matches")
    school = tmp_path / "copy" / again / "school"
    next(school.glob("red/*.json")).unlink()
    gone = next(school.glob("blue/*/config.json")).parent
    shutil.rmtree(gone)
    left_over = gone.parent / ".new-left-over"
    left_over.mkdir()
    (left_over / "config.json").touch()
    league.run()

    assert contents(tmp_path / "copy") == contents(schooled.folder)


def test_a_model_that_fills_several_places_goes_to_school_once(
    tiny: LeagueSettings, starters: dict[str, Path], tmp_path: Path
) -> None:
    league = League.create(tmp_path, replace(tiny, keep=4), {"one": starters["one"]})
    League(tmp_path, replace(league.settings, iterations=0)).run()

    assert [len(members) for members in league.kept(0).values()] == [4, 4]
    assert [pupil.folder.name for pupil in league.pupils(1)] == ["one", "one"]


def test_models_that_play_alike_play_the_round_robin_once(whole: League, tmp_path: Path) -> None:
    """Where no training made a model better, its groups leave it as it came."""
    shutil.copytree(whole.folder, tmp_path / "league")
    league = League.open(tmp_path / "league")
    shutil.rmtree(league.iteration(2) / "matches")
    league.table(2).unlink()
    same = league.models(2)["red"]
    for member in same[1:3]:
        shutil.rmtree(member.folder)
        shutil.copytree(same[0].folder, member.folder)
    league.run()

    found = json.loads(league.table(2).read_text())
    assert {row["name"] for row in found["standings"]["red"]} == {same[0].name, same[3].name}
    assert len(set(found["kept"]["red"])) == 2


def test_without_school_nobody_searches(whole: League) -> None:
    assert not list(whole.folder.rglob("school"))
    assert whole.specs(2)[0].members["red"] == whole.kept(1)["red"][0]


def test_the_learning_rate_falls_from_iteration_to_iteration(whole: League) -> None:
    rates = [whole.learner(4, k)["learning_rate"] for k in (1, 2, 3)]

    assert rates == pytest.approx([1e-3, 1e-3 * whole.settings.cooling, 1e-3 * whole.settings.cooling**2])


def test_random_tasks_grow_rare_over_the_first_games_with_those_of_the_refit(whole: League) -> None:
    league = League(whole.folder, replace(whole.settings, refit_games=200))

    assert league.learner(800, 1)["exploration_episodes"] == 600


def test_the_best_weighted_win_rate_is_kept(whole: League) -> None:
    """Half of it over the enemy's models, half against the bot that it does worst against."""
    found = json.loads((whole.iteration(2) / "table.json").read_text())
    rates: dict[str, dict[bool, list[float]]] = {}
    for pair, rate in found["red_win_rates"].items():
        red, blue = pair.split()
        if red not in BOTS:
            rates.setdefault(red, {True: [], False: []})[blue in BOTS].append(rate)
    means = {
        name: (min(parts[True]) + sum(parts[False]) / len(parts[False])) / 2 for name, parts in rates.items()
    }

    reds, blues = (len(distinct(whole, 2, camp)) for camp in ("red", "blue"))
    assert len(found["red_win_rates"]) == reds * blues + (reds + blues) * len(BOTS)
    assert {row["name"]: row["win_rate"] for row in found["standings"]["red"]} == pytest.approx(means)
    assert means[found["kept"]["red"][0]] == max(means.values())
    worst = min(row["win_rate"] for row in found["standings"]["blue"] if row["name"] in found["kept"]["blue"])
    assert all(
        row["win_rate"] <= worst
        for row in found["standings"]["blue"]
        if row["name"] not in found["kept"]["blue"]
    )
    for row in found["standings"]["blue"]:
        low, high = row["win_rate_interval"]
        assert 0.0 <= low <= row["win_rate"] <= high <= 1.0


def test_bots_play_in_the_round_robin_but_are_not_kept(whole: League) -> None:
    found = json.loads((whole.iteration(2) / "table.json").read_text())

    for camp in ("red", "blue"):
        assert len(found["standings"][camp]) == len(distinct(whole, 2, camp))
        assert not set(found["kept"][camp]) & set(BOTS)
    assert not any(set(pair.split()) <= set(BOTS) for pair in found["red_win_rates"])


def test_a_league_of_another_mixer_is_trained(
    tiny: LeagueSettings, starters: dict[str, Path], tmp_path: Path
) -> None:
    settings = replace(tiny, keep=1, refit_games=2, learner={**tiny.learner, "mixer": "vdn"})
    League.create(tmp_path, settings, starters).run()

    assert League.open(tmp_path).is_done(2)


def test_a_model_knows_its_parent(whole: League) -> None:
    found = json.loads((whole.iteration(2) / "table.json").read_text())
    before = whole.kept(1)
    for camp in ("red", "blue"):
        for row in found["standings"][camp]:
            assert row["parent"] == before[camp][parent_of(row["name"], camp)].name
    assert (parent_of(group_name(3, 1, 2), "red"), parent_of(group_name(3, 1, 2), "blue")) == (1, 2)


def test_a_group_is_a_function_of_its_spec(whole: League, tmp_path: Path) -> None:
    spec = whole.specs(1)[2]
    train_group(replace(spec, folder=tmp_path / "again"))

    assert contents(tmp_path / "again") == contents(spec.folder)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["again"]


@pytest.mark.parametrize("learned", [True, False])
def test_a_group_leaves_what_a_model_learned_unless_it_was_better_before(
    whole: League, tmp_path: Path, *, learned: bool
) -> None:
    """Versions are judged one after the other, the model as it entered first."""
    shares = iter(k / 100 if learned else 1.0 - k / 100 for k in range(100))
    spec = replace(whole.specs(1)[0], trial=Rigged(shares=shares), folder=tmp_path / "group")
    train_group(spec)

    for camp, member in spec.members.items():
        left = FrozenPolicy.load(tmp_path / "group" / camp)
        assert (left.sha256 != member.policy().sha256) == learned


BREAKS: dict[str, Callable[[League], object]] = {
    "a group": lambda league: shutil.rmtree(league.group(1, "1-r1b0")),
    "all matches": lambda league: shutil.rmtree(league.iteration(2) / "matches"),
    "one match": lambda league: next((league.iteration(2) / "matches").glob("*.json")).unlink(),
}


@pytest.mark.parametrize("lost", BREAKS)
def test_a_league_that_was_broken_off_ends_as_an_unbroken_one(
    lost: str, whole: League, tmp_path: Path
) -> None:
    folder = tmp_path / "league"
    shutil.copytree(whole.folder, folder)
    league = League.open(folder)
    (league.iteration(2) / "table.json").unlink()
    if lost == "a group":  # then what comes after it was not there yet
        shutil.rmtree(league.iteration(2))
        (league.iteration(1) / "table.json").unlink()
        left_over = league.iteration(1) / "groups" / ".new-left-over"
        left_over.mkdir()
        (left_over / "config.json").touch()
    BREAKS[lost](league)
    league.run()

    assert contents(folder) == contents(whole.folder)


def test_two_processes_make_the_same_league_as_one(
    whole: League, starters: dict[str, Path], tmp_path: Path
) -> None:
    league = League.create(tmp_path, replace(whole.settings, iterations=1), starters)
    league.run(jobs=2)

    assert contents(league.iteration(1)) == contents(whole.iteration(1))


def test_a_finished_league_plays_nothing_again(whole: League, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(group, "begin", None)
    done: list[int] = []
    whole.run(after=done.append)

    assert done == [0, 1, 2]


def test_more_iterations_go_on_from_the_last(
    whole: League, starters: dict[str, Path], tmp_path: Path
) -> None:
    shutil.copytree(whole.folder, tmp_path / "league")
    longer = League.create(tmp_path / "league", replace(whole.settings, iterations=3), starters)
    longer.run()

    assert longer.is_done(3)
    assert contents(longer.iteration(2)) == contents(whole.iteration(2))
    with pytest.raises(ConfigError, match="other settings: iterations 3, not 1"):
        League.create(tmp_path / "league", replace(whole.settings, iterations=1), starters)


def test_other_settings_are_refused(whole: League, starters: dict[str, Path]) -> None:
    with pytest.raises(ConfigError, match="holds a league of other settings: games 4, not 5"):
        League.create(whole.folder, replace(whole.settings, games=5), starters)


def test_other_models_to_begin_with_are_refused(whole: League, starters: dict[str, Path]) -> None:
    with pytest.raises(ConfigError, match="a league that began with one, two, not with one, three"):
        League.create(whole.folder, whole.settings, {"one": starters["one"], "three": starters["two"]})
    with pytest.raises(ConfigError, match="a league that began with another one"):
        League.create(whole.folder, whole.settings, {"one": starters["two"], "two": starters["two"]})


def test_a_scenario_with_other_pieces_leaves_no_league(
    tiny: LeagueSettings, tmp_path: Path, starters: dict[str, Path]
) -> None:
    policy = FrozenPolicy.load(starters["one"])
    small = FrozenPolicy(policy.weights, n_pieces=3, n_tasks=policy.n_tasks, about=policy.about)
    small.save(tmp_path / "small")
    with pytest.raises(ConfigError, match=r"small has \(pieces, .*\) \(3, 40, 257, 36\), plain \(7, 40, 257"):
        League.create(tmp_path / "league", tiny, {"small": tmp_path / "small"})
    assert not (tmp_path / "league" / "league.json").exists()


def test_a_beginning_that_was_broken_off_leaves_no_models(
    tiny: LeagueSettings, tmp_path: Path, starters: dict[str, Path]
) -> None:
    shutil.copytree(starters["two"], tmp_path / "iteration_00" / "models" / "three")
    league = League.create(tmp_path, tiny, starters)

    assert [member.name for member in league.starters("red")] == ["one", "two"]


def test_a_colour_needs_a_model_to_begin_with(tiny: LeagueSettings, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no model to begin with for red"):
        League.create(tmp_path / "league", tiny, {})
    assert not (tmp_path / "league" / "league.json").exists()


def test_a_bot_that_does_not_exist_leaves_no_league(
    tiny: LeagueSettings, starters: dict[str, Path], tmp_path: Path
) -> None:
    with pytest.raises(UnknownNameError, match="unknown bot 'MA7'"):
        League.create(tmp_path / "league", replace(tiny, bots=("MA7",)), starters)
    assert not (tmp_path / "league").exists()


def test_a_model_wider_than_the_leagues_is_refused(
    tiny: LeagueSettings, starters: dict[str, Path], tmp_path: Path
) -> None:
    for narrow in (replace(tiny, hidden=8), replace(tiny, embed=8)):
        with pytest.raises(ConfigError, match=r"one is wider than the league's models: .*64.*32"):
            League.create(tmp_path / "league", narrow, starters)
    assert not (tmp_path / "league").exists()


def test_models_are_as_wide_as_the_league_says(whole: League) -> None:
    policy = whole.models(1)["red"][0].policy()

    assert policy.weights["context_set.weight"].shape == (whole.settings.hidden, whole.settings.embed)
    assert whole.models(0)["red"][0].policy().weights["context_set.weight"].shape == (64, 32)


def test_models_of_other_decision_ticks_cannot_meet(
    tiny: LeagueSettings, starters: dict[str, Path], tmp_path: Path
) -> None:
    policy = FrozenPolicy.load(starters["one"])
    policy.about["decision_ticks"] = "25"
    policy.save(tmp_path / "quick")
    with pytest.raises(ConfigError, match=r"quick was trained with .*25.*: they cannot meet"):
        League.create(tmp_path / "league", tiny, {**starters, "quick": tmp_path / "quick"})
    assert not (tmp_path / "league").exists()


def test_what_a_group_leaves_can_be_read_by_others(whole: League) -> None:
    mode = whole.folder.joinpath("iteration_01").stat().st_mode
    assert whole.specs(1)[0].folder.stat().st_mode == mode


def test_a_name_that_leads_elsewhere_is_refused(
    tiny: LeagueSettings, starters: dict[str, Path], tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=r"a model's name is of letters.*'\.\./one'"):
        League.create(tmp_path / "league", tiny, {"../one": starters["one"]})


BROKEN: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "other rules": (lambda head: head.update(rules="0.9 abc"), "rules: found 0.9 abc"),
    "no settings": (lambda head: head.pop("settings"), "format: "),
    "another format": (lambda head: head.update(format="pickle"), "format: found 'pickle'"),
    "no bots": (lambda head: head["settings"].update(bots=None), "bots: found None; expected a list"),
    "a setting less": (
        lambda head: head["settings"].pop("anchor"),
        "anchor: found nothing; expected a finite number",
    ),
    "a setting more": (
        lambda head: head["settings"].update(policy="os.system"),
        "policy: found an unknown setting",
    ),
    "a list for settings": (
        lambda head: head.update(settings=[1]),
        r"format: found 'hexwar league 1' with \[1\]",
    ),
}


@pytest.mark.parametrize("broken", BROKEN)
def test_a_foreign_league_is_refused(broken: str, whole: League, tmp_path: Path) -> None:
    head = json.loads((whole.folder / "league.json").read_text())
    change, message = BROKEN[broken]
    change(head)
    (tmp_path / "league.json").write_text(json.dumps(head))
    with pytest.raises(FileFormatError, match=f"league.json: {message}"):
        League.open(tmp_path)


@pytest.mark.parametrize(
    "names", [["../../../etc", "x"], [["2-r0b0"], 7], ["2-r0b0"], 7, ["2-r0b0", "9-r0b0"]]
)
def test_names_in_a_table_are_models_of_its_iteration(names: object, whole: League, tmp_path: Path) -> None:
    shutil.copytree(whole.folder, tmp_path / "league")
    league = League.open(tmp_path / "league")
    table = json.loads((league.iteration(2) / "table.json").read_text())
    table["kept"]["blue"] = names
    (league.iteration(2) / "table.json").write_text(json.dumps(table))
    with pytest.raises(FileFormatError, match=r"kept\.blue: found .*; expected 2 models of this iteration"):
        league.kept(2)


def test_a_broken_model_is_named(whole: League, tmp_path: Path) -> None:
    shutil.copytree(whole.folder, tmp_path / "league")
    league = League.open(tmp_path / "league")
    member = league.kept(1)["red"][0]
    (member.folder / "weights.safetensors").write_bytes(b"\x80\x04pickle")
    with pytest.raises(PolicyFileError, match="sha256: found other weights"):
        train_group(replace(league.specs(2)[0], folder=tmp_path / "again"))


def test_what_is_kept_of_a_league_goes_on_as_the_league(
    whole: League, starters: dict[str, Path], tmp_path: Path
) -> None:
    unfinished = tmp_path / "unfinished"
    shutil.copytree(whole.folder, unfinished)
    shutil.rmtree(unfinished / "iteration_02")
    League.open(unfinished).keep(tmp_path / "kept")
    League.open(unfinished).keep(tmp_path / "kept")  # over what is there
    kept = League.create(tmp_path / "kept", whole.settings, starters)
    kept.run()

    assert contents(kept.iteration(2)) == contents(whole.iteration(2))
    left = {path.relative_to(kept.folder) for path in (kept.iteration(1) / "groups").glob("*/*")}
    members = [one for members in whole.kept(1).values() for one in members]
    assert left == {member.folder.relative_to(whole.folder) for member in members}


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_league_whose_folder_is_removed_ends_and_makes_nothing(
    jobs: int, starters: dict[str, Path], tiny: LeagueSettings, tmp_path: Path
) -> None:
    league = League.create(tmp_path / "league", tiny, starters)
    with pytest.raises(FileNotFoundError, match="removed while it was in use"):
        league.run(jobs, after=lambda k: shutil.rmtree(league.folder) if k == 0 else None)

    assert not league.folder.exists()


def test_what_a_killed_league_was_making_goes_away_at_its_next_start(whole: League, tmp_path: Path) -> None:
    copy = League(Path(shutil.copytree(whole.folder, tmp_path / "copy")), whole.settings)
    lefts = [
        copy.iteration(1) / "groups" / ".new-x" / "red" / "config.json",
        copy.folder / ".new-league-x.json",
    ]
    for left in lefts:
        left.parent.mkdir(parents=True, exist_ok=True)
        left.touch()
    copy.run()

    assert not [*copy.folder.rglob(".new-*")]
    assert copy.kept(2) == {
        camp: [replace(one, folder=copy.folder / one.folder.relative_to(whole.folder)) for one in members]
        for camp, members in whole.kept(2).items()
    }
