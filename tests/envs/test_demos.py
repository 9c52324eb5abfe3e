"""Recorded games in the learner's seat: the very games that they were, at any break, in the words of its task sets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stable_baselines3.common.callbacks import BaseCallback

from hexwar_sb3.algorithms.checkpoint import load_checkpoint, save_checkpoint
from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import CheckpointError, ConfigError, HexWarError, ReplayFileError
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.play.seeds import episode_draw
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.tasks.records import MAX_TASKS

TASK, FLAT = "HexWarTask-v0", "HexWarFlat-v0"
SEED, SHARE, EPISODES = 5, 0.6, 12
SHORT = replace(load_scenario("plain"), name="short", game_ticks=600)
GAMES: dict[str, Any] = {
    "scenario": SHORT,
    "side": "both",
    "opponent": "nearest",
    "seed": SEED,
    "demo_share": SHARE,
}
AsPerson = Callable[..., Replay]


def demonstrations() -> list[tuple[int, str]]:
    """Episode and camp of the games in which somebody shows an env of these settings how to play."""
    shown = [e for e in range(EPISODES) if episode_draw(SEED, e, 2).random() < SHARE]
    return [(e, ("red", "blue")[e % 2]) for e in shown]


@pytest.fixture(scope="module")
def recorded(as_person: AsPerson, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The very games that MA2 plays as demonstrations, as if people had played for MA2."""
    folder = tmp_path_factory.mktemp("games")
    for episode, camp in demonstrations():
        seats = ("MA2", "nearest") if camp == "red" else ("nearest", "MA2")
        as_person(record_game(*seats, Terms(scenario=SHORT), SEED, episode=episode), camp).save(
            folder / f"{episode:03}.hwr"
        )
    return folder


@pytest.fixture(scope="module")
def few(recorded: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One of these games for each camp."""
    folder = tmp_path_factory.mktemp("few")
    files = {int(path.stem) % 2: path for path in recorded.iterdir()}
    for path in files.values():
        (folder / path.name).write_bytes(path.read_bytes())
    return folder


@pytest.fixture(scope="module")
def by_orders(recorded: Path, as_person: AsPerson, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same games, of which the orders alone are known."""
    folder = tmp_path_factory.mktemp("by_orders")
    for path in recorded.iterdir():
        replay = Replay.load(path)
        people = [camp for camp, one in replay.head["players"].items() if one["kind"] == "human"]
        as_person(replay, *people, named=False).save(folder / path.name)
    return folder


def native(name: str, **settings: Any) -> Any:
    return make_vec_env(name, **{"n_envs": 2, **GAMES, **settings}).unwrapped


def picked(env: Any, rng: np.random.Generator) -> Any:
    """A random legal action of every game."""
    masks = env.action_masks()
    if env.games.keeps_answers:
        return (rng.random(masks.shape) * masks).argmax(axis=-1)
    masks = masks.reshape(env.num_envs, -1, MAX_TASKS)
    return (rng.random(masks.shape) * masks).argmax(axis=-1)


def same(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return bool(np.array_equal(one, other))


@pytest.mark.parametrize(
    ("name", "settings", "steps"),
    [
        (TASK, {"privileged_state": True}, 36),
        (TASK, {"decisions": "event", "decision_ticks": 100, "n_envs": 3}, 15),
        (FLAT, {"decision_ticks": 150}, 120),
    ],
)
def test_recorded_games_of_a_bot_are_its_demonstrations_to_the_bit(
    recorded: Path, name: str, settings: dict[str, Any], steps: int
) -> None:
    """Observations, rewards, ends and all infos, the tasks that were played among them."""
    live, again = native(name, demo="MA2", **settings), native(name, demo=recorded, **settings)
    rng, shown = np.random.default_rng(0), 0

    assert same(live.reset(), again.reset())
    for _ in range(steps):
        actions = picked(live, rng)
        for mine, its in zip(live.step(actions), again.step(actions), strict=True):
            assert all(map(same, mine, its)) if isinstance(mine, list) else same(mine, its)
        shown += int(live.games.demos.sum())
    assert shown > steps / 4
    assert again.games.demonstrations.turns.sum() > 2


def test_by_their_orders_alone_they_are_the_same_games_and_every_task_is_a_valid_one(by_orders: Path) -> None:
    """What the learner's own tasks were is another matter: of that a person's game says nothing."""
    live = native(TASK, demo="MA2", privileged_state=True)
    again = native(TASK, demo=by_orders, privileged_state=True)
    obs, seen, rng = live.reset(), again.reset(), np.random.default_rng(0)
    named = np.zeros(2, np.int64)

    for _ in range(36):
        actions, mask = picked(live, rng), seen["action_mask"].copy()
        obs, *mine, infos = live.step(actions)
        seen, *its, told = again.step(actions)
        assert all(map(same, mine, its))
        for key in ("state", "alive", "action_mask"):
            assert same(obs[key], seen[key])
        for b in np.flatnonzero(["demo_actions" in info for info in told]):
            tasks = told[b]["demo_actions"]
            assert np.take_along_axis(mask[b], tasks[:, None], axis=1).all()
            open_to = mask[b].sum(axis=1) > 1
            named += [(tasks == infos[b]["demo_actions"])[open_to].sum(), open_to.sum()]
    assert 0.4 < named[0] / named[1] < 1.0


def test_every_snapshot_goes_on_to_the_bit(recorded: Path, by_orders: Path) -> None:
    """With recorded games of both kinds and a bot beside them."""
    two = sorted(by_orders.iterdir())[:2]
    settings: dict[str, Any] = {"demo": [recorded, *two, "MA1"], "demo_share": 0.9}
    settings |= {"decision_ticks": 200}
    env, other, rng = native(TASK, **settings), native(TASK, **settings), np.random.default_rng(0)
    shown = set[int]()

    obs = env.reset()
    for _ in range(12):
        assert same(obs, other.restore(env.snapshot()))
        actions = picked(env, rng)
        obs, *mine = env.step(actions)
        restored, *its = other.step(actions)
        assert same(obs, restored)
        assert all(map(same, mine[:2], its[:2]))
        shown |= set(env.games.shown.tolist())
    assert len(shown) > 3


def test_a_snapshot_goes_on_with_the_same_files_alone(few: Path, by_orders: Path, tmp_path: Path) -> None:
    env = native(TASK, demo=few)
    env.reset()
    snapshot = env.snapshot()
    for path in few.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())

    native(TASK, demo=tmp_path).restore(snapshot)  # the same, elsewhere
    with pytest.raises(ConfigError, match=r"were saved without the demonstration .*\.hwr \([0-9a-f]{16}\)"):
        native(TASK, demo=next(by_orders.iterdir())).restore(snapshot)
    next(tmp_path.iterdir()).unlink()
    with pytest.raises(
        ConfigError, match=r"saved with \d+ demonstrations, this env has \d+: name the same bots"
    ):
        native(TASK, demo=tmp_path).restore(snapshot)
    with pytest.raises(CheckpointError, match="an unknown 'shown'"):
        native(TASK, demo="MA2").restore(snapshot)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("shown", 99, "shown"),
        ("shown", -2, "shown"),
        ("shown", 1, "a recorded game with these dice"),
        ("demo_turns", -1, "demo_turns"),
        ("demo_games", 0, "demo_games: found something else; expected hashes of recorded games"),
    ],
)
def test_a_broken_snapshot_is_refused(few: Path, name: str, value: int, message: str) -> None:
    env = native(TASK, demo=few, demo_share=1.0)
    env.reset()
    snapshot = env.snapshot()
    snapshot[name] = np.full_like(snapshot[name], value) if name != "demo_games" else np.array(value)

    with pytest.raises(CheckpointError, match=message):
        env.restore(snapshot)


def test_files_take_turns_and_each_is_for_its_camp(recorded: Path) -> None:
    """The first game of blue after all of blue's were shown is the first one again."""
    env = native(TASK, demo=recorded, demo_share=1.0, n_envs=1, side="blue", decision_ticks=300)
    env.reset()
    games, seen = env.games, list[str]()
    for _ in range(2 * 8):
        if games.arena.state.games.tick[0] == 0:
            game = games.demonstrations.recorded(int(games.shown[0]))
            seen.append(game.source.name)
        env.step(np.zeros((1, 7), np.int64))

    own = [f"{episode:03}.hwr" for episode, camp in demonstrations() if camp == "blue"]
    assert seen == (own * 8)[: len(seen)]
    assert len(seen) == 8


def test_an_entry_is_drawn_by_its_weight(few: Path) -> None:
    games = native(TASK, demo=[few, ("MA1", 3), ("MA2", 0)], demo_share=1.0).games
    drawn = [games.demonstrations.draw(games.camp_of(e), episode_draw(0, e, 2)) for e in range(400)]
    shows = [games.demonstrations.shows[k] for k in drawn]

    bots = [one.name for one in shows if hasattr(one, "bot")]
    assert set(bots) == {"MA1"}
    assert 270 <= len(bots) <= 330  # 300 are expected


def test_where_nobody_shows_a_camp_the_learner_plays_itself(by_orders: Path) -> None:
    one = next(path for path in sorted(by_orders.iterdir()) if (int(path.stem) % 2) == 0)  # red's
    games = native(TASK, demo=one, demo_share=1.0, n_envs=4).games
    games.begin(games.all)

    assert games.demos.tolist() == [True, False, True, False]
    with pytest.raises(ConfigError, match="demo: nobody shows how to play blue: "):
        native(TASK, demo=one, side="blue")


@pytest.mark.parametrize("demo", ["", "MA3", "HRL0", 3, ["MA1", ["MA2"]], [("MA1", -1)], [], [("MA1", 0)]])
def test_what_can_show_nothing_is_refused(demo: object) -> None:
    with pytest.raises(HexWarError):
        native(TASK, demo=demo)


def test_a_damaged_file_is_refused_before_any_game(few: Path, tmp_path: Path) -> None:
    for path in few.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    last = max(tmp_path.iterdir())
    last.write_bytes(last.read_bytes()[:-9])

    with pytest.raises(ReplayFileError, match=rf"{last.name}: byte \d+"):
        native(TASK, demo=tmp_path)


def test_recorded_games_are_of_the_fog(few: Path) -> None:
    with pytest.raises(ConfigError, match="recorded games were played under fog"):
        native(TASK, demo=few, fog=False)


@pytest.mark.parametrize("name", [TASK, FLAT])
@pytest.mark.parametrize("end", [75, 200])
def test_where_a_game_was_broken_off_the_learner_plays_on(tmp_path: Path, name: str, end: int) -> None:
    """From the first decision after it, against the opponent that it was drawn."""
    game = Game(SHORT, seed=3)
    game.submit("red", "tank0 move E E E E E E")
    game.advance(end)
    Replay.of(game, PlayerName(name="Ann"), PlayerName(name="MA1", kind="bot")).save(tmp_path / "a.hwr")
    settings: dict[str, Any] = {"demo": tmp_path / "a.hwr", "demo_share": 1.0, "side": "red", "n_envs": 1}
    env, other = native(name, **settings), native(name, **settings)
    obs, rng, done, shown = env.reset(), np.random.default_rng(0), False, list[int]()
    while not done:
        if name == TASK:
            assert same(obs, other.restore(env.snapshot()))
        tick = int(env.games.arena.state.games.tick[0])
        actions = picked(env, rng)
        obs, *_, dones, infos = env.step(actions)
        if "demo_actions" in infos[0]:
            shown.append(tick)
        done = bool(dones[0])

    assert max(shown) - 75 * ((end - 1) // 75) in (0, 1)  # the flat env shows the tick after the decision
    assert infos[0]["opponent"] == "nearest"
    assert infos[0]["illegal_actions"] == 0


def new_env(demo: object) -> Any:
    return make_vec_env(TASK, n_envs=2, demo=demo, privileged_state=True, **GAMES)


def new_model(demo: object) -> HierarchicalQMIX:
    small: dict[str, Any] = {"hidden": 16, "embed": 8}
    how: dict[str, Any] = {"learning_starts": 24, "batch_size": 16, "policy_kwargs": small}
    how |= {"buffer_size": 1_000, "seed": SEED, "phase_ticks": (10**9, 0)}
    return HierarchicalQMIX("HierarchicalPolicy", new_env(demo), **how)


def same_weights(one: HierarchicalQMIX, other: HierarchicalQMIX) -> bool:
    mine, its = one.policy.state_dict(), other.policy.state_dict()
    return all(np.array_equal(mine[name].numpy(), its[name].numpy()) for name in mine)


def test_who_learns_from_files_has_the_weights_of_who_watched_the_bot(recorded: Path) -> None:
    """The very games that the bot would play, from their files: the same training, to the last bit."""
    live, again = new_model("MA2").learn(80), new_model(recorded).learn(80)

    assert live.num_timesteps == again.num_timesteps
    assert same_weights(live, again)
    assert not same_weights(live, new_model("MA1").learn(80))


class SaveAt(BaseCallback):
    """Saves at a vector-step boundary, as a run's own callback does."""

    def __init__(self, step: int, path: Path) -> None:
        super().__init__()
        self.step, self.path = step, path

    def _on_rollout_start(self) -> None:
        if self.model.num_timesteps == self.step:
            save_checkpoint(self.model, self.path)  # type: ignore[arg-type]

    def _on_step(self) -> bool:
        return True


def test_a_training_from_files_goes_on_to_the_bit_and_from_no_others(
    by_orders: Path, few: Path, tmp_path: Path
) -> None:
    path = tmp_path / "checkpoint"
    unbroken = new_model([by_orders, "MA1"]).learn(80, callback=SaveAt(38, path))

    resumed = load_checkpoint(path, new_env([by_orders, "MA1"]), HierarchicalQMIX)
    assert resumed.num_timesteps == 38
    resumed.learn(80 - 38, reset_num_timesteps=False)

    assert same_weights(unbroken, resumed)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="these games were saved without the demonstration"):
        load_checkpoint(path, new_env([few, "MA1"]), HierarchicalQMIX)
