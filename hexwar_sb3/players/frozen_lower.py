"""Who may answer for pieces on their way: the heuristic, a network without torch, or any callable."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.errors import ConfigError, PolicyFileError, UnknownNameError
from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.players.policy_files import CONFIG_FILE, PolicyFormat, Weights
from hexwar_sb3.players.route_network import HIDDEN, LOWER_NET, best_answer, route_values
from hexwar_sb3.tasks.features import PER_DETOUR, ROUTE, ROUTE_WIDTH, feature_index
from hexwar_sb3.tasks.route import N_ANSWERS, STAY

HEURISTIC_LOWER = "heuristic"
FOLDER = "lower"  # within the folder of a policy of the task level
FORMAT = PolicyFormat(
    "hexwar route policy",
    1,
    {
        "layer1.weight": ("hidden1", "state"),
        "layer1.bias": ("hidden1",),
        "layer2.weight": ("hidden2", "hidden1"),
        "layer2.bias": ("hidden2",),
        "layer3.weight": ("answers", "hidden2"),
        "layer3.bias": ("answers",),
    },
)
SIZES = {"state": ROUTE_WIDTH, "hidden1": HIDDEN, "hidden2": HIDDEN, "answers": N_ANSWERS}
FEATURES = hashlib.sha256(repr(ROUTE).encode()).hexdigest()[:16]  # of the state that it reads

Answerer: TypeAlias = Callable[[NDArray[np.float32], NDArray[np.int8]], NDArray[Any]]
"""(states [n, Dl], masks [n, 7]) -> answers [n]: 0 stay and perform, or 1 + a direction in the camp's frame."""


class FrozenLower:
    """The lower level's network, frozen; it runs inside the drive loop.

    Args:
        weights: two layers of 64 and the values of 7 answers, by name, [output, input].
        ways: it was trained with the fastest ways in its state.
        tie: answers whose values differ by no more are equal, and the first of them is taken. Equally fast ways
            have values that differ by chance alone (assumption A34).
        about: what it was trained on.

    Raises:
        ConfigError: other layers, or numbers that are not finite or out of range.
    """

    def __init__(
        self,
        weights: Weights,
        *,
        ways: bool = True,
        tie: float = 0.0,
        about: Mapping[str, str] | None = None,
    ) -> None:
        self.weights = FORMAT.as_weights(weights)
        self.ways, self.tie = ways, tie
        self.about = {**(about or {}), "features": FEATURES, "ways": "yes" if ways else "no", "tie": str(tie)}
        problem = FORMAT.why_unusable(self.weights, SIZES)
        if problem:
            raise ConfigError(f"no network for the drive loop: {problem}")
        if not 0.0 <= tie < float("inf"):
            raise ConfigError(f"tie must be finite and at least 0, got {tie}")

    def record(self) -> Row:
        """The network as the drive loop reads it, LOWER_NET."""
        row = np.zeros((), LOWER_NET)
        for k in (1, 2, 3):
            row[f"weight{k}"] = self.weights[f"layer{k}.weight"].T
            row[f"bias{k}"] = self.weights[f"layer{k}.bias"]
        row["ways"], row["tie"] = self.ways, self.tie
        return row

    def q_values(self, states: NDArray[np.float32]) -> NDArray[np.float32]:
        """Values of all answers, valid or not: [n, Dl] -> [n, 7]."""
        q = np.zeros((len(states), N_ANSWERS), np.float32)
        _all_values(np.require(states, np.float32, ("C", "W")), self._nets(), q)
        return q

    def __call__(self, states: NDArray[np.float32], masks: NDArray[np.int8]) -> NDArray[np.int64]:
        """Best valid answers [n]."""
        answers = np.zeros(len(states), np.int64)
        _all_answers(self.q_values(states), np.require(masks, np.int8, ("C", "W")), self.tie, answers)
        return answers

    def _nets(self) -> Rows:
        return self.record().reshape(1).view(np.recarray)

    def packed(self) -> tuple[bytes, bytes]:
        """Config and weights, as `save` writes them."""
        return FORMAT.packed(self.weights, self.about, {})

    def save(self, folder: str | Path) -> None:
        """Write the folder `config.json` + `weights.safetensors`."""
        FORMAT.save(Path(folder), self.packed())

    @classmethod
    def load(cls, folder: str | Path) -> FrozenLower:
        """Read a folder; nothing in it is run.

        Raises:
            PolicyFileError: it is broken, or its state has other features than this version's.
        """
        return cls.unpacked(Path(folder), *FORMAT.load(Path(folder)))

    @classmethod
    def unpacked(cls, place: Path, config: Mapping[str, Any], weights: Weights) -> FrozenLower:
        """Make it of what was read at a place, which is named in errors.

        Raises:
            PolicyFileError: its state has other features than this version's, or a word of `about` is none.
        """
        about, path = config["about"], place / CONFIG_FILE
        if about.get("features") != FEATURES or config["sizes"] != SIZES:
            found = f"{about.get('features')!r}, sizes {config['sizes']}"
            expected = f"{FEATURES!r}, sizes {SIZES}: train the lower level anew"
            raise PolicyFileError(path, "features", found=found, expected=expected)
        if about.get("ways") not in ("yes", "no"):
            raise PolicyFileError(path, "about.ways", found=repr(about.get("ways")), expected="yes or no")
        tie = about.get("tie", "0.0")
        try:
            return cls(weights, ways=about.get("ways") == "yes", tie=float(tie), about=about)
        except ValueError as error:
            raise PolicyFileError(
                path, "about.tie", found=repr(tie), expected="a number of at least 0"
            ) from error


def fastest_way_network() -> FrozenLower:
    """Say in weights what the heuristic does: the valid direction that loses least against the fastest way."""
    weights = {
        name: np.zeros([SIZES[axis] for axis in axes], np.float32) for name, axes in FORMAT.layers.items()
    }
    places = feature_index("route", 1, 1, 1)
    for direction in range(N_ANSWERS - 1):
        weights["layer1.weight"][direction, places[f"neighbour {direction}: detour"]] = 1.0
        weights["layer2.weight"][direction, direction] = 1.0
        weights["layer3.weight"][1 + direction, direction] = -1.0
    weights["layer3.bias"][STAY] = (
        0.5 * PER_DETOUR
    )  # better than a base hop lost: it is valid in the right place
    return FrozenLower(weights, about={"trained": "no"})


Lower: TypeAlias = str | FrozenLower | Answerer


def make_lower(lower: object) -> Lower:
    """Turn "heuristic", a folder, a network or a callable into a lower level.

    A folder is that of a lower policy, of a policy with one in it, or of a run.

    Raises:
        UnknownNameError: neither "heuristic" nor a folder.
        PolicyFileError: the folder is broken.
        ConfigError: the object cannot answer.
    """
    if isinstance(lower, str | Path):
        return _named_lower(lower)
    if callable(lower) and not inspect.isclass(lower):
        return cast("Lower", lower)
    raise ConfigError(
        f'lower is "heuristic", a folder or a callable (states, masks) -> answers, got {lower!r}'
    )


def _named_lower(name: str | Path) -> Lower:
    if name == HEURISTIC_LOWER:
        return HEURISTIC_LOWER
    folder = Path(name)
    for place in (folder / "policy" / FOLDER, folder / FOLDER, folder):
        if (place / CONFIG_FILE).is_file():
            return FrozenLower.load(place)
    if folder.exists():
        raise PolicyFileError(
            folder, CONFIG_FILE, found="nothing", expected="a lower policy, or a folder with one"
        )
    raise UnknownNameError("lower", str(name), (HEURISTIC_LOWER,))


def check_answers(answers: object, masks: NDArray[np.int8]) -> NDArray[np.int64]:
    """Check what a callable answered.

    Raises:
        ConfigError: other than one valid answer a row.
    """
    found = np.asarray(answers)
    if found.shape != (len(masks),) or found.dtype.kind not in "iu":
        raise ConfigError(
            f"a lower level must give {len(masks)} whole numbers, one a row, got {found.dtype} {found.shape}"
        )
    known = (found >= 0) & (found < N_ANSWERS)
    if not (known & (masks[np.arange(len(masks)), np.where(known, found, 0)] != 0)).all():
        raise ConfigError(f"a lower level must give valid answers by the masks, got {found.tolist()}")
    return found.astype(np.int64)


@kernel
def _all_values(states: Rows, nets: Rows, q: Rows) -> None:
    for n in range(states.shape[0]):
        route_values(states[n], nets[0], q[n])


@kernel
def _all_answers(q: Rows, masks: Rows, tie: float, answers: Rows) -> None:
    for n in range(answers.size):
        answers[n] = best_answer(q[n], masks[n], tie)
