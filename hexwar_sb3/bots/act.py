"""What a scripted player does at an event: it thinks when it is time to, then gives fire that takes two."""

from __future__ import annotations

from hexwar_sb3.bots.config import BotConfig, Style
from hexwar_sb3.bots.draw import draw_player
from hexwar_sb3.bots.drawn import think_drawn
from hexwar_sb3.bots.duties import order_duties
from hexwar_sb3.bots.fire import guide_missiles, lob_rounds
from hexwar_sb3.bots.ladder import climb
from hexwar_sb3.bots.points import choose_people, first_points, move_idle
from hexwar_sb3.bots.random_player import act_at_random
from hexwar_sb3.bots.records import AtlasRecord, BrainRecord
from hexwar_sb3.bots.registry import Bot
from hexwar_sb3.bots.unseen import think_unseen
from hexwar_sb3.bots.weigh import known_lead, renew_trust
from hexwar_sb3.engine.records import GameRecord, Memory, Orders, Pieces, Rounds
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import Cells, Sightlines, TravelTimes
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.indices import CampIndex, piece_range
from hexwar_sb3.tasks.known import end_piece, first_piece
from hexwar_sb3.tasks.records import Missions


@kernel
def bot_act(
    bot: int, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds, orders: Orders,
    missions: Missions, brains: Rows, rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """Let a bot look at its game at an event tick: it may choose missions and give direct orders."""
    brain = brains[camp]
    config = atlas.config
    thinks = is_time_to_think(camp, game, brain, config)
    if bot == Bot.ATTACK or bot == Bot.DEFENCE:
        style = atlas.style[bot]
        if thinks:
            think(style, camp, game, pieces, memory, rounds, missions, brain, rules, cells, los, eta, atlas)
        support(style, camp, game, pieces, memory, rounds, orders, brain, rules, cells, config)
    elif bot == Bot.DRAWN or bot == Bot.UNSEEN or bot == Bot.DRAWN_PLAN:
        if brain.thoughts == 1 and thinks:
            draw_player(bot, camp, game, pieces, brain.drawn)
        if thinks and bot == Bot.DRAWN:
            think_drawn(camp, game, pieces, memory, rounds, missions, brain, rules, cells, los, eta, atlas)
        elif thinks and bot == Bot.UNSEEN:
            think_unseen(camp, game, pieces, memory, missions, brain, rules, cells, atlas)
        elif thinks:
            climb(bot, camp, game, pieces, memory, missions, brain, rules, cells, eta, atlas)
        support(brain.drawn.style, camp, game, pieces, memory, rounds, orders, brain, rules, cells, config)
    elif thinks and bot == Bot.RANDOM:
        act_at_random(camp, game, pieces, orders, missions, brain, rules, cells, config)
    elif thinks:
        climb(bot, camp, game, pieces, memory, missions, brain, rules, cells, eta, atlas)


@kernel
def next_thought(brain: BrainRecord, tick: int) -> int:
    """First tick after `tick` at which the bot wants to act though nothing happens."""
    return max(int(brain.wake_at), tick + 1)


@kernel
def is_time_to_think(camp: CampIndex, game: GameRecord, brain: BrainRecord, config: BotConfig) -> bool:
    """Every `think_ticks`, and soon after an own loss or a new contact; sets when the bot wakes next."""
    tick = int(game.tick)
    news = game.loss_tick[camp] != brain.loss_at or game.contact_tick[camp] != brain.contact_at
    rethink_at = int(brain.thought_at) + int(config.rethink_ticks)
    brain.wake_at = (tick // config.think_ticks + 1) * config.think_ticks
    regular = tick % config.think_ticks == 0 and brain.thought_at != tick
    if brain.thoughts > 0 and not regular and not (news and tick >= rethink_at):
        if news:
            brain.wake_at = min(int(brain.wake_at), rethink_at)
        return False
    brain.thoughts += 1
    brain.thought_at = tick
    brain.loss_at = game.loss_tick[camp]
    brain.contact_at = game.contact_tick[camp]
    return True


@kernel
def support(
    style: Style, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds, orders: Orders, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, config: BotConfig,
) -> None:  # fmt: skip
    """Look for guided shots while in contact, and for targets of the mortars."""
    tick = int(game.tick)
    brain.allotted[:] = 0
    if sees_any(camp, game, pieces):
        if tick % config.fire_ticks == 0:
            guide_missiles(style, camp, game, pieces, memory, orders, brain, rules, cells, config)
        brain.wake_at = min(int(brain.wake_at), (tick // config.fire_ticks + 1) * config.fire_ticks)
    if tick % config.lob_ticks == 0:
        lob_rounds(style, camp, game, pieces, memory, rounds, orders, rules, cells, config)


@kernel
def think(
    style: Style, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, rounds: Rounds, missions: Missions, brain: BrainRecord,
    rules: RulesRecord, cells: Cells, los: Sightlines, eta: TravelTimes, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """One thought of a full player: what is known, who takes and keeps which point, what everybody does."""
    config = atlas.config
    renew_trust(camp, game, memory, brain, config)
    if brain.thoughts == 1:
        first_points(camp, game, pieces, brain, atlas)
    brain.rush = game.tick >= config.endgame_tick and known_lead(camp, game, pieces, memory, rules) < 0
    choose_people(style, camp, game, pieces, brain, rules, cells, eta, config)
    move_idle(camp, game, pieces, memory, brain, cells, config, atlas)
    order_duties(style, camp, game, pieces, memory, rounds, missions, brain, rules, cells, los, eta, atlas)


@kernel
def sees_any(camp: CampIndex, game: GameRecord, pieces: Pieces) -> bool:
    """An own piece sees an enemy."""
    for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
        if pieces[i].sees != 0:
            return True
    return False
