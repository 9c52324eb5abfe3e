"""The core of the route env: in each game one piece, the focal one, is led hop by hop from outside.

An episode is one route: from the first question about a task of the focal piece to its staying in the right
place. Then the next piece of the same game takes its turn, so that all types of pieces serve one network.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.fields import check_all, check_form, check_names, check_range
from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE
from hexwar_sb3.engine.roster import parse_camp
from hexwar_sb3.envs.route_draws import Draws
from hexwar_sb3.envs.route_settings import RANDOM_UPPER, RouteSettings
from hexwar_sb3.envs.task_games import TaskGames
from hexwar_sb3.envs.turns import NO_FOCUS, send_away, take_turns
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.kernels import Rows
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.play.arena import Games, Snapshot
from hexwar_sb3.play.seeds import rng_array, rng_state
from hexwar_sb3.players.fit import check_fit, check_tasks
from hexwar_sb3.players.frozen_lower import FrozenLower, Lower
from hexwar_sb3.players.player import BotPlayer, Player, given_name, make_player
from hexwar_sb3.players.terms import CAMPS_OF
from hexwar_sb3.tasks.features import PER_HOP, feature_index
from hexwar_sb3.tasks.records import ENDED, TaskKind
from hexwar_sb3.tasks.route import N_ANSWERS, STAY, new_route_buffers

DROP_SHARE = 0.5  # of such walks of a chariot: it sets its passenger down, who else would hardly ever walk
_WAY = feature_index("route", 1, 1, 1)["goal: way"].start
_TASK_FIELDS = ("kind", "target", "cell")


@dataclass
class Hop:
    """What the last answers led to, a row a game."""

    reward: NDArray[np.float32]  # r_L, and the gain of the potential if there is one [n]
    lower_reward: NDArray[np.float32]  # r_L, eq. (5) [n]
    finished: NDArray[np.bool_]  # the piece stays in the right place [n]
    cut: NDArray[
        np.bool_
    ]  # it ended otherwise: another or impossible task, the piece's loss, the game's end [n]
    ticks: NDArray[np.int64]  # of the way [n]
    steps: NDArray[np.float64]  # length in base hops, or 1 an answer (`beta_per`) [n]
    rest: NDArray[np.int64]  # where `cut`: ticks until the hop under way is done [n]
    last_state: NDArray[np.float32]  # what the lower level would have read where it was `cut` [n, Dl]
    last_mask: NDArray[np.int8]  # [n, 7]

    @property
    def over(self) -> NDArray[np.bool_]:
        """The route has ended [n]."""
        return self.finished | self.cut


@dataclass
class Focus:
    """The focal piece of every game, and the route that it is on."""

    piece: NDArray[np.int64]  # NO_FOCUS: none [n]
    turn: NDArray[np.int64]  # slot of the camp that had its turn last [n]
    kind: NDArray[np.int64]  # of the task [n]
    target: NDArray[np.int64]
    cell: NDArray[np.int64]
    hops: NDArray[np.int64]  # answers on this route so far

    @classmethod
    def none(cls, n: int) -> Focus:
        """Nobody is led."""
        return cls(
            np.full(n, NO_FOCUS), np.full(n, -1), *(np.zeros(n, np.int64) for _ in (*_TASK_FIELDS, "hops"))
        )


class RouteGames:
    """Games of one scenario with a focal piece each.

    Args:
        n_games: games side by side.
        settings: of the env.
        scenario: one of the settings' fields.
        seed: of the episodes.
    """

    def __init__(self, n_games: int, settings: RouteSettings, scenario: ScenarioLike, seed: int) -> None:
        self.settings, self.n_games = settings, n_games
        self.tasks = TaskGames(n_games, settings.task_settings(scenario), seed)
        check_leader(self.tasks.lower)
        self.arena, self.all = self.tasks.arena, self.tasks.all
        self.set_upper(settings.upper)
        self.focus = Focus.none(n_games)
        self._idle = np.zeros(n_games, np.bool_)  # nobody had a way to go in a whole game
        self._passable = np.flatnonzero(self.arena.world.cells.passable == 1)
        self.state, self.mask = new_route_buffers(n_games)
        self.seed(seed)

    def seed(self, seed: int) -> None:
        """Count games from 0 again, under another seed."""
        self.seed_slots([seed])

    def seed_slots(self, seeds: Sequence[int]) -> None:
        """Count games from 0 again: those of one seed for all slots, or of a seed a slot, as an env of one game has them."""
        self.tasks.seed_slots(seeds)
        self.draws = Draws(seeds, self.n_games)
        self.focus.turn[:] = -1

    def set_upper(self, upper: object) -> None:
        """Let another policy give the tasks, from the next decision on.

        Raises:
            ConfigError: it is for other pieces, tasks or features; the one of before stays.
        """
        made = _make_upper(upper)
        if made is not None:
            for side in CAMPS_OF[self.settings.side]:
                check_fit(made, self.arena.world, parse_camp(side), given_name(upper))
        self.upper = made

    def begin(self, which: Games) -> None:
        """Start new games in these slots, and the first route of each."""
        self.tasks.begin(which)
        self.focus.piece[which] = NO_FOCUS
        self.decide(which)
        self.next_route(which)

    def next_route(self, which: Games) -> NDArray[np.int64]:
        """Let the next piece of each game take its turn; play on until it asks for its way.

        After a whole game in which nobody asked, every task of the next one is a walk: an upper level that sends nobody
        anywhere must not be waited for without end.

        Returns:
            Ticks that were played until then, of every game [n].

        Raises:
            ConfigError: none of the camp's pieces can leave its cell at the start.
        """
        waited, ticks = np.zeros(self.n_games, np.int64), self.arena.state.games.tick
        whole = np.zeros(self.n_games, np.bool_)  # the game was waited for from its beginning
        self._let_go(which)
        while which.size:
            self._take_turns(which)
            waited[which] -= ticks[which]
            self.arena.advance(which)
            waited[which] += ticks[which]
            over, due = self.arena.over(which), self.arena.due(which, self.tasks.camps[which])
            if over.any():
                self.tasks.begin(which[over])
                self.focus.piece[which[over]] = NO_FOCUS
                self._idle[which[over]] = whole[which[over]]
                self._check_ways(which[over & whole[which]])
                whole[which[over]] = True
            self.decide(which[over | due])
            which = which[~self._starts(which)]
        self._idle[:] = False
        return waited

    def _check_ways(self, which: Games) -> None:
        """Check in these games, at their start, that somebody can leave his cell: nobody waits for those who never can."""
        if not which.size:
            return
        pieces, _ = self._own_pieces(which)
        _, masks = self.arena.look_routes(which.repeat(pieces.shape[1]), pieces.ravel(), ways=False)
        if not masks[:, STAY + 1 :].any():
            name = self.arena.world.scenario.name
            raise ConfigError(f"scenario {name!r}: no piece of the learner's camp has a way out of its cell")

    def play(self, answers: NDArray[np.int64]) -> Hop:
        """Give each focal piece its answer [n], and play on until it asks again or its route is over: eq. (5)."""
        self.tasks.check_begun()
        hop = self._new_hop()
        known = np.where((answers >= 0) & (answers < N_ANSWERS), answers, STAY)
        answers = np.where(self.mask[self.all, known] != 0, known, STAY)
        before, start = self.tasks.scores(), self.arena.state.games.tick.astype(np.int64)
        goals = self.arena.missions.goal[self.all, self.focus.piece]
        hop.finished[:] = (answers == STAY) & (goals == self._pieces.cell[self.all, self.focus.piece])
        base = self._base_ticks()
        self.focus.hops += 1
        self.arena.tell(self.all, self.focus.piece, answers)
        self._play_on(self.all[~hop.finished], hop)
        hop.ticks[:] = self.arena.state.games.tick - start
        hop.steps[:] = (hop.ticks + hop.rest) / base if self.settings.beta_per == "base_hop" else 1.0
        limit = self.settings.gain_limit
        gain = np.clip(self.tasks.scores() - before, -limit, limit)
        hop.lower_reward[:] = hop.finished + self.settings.alpha * gain - self.settings.beta * hop.steps
        hop.reward[:] = hop.lower_reward + self._gained_potential(hop)
        return hop

    def _gained_potential(self, hop: Hop) -> NDArray[np.float64]:
        """What is added to r_L for the way that was made good, see `RouteSettings.potential` [n]."""
        if not self.settings.is_shaped:
            return np.zeros(self.n_games)
        before = self.settings.potential(_hops_left(self.state))
        self.look()
        after = self.settings.potential(_hops_left(np.where(hop.over[:, None], hop.last_state, self.state)))
        return np.where(hop.finished, 0.0, self.settings.shaping**hop.steps * after) - before

    def look(self) -> None:
        """Read what every focal piece asks about."""
        self.state[:], self.mask[:] = self.arena.look_routes(
            self.all, self.focus.piece, ways=self.settings.ways
        )

    def decide(self, which: Games) -> None:
        """Give tasks in these games: kept ones, those of the upper level, and walks to random cells."""
        if not which.size:
            return
        self.arena.ask(which.tolist())  # an opponent that is a policy
        pieces, there = self._own_pieces(which)
        at = which[:, None], pieces
        before = self.arena.missions[at].copy().view(np.recarray)
        obs = {key: value[which] for key, value in self.tasks.look(which).items()}
        mask = obs["action_mask"] != 0
        if self.upper is None:
            wanted = self._random_tasks(which, mask)
        else:
            wanted = check_tasks(self.upper.act(obs), mask.shape[:2])
        self.arena.choose(which, which, self.tasks.camps[which], wanted, self.tasks.sight)
        kept = self.draws.random(which, pieces.shape[1:]) < self.settings.keep_task
        kept |= (pieces == self.focus.piece[which, None]) & (
            self.focus.hops[which, None] <= 1
        )  # a hop at least
        kept &= there & (before.state != ENDED) & (before.chosen_at >= 0)
        self.arena.missions[which.repeat(pieces.shape[1])[kept.ravel()], pieces[kept]] = before[kept]
        wanders = ~kept & (self.draws.random(which, pieces.shape[1:]) < self.settings.wander)
        wanders = there & (wanders | self._idle[which, None])
        self._wander(which.repeat(pieces.shape[1])[wanders.ravel()], pieces[wanders])
        self.arena.missions.chosen_at[at] = self.arena.state.games.tick[which][:, None]

    def _own_pieces(self, which: Games) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Numbers of the learner's pieces in each game [n, N], and where there is one: an empty slot names the first."""
        first, end = self.arena.world.sides[self.tasks.camps[which]].T
        pieces = first[:, None] + np.arange(self.arena.world.n_slots)
        there = pieces < end[:, None]
        return np.where(there, pieces, first[:, None]), there

    def _random_tasks(self, which: Games, mask: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Draw a valid task for every piece of these games: mask [n, N, K] -> [n, N]."""
        return np.asarray((self.draws.random(which, mask.shape[1:]) * mask).argmax(axis=-1))

    def _wander(self, which: Games, own: NDArray[np.int64]) -> None:
        """Send pieces own[k] of games which[k] to random cells that they can reach; some set their passenger down."""
        cells, shares = self.draws.walks(which, len(self._passable))
        goals, drops = self._passable[cells], shares < DROP_SHARE
        state, world = self.arena.state, self.arena.world
        send_away(
            which, own, goals, drops, state.games, state.pieces, self.arena.missions,
            world.rules[0], world.cells, world.eta,
        )  # fmt: skip

    def _play_on(self, which: Games, hop: Hop) -> None:
        """Advance until the focal piece asks or its route is over; note how it ended."""
        while which.size:
            self.arena.advance(which)
            stopped = which[~self._asks(which)]
            if stopped.size:
                self._note_last(stopped, hop)
            focal = self.focus.piece[stopped]
            dead = self._pieces.blood[stopped, focal] == 0
            ended = self.arena.missions.state[stopped, focal] == ENDED
            over = self.arena.over(stopped)
            self.decide(stopped[~over])
            hop.cut[stopped] = dead | ended | over | ~self._same_task(stopped)
            hop.rest[stopped[~hop.cut[stopped]]] = 0
            which = stopped[~hop.cut[stopped]]

    def _note_last(self, which: Games, hop: Hop) -> None:
        """Note where the route would go on if it is cut here: a hop under way is counted to its end."""
        focal = self.focus.piece[which]
        hop.last_state[which], hop.last_mask[which] = self.arena.look_routes(
            which, focal, ways=self.settings.ways
        )
        arrives_at = self._pieces.arrives_at[which, focal]
        hop.rest[which] = np.where(arrives_at == NEVER, 0, arrives_at - self.arena.state.games.tick[which])

    @property
    def _pieces(self) -> Rows:
        return self.arena.state.pieces

    def _base_ticks(self) -> NDArray[np.float64]:
        """Ticks of a hop on open ground of every focal piece [n]."""
        ticks = self.arena.world.rules[0].base_hop.astype(np.float64)
        return np.asarray(ticks[self._pieces.kind[self.all, self.focus.piece]])

    def _asks(self, which: Games) -> NDArray[np.bool_]:
        """The focal piece waits for an answer [n]."""
        return np.asarray(self.arena.drives.waiting[which, self.focus.piece[which]] == 1)

    def _starts(self, which: Games) -> NDArray[np.bool_]:
        """The focal piece asks for its way, and has one to go: the route begins, and its task is noted [n].

        One that is in the right place already stays there, and has no route.
        """
        focal = self.focus.piece[which]
        started = (focal != NO_FOCUS) & self._asks(which)
        begun, focal = which[started], focal[started]
        piece, mission = self._pieces[begun, focal], self.arena.missions[begun, focal]
        for name in _TASK_FIELDS:
            getattr(self.focus, name)[begun] = mission[name]
        self.focus.hops[begun] = 0
        there = mission.goal == piece.cell
        self.arena.tell(begun[there], focal[there], np.full(there.sum(), STAY))
        self._let_go(begun[there])
        started[started] = ~there
        return started

    def _same_task(self, which: Games) -> NDArray[np.bool_]:
        """The focal piece still has the task that its route is for [n]."""
        missions = self.arena.missions[which, self.focus.piece[which]]
        return np.logical_and.reduce(
            [missions[name] == getattr(self.focus, name)[which] for name in _TASK_FIELDS]
        )

    def _let_go(self, which: Games) -> None:
        """Nobody outside answers for pieces of these games any more."""
        self.focus.piece[which] = NO_FOCUS
        self._lead_focal(which)

    def _take_turns(self, which: Games) -> None:
        """Make the next piece that has somewhere to go the focal one, where the focal one has not."""
        first, end = self.arena.world.sides[self.tasks.camps[which]].T
        take_turns(
            which,
            first,
            end,
            self._pieces,
            self.arena.missions,
            self.focus.piece,
            self.focus.turn,
        )
        self._lead_focal(which)

    def _new_hop(self) -> Hop:
        n = self.n_games
        return Hop(
            reward=np.zeros(n, np.float32),
            lower_reward=np.zeros(n, np.float32),
            finished=np.zeros(n, np.bool_),
            cut=np.zeros(n, np.bool_),
            ticks=np.zeros(n, np.int64),
            steps=np.zeros(n),
            rest=np.zeros(n, np.int64),
            last_state=self.state.copy(),
            last_mask=self.mask.copy(),
        )

    def snapshot(self) -> Snapshot:
        """Everything that changes in play, as arrays."""
        focus = {f"focus_{name}": value.copy() for name, value in vars(self.focus).items()}
        return {**self.tasks.snapshot(), **focus, "rng": rng_array(self.draws.first)}

    def restore(self, snapshot: Snapshot) -> None:
        """Go on where `snapshot` was taken, in an env of the same settings.

        Raises:
            ConfigError: it was taken on another scenario, under other rules, with other bots or more opponents.
            CheckpointError: it is broken; nothing is changed then.
        """
        self.check(snapshot)
        self.tasks.restore(self._of_tasks(snapshot), self._waiting(snapshot))
        for name, value in vars(self.focus).items():
            value[...] = snapshot[f"focus_{name}"]
        self._lead_focal(self.all)
        waiting = self._waiting(snapshot)
        self.arena.drives.waiting[:, : waiting.shape[1]] = waiting
        self.draws = Draws([self.tasks.first_seed], self.n_games)
        self.draws.first.bit_generator.state = rng_state(snapshot["rng"], "rng")

    def check(self, snapshot: Snapshot) -> None:
        """Check a snapshot, whatever wrote it, before anything is changed.

        Raises:
            ConfigError, CheckpointError: as `restore`.
        """
        check_names(snapshot, [*self._of_tasks(snapshot), *self._focus_names(), "rng"])
        rng_state(snapshot["rng"], "rng")
        for name in self._focus_names():
            check_form(name, snapshot[name], np.int64, (self.n_games,))
        world = self.arena.world
        check_range("focus_piece", snapshot["focus_piece"], 0, world.n_pieces - 1)
        state, missions, _ = self.tasks.check(self._of_tasks(snapshot), self._waiting(snapshot))
        focal = self.all, snapshot["focus_piece"]
        piece, mission = state.pieces[focal], missions[focal]
        check_all(
            "focus_piece",
            piece.camp == snapshot["camps"],
            snapshot["focus_piece"],
            "a piece of the learner's",
        )
        asks = (
            (piece.blood > 0)
            & (piece.carrier == NO_PIECE)
            & (piece.arrives_at == NEVER)
            & (mission.goal != NO_CELL)
        )
        asks &= (mission.state != ENDED) & ~np.isin(mission.kind, (TaskKind.STOP, TaskKind.RECOVER))
        check_all("focus_piece", asks, snapshot["focus_piece"], "a piece that has a way to go")
        for name in _TASK_FIELDS:
            its = snapshot[f"focus_{name}"]
            check_all(f"focus_{name}", its == mission[name], its, "what the piece's task has")
        own = np.diff(world.sides, axis=1)[snapshot["camps"], 0]
        check_range("focus_turn", snapshot["focus_turn"], -1, "last", {"last": own - 1})
        check_range("focus_hops", snapshot["focus_hops"], 0, "tick", {"tick": state.games.tick})

    def _focus_names(self) -> list[str]:
        return [f"focus_{name}" for name in vars(self.focus)]

    def _of_tasks(self, snapshot: Snapshot) -> Snapshot:
        """The part that the task games took."""
        return {name: array for name, array in snapshot.items() if name not in (*self._focus_names(), "rng")}

    def _waiting(self, snapshot: Snapshot) -> NDArray[np.bool_]:
        """The focal piece of each game: it waits [n, P]."""
        return self._only(snapshot["focus_piece"])

    def _lead_focal(self, which: Games) -> None:
        """The focal pieces, and no others, are answered for outside."""
        self.arena.lead_outside(which, self._only(self.focus.piece[which]))

    def _only(self, focal: NDArray[np.int64]) -> NDArray[np.bool_]:
        """One piece of each game; nobody where it is NO_FOCUS [n, P]."""
        return np.asarray(np.arange(self.arena.world.n_pieces) == focal[:, None])


def check_leader(lower: Lower) -> Lower:
    """Check that a lower level may lead the pieces that are not in focus: it must run inside the drive loop.

    Raises:
        ConfigError: it is a callable.
    """
    if not isinstance(lower, str | FrozenLower):
        raise ConfigError("the route env leads its other pieces by the heuristic or a network, no callable")
    return lower


def _hops_left(states: NDArray[np.float32]) -> NDArray[np.float64]:
    """Base hops of the fastest way, from the lower level's states [n, Dl]; at most what the feature can say."""
    return states[:, _WAY].astype(np.float64) / PER_HOP


def _make_upper(upper: object) -> Player | None:
    """Who gives the tasks; None for random ones."""
    if isinstance(upper, str) and upper == RANDOM_UPPER:
        return None
    seat = make_player(upper)
    if isinstance(seat, BotPlayer):
        raise ConfigError(
            f'upper is "{RANDOM_UPPER}" or a policy that picks tasks; {seat.name} gives orders by itself'
        )
    return seat
