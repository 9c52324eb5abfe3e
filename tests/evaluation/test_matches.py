from __future__ import annotations

import numpy as np
import pytest

from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.evaluation.matches import Evaluation, play_match, player_name
from hexwar_sb3.evaluation.panel import play_panel
from hexwar_sb3.evaluation.results import CampResult
from hexwar_sb3.evaluation.seeds import Purpose


def test_the_same_seed_gives_the_same_games_and_another_seed_others() -> None:
    first, again, other = (play_match("MA1", "nearest", games=3, seed=seed) for seed in (0, 0, 1))

    assert first.red.margins.tolist() == again.red.margins.tolist()
    assert first.red.margins.tolist() != other.red.margins.tolist()


def test_the_first_games_of_a_longer_match_are_those_of_a_shorter_one() -> None:
    short, long = (play_match("MA1", "nearest", games=games) for games in (2, 5))

    assert long.red.margins[:2].tolist() == short.red.margins.tolist()


def test_games_that_select_are_never_the_reported_games() -> None:
    selected, reported = (
        Evaluation(games=3, purpose=p).play("MA1", "nearest") for p in (Purpose.SELECTION, Purpose.REPORT)
    )

    assert selected.red.margins.tolist() != reported.red.margins.tolist()


def test_what_red_wins_blue_loses() -> None:
    match = play_match("MA1", "nearest", games=5)

    assert (match.red.wins, match.red.draws, match.red.losses) == (
        match.blue.losses,
        match.blue.draws,
        match.blue.wins,
    )
    assert np.all(match.red.points_held + match.blue.points_held <= 2)


@pytest.mark.parametrize("games", [0, -3])
def test_a_match_without_games_is_refused(games: int) -> None:
    with pytest.raises(ConfigError, match=f"games must be at least 1, got {games}"):
        play_match("MA1", "MA2", games=games)


def test_an_unknown_player_is_met_with_the_nearest_name() -> None:
    with pytest.raises(UnknownNameError, match="unknown player 'narest'; did you mean 'nearest'"):
        play_match("MA1", "narest", games=1)


def test_a_folder_is_called_by_its_name() -> None:
    assert player_name("runs/commander_1") == "commander_1"
    assert player_name("policies/CAI/both") == "CAI/both"  # a camp's name alone would say nothing
    assert player_name("both") == "both"


def test_a_panel_has_a_cell_for_each_opponent_and_camp() -> None:
    panel = play_panel("nearest", ["MA1", "random"], Evaluation(games=2), name="nearest")

    assert list(panel.cells) == [
        (opponent, camp) for opponent in ("MA1", "random") for camp in ("red", "blue")
    ]
    assert panel.total.games == 8
    assert panel.against("random").games == 4


@pytest.mark.parametrize("threads", [1, 2])
def test_what_has_not_begun_when_the_user_stops_is_never_played(threads: int) -> None:
    begun = []

    class Counted(Evaluation):
        def play_as(self, camp: str, player: object, opponent: object) -> CampResult:
            begun.append(camp)
            return super().play_as(camp, player, opponent)

    def stop(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        play_panel("nearest", ["MA1"] * 20, Counted(games=8), name="nearest", threads=threads, progress=stop)

    assert threads <= len(begun) < 20


def test_two_threads_play_the_games_of_one() -> None:
    one, two = (
        play_panel("nearest", ["MA1", "drawn"], Evaluation(games=8), name="nearest", threads=threads)
        for threads in (1, 2)
    )

    assert one.summary() == two.summary()
    assert list(one.cells) == list(two.cells)
