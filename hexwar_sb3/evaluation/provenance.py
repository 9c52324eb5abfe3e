"""What a figure depends on beside its command and seed: software, rules, scenario and bots."""

from __future__ import annotations

from hexwar_sb3.bots.config import bots_hash
from hexwar_sb3.bots.registry import BOTS_VERSION
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.version import __version__


def provenance(scenario: ScenarioLike) -> dict[str, str]:
    """Name versions and hashes; they stand in every result file."""
    world = load_world(scenario)
    return {
        "software": __version__,
        "rules": f"{world.ruleset.version} {world.ruleset.hash}",
        "scenario": f"{world.scenario.name} {world.scenario.hash}",
        "bots": f"{BOTS_VERSION} {bots_hash()}",
    }
