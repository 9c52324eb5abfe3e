"""The margins of a recorded game at the ticks at which they change, without playing it again."""

from __future__ import annotations

from hexwar_sb3.engine.record import Line
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.errors import ReplayFileError

_CAMPS = tuple(map(camp_name, SIDES))


def margins(replay: Replay) -> dict[str, list[tuple[int, int]]]:
    """Ticks at which a camp's margin changes, and what it is from then on, in points; the first is tick 0.

    Losses and captures tell; what they do not explain, a change by hand, steps at the next state.

    Raises:
        ReplayFileError: an event of them lacks what it lost, or where it was.
    """
    try:
        return _followed(replay)
    except (LookupError, ValueError, TypeError) as error:
        found, expected = f"{type(error).__name__}: {error}", "losses, and captures of control points"
        raise ReplayFileError(replay.source, "events", found=found, expected=expected) from error


def _followed(replay: Replay) -> dict[str, list[tuple[int, int]]]:
    score = _Score(replay)
    found = {camp: [(0, replay.states[0]["margin"][camp])] for camp in _CAMPS}
    for line in replay.lines:
        if line["type"] == "state":
            score.begin(line)
        elif line["type"] != "event" or not score.follow(line):
            continue
        for camp, steps in found.items():
            now = line["margin"][camp] if line["type"] == "state" else score.margin(camp)
            if steps[-1][0] == line["tick"] and len(steps) > 1:
                steps.pop()  # of one tick the last counts
            if now != steps[-1][1]:
                steps.append((line["tick"], now))
    return found


class _Score:
    """Blood and owners, followed by the events from a state on; eq. (1) of them."""

    def __init__(self, replay: Replay) -> None:
        scenario, rules = replay.scenario(), replay.ruleset()
        self.net = scenario.net_score
        self.worth = {str(piece): rules.pieces[piece.kind].value for piece in scenario.pieces}
        self.cells = [scenario.hexmap.cell_name(point.cell) for point in scenario.points]
        self.values = [point.value for point in scenario.points]
        self.begin(replay.states[0])

    def begin(self, state: Line) -> None:
        """Take blood and owners from a state."""
        self.blood: dict[str, int] = {name: blood for name, _, blood, *_ in state["pieces"]}
        self.owners: list[str] = list(state["owners"])

    def follow(self, event: Line) -> bool:
        """Take over what an event changed; False if it is none of the score's."""
        if event["kind"] == "loss":
            self.blood[event["piece"]] -= event["losses"]
        elif event["kind"] == "dead":  # a passenger dies with what it had
            self.blood[event["piece"]] = 0
        elif event["kind"] == "occupied":
            self.owners[self.cells.index(event["cell"])] = event["piece"].split(":")[0]
        else:
            return False
        return True

    def margin(self, camp: str) -> int:
        """Eq. (1): own points less the others', neutral ones included unless `net_score`."""
        total = sum(
            self.worth[name] * blood * (1 if name.startswith(f"{camp}:") else -1)
            for name, blood in self.blood.items()
        )
        for owner, value in zip(self.owners, self.values, strict=True):
            if owner == camp:
                total += value
            elif owner in _CAMPS or not self.net:
                total -= value
        return total
