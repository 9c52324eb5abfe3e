"""A hexagonal war game under fog, and hierarchical reinforcement learning on it with Stable-Baselines3.

Every public name below is imported when it is first used: the game needs no torch, and a script
that only plays does not wait for it.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from hexwar_sb3.version import __version__ as __version__

if TYPE_CHECKING:  # for type checkers and editors; `_HOMES` says the same to Python
    from hexwar_sb3 import rules as rules
    from hexwar_sb3.algorithms.hierarchical import HierarchicalQMIX as HierarchicalQMIX
    from hexwar_sb3.algorithms.masked_dqn import MaskedDQN as MaskedDQN
    from hexwar_sb3.algorithms.masked_dqn import MaskedQRDQN as MaskedQRDQN
    from hexwar_sb3.algorithms.qmix import QMIX as QMIX
    from hexwar_sb3.engine.batch import Engine as Engine
    from hexwar_sb3.engine.game import Game as Game
    from hexwar_sb3.engine.game import IllegalOrderWarning as IllegalOrderWarning
    from hexwar_sb3.engine.orders import Decompress as Decompress
    from hexwar_sb3.engine.orders import GetOff as GetOff
    from hexwar_sb3.engine.orders import GetOn as GetOn
    from hexwar_sb3.engine.orders import GuideShoot as GuideShoot
    from hexwar_sb3.engine.orders import Hide as Hide
    from hexwar_sb3.engine.orders import IndirectShoot as IndirectShoot
    from hexwar_sb3.engine.orders import Move as Move
    from hexwar_sb3.engine.orders import Null as Null
    from hexwar_sb3.engine.orders import Occupy as Occupy
    from hexwar_sb3.engine.orders import Shoot as Shoot
    from hexwar_sb3.engine.orders import Stop as Stop
    from hexwar_sb3.engine.replay import Replay as Replay
    from hexwar_sb3.engine.view import SideView as SideView
    from hexwar_sb3.envs.joint_action import JointActionEnv as JointActionEnv
    from hexwar_sb3.envs.registration import make_vec_env as make_vec_env
    from hexwar_sb3.errors import HexWarError as HexWarError
    from hexwar_sb3.evaluation.matches import play_match as play_match
    from hexwar_sb3.maps.files import load_map as load_map
    from hexwar_sb3.maps.files import load_scenario as load_scenario
    from hexwar_sb3.players.frozen import FrozenPolicy as FrozenPolicy
    from hexwar_sb3.players.terms import Terms as Terms

_HOMES = {
    "Decompress": "engine.orders",
    "Engine": "engine.batch",
    "FrozenPolicy": "players.frozen",
    "Game": "engine.game",
    "GetOff": "engine.orders",
    "GetOn": "engine.orders",
    "GuideShoot": "engine.orders",
    "HexWarError": "errors",
    "Hide": "engine.orders",
    "IllegalOrderWarning": "engine.game",
    "IndirectShoot": "engine.orders",
    "HierarchicalQMIX": "algorithms.hierarchical",
    "JointActionEnv": "envs.joint_action",
    "MaskedDQN": "algorithms.masked_dqn",
    "MaskedQRDQN": "algorithms.masked_dqn",
    "Move": "engine.orders",
    "Null": "engine.orders",
    "Occupy": "engine.orders",
    "QMIX": "algorithms.qmix",
    "Replay": "engine.replay",
    "Shoot": "engine.orders",
    "SideView": "engine.view",
    "Stop": "engine.orders",
    "Terms": "players.terms",
    "load_map": "maps.files",
    "load_scenario": "maps.files",
    "make_vec_env": "envs.registration",
    "play_match": "evaluation.matches",
}
_LINKS = ("callbacks", "policies", "tuning")  # folders of the root that belong to this package

__all__ = [*_HOMES, "rules"]  # noqa: PLE0604  (all of them are strings)

# A link that arrived as a text file (ZIP download, Windows checkout) is no folder: look in the root.
_here = Path(__file__).parent
if any((_here / link).is_file() for link in _LINKS):
    __path__.append(str(_here.parent))

import_module("hexwar_sb3.envs")  # registers the ids for `gymnasium.make`


def __getattr__(name: str) -> object:
    """Import a public name when it is first used (PEP 562)."""
    if name == "rules":
        return import_module("hexwar_sb3.rules")
    if name not in _HOMES:
        raise AttributeError(f"module 'hexwar_sb3' has no attribute {name!r}")
    return getattr(import_module(f"hexwar_sb3.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """List the public names, imported or not."""
    return sorted({*globals(), *__all__})
