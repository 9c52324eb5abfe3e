"""How a lower level leads on maps that it knows and on maps that it never saw (learning.md, section 2; IV-D).

`python -m hexwar_sb3.experiments.routes POLICY --output results/routes`
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.evaluation.routes import measure_routes
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.files import replacing
from hexwar_sb3.maps.files import load_map, load_scenario
from hexwar_sb3.maps.generator import standard_scenario
from hexwar_sb3.maps.hexmap import LAYERS, HexMap
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.maps.spec import STANDARD

UNSEEN_SEED = 1001  # of the generator; the built-in maps have others


def unseen() -> Scenario:
    """A map like "hills" from another seed."""
    return load_scenario(f"hills@{UNSEEN_SEED}")


def asymmetric() -> Scenario:
    """A map whose west is like "paddy" and whose east is like "hills"."""
    west, east = (load_map(f"{name}@{UNSEEN_SEED}") for name in ("paddy", "hills"))
    return standard_scenario(_joined(west, east))


def _joined(west: HexMap, east: HexMap) -> HexMap:
    in_east = np.arange(west.width) > west.width // 2
    layers = {
        name: np.where(in_east, getattr(east, name), getattr(west, name)) for name in (*LAYERS, "elev_m")
    }
    return replace(west, name="asymmetric", seed=None, **layers)


def scenarios() -> dict[str, Scenario]:
    """Maps of the report: the built-in ones, and two that nobody trains on."""
    known = {name: load_scenario(name) for name in STANDARD}
    return {**known, "unseen": unseen(), "asymmetric": asymmetric()}


def report(lower: object, routes: int, seed: int = 0) -> list[dict[str, Any]]:
    """Measure a lower level on every map: one row a map and type of piece.

    Args:
        lower: as `make_lower` takes it.
        routes: of each piece of a scenario.
        seed: of the goals, shifted into the range of reported games.
    """
    shifted = seed_for(Purpose.REPORT, seed)
    return [
        {"map": name, **result.summary()}
        for name, scenario in scenarios().items()
        for result in measure_routes(lower, scenario, routes, shifted)
    ]


def text(rows: list[dict[str, Any]]) -> str:
    """Give the rows as a table."""
    lines = [f"{'map':<11} {'piece':<10} {'routes':>6} {'finished':>9} {'agreement':>9} {'slowness':>8}"]
    lines += [
        f"{row['map']:<11} {row['piece']:<10} {row['routes']:>6} {row['finished']:>9.1%} {row['agreement']:>9.1%}"
        f" {row['slowness']:>8.3f}"
        for row in rows
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure a lower policy, print the table and keep it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("policy", help='folder of a policy or run, or "heuristic"')
    parser.add_argument("--routes", type=int, default=200, help="routes of each piece")
    parser.add_argument("--output", type=Path, default=None, help="folder for routes.json and routes.txt")
    options = parser.parse_args()
    rows = report(options.policy, options.routes)
    sys.stdout.write(text(rows))
    if options.output is not None:
        figures = {"policy": options.policy, "routes": options.routes, **provenance("plain"), "rows": rows}
        for name, content in (
            ("routes.json", json.dumps(figures, indent=2) + "\n"),
            ("routes.txt", text(rows)),
        ):
            with replacing(options.output / name) as temporary:
                temporary.write_text(content, encoding="utf-8")


if __name__ == "__main__":
    main()
