"""The same league on a real Ray cluster of two workers."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pathlib import Path

import joblib
import pytest

from hexwar_sb3.league.league import League
from tests.league.test_league import contents


@pytest.mark.slow
@pytest.mark.timeout(900)  # every stage starts workers anew
def test_ray_workers_make_the_same_league_as_one_process(
    whole: League, starters: dict[str, Path], tmp_path: Path
) -> None:
    ray = import_module("ray")  # the extra of that name
    league = League.create(tmp_path, replace(whole.settings, iterations=1), starters)
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        import_module("ray.util.joblib").register_ray()
        with joblib.parallel_config("ray", n_jobs=2):
            league.run(jobs=2)
    finally:
        ray.shutdown()

    assert contents(league.iteration(1)) == contents(whole.iteration(1))
