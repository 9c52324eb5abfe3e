"""The task env as PettingZoo sees it: one agent a piece."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from hexwar_sb3.checks import check_choice
from hexwar_sb3.engine.roster import SIDES, camp_name, parse_camp
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.screen import METADATA, Frame, Screen
from hexwar_sb3.envs.settings import TaskSettings, task_settings
from hexwar_sb3.envs.task_games import Obs, box_of, check_pieces, fitting_mixture
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.encounters import Encounters
from hexwar_sb3.play.seeds import check_seed, chosen_seed, game_seed
from hexwar_sb3.play.sight import Sight
from hexwar_sb3.players.fit import check_actions
from hexwar_sb3.players.player import Seat, member_of
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.records import MAX_TASKS

CAMPS = ("red", "blue", "both")
NAME = "hexwar_task_v0"  # as PettingZoo writes names


class TaskParallelEnv(ParallelEnv[str, Obs, int]):  # type: ignore[misc]  # PettingZoo ships no types
    """One agent a piece, "red:tank0"; its action is a task index of its own task set.

    Every agent of a camp gets the camp's reward, eq. (3). Agents leave when their piece is destroyed.
    The reward is the referee's margin, so it tells of hits on enemies that the camp does not see; the observations
    tell nothing of them.

    Args:
        settings: the env's settings; `side` stands for itself, `opponent` for the camp not played.
        camps: "red", "blue" or "both".
        render_mode: "rgb_array": `render` draws what the first camp knows; "human": a window shows it after each step
            (needs pygame: the extra "human"); None: nothing is drawn.
    """

    metadata: ClassVar[dict[str, Any]] = {"name": NAME, "is_parallelizable": True, **METADATA}

    def __init__(self, settings: TaskSettings, camps: str = "both", render_mode: str | None = None) -> None:
        check_choice("camps", camps, CAMPS)
        self.render_mode, self._screen = render_mode, Screen(render_mode, self._draw, NAME)
        self.camps = SIDES if camps == "both" else (parse_camp(camps),)
        world = load_world(settings.scenario)
        check_pieces(world)
        rivals = [camp for camp in SIDES if camp not in self.camps]
        self.mixture = fitting_mixture(settings.opponent, world, rivals)
        self.encounters = Encounters(len(self.mixture.players), settings.priority)
        self._opponent = 0  # of this game, its place in the mixture
        self._rival = self.mixture.players[0]  # of this game
        self.arena, self._net = Arena(world, 1, settings), settings.reward == "net"
        self.sights = {camp: Sight(world, 1, dtype=settings.dtype, with_state=True) for camp in self.camps}
        self.possible_agents = [
            f"{camp_name(camp)}:{name}" for camp in self.camps for name in world.piece_names(camp)
        ]
        self.agents: list[str] = []
        self._places = {agent: self._place(agent) for agent in self.possible_agents}
        self._action_spaces = {agent: spaces.Discrete(MAX_TASKS) for agent in self.possible_agents}
        self._observation_spaces = {agent: self._space(agent) for agent in self.possible_agents}
        self.state_space = box_of("state", self.state())  # of `state`
        self._seed, self._episode = chosen_seed(None), 0

    def observation_space(self, agent: str) -> spaces.Dict:
        """The piece's own features, its task rows and their mask."""
        return self._observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """A task index."""
        return self._action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Obs], dict[str, dict[str, Any]]]:
        """Start the next episode; with a seed, the first one of that seed. A new env draws one."""
        if seed is not None:
            self._seed, self._episode = check_seed(seed), 0
        self.arena.begin(0, game_seed(self._seed, self._episode), *self._seats())
        self._episode += 1
        self.agents = list(self.possible_agents)
        self._look()
        self._screen.follow()
        return {agent: self._observe(agent) for agent in self.agents}, {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, int]
    ) -> tuple[dict[str, Obs], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Play one decision; an agent without an action, or with an illegal one, stops.

        Actions of agents that have left are not looked at.

        Raises:
            UnknownNameError: no such agent.
            ConfigError: an action is no whole number, or no game has begun.
        """
        if not self._episode:
            raise ConfigError("no game has begun: reset the env before the first step")
        picked = {agent: _whole(agent, action) for agent, action in self._known(actions)}
        before, tick = self._scores(), int(self.arena.state.games.tick[0])
        for camp in self.camps:
            self._choose(camp, picked)
        self._advance()
        self._look()
        gain = {camp: after - before[camp] for camp, after in self._scores().items()}
        over = bool(self.arena.state.games.over[0])
        if over and len(self.camps) == 1:
            win = self.arena.wins(np.zeros(1, np.int64), np.array(self.camps, np.int64))
            member = member_of(self.mixture.players[self._opponent], self._rival)
            self.encounters.note(self._opponent, float(win[0]), member)
        ticks = int(self.arena.state.games.tick[0]) - tick
        acted = self.agents
        ended = {agent: over or not self._is_alive(agent) for agent in acted}
        self.agents = [agent for agent in acted if not ended[agent]]
        self._screen.follow()
        return (
            {agent: self._observe(agent) for agent in acted},
            {agent: gain[self._places[agent][0]] for agent in acted},
            ended,
            dict.fromkeys(acted, False),
            {agent: {"ticks": ticks} for agent in acted},
        )

    def state(self) -> NDArray[Any]:
        """The truth, in the first camp's frame [Ds]; for training only."""
        return self.sights[self.camps[0]].obs["state"][0].copy()

    def render(self) -> Frame | None:
        """Draw what the first camp knows, [height, width, RGB]; None without a render mode, or to a window."""
        return self._screen.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    def _draw(self) -> Frame:
        from hexwar_sb3.envs.render import draw_position  # matplotlib: only where it is asked for

        return draw_position(self.arena, 0, int(self.camps[0]))

    def _seats(self) -> tuple[Seat | None, Seat | None]:
        self._opponent = self.mixture.draw(self._seed, self._episode, self.encounters.urgency)
        met = self.mixture.players[self._opponent]
        other = self._rival = self.encounters.seat(self._opponent, met, self._seed, self._episode)
        red, blue = (None if camp in self.camps else other for camp in SIDES)
        return red, blue

    def _known(self, actions: dict[str, int]) -> Iterator[tuple[str, int]]:
        """Actions of agents that are still there."""
        for agent, action in actions.items():
            if agent not in self._places:
                raise UnknownNameError("agent", str(agent), self._places)
            if agent in self.agents:
                yield agent, action

    def _choose(self, camp: Camp, actions: dict[str, int]) -> None:
        row = np.zeros((1, self.sights[camp].rows.shape[1]), np.int64)
        for agent, action in actions.items():
            owner, slot = self._places[agent]
            if owner == camp:
                row[0, slot] = action
        one = np.zeros(1, np.int64)
        self.arena.choose(one, one, np.array([camp], np.int64), row, self.sights[camp])

    def _advance(self) -> None:
        """Play until the camps are due again or the game is over, asking the opponent meanwhile."""
        one, due = np.zeros(1, np.int64), False
        while not due and not self.arena.over(one)[0]:
            self.arena.ask([0])
            self.arena.advance(one)
            due = any(self.arena.due(one, int(camp))[0] for camp in self.camps)

    def _look(self) -> None:
        one = np.zeros(1, np.int64)
        for camp, sight in self.sights.items():
            self.arena.look(one, one, np.array([camp], np.int64), sight)

    def _scores(self) -> dict[Camp, float]:
        one = np.zeros(1, np.int64)
        return {
            camp: float(self.arena.scores(one, np.array([camp], np.int64), net=self._net)[0])
            for camp in self.camps
        }

    def _place(self, agent: str) -> tuple[Camp, int]:
        side, name = agent.split(":")
        camp = parse_camp(side)
        return camp, self.arena.world.piece_names(camp).index(name)

    def _is_alive(self, agent: str) -> bool:
        camp, slot = self._places[agent]
        return bool(self.arena.state.pieces[0, self.arena.world.side(camp)][slot].blood > 0)

    def _observe(self, agent: str) -> Obs:
        camp, slot = self._places[agent]
        obs = self.sights[camp].obs
        return {
            "observation": obs["obs"][0, slot].copy(),
            "tasks": obs["tasks"][0, slot].copy(),
            "action_mask": obs["action_mask"][0, slot].copy(),
        }

    def _space(self, agent: str) -> spaces.Dict:
        return spaces.Dict({key: box_of(key, value) for key, value in self._observe(agent).items()})


def _whole(agent: str, action: object) -> int:
    try:
        return int(check_actions(action, (), axes=""))
    except ConfigError as error:
        raise ConfigError(f"agent {agent!r}: {error}") from error


def parallel_env(
    scenario: Any = "plain", camps: str = "both", render_mode: str | None = None, **settings: Any
) -> TaskParallelEnv:
    """PettingZoo's parallel view of the task env.

    Args:
        scenario: name, file or object.
        camps: "red", "blue" (the other one is the `opponent`) or "both".
        render_mode: "rgb_array", "human" or None.
        settings: see `TaskSettings`.

    Example:
        >>> env = parallel_env("plain", camps="red", opponent="MA2")
        >>> observations, infos = env.reset(seed=0)
        >>> list(observations)[:2]
        ['red:tank0', 'red:tank1']
    """
    return TaskParallelEnv(task_settings({"scenario": scenario, **settings}), camps, render_mode)
