"""`hexwar maps`: the maps there are, their pictures, and new ones."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import tyro

from hexwar_sb3.checks import check_whole
from hexwar_sb3.commands.output import print_json, table
from hexwar_sb3.commands.settings import Json, check_name
from hexwar_sb3.errors import ConfigError

if TYPE_CHECKING:
    from hexwar_sb3.maps.spec import MapSpec

HEADS = ("map", "cells", "relief, m", "concealed", "slushy", "paved", "pieces", "points", "hash")


@dataclass(frozen=True, kw_only=True)
class Maps:
    """List maps, draw them, or make a new one from a seed."""

    names: tyro.conf.Positional[tuple[str, ...]] = ()  # names or scenario files; none: all built-in ones
    output: Path | None = None  # folder that gets a picture of each (NAME.png)
    new: str | None = None  # name of a new map and scenario, written to the folder --output
    like: str = "plain"  # built-in map that the new one is like
    seed: int = 0  # of the new map
    width: int | None = None  # of the new map, cells; else as the built-in one
    height: int | None = None  # of the new map, cells
    pieces: tuple[int, ...] | None = None  # of a camp, or of red and of blue, on the new map
    mirror: Literal["yes", "no"] | None = None  # west and east of the new map alike
    json: Json = False

    def run(self) -> int:
        """Print the list, and write what was asked for."""
        from hexwar_sb3.maps.files import builtin_names, load_scenario
        from hexwar_sb3.maps.picture import map_picture

        names = (str(self._make()),) if self.new else self.names or tuple(builtin_names())
        scenarios = [load_scenario(name) for name in names]
        rows = [describe(scenario) for scenario in scenarios]
        if self.json:
            print_json({"maps": rows})
        else:
            print(table(HEADS, [[str(value) for value in row.values()] for row in rows]))
        if self.output is not None:
            self.output.mkdir(parents=True, exist_ok=True)
            for scenario in scenarios:
                drawn = self.output / f"{_safe(scenario.name)}.png"
                map_picture(scenario.hexmap, scenario).savefig(drawn, dpi=110)
                print(f"picture: {drawn}", file=sys.stderr)
        return 0

    def _make(self) -> Path:
        """Write a new map and its scenario; return the scenario's path."""
        from hexwar_sb3.errors import UnknownNameError
        from hexwar_sb3.maps.files import builtin_names, save_map, save_scenario
        from hexwar_sb3.maps.generator import generate, standard_scenario
        from hexwar_sb3.maps.spec import MAP_SPECS

        if self.output is None:
            raise ConfigError("--new needs --output, the folder for the new files")
        check_name("new", str(self.new))
        check_whole("seed", self.seed, least=0)
        if self.new in builtin_names():
            raise ConfigError(f"{self.new!r} is a built-in map; give the new one another name")
        if self.like not in MAP_SPECS:
            raise UnknownNameError("map", self.like, MAP_SPECS)
        spec = self._spec(MAP_SPECS[self.like])
        hexmap = generate(spec)
        map_file, scenario_file = (self.output / f"{self.new}.{kind}.json" for kind in ("map", "scenario"))
        save_map(hexmap, map_file)
        save_scenario(standard_scenario(hexmap, spec.start), scenario_file, map_name=map_file.name)
        return scenario_file

    def _spec(self, like: MapSpec) -> MapSpec:
        """What the new map is to be like."""
        spec = replace(like, name=str(self.new), seed=self.seed)
        if (self.width or like.width, self.height or like.height) != (like.width, like.height):
            spec = spec.resized(self.width or like.width, self.height or like.height)
        if self.mirror is not None:
            spec = replace(spec, mirror=self.mirror == "yes")
        if self.pieces is None:
            return spec
        if len(self.pieces) not in (1, 2):
            raise ConfigError(
                f"--pieces takes a number for both camps, or one of each, got {len(self.pieces)}"
            )
        return replace(spec, start=replace(spec.start, pieces=(self.pieces[0], self.pieces[-1])))


def _safe(name: str) -> str:
    """A scenario's name, perhaps a stranger's, as a file's: no folders in it."""
    return re.sub(r"[^\w@.-]+", "_", name).lstrip(".") or "scenario"


def describe(scenario: Any) -> dict[str, Any]:
    """One row of the list; shares are of the playable cells."""
    hexmap = scenario.hexmap
    cells = int(hexmap.playable.sum())
    red = sum(piece.camp == 0 for piece in scenario.pieces)
    blue = len(scenario.pieces) - red
    return {
        "map": scenario.name,
        "cells": cells,
        "relief_m": int(hexmap.elev_m.max()),
        "concealed": f"{hexmap.concealed.sum() / cells:.0%}",
        "slushy": f"{hexmap.slushy.sum() / cells:.0%}",
        "paved": f"{hexmap.paved.sum() / cells:.1%}",
        "pieces": f"{red} against {blue}",
        "points": ", ".join(f"{point.name} {point.value}" for point in scenario.points),
        "hash": scenario.hash,
    }
