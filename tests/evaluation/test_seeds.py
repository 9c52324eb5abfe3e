from __future__ import annotations

import itertools
import re
from pathlib import Path

import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.seeds import SEEDS_PER_PURPOSE, Purpose, seed_for


def test_the_ranges_do_not_overlap() -> None:
    ends = [(seed_for(purpose, 0), seed_for(purpose, SEEDS_PER_PURPOSE - 1)) for purpose in Purpose]

    assert all(last < first for (_, last), (first, _) in itertools.pairwise(ends))


def test_the_page_lists_the_ranges_of_the_code() -> None:
    page = (Path(__file__).parents[2] / "docs" / "seeds.md").read_text(encoding="utf-8")

    listed = re.findall(r"^\| (\w+) \| (\d+) \| (\d+) \|", page, re.MULTILINE)

    assert listed == [
        (purpose.name.lower(), str(seed_for(purpose, 0)), str(seed_for(purpose, SEEDS_PER_PURPOSE - 1)))
        for purpose in Purpose
    ]


@pytest.mark.parametrize("seed", [-1, SEEDS_PER_PURPOSE])
def test_a_seed_outside_its_range_is_refused(seed: int) -> None:
    with pytest.raises(ConfigError, match=rf"seed must be in 0..999999, got {seed}"):
        seed_for(Purpose.REPORT, seed)
