"""Grouped self-play (III-C, Fig. 6): the folder is the state, a league that was killed ends as an unbroken one."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import mean
from typing import Any, cast

import numpy as np
import pytest
from safetensors.numpy import load_file

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import CheckpointError, ConfigError, FileFormatError, PolicyFileError, UnknownNameError
from hexwar_sb3.league import group
from hexwar_sb3.league.group import train_group, with_partners
from hexwar_sb3.league.league import League
from hexwar_sb3.league.member import as_member
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.league.work import begin
from hexwar_sb3.players.frozen import FrozenPolicy

BOTS = ("MA1", "drawn")  # of the tests' leagues


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


def test_every_red_model_trains_with_every_blue_one(split: League) -> None:
    specs = split.specs(2)

    pairs = [(spec.members["red"].name, spec.members["blue"].name) for spec in specs]
    kept = split.kept(1)
    assert pairs == [(red.name, blue.name) for red in kept["red"] for blue in kept["blue"]]


def test_a_model_for_both_camps_trains_with_all_that_were_kept(whole: League) -> None:
    kept = whole.kept(1)["red"]

    assert [spec.members["red"] for spec in whole.specs(2)] == kept
    assert all(spec.partners == tuple(kept) for spec in whole.specs(2))


def test_what_it_comes_from_may_be_kept_again(whole: League) -> None:
    names = [member.name for member in whole.models(2)["red"]]

    assert names[:2] == ["2-m0", "2-m1"]
    assert names[2:] == list(dict.fromkeys(member.name for member in whole.kept(1)["red"]))


def test_models_meet_their_partner_the_past_and_the_opponents(whole: League) -> None:
    spec = whole.specs(2)[0]

    assert [str(player) for player, _ in spec.others["red"]] == [
        *dict.fromkeys(str(whole.kept(k)["blue"][0].folder) for k in (0, 1)),
        "MA1",
        "drawn",
    ]
    past = [weight for _, weight in spec.others["red"][:-2]]
    assert sum(past) == pytest.approx(0.05)
    assert [weight for _, weight in spec.others["red"][-2:]] == pytest.approx([0.9 / 3, 1.8 / 3])
    met = with_partners(spec.partners, 0.05, spec.others["red"])
    hashes = [cast("FrozenPolicy", player).sha256 for player, _ in met[:2]]
    assert hashes == [member.policy().sha256 for member in whole.kept(1)["red"]]
    assert [weight for _, weight in met] == pytest.approx([0.025] * 2 + [w for _, w in spec.others["red"]])
    assert spec.env["priority"] == 1.0


def test_partners_may_be_all_that_is_met(whole: League) -> None:
    assert [weight for _, weight in with_partners(whole.kept(1)["red"], 0.2, [])] == [0.5, 0.5]


def test_one_model_plays_both_camps_where_it_is_not_split(whole: League) -> None:
    for k in (1, 2):
        assert whole.kept(k)["red"] == [replace(one, camp="red") for one in whole.kept(k)["blue"]]
        assert {one.policy().about["side"] for one in whole.models(k)["red"]} == {"both"}


def test_each_camp_has_its_own_where_it_is_split(split: League) -> None:
    for camp in ("red", "blue"):
        assert {one.policy().about["side"] for one in split.models(2)[camp]} == {camp}
    reds, blues = (distinct(split, 2, camp) for camp in ("red", "blue"))
    assert len(reds | blues) == 8


def test_blue_learns_against_red_as_it_is_now(split: League, tmp_path: Path) -> None:
    """A red model of another seed is another one, and then so is the blue one that met it."""
    spec = split.specs(1)[0]
    train_group(replace(spec, folder=tmp_path / "as it was"))
    others = {**spec.others, "red": [("MA2", 1.0)]}
    train_group(replace(spec, partner_share=0.9, others=others, folder=tmp_path / "other"))

    folders = (spec.folder, tmp_path / "as it was", tmp_path / "other")
    hashes = {
        camp: [FrozenPolicy.load(folder / camp).sha256 for folder in folders] for camp in ("red", "blue")
    }
    for first, again, other in hashes.values():
        assert first == again != other


def test_a_model_goes_on_with_its_mixer_and_its_targets(whole: League) -> None:
    spec = whole.specs(2)[1]
    member = spec.members["red"]
    model = begin(member, {**spec.env, "side": "both", "opponent": "MA1"}, spec.learner, 7)

    kept, taken = load_file(member.networks), model.policy.state_dict()
    assert kept.keys() == taken.keys()
    assert all(np.array_equal(kept[name], taken[name].numpy()) for name in kept)
    assert any(name.startswith("mixer_target") for name in kept)


@pytest.mark.parametrize(("hidden", "goes_on"), [(64, True), (128, False)])
def test_the_best_model_of_a_run_brings_its_mixer_where_it_fits(
    hidden: int, goes_on: bool, tiny: LeagueSettings, tmp_path: Path
) -> None:
    env = make_vec_env(n_envs=1, privileged_state=True, seed=0)
    model = QMIX("TaskPolicy", env, seed=3, buffer_size=10, policy_kwargs={"mirrored": True})
    model.save(tmp_path / "run" / "best_model.zip")
    as_member(model, side="both", scenario="plain").save(tmp_path / "run" / "policy")
    starters = {"run": tmp_path / "run" / "policy"}
    league = League.create(tmp_path / "league", replace(tiny, hidden=hidden), starters)

    (member,) = league.starters("red")
    assert member.networks.is_file() == goes_on
    if goes_on:
        spec = {**league.env(), "side": "both", "opponent": "MA1"}
        taken = begin(member, spec, league.learner(4), 7).policy.state_dict()
        assert all(np.array_equal(taken[name], one) for name, one in model.policy.state_dict().items())
    assert League.create(tmp_path / "league", replace(tiny, hidden=hidden), starters).folder == league.folder


def test_models_of_another_width_do_not_go_on(whole: League) -> None:
    spec = whole.specs(2)[1]
    wide = {**spec.learner, "policy_kwargs": {**spec.learner["policy_kwargs"], "hidden": 128}}
    with pytest.raises(
        CheckpointError, match=r"networks: agent\..*: found float32 .*64.*; expected float32 .*128"
    ):
        begin(spec.members["red"], {**spec.env, "side": "both", "opponent": "MA1"}, wide, 7)


def test_what_is_left_is_the_mean_of_the_last_updates(whole: League) -> None:
    member = whole.models(1)["red"][0]
    networks = load_file(member.networks)

    for name, array in member.policy().weights.items():
        np.testing.assert_array_equal(array, networks[f"agent_mean.{name}"])
    assert not np.array_equal(networks["agent_mean.value.weight"], networks["agent.value.weight"])


def test_schedules_are_of_a_groups_games(whole: League) -> None:
    found = whole.learner(1000)

    assert (found["exploration_episodes"], found["squad_episodes"]) == (400, 700)
    assert found["policy_kwargs"] == {"hidden": 64, "embed": 32, "mirrored": True}


@pytest.mark.parametrize("which", ["whole", "split"])
def test_the_best_score_is_kept(which: str, request: pytest.FixtureRequest) -> None:
    """Half of it the win rate over the enemy's models, half how little it is behind the best against a bot."""
    league: League = request.getfixturevalue(which)
    found = json.loads((league.iteration(2) / "table.json").read_text())
    rates: dict[str, dict[str, float]] = {}
    for pair, rate in found["red_win_rates"].items():
        red, blue = pair.split()
        if red not in BOTS:
            rates.setdefault(red, {})[blue] = rate
    best = {bot: max(own[bot] for own in rates.values()) for bot in BOTS}
    means = {
        name: (
            mean([rate for blue, rate in own.items() if blue not in BOTS]),
            max(best[bot] - own[bot] for bot in BOTS),
        )
        for name, own in rates.items()
    }
    own = {camp: {row["name"]: row["score"] for row in found["standings"][camp]} for camp in ("red", "blue")}

    assert len(found["red_win_rates"]) == 4 * 4 + (4 + 4) * len(BOTS)
    assert own["red"] == pytest.approx(
        {name: (rate + 1 - behind) / 2 for name, (rate, behind) in means.items()}
    )
    for camp in ("red", "blue"):
        both = {name: own["red"][name] + own["blue"][name] for name in own["red"]}
        scores = own[camp] if league.settings.split else both
        worst = min(scores[name] for name in found["kept"][camp])
        assert all(score <= worst for name, score in scores.items() if name not in found["kept"][camp])
    for row in found["standings"]["blue"]:
        low, high = row["win_rate_interval"]
        assert 0.0 <= low <= row["win_rate"] <= high <= 1.0


def test_opponents_play_in_the_round_robin_but_are_not_kept(whole: League) -> None:
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


@pytest.mark.parametrize("which", ["whole", "split"])
def test_a_model_knows_its_parent(which: str, request: pytest.FixtureRequest) -> None:
    league: League = request.getfixturevalue(which)
    found = json.loads((league.iteration(2) / "table.json").read_text())
    specs = {spec.folder.name: spec for spec in league.specs(2)}
    assert list(specs) == (["2-r0b0", "2-r0b1", "2-r1b0", "2-r1b1"] if which == "split" else ["2-m0", "2-m1"])
    for camp in ("red", "blue"):
        parents = {row["name"]: row["parent"] for row in found["standings"][camp]}
        assert specs.keys() <= parents.keys()
        for name, parent in parents.items():  # a model that stays is its own
            assert parent == (specs[name].members[camp].name if name in specs else name)


def test_a_group_is_a_function_of_its_spec(whole: League, tmp_path: Path) -> None:
    spec = whole.specs(1)[1]
    train_group(replace(spec, folder=tmp_path / "again"))

    assert contents(tmp_path / "again") == contents(spec.folder)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["again"]


BREAKS: dict[str, Callable[[League], object]] = {
    "a group": lambda league: shutil.rmtree(league.group(1, "1-m1")),
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
    with pytest.raises(UnknownNameError, match="unknown opponent 'MA7'"):
        League.create(tmp_path / "league", replace(tiny, opponents=("MA7",)), starters)
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
    "no bots": (
        lambda head: head["settings"].update(opponents=None),
        "opponents: found None; expected a list",
    ),
    "a setting less": (
        lambda head: head["settings"].pop("priority"),
        "priority: found nothing; expected a finite number",
    ),
    "an older league": (
        lambda head: head.update(format="hexwar league 1"),
        "format: found 'hexwar league 1'",
    ),
    "a setting more": (
        lambda head: head["settings"].update(policy="os.system"),
        "policy: found an unknown setting",
    ),
    "a list for settings": (
        lambda head: head.update(settings=[1]),
        r"format: found 'hexwar league 4' with \[1\]",
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


@pytest.mark.parametrize("names", [["../../../etc", "x"], [["2-m0"], 7], ["2-m0"], 7, ["2-m0", "9-m0"]])
def test_names_in_a_table_are_models_of_its_iteration(names: object, whole: League, tmp_path: Path) -> None:
    shutil.copytree(whole.folder, tmp_path / "league")
    league = League.open(tmp_path / "league")
    table = json.loads((league.iteration(2) / "table.json").read_text())
    table["kept"]["blue"] = names
    (league.iteration(2) / "table.json").write_text(json.dumps(table))
    with pytest.raises(FileFormatError, match=r"kept\.blue: found .*; expected 2 models of this iteration"):
        league.kept(2)


@pytest.mark.parametrize("content", [b"", b"\x80\x04pickle", b"\x02\0\0\0\0\0\0\0{}"])
def test_broken_networks_are_named(content: bytes, whole: League, tmp_path: Path) -> None:
    spec = whole.specs(2)[0]
    folder = Path(shutil.copytree(spec.members["red"].folder, tmp_path / "member"))
    (folder / "networks.safetensors").write_bytes(content)
    members = {**spec.members, "red": replace(spec.members["red"], folder=folder)}
    with pytest.raises(CheckpointError, match=r"networks\.safetensors: sha256: found other networks"):
        train_group(replace(spec, members=members, folder=tmp_path / "again"))
    assert not (tmp_path / "again").exists()


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
