"""Games that are written down while a model learns."""

from __future__ import annotations

from pathlib import Path

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.record import RecordGame, write_album
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.players.terms import Terms

SHORT = 300  # Delta-t: a game in six decisions


def test_a_game_of_each_camp_is_written_with_its_picture(tmp_path: Path) -> None:
    env = make_vec_env(decision_ticks=SHORT, privileged_state=True, seed=0)
    model = QMIX("TaskPolicy", env, buffer_size=100, seed=0)

    model.learn(
        12,
        callback=RecordGame(
            6, "random", Evaluation(terms=Terms(decision_ticks=SHORT), games=1), folder=tmp_path
        ),
    )

    names = [f"{camp}_{step:09d}" for camp in ("blue", "red") for step in (6, 12)]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        f"{name}{suffix}" for name in names for suffix in (".hwr", ".png")
    )
    for name in names:
        replay = Replay.load(tmp_path / f"{name}.hwr")
        replay.verify()
        players = {camp: player["name"] for camp, player in replay.head["players"].items()}
        assert players["blue" if name.startswith("red") else "red"] == "random"


def test_an_album_spans_a_training_in_twelve_games_of_one_seed(tmp_path: Path) -> None:
    policy = QMIX("TaskPolicy", make_vec_env(seed=0), buffer_size=10).policy.freeze()
    for step in range(0, 2300, 100):
        policy.save(tmp_path / "snapshots" / f"{step:09d}")
    how = Evaluation(terms=Terms(decision_ticks=SHORT), games=1)

    paths = write_album(tmp_path / "snapshots", "random", how, tmp_path)

    steps = range(0, 2300, 200)
    assert [path.name for path in paths] == [f"red_{step:09d}_against_random.hwr" for step in steps]
    assert len({Replay.load(path).seed for path in paths}) == 1
