"""A hexagonal war game under fog, and hierarchical reinforcement learning on it with Stable-Baselines3.

Every public name (`__init__.pyi`) is imported when it is first used: the game needs no torch, and a script
that only plays does not wait for it.
"""

from importlib import import_module
from pathlib import Path

from lazy_loader import attach_stub

from hexwar_sb3.version import __version__ as __version__

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)

# A link that arrived as a text file (ZIP download, Windows checkout) is no folder: look in the root.
_here = Path(__file__).parent
if any((_here / link).is_file() for link in ("callbacks", "policies", "tuning")):
    __path__.append(str(_here.parent))

import_module("hexwar_sb3.envs")  # registers the ids for `gymnasium.make`
