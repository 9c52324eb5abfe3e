"""A batch of games on one world, each seat held by a bot or by somebody who picks tasks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import fields
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.bots.atlas import make_atlas
from hexwar_sb3.bots.records import BRAIN
from hexwar_sb3.engine.fields import check_form, check_names, check_same, copied
from hexwar_sb3.engine.records import NEVER
from hexwar_sb3.engine.score import margin, points_held
from hexwar_sb3.engine.sight import remember
from hexwar_sb3.engine.sound import check_state
from hexwar_sb3.engine.state import State, new_state, seed_game
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.play.demos import name_missions, name_moves
from hexwar_sb3.play.drive import advance_until_decision
from hexwar_sb3.play.lower import HEURISTIC, KEPT, tell_pieces
from hexwar_sb3.play.records import BY_HAND, DRIVE, EXTERNAL
from hexwar_sb3.play.sight import Sight, choose_batch, look_batch, observe_routes
from hexwar_sb3.play.sound import check_play
from hexwar_sb3.players.fit import check_actions, check_fit, check_tasks
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, Answerer, FrozenLower, Lower, check_answers
from hexwar_sb3.players.player import BotPlayer, Player, Seat, seat_name
from hexwar_sb3.players.route_network import LOWER_NET
from hexwar_sb3.players.terms import USUAL, Terms
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CampIndex, camp_range, point_range
from hexwar_sb3.tasks.choose import new_missions
from hexwar_sb3.tasks.route import N_ANSWERS, new_route_buffers
from hexwar_sb3.tasks.spots import load_spots

Games = NDArray[np.int64]  # indices of games in the batch, [n]
Snapshot = dict[str, NDArray[Any]]


class Arena:
    """Games that run to their next decisions together.

    A seat is a `BotPlayer` (it runs inside the drive loop), a `Player` (asked by `ask`), or None: then
    the caller looks and chooses.

    Args:
        world: scenario and rules, loaded.
        n_games: games in the batch.
        terms: of the games; their scenario is the world's.
        decision_ticks: between decisions of (red, blue), where they differ from the terms.
    """

    def __init__(
        self, world: World, n_games: int, terms: Terms = USUAL, decision_ticks: tuple[int, int] | None = None
    ) -> None:
        self.world, self.terms, self.n_games = world, terms, n_games
        self.decision_ticks = decision_ticks or (terms.decision_ticks, terms.decision_ticks)
        self._early = int(terms.decisions == "event")
        self.state = new_state(world, n_games)
        self.missions = new_missions(n_games, world.n_pieces)
        self.brains = np.zeros((n_games, 2), BRAIN).view(np.recarray)
        self.drives = np.zeros(n_games, DRIVE).view(np.recarray)
        self.players: list[list[Player | None]] = [[None, None] for _ in range(n_games)]
        self._start = _start(world, terms.fog)
        self._sights: dict[int, Sight] = {}
        self.chosen: dict[
            int, NDArray[np.int64]
        ] = {}  # by camp, task indices of the players last asked [n, N]
        self._first = self._first_game()
        self.nets = np.zeros(1, LOWER_NET).view(np.recarray)  # that drives.lower names
        self._net_numbers: dict[FrozenLower, int] = {}
        self._answerers: dict[tuple[int, int], Answerer] = {}  # (game, camp) -> who answers outside the loop
        self.atlas = make_atlas(world)
        self._spots = load_spots(world, terms.spots)

    def __getstate__(self) -> dict[str, Any]:
        return {
            **self.__dict__,
            "atlas": None,
        }  # read-only, which a copy would not be: kernels would compile anew

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.atlas = make_atlas(self.world)

    def twin(self, state: State) -> Arena:
        """An independent arena at the same point of its games, which go on in a copy of their state."""
        other = copy(self)
        other.state, other.missions = state, self.missions.copy()
        other.brains, other.drives = self.brains.copy(), self.drives.copy()
        other._sights, other.chosen = {}, {}  # noqa: SLF001 - of the same class
        return other

    def begin(self, b: int, seed: int, red: Seat | None, blue: Seat | None) -> None:
        """Put game b back to tick 0 with a seed for its dice, and seat its two players."""
        self.restart(np.array([b]), [seed])
        for camp, seat in enumerate((red, blue)):
            self.sit(b, camp, seat)

    def restart(self, which: Games, seeds: Sequence[int]) -> None:
        """Put games back to tick 0, each with a seed for its dice; both players of each are to be seated then."""
        own = self._arrays()
        for name, first in self._first.items():  # as bytes: records are copied field by field
            own[name].view(np.uint8).reshape(self.n_games, -1)[which] = first.view(np.uint8).reshape(1, -1)
        for b, seed in zip(which, seeds, strict=True):
            seed_game(self.state.games[b], np.uint64(seed))

    def sit(self, b: int, camp: int, seat: Seat | None) -> None:
        """Seat a player, a bot or (None) the caller.

        Raises:
            ConfigError: the player is for other pieces, tasks or features.
        """
        if seat is not None:
            check_fit(seat, self.world, camp)
        bot = isinstance(seat, BotPlayer)
        drives = self.drives.view(np.ndarray)
        drives["seat"][b, camp] = seat.bot if isinstance(seat, BotPlayer) else EXTERNAL
        self.brains.view(np.ndarray)["drawn"]["member"][b, camp] = (
            seat.member if isinstance(seat, BotPlayer) else 0
        )
        drives["wake_at"][b, camp] = 0 if bot else NEVER
        drives["asked"][b, camp] = drives["due"][b, camp] = not bot
        self.players[b][camp] = None if isinstance(seat, BotPlayer) else seat
        self.set_lower(b, camp, getattr(seat, "lower", HEURISTIC_LOWER))

    def leave(self, b: int, camp: int) -> None:
        """Let a camp without a player: whoever writes its orders gives them all, and it has no tasks."""
        self.sit(b, camp, None)
        self.drives[b].seat[camp] = BY_HAND
        self.drives[b].asked[camp] = self.drives[b].due[camp] = 0

    def set_lower(self, b: int, camp: int, lower: Lower) -> None:
        """Say who answers for a camp's pieces on their way: "heuristic", a network, or any callable."""
        pieces = self.world.side(camp)
        lowers = self.drives.view(np.ndarray)["lower"]
        lowers[b, camp] = HEURISTIC
        if self._answerers.pop((b, camp), None) is not None:
            self.drives[b].outside[pieces] = 0
        if isinstance(lower, FrozenLower):
            lowers[b, camp] = 1 + self._number(lower)
        elif callable(lower):
            self._answerers[b, camp] = lower
            self.drives[b].outside[pieces] = 1

    def keep_answers(self, which: Games, camps: NDArray[np.int64], answers: NDArray[Any]) -> None:
        """Let the pieces of camp camps[k] in game which[k] keep answers[k], until illegal or given anew.

        Args:
            answers: 0 stay and perform, or 1 + a direction in the camp's frame [n, N].

        Raises:
            ConfigError: they are none, or of another shape.
        """
        answers = check_actions(answers, (len(which), self.world.n_slots))
        if ((answers < 0) | (answers >= N_ANSWERS)).any():
            raise ConfigError(f"answers must be in 0..{N_ANSWERS - 1}, got {answers.tolist()}")
        for b, camp, kept in zip(which, camps, answers, strict=True):
            self.drives[b].lower[camp] = KEPT
            own = self.world.side(int(camp))
            self.drives[b].kept[own] = kept[: own.stop - own.start]

    def lead_outside(self, which: Games, pieces: NDArray[np.bool_]) -> None:
        """Let the caller answer for some pieces of these games, and no others: `advance` stops where they ask.

        What callables lead stays with them.

        Args:
            which: games [n].
            pieces: that are led [n, P].
        """
        led = pieces.copy()
        for game, camp in self._answerers:
            led[which == game, self.world.side(camp)] = True
        self.drives.outside[which, : led.shape[1]] = led
        self.drives.waiting[which, : led.shape[1]] &= led

    def _number(self, lower: FrozenLower) -> int:
        """Row of a network in `nets`; a new one is put there."""
        if lower not in self._net_numbers:
            number = self._net_numbers[lower] = len(self._net_numbers)
            self.nets = np.resize(self.nets, max(len(self.nets), number + 1)).view(np.recarray)
            self.nets[number] = lower.record()
        return self._net_numbers[lower]

    def due(self, which: Games, camps: NDArray[np.int64] | int) -> NDArray[np.bool_]:
        """Whether camp camps[k] of game which[k] is to decide now, [n]."""
        return self.drives.due[which, camps] == 1

    def over(self, which: Games) -> NDArray[np.bool_]:
        """Whether each game has ended, [n]."""
        return self.state.games.over[which] == 1

    def advance(self, which: Games) -> None:
        """Play each game to its next decision or its end, or until a piece waits for an answer of the caller."""
        while which.size:
            self._drive(which)
            which = self.answer(which)

    def answer(self, which: Games) -> Games:
        """Let the callables among the lower levels answer for the pieces that wait; the games that go on by it."""
        if not self._answerers:
            return which[:0]
        asked: dict[Answerer, list[tuple[int, int]]] = {}
        for b in which[self.drives.waiting[which].any(axis=1)].tolist():
            for camp in camp_range(2):
                if (b, camp) in self._answerers:
                    pairs = [(b, int(i)) for i in self.waiting(b, camp)]
                    asked.setdefault(self._answerers[b, camp], []).extend(pairs)
        for answerer, pairs in asked.items():
            if not pairs:
                continue
            games, pieces = np.array(pairs, np.int64).reshape(-1, 2).T.copy()
            states, masks = self.look_routes(games, pieces, ways=True)
            self.tell(games, pieces, check_answers(answerer(states, masks), masks))
        return np.unique([b for pairs in asked.values() for b, _ in pairs]).astype(np.int64)

    def waiting(self, b: int, camp: int) -> NDArray[np.int64]:
        """Pieces of a camp that wait for an answer in game b."""
        side = self.world.side(camp)
        return side.start + np.flatnonzero(self.drives[b].waiting[side])

    def look_routes(
        self, which: Games, pieces: NDArray[np.int64], *, ways: bool
    ) -> tuple[NDArray[np.float32], NDArray[np.int8]]:
        """What the lower level reads of piece pieces[k] in game which[k]: states [n, Dl] and masks [n, 7]."""
        states, masks = new_route_buffers(len(which))
        world, state = self.world, self.state
        observe_routes(
            which,
            pieces,
            ways,
            state.pieces,
            self.missions,
            world.rules,
            world.cells,
            world.eta,
            states,
            masks,
        )
        return states, masks

    def tell(self, which: Games, pieces: NDArray[np.int64], answers: NDArray[np.int64]) -> None:
        """Give the answer answers[k], in the camp's frame, to piece pieces[k] of game which[k], which waits."""
        tell_pieces(which, pieces, answers, self.drives, self.state.games, self.state.pieces, self.missions)

    def _drive(self, which: Games) -> None:
        world, state = self.world, self.state
        advance_until_decision(
            which, self.drives, state.games, state.pieces, state.memory, state.paths, state.rounds,
            state.orders, state.log, self.missions, self.brains,
            world.rules, world.cells, world.los, world.eta, self.atlas, self.nets,
        )  # fmt: skip

    def look(self, slots: Games, which: Games, camps: NDArray[np.int64], sight: Sight) -> None:
        """Fill slots[k] of the buffers with what camp camps[k] of game which[k] sees."""
        world, state = self.world, self.state
        look_batch(
            slots, which, camps, state.games, state.pieces, state.memory, self.missions,
            world.rules, world.cells, world.los, world.eta, self._spots, *sight.out,
        )  # fmt: skip
        sight.publish(slots)

    def choose(
        self, slots: Games, which: Games, camps: NDArray[np.int64], actions: NDArray[Any], sight: Sight
    ) -> NDArray[np.int64]:
        """Give camp camps[k] of game which[k] the tasks actions[k] of what it saw in slots[k].

        Returns:
            Number of illegal actions of each game, [n]; an illegal action stands for stop.

        Raises:
            ConfigError: the actions are no whole numbers [n, N].
        """
        actions = check_actions(actions, (len(which), sight.rows.shape[1]))
        illegal = np.zeros(len(which), np.int64)
        actions = np.array(actions, np.int64, order="C")
        choose_batch(
            slots, which, camps, actions, self.drives, self.state.games, self.missions,
            sight.rows, sight.obs["action_mask"], illegal,
        )  # fmt: skip
        return illegal

    def ask(self, which: Iterable[int]) -> None:
        """Let every seated `Player` whose turn it is in these games pick its tasks."""
        turns: dict[tuple[CampIndex, int], list[int]] = {}
        for b in which:
            for camp in camp_range(2):
                player = self.players[b][camp]
                if player is not None and self.drives[b].due[camp]:
                    turns.setdefault((camp, id(player)), []).append(b)
        for (camp, _), games in turns.items():
            self._ask_one(camp, np.array(games, np.int64))

    def _ask_one(self, camp: int, which: Games) -> None:
        player = cast("Player", self.players[which[0]][camp])
        sight = self.sight(camp)
        slots, camps = np.arange(len(which)), np.full(len(which), camp)
        self.look(slots, which, camps, sight)
        actions = player.act({key: value[: len(which)] for key, value in sight.obs.items()})
        try:
            tasks = check_tasks(actions, (len(which), sight.rows.shape[1]))
            self.choose(slots, which, camps, tasks, sight)
            self.chosen[camp] = tasks
            if hasattr(player, "answers"):
                self.keep_answers(which, camps, player.answers)
        except ConfigError as error:
            raise ConfigError(f"player {seat_name(player)!r}: {error}") from error

    def sight(self, camp: int) -> Sight:
        """What the players of a camp that were last asked saw."""
        if camp not in self._sights:
            self._sights[camp] = Sight(self.world, self.n_games)
        return self._sights[camp]

    def name_missions(
        self, b: int, camp: CampIndex, sight: Sight, slot: int, missions: Rows | None = None
    ) -> NDArray[np.int64]:
        """Task indices [N] nearest to what camp is doing in game b, or to other missions [P], by what it saw in a slot."""
        tasks, mask = sight.rows[slot], sight.obs["action_mask"][slot]
        actions, under_way = (
            np.zeros(len(tasks), np.int64),
            self.missions[b] if missions is None else missions,
        )
        name_missions(camp, self.state.games[b], under_way, tasks, mask, self.world.cells, actions)
        return actions

    def name_moves(self, b: int, camp: CampIndex) -> NDArray[np.int64]:
        """Answers [N] that lead the camp's pieces where their paths lead next in game b."""
        answers = np.zeros(self.world.n_slots, np.int64)
        name_moves(
            camp, self.state.games[b], self.state.pieces[b], self.state.paths[b], self.world.cells, answers
        )
        return answers

    def margins(self, which: Games, camps: NDArray[np.int64]) -> NDArray[np.int64]:
        """True margin of camp camps[k] in game which[k], points [n]."""
        out = np.zeros(len(which), np.int64)
        margins_of(which, camps, self.state.games, self.state.pieces, self.world.rules, out)
        return out

    def scores(self, which: Games, camps: NDArray[np.int64], *, net: bool) -> NDArray[np.int64]:
        """What a reward is the gain of, points [n]: the true margin, or (`net`) own minus enemy without green.

        The choice is the reward's alone: nothing that a camp observes depends on it.
        """
        margins = self.margins(which, camps)
        if net and not self.world.scenario.net_score:
            add_green(which, self.state.games, margins)
        return margins

    def wins(self, which: Games, camps: NDArray[np.int64]) -> NDArray[np.float64]:
        """1 where camp camps[k] has the larger margin in game which[k], 0.5 where they are equal, [n]."""
        lead = np.sign(self.margins(which, camps) - self.margins(which, 1 - camps))
        return (lead + 1) / 2

    def points_held(self, b: int, camp: CampIndex) -> int:
        """Number of control points that a camp owns in game b."""
        return points_held(self.state.games[b], camp)

    def snapshot(self) -> Snapshot:
        """Copies of everything that changes in play, players apart."""
        return {name: array.copy() for name, array in self._arrays().items()}

    def snapshot_of(self, b: int) -> Snapshot:
        """The rows of one game in a snapshot."""
        return {name: array[b].copy() for name, array in self._arrays().items()}

    def restore(self, snapshot: Snapshot) -> None:
        """Put back what `snapshot` took; the players must be seated again first, with their lower levels.

        What comes from elsewhere is to be checked first (`check`).
        """
        lower = self.drives.lower.copy()  # numbers of networks are this arena's own
        for name, array in self._arrays().items():
            check_form(name, snapshot[name], array.dtype, array.shape)
        for name, array in self._arrays().items():
            array[...] = snapshot[name]
        self.drives.lower = np.where(self.drives.lower == KEPT, KEPT, lower)

    def check(self, snapshot: Snapshot) -> tuple[State, Rows, Rows]:
        """Check a snapshot that may come from a file: kernels trust every index in it.

        Returns:
            Copies of its state, missions and drives.

        Raises:
            CheckpointError: these are no games of this world, as this arena plays them.
        """
        check_names(snapshot, self._arrays())
        arrays = {field.name: snapshot[field.name] for field in fields(State)}
        state = check_state(self.world, arrays, self.state, self._start)
        missions, brains, drives = (
            copied(name, snapshot[name], getattr(self, name)) for name in ("missions", "brains", "drives")
        )
        own = {"period": self.decision_ticks, "early": self._early}
        check_same("drives", drives, {name: np.array(value) for name, value in own.items()}, own)
        check_play(self.world, state, missions, brains, drives)
        return state, missions, drives

    def _first_game(self) -> Snapshot:
        """Tick 0 of every game; nothing is logged."""
        drives = np.zeros(1, DRIVE)
        drives["period"], drives["early"] = self.decision_ticks, self._early
        state = {field.name: getattr(self._start, field.name) for field in fields(State)}
        del state["log"]
        missions = new_missions(1, self.world.n_pieces)
        return {**state, "missions": missions, "brains": np.zeros((1, 2), BRAIN), "drives": drives}

    def _arrays(self) -> Snapshot:
        state = {field.name: getattr(self.state, field.name) for field in fields(State)}
        return {**state, "missions": self.missions, "brains": self.brains, "drives": self.drives}


def _start(world: World, fog: bool) -> State:
    """Tick 0 of every game of an arena."""
    state = new_state(world, 1)
    game, pieces, memory, paths, *_ = state.game(0)
    game.fog = fog
    remember(game, pieces, memory, paths, world.cells)
    return state


@kernel
def margins_of(which: Rows, camps: Rows, games: Rows, pieces: Rows, rules_array: Rows, out: Rows) -> None:
    """Write the true margin of camp camps[k] in game which[k] to out[k]."""
    for k in range(which.size):
        out[k] = margin(games[which[k]], pieces[which[k]], camps[k], rules_array[0])


@kernel
def add_green(which: Rows, games: Rows, out: Rows) -> None:
    """Add the points that nobody holds in game which[k] to out[k]."""
    for k in range(which.size):
        game = games[which[k]]
        for p in point_range(game.n_points):
            if game.point_owner[p] == Camp.GREEN:
                out[k] += game.point_value[p]
