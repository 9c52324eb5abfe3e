"""One game between two players, recorded step by step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from hexwar_sb3.bots.config import bots_hash
from hexwar_sb3.engine.game import LOG_ROWS
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.record import Recorder
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.engine.state import new_state
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.decisions import DecisionLog
from hexwar_sb3.play.drive import make_step, next_decision, note_due, take_turn
from hexwar_sb3.play.records import STEPS, WAITS
from hexwar_sb3.play.seeds import check_seed, game_seed
from hexwar_sb3.players.player import BotPlayer, Seat, make_player
from hexwar_sb3.players.terms import USUAL, Terms

_GAME = np.zeros(1, np.int64)  # the one of the arena


def record_game(
    red: object,
    blue: object,
    terms: Terms = USUAL,
    seed: int = 0,
    *,
    episode: int = 0,
    decision_ticks: tuple[int, int] | None = None,
    names: tuple[str, str] | None = None,
    command: str | None = None,
) -> Replay:
    """Play one game and write it down; it is the game that `play_games` plays as its number `episode`.

    What both camps decided is in it, with the task sets and values of players that have them.

    Args:
        red: a player as `make_player` takes them.
        blue: likewise.
        terms: of the game.
        seed: of the match.
        episode: number of the game.
        decision_ticks: between decisions of (red, blue), where they differ from the terms.
        names: of (red, blue) in the replay; None: the bots' or the folders'.
        command: what made it, as one would type it.

    Example:
        >>> replay = record_game("MA1", "MA2", Terms(scenario="hills"))
        >>> replay.verify()  # plays it again: the same, line by line
        >>> replay.save("game.hwr")
    """
    world = load_world(terms.scenario)
    arena = Arena(world, 1, terms, decision_ticks)
    arena.state = new_state(world, 1, LOG_ROWS)
    seats = make_player(red), make_player(blue)
    dice_seed = game_seed(check_seed(seed), episode)
    arena.begin(0, dice_seed, *seats)
    recorder, decisions = Recorder(world), DecisionLog(arena)
    game = arena.state.games[0]
    while not game.over:
        play_turn(arena, recorder, decisions, int(game.end_tick))
    told = [player_name(player, seat) for player, seat in zip((red, blue), seats, strict=True)]
    if names is not None:
        told = [replace(one, name=name) for one, name in zip(told, names, strict=True)]
    return Replay.recorded(recorder, arena.state, 0, dice_seed, told[0], told[1], command)


def play_turn(
    arena: Arena,
    recorder: Recorder,
    decisions: DecisionLog,
    until: int,
    given: dict[int, Order] | None = None,
) -> list[GameEvent]:
    """Let the camps act, then make a step or, where nobody has an order, jump to where something is due.

    It does what `advance_game` does in one turn, with both looking on.

    Args:
        arena: of one game, which is not over.
        recorder: of it.
        decisions: of it.
        until: tick at which a jump ends at the latest.
        given: orders that somebody wrote into the state, by piece.

    Returns:
        What happened in the step, in order; nothing where there was none.
    """
    world, state = arena.world, arena.state
    game, pieces, memory, paths, rounds, orders, log = state.game(0)
    drive, missions, brains = arena.drives[0], arena.missions[0], arena.brains[0]
    rules, atlas = world.rules[0], arena.atlas[0]
    tick = int(game.tick)
    decisions.ask()
    decides = next_decision(drive, game)
    turn = take_turn(
        min(until, decides), drive, game, pieces, memory, paths, rounds, orders, missions, brains,
        rules, world.cells, world.los, world.eta, atlas, arena.nets,
    )  # fmt: skip
    if turn == WAITS:
        arena.answer(_GAME)
        return []
    for line in decisions.lines(tick):
        recorder.note_line(state, 0, line)
    events = list[GameEvent]()
    if turn == STEPS:
        recorder.before_step(state, 0, given)
        make_step(drive, game, pieces, memory, paths, rounds, orders, log, rules, world.cells, world.los)
        events = recorder.after_step(state, 0)
    if turn == STEPS or game.tick == decides:
        note_due(drive, game, missions)
    return events


def player_name(player: object, seat: Seat) -> PlayerName:
    """What a replay says of a player: as it was given, and as it sits."""
    if isinstance(seat, BotPlayer):
        return PlayerName(name=seat.name, kind="bot", hash=bots_hash())
    name = Path(player).name if isinstance(player, str | Path) else type(player).__name__
    return PlayerName(name=name, kind="policy", hash=getattr(seat, "sha256", None))
