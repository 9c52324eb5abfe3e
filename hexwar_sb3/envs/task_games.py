"""The core of the task env: n games, each seen and commanded by the learner's camp."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.bots.config import bots_hash, drawn_hash
from hexwar_sb3.bots.registry import BOTS
from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.fields import check_all
from hexwar_sb3.engine.roster import SIDES, camp_name, enemy_of, parse_camp
from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.envs.snapshots import check_games, check_opponents, check_origin, check_seats
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.kernels import Rows
from hexwar_sb3.play.arena import Arena, Games, Snapshot
from hexwar_sb3.play.encounters import Encounters
from hexwar_sb3.play.recorded import RecordedGame
from hexwar_sb3.play.records import EXTERNAL
from hexwar_sb3.play.seeds import chosen_seed, episode_draw, game_seed
from hexwar_sb3.play.shows import NOBODY, Demonstrations
from hexwar_sb3.play.sight import Sight
from hexwar_sb3.play.warm_start import WARM_TICKS, send_out
from hexwar_sb3.players.fit import check_actions, check_fit
from hexwar_sb3.players.frozen_lower import make_lower
from hexwar_sb3.players.player import (
    BotPlayer,
    Mixture,
    Seat,
    bot_player,
    has_played,
    make_mixture,
    member_of,
    same_player,
)
from hexwar_sb3.players.terms import CAMPS_OF
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CampIndex
from hexwar_sb3.tasks.features import BOUND, feature_index
from hexwar_sb3.tasks.records import MAX_TASKS

Obs = dict[str, NDArray[Any]]

_UNDER_WAY = feature_index("row", 1, 1, 1)["task: under way"].start  # column of a task row

_DEMO_STREAM, _WARM_STREAM = 2, 3  # of an episode's draws; 1 is the opponent's


@dataclass(frozen=True)
class Span:
    """What one decision led to, a row a game."""

    reward: NDArray[np.float32]  # gain of the margin, eq. (3), points [n]
    over: NDArray[np.bool_]  # [n]
    ticks: NDArray[np.int64]  # length [n]
    illegal: NDArray[np.int64]  # actions that named no valid task [n]
    demo: dict[int, NDArray[np.int64]]  # game -> task indices of who shows it [N]

    def infos(self) -> list[dict[str, Any]]:
        """What the info of each game says of it."""
        pairs = zip(self.ticks.tolist(), self.illegal.tolist(), strict=True)
        return [{"ticks": ticks, "illegal_actions": illegal} for ticks, illegal in pairs]


class TaskGames:
    """Batch of games for one learner; episode k of a seed is the same game in any slot.

    Observations lie in two sets of buffers that take turns: one stays as it is until the step after
    the next.
    """

    keeps_answers = False  # the learner gives directions beside its tasks

    def __init__(self, n_games: int, settings: TaskSettings, seed: int | None = None) -> None:
        check_whole("n_envs", n_games, least=1)
        self.settings, self.n_games = settings, n_games
        self.lower = make_lower(settings.lower)
        self.demo_share, self.warm_start = settings.demo_share, settings.warm_start
        self.arena = Arena(load_world(settings.scenario), n_games, settings)
        check_pieces(self.arena.world)
        camps = [parse_camp(side) for side in CAMPS_OF[settings.side]]
        self.demonstrations = Demonstrations(settings.demo, self.arena.world, camps, fog=settings.fog)
        self.mixture = fitting_mixture(settings.opponent, self.arena.world, self._rival_camps)
        self.encounters = Encounters(len(self.mixture.players), settings.priority)
        self.all = np.arange(n_games)
        self.camps = np.zeros(n_games, np.int64)  # the learner's [n]
        self.episodes = np.full(n_games, -1)  # number of the episode in each slot [n]
        self.opponents = np.zeros(n_games, np.int64)  # index in the mixture [n]
        self.rivals: list[Seat] = [self.mixture.players[0]] * n_games  # each game's own [n]
        self.demos = np.zeros(n_games, np.bool_)  # somebody shows the learner how to play its camp [n]
        self.shown = np.full(
            n_games, NOBODY
        )  # number of the demonstration, NOBODY where the learner plays [n]
        self._sights = self._new_sight(), self._new_sight()
        self.seed(seed)

    def seed(self, seed: int | None) -> None:
        """Count episodes from 0 again, under another seed; None draws one."""
        self.seed_slots([chosen_seed(seed)])

    def seed_slots(self, seeds: Sequence[int]) -> None:
        """Count episodes from 0 again: those of one seed for all slots, or of a seed a slot, as an env of one game has them."""
        self._seeds, self._next_episodes, self._turn = list(seeds), [0] * len(seeds), 0

    @property
    def first_seed(self) -> int:
        """The seed of the episodes, as it was given or drawn."""
        return self._seeds[0]

    def _next_episode(self, b: int) -> tuple[int, int]:
        """Seed and number of the episode that begins in a slot."""
        k = b % len(self._seeds)
        episode, self._next_episodes[k] = self._next_episodes[k], self._next_episodes[k] + 1
        return self._seeds[k], episode

    @property
    def sight(self) -> Sight:
        """The buffers that hold the present observation."""
        return self._sights[self._turn]

    def begin(self, which: Games) -> None:
        """Start the next episodes in these slots."""
        slots = which.tolist()
        episodes = [self._next_episode(b) for b in slots]
        urgency = self.encounters.urgency
        seeds = [self._draw(b, *episode, urgency) for b, episode in zip(slots, episodes, strict=True)]
        self.arena.restart(which, seeds)
        for b in slots:
            for camp, seat in enumerate(self._seats(b)):
                self.arena.sit(b, camp, seat)
            self._lead(b)
        self.arena.drives.asked[which, self.camps[which]] = 1
        if self.warm_start:
            for b, episode in zip(slots, episodes, strict=True):
                self._warm_up(b, episode_draw(*episode, _WARM_STREAM))

    def _draw(self, b: int, seed: int, episode: int, urgency: NDArray[np.float64]) -> int:
        """Draw who plays an episode in a slot; the seed of its dice."""
        self.episodes[b] = episode
        self.camps[b] = self.camp_of(episode)
        met = self.opponents[b] = self.mixture.draw(seed, episode, urgency)
        self.rivals[b] = self.encounters.seat(met, self.mixture.players[met], seed, episode)
        self.shown[b] = self._draw_show(Camp(self.camps[b]), seed, episode)
        self.demos[b] = self.shown[b] != NOBODY
        recorded = self._recorded(b)
        return game_seed(seed, episode) if recorded is None else recorded.seed

    def _draw_show(self, camp: Camp, seed: int, episode: int) -> int:
        """Draw whether somebody shows the learner how to play a game, and who."""
        if not self.demo_share:
            return NOBODY
        rng = episode_draw(seed, episode, _DEMO_STREAM)
        return self.demonstrations.draw(camp, rng) if rng.random() < self.demo_share else NOBODY

    def _recorded(self, b: int) -> RecordedGame | None:
        """The recorded game that is played again in a slot, if it is one."""
        return self.demonstrations.recorded(int(self.shown[b]))

    def _take_over(self, which: Games) -> None:
        """Let the learner go on, against the drawn opponent, where a recorded game was broken off before this decision."""
        for b, recorded in self._of_records(which).items():
            game = self.arena.state.games[b]
            if game.tick < recorded.end_tick or game.over:
                continue
            self.shown[b], self.demos[b] = NOBODY, False
            for camp, seat in enumerate(self._seats(b)):
                self.arena.sit(b, camp, seat)
            self._lead(b)

    def set_lower(self, lower: object) -> None:
        """Let another lower level lead the learner's pieces, from their next cell or decision on."""
        self.lower = make_lower(lower)
        for b in self.all:
            self._lead(int(b))

    def set_opponent(self, opponent: object) -> None:
        """Draw the opponents of the next episodes from another mixture; running games end as they began.

        A snapshot names opponents by their place in the mixture: to restore one, give those that play their places.

        Raises:
            ConfigError: one of them is for other pieces, tasks or features; those of before stay.
        """
        before, counted = self.mixture.players, self.encounters
        self.mixture = fitting_mixture(opponent, self.arena.world, self._rival_camps)
        self.encounters = Encounters(len(self.mixture.players), self.settings.priority)
        for k, player in enumerate(self.mixture.players):
            known = [n for n, other in enumerate(before) if same_player(player, other)]
            if known:
                self.encounters.take(k, counted, known[0])

    def _lead(self, b: int) -> None:
        """Say who answers for the learner's pieces on their way; who shows a game leads its own."""
        if not self.demos[b]:
            self.arena.set_lower(b, int(self.camps[b]), self.lower)

    def look(self, which: Games) -> Obs:
        """Fill the present buffers for these games; the observation of all of them."""
        self.arena.look(which, which, self.camps[which], self.sight)
        return self.sight.obs

    def turn(self) -> None:
        """Let the other set of buffers be the present one."""
        self._turn = 1 - self._turn

    def check_begun(self) -> None:
        """Check that every slot has a game.

        Raises:
            ConfigError: some have none.
        """
        if (self.episodes < 0).any():
            raise ConfigError("no game has begun: reset the env before the first step")

    def play(self, actions: object) -> Span:
        """Play one decision: give the tasks, advance to the learner's next decision or the end.

        The reward is the gain of the referee's margin, eq. (3), whoever sees why.

        Args:
            actions: task indices [n, N].

        Raises:
            ConfigError: they are no whole numbers, or of another shape; or no game has begun.
        """
        self.check_begun()
        picked = check_actions(actions, self.sight.rows.shape[:2])
        self._take_over(self.all)
        before, start = self.scores(), self.arena.state.games.tick.astype(np.int64)
        shown, learns = self.all[self.demos], self.all[~self.demos]
        illegal = np.zeros(self.n_games, np.int64)
        illegal[learns] = self.arena.choose(learns, learns, self.camps[learns], picked[learns], self.sight)
        demo = self._show(shown)
        self._advance(self.all)
        over = self.arena.over(self.all)
        if over.any():
            self._note(self.all[over & ~self.demos])
        return Span(
            reward=(self.scores() - before).astype(np.float32),
            over=over,
            ticks=self.arena.state.games.tick - start,
            illegal=illegal,
            demo=demo,
        )

    def _note(self, ended: Games) -> None:
        """Count games of the learner's that have ended against those whom they were played with."""
        for b, win in zip(ended, self.arena.wins(ended, self.camps[ended]), strict=True):
            opponent, rival = int(self.opponents[b]), self.rivals[b]
            known = self.mixture.players[opponent]
            if has_played(known, rival):  # else another mixture came meanwhile
                self.encounters.note(opponent, float(win), member_of(known, rival))

    def outcome(self, b: int) -> dict[str, Any]:
        """What the last info of an episode says."""
        camps = self.camps[[b, b]]
        camps[1] = 1 - camps[0]
        margin, other = self.arena.margins(np.array([b, b]), camps).tolist()
        return {
            "margin": float(margin),
            "win": (float(np.sign(margin - other)) + 1.0) / 2.0,
            "points_held": self.arena.points_held(b, CampIndex(camps[0])),
            "side": camp_name(int(camps[0])),
            "opponent": self._rival_name(b),
        }

    def _rival_name(self, b: int) -> str:
        recorded = self._recorded(b)
        return _label(self.rivals[b]) if recorded is None else recorded.names[1 - self.camps[b]]

    def positions(self) -> Iterator[tuple[Arena, int, int]]:
        """Of every game: the arena, its number there, and the learner's camp."""
        for b, camp in enumerate(self.camps.tolist()):
            yield self.arena, b, camp

    def current_tasks(self, obs: Obs) -> NDArray[np.int64]:
        """Row of each piece's task under way in the task sets of an observation; -1: it is not there [n, N]."""
        same = (obs["tasks"][..., _UNDER_WAY] > 0) & (obs["action_mask"] != 0)
        return np.where(same.any(axis=-1), same.argmax(axis=-1), -1)

    def scores(self) -> NDArray[np.int64]:
        """What the reward is the gain of, for the learner in every game, points [n]."""
        return self.arena.scores(self.all, self.camps, net=self.settings.reward == "net")

    def snapshot(self) -> Snapshot:
        """Everything that changes in play, as arrays without objects.

        Raises:
            ConfigError: every slot has a seed of its own.
        """
        if len(self._seeds) > 1:
            raise ConfigError("no snapshot is taken of games that have a seed each")
        slots = {name: array.copy() for name, array in self._slots().items()}
        counters = np.array([*self._seeds, *self._next_episodes], np.int64)
        others = {**self.encounters.snapshot(), **self.demonstrations.snapshot()}
        return {**self.arena.snapshot(), **slots, **others, "counters": counters, "origin": self.origin}

    def restore(self, snapshot: Snapshot, waiting: NDArray[np.bool_] | None = None) -> Obs:
        """Go on where `snapshot` was taken, in an env of the same settings; the observation there.

        Args:
            snapshot: to restore.
            waiting: as in `check`.

        Raises:
            ConfigError: it was taken on another scenario, under other rules, with other bots, other demonstrations or
                more opponents.
            CheckpointError: it is broken; the env is as it was.
        """
        _, _, drives = self.check(snapshot, waiting)
        for name, array in self._slots().items():
            array[...] = snapshot[name]
        self.shown = self._shown_in(snapshot).copy()
        (self._seeds, self._next_episodes) = ([number] for number in snapshot["counters"].tolist())
        self.encounters.restore(snapshot)
        self.demonstrations.restore(snapshot)
        for b in self.all:
            self.rivals[b] = self._rival(int(b), snapshot, drives)
            for camp, seat in enumerate(self._seats(int(b))):
                self.arena.sit(int(b), camp, seat)
            self._lead(int(b))
        self.arena.restore(snapshot)
        # As the lower levels here have it.
        self.arena.lead_outside(self.all, np.zeros((len(self.all), self.arena.world.n_pieces), np.bool_))
        return self.look(self.all)

    def check(self, snapshot: Snapshot, waiting: NDArray[np.bool_] | None = None) -> tuple[State, Rows, Rows]:
        """Check a snapshot, whatever wrote it, before anything is changed.

        Args:
            snapshot: to check.
            waiting: pieces that wait for an answer from outside, in each game; None: nobody [n, P].

        Returns:
            Copies of its state, missions and drives.

        Raises:
            ConfigError, CheckpointError: as `restore`.
        """
        check_origin(snapshot, self.origin)
        parts = [*self.encounters.snapshot(), *self.demonstrations.snapshot()]
        state, missions, drives = check_games(snapshot, self.arena, self._slots(), parts)
        self.demonstrations.check(snapshot)
        expected = np.zeros_like(drives.waiting)
        if waiting is not None:
            expected[:, : waiting.shape[1]] = waiting
        check_all("drives.waiting", drives.waiting == expected, drives.waiting, "none")
        self._check_slots(snapshot, state, drives)
        self.encounters.check(snapshot)
        return state, missions, drives

    def _check_slots(self, snapshot: Snapshot, state: State, drives: Rows) -> None:
        """Check who plays which camp against whom."""
        camps = snapshot["camps"]
        own = np.array([self.camp_of(int(episode)) for episode in snapshot["episodes"]])
        check_all("camps", camps == own, camps, "the camp of the episode")
        check_opponents(snapshot["opponents"], len(self.mixture.players))
        shown = self._shown_in(snapshot)
        check_all(
            "demos", snapshot["demos"] == (shown != NOBODY), snapshot["demos"], "1 where a game is shown"
        )
        self.demonstrations.check_shown(shown, camps, state.games.seed)
        bots = [self.demonstrations.bot(int(show), camp) for show, camp in zip(shown, camps, strict=True)]
        check_seats(snapshot, drives, np.array(bots), keeps_answers=self.keeps_answers)
        for b in self.all:
            self._rival(int(b), snapshot, drives)

    def _shown_in(self, snapshot: Snapshot) -> NDArray[np.int64]:
        """What a snapshot's games show [n]; where there is one bot, it is said by `demos`."""
        return np.where(snapshot["demos"], 0, NOBODY) if self.demonstrations.alone else snapshot["shown"]

    def _rival(self, b: int, snapshot: Snapshot, drives: Rows) -> Seat:
        """Who plays on against the learner: a bot that began a game ends it, whatever the mixture has now.

        Raises:
            ConfigError: a policy began it, and a bot has its place now.
        """
        opponent, camp = snapshot["opponents"][b], 1 - snapshot["camps"][b]
        player, seat = self.mixture.players[opponent], drives.seat[b, camp]
        if self.demonstrations.recorded(int(self._shown_in(snapshot)[b])) is not None:
            check_all("drives.seat", seat == EXTERNAL, seat, "nobody, as the orders are recorded")
            return player
        if seat != EXTERNAL:
            bot = next(name for name, spec in BOTS.items() if spec.id == seat)
            rival = bot_player(bot, int(snapshot["brains"]["drawn"]["member"][b, camp]))
            began = isinstance(player, BotPlayer) and has_played(player, rival)
            return replace(player, member=rival.member) if began else rival
        if isinstance(player, BotPlayer):
            raise ConfigError(
                f"these games were saved with a policy as opponent {opponent}, this env has {player.name}:"
                " set it first (SelfPlayCallback.seat does)"
            )
        return player

    @property
    def origin(self) -> NDArray[np.str_]:
        """Where the games come from: rules, scenario and bots by their hashes."""
        world = self.arena.world
        names = ("rules", world.ruleset.hash), ("scenario", world.scenario.hash), ("bots", bots_hash())
        return np.array([f"{name} {its}" for name, its in (*names, ("drawn", drawn_hash()))])

    def _slots(self) -> Snapshot:
        return {
            "camps": self.camps,
            "episodes": self.episodes,
            "opponents": self.opponents,
            "demos": self.demos,
            **({} if self.demonstrations.alone else {"shown": self.shown}),
        }

    @property
    def _rival_camps(self) -> list[Camp]:
        """Camps that opponents play."""
        return [enemy_of(parse_camp(side)) for side in CAMPS_OF[self.settings.side]]

    def camp_of(self, episode: int) -> Camp:
        """The learner's camp in an episode."""
        if self.settings.side == "both":
            return (Camp.RED, Camp.BLUE)[episode % 2]
        return parse_camp(self.settings.side)

    def _seats(self, b: int) -> tuple[Seat | None, Seat | None]:
        return self.demonstrations.seats(int(self.shown[b]), Camp(self.camps[b]), self.rivals[b])

    def _warm_up(self, b: int, rng: np.random.Generator) -> None:
        """In a share of the episodes, play the way to the hot spots before the first decision (III-C)."""
        if rng.random() >= self.warm_start or self.demos[b]:
            return
        arena, camp, step = self.arena, int(self.camps[b]), self.settings.decision_ticks
        game, pieces, missions = arena.state.games[b], arena.state.pieces[b], arena.missions[b]
        send_out(camp, game, pieces, missions, arena.world, self.settings.spots, rng)
        arena.drives[b].due[camp], arena.drives[b].fresh[camp] = 0, 1
        arena.drives[b].period[camp] = max(1, WARM_TICKS // step) * step
        self._advance(np.array([b]))
        arena.drives[b].period[camp] = step

    def _advance(self, which: Games) -> None:
        """Play on until the learner is due or the game is over, asking the opponents meanwhile."""
        while which.size:
            self.arena.ask(which)
            self._play_on(which)
            waiting = ~self.arena.due(which, self.camps[which]) & ~self.arena.over(which)
            which = which[waiting]

    def _play_on(self, which: Games) -> None:
        """Play each game to its next decision or its end: the recorded ones by their orders."""
        recorded = self._of_records(which)
        self.arena.advance(np.setdiff1d(which, list(recorded)) if recorded else which)
        for b, game in recorded.items():
            game.play(self.arena, b)

    def _of_records(self, which: Games) -> dict[int, RecordedGame]:
        """The recorded games among these slots."""
        if not self.demonstrations.games:
            return {}
        return {
            int(b): game for b in which[self.demos[which]] if (game := self._recorded(int(b))) is not None
        }

    def _show(self, shown: Games) -> dict[int, NDArray[np.int64]]:
        """Let the bot that shows a game think in this state, and name its missions by the task sets that were observed.

        Where no bot does, the pieces get tasks by what the record says they were about.
        """
        named: dict[int, NDArray[np.int64]] = {}
        if not shown.size:
            return named
        periods, camps = self.arena.drives.period, self.camps[shown]
        for b, camp in zip(shown.tolist(), camps.tolist(), strict=True):
            self._choose_recorded(b, Camp(camp))
        periods[shown, camps] = 1
        self._advance(shown)
        periods[shown, camps] = self.settings.decision_ticks
        for b, camp in zip(shown, camps, strict=True):
            named[int(b)] = self.arena.name_missions(int(b), CampIndex(camp), self.sight, int(b))
        return named

    def _choose_recorded(self, b: int, camp: Camp) -> None:
        """Give the pieces of a camp that is shown without a bot their tasks of this decision."""
        recorded = self._recorded(b)
        if recorded is not None and recorded.bots[camp] is None:
            period = self.settings.decision_ticks
            until = (int(self.arena.state.games.tick[b]) // period + 1) * period
            recorded.choose(self.arena, b, camp, until, self.sight, b)

    def _new_sight(self) -> Sight:
        with_state = self.settings.privileged_state
        return Sight(self.arena.world, self.n_games, dtype=self.settings.dtype, with_state=with_state)


def check_pieces(world: World) -> None:
    """Check that both camps have somebody to play with.

    Raises:
        ConfigError: one has no piece.
    """
    for camp in SIDES:
        if not world.piece_names(camp):
            raise ConfigError(
                f"scenario {world.scenario.name!r}: {camp_name(camp)} has no pieces, nothing to learn"
            )


def fitting_mixture(opponent: object, world: World, camps: Iterable[Camp]) -> Mixture:
    """Opponents that can play these camps, as `make_mixture` takes them.

    Raises:
        ConfigError: one is for other pieces, tasks or features; and as `make_mixture`.
    """
    mixture = make_mixture(opponent)
    for camp in camps:
        for seat, name in zip(mixture.players, mixture.names, strict=True):
            check_fit(seat, world, camp, name)
    return mixture


def _label(seat: Seat) -> str:
    return seat.name if isinstance(seat, BotPlayer) else type(seat).__name__


def observation_space(sight: Sight) -> spaces.Dict:
    """Space of one game's observation; a slot of the buffers is an element of it."""
    return spaces.Dict({key: box_of(key, value[0]) for key, value in sight.obs.items()})


def box_of(key: str, sample: NDArray[Any]) -> spaces.Box:
    """Space of one part of an observation."""
    low, high = (0, 1) if key in ("action_mask", "alive") else (-BOUND, BOUND)
    return spaces.Box(low, high, sample.shape, sample.dtype.type)


def action_space(sight: Sight) -> spaces.MultiDiscrete:
    """A task index for every piece."""
    n_own = sight.rows.shape[1]
    return spaces.MultiDiscrete([MAX_TASKS] * n_own)
