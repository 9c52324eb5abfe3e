"""Settings that several commands share, with their flags."""

from __future__ import annotations

from typing import Annotated

import tyro

Json = Annotated[bool, tyro.conf.arg(help="print one JSON object instead of a table")]
Games = Annotated[int, tyro.conf.arg(help="games a cell of the table")]
Seed = Annotated[int, tyro.conf.arg(help="0..999999; the same seed gives the same games")]
DecisionTicks = Annotated[
    int, tyro.conf.arg(help="ticks between two decisions of a policy; as it was trained")
]
ScenarioName = Annotated[str, tyro.conf.arg(help="name of a built-in scenario, or path of a file")]
