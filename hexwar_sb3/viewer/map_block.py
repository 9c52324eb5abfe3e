"""The map of a page: once for all games on it, by the hash of what is drawn."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.map_file import map_document

_HIDDEN = ("seed", "hash", "controllable")  # a camp's own record has no seed and no hash, either


def map_block(hexmap: HexMap) -> dict[str, Any]:
    """What a page has of a map: a map document without what nobody draws."""
    return {key: value for key, value in map_document(hexmap).items() if key not in _HIDDEN}


def map_key(hexmap: HexMap) -> str:
    """Name of a map within a page: equal maps have equal names."""
    return hashlib.sha256(json.dumps(map_block(hexmap)).encode()).hexdigest()[:16]
