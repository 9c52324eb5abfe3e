"""What a policy would do in a person's place, by the same camp's own observation."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.roster import parse_camp
from hexwar_sb3.errors import ConfigError, OrderError
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.decisions import DecisionLog
from hexwar_sb3.players.player import BotPlayer, make_player
from hexwar_sb3.players.terms import trained_terms
from hexwar_sb3.rules.enums import Camp


class Adviser:
    """A policy that looks at a game with the eyes of one camp, and plays nothing.

    Args:
        policy: as `make_player` takes it.
        name: of it, for the person.
        game: that is looked at.
        camp: whose eyes it has.

    Raises:
        ConfigError: it is a bot, which does not say what it chooses from, or is for other pieces, tasks or features.
    """

    def __init__(self, policy: object, name: str, game: Game, camp: str) -> None:
        player = make_player(policy)
        if isinstance(player, BotPlayer):
            raise ConfigError(f"{name} is a bot; hints are given by a policy, like HRL0")
        self.name, self.camp, self.roster = name, parse_camp(camp), game.roster
        terms = replace(trained_terms(player), scenario=game.world.scenario)
        arena = Arena(game.world, 1, terms)
        arena.begin(0, 0, *((player, None) if self.camp == Camp.RED else (None, player)))
        arena.state = game.state  # the missions and drives are the arena's own
        self.log = DecisionLog(arena)

    def hint(self, piece: str) -> dict[str, Any]:
        """The task that the policy would give a piece, and what it chose from.

        Raises:
            OrderError, UnknownNameError: the camp has no such living piece.
        """
        i = self.roster.own_index(self.camp, piece)
        choices = {name: choice for name, *choice in self.log.choices(self.camp)}
        if self.roster.short(i) not in choices:
            raise OrderError(f"{piece} is destroyed; only a living piece has tasks")
        chosen, tasks, values = choices[self.roster.short(i)]
        return {"piece": piece, "chosen": chosen, "tasks": tasks, "values": values}
