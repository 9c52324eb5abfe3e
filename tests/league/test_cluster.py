"""The same league and tournament on a real Ray cluster: three machines that share no folder, one of which dies."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest

from hexwar_sb3.cli import parse
from hexwar_sb3.errors import ClusterError
from hexwar_sb3.evaluation.cluster import working_on
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.league.league import League
from tests.league.test_league import contents
from tests.ray_nodes import Node, three_nodes, until

WORK_S = 300
Nodes = tuple[str, list[Node]]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(1800),  # nodes start one after the other, and workers import all they need
    pytest.mark.skipif(find_spec("ray") is None, reason="ray is not installed"),
    pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="finds a node's processes in /proc"),
]


@pytest.fixture(scope="module")
def nodes() -> Iterator[Nodes]:
    """Three machines."""
    with three_nodes() as found:
        yield found


def _where(_: int) -> tuple[str, str]:
    return os.environ["HOME"], str(Path.cwd())


def test_every_machine_works_in_folders_of_its_own(nodes: Nodes) -> None:
    with working_on(nodes[0]) as jobs:
        assert jobs == 3
        found = run_jobs(_where, list(range(12)), jobs, "place")

    assert {home for home, _ in found} <= {str(node.folder / "home") for node in nodes[1]}
    assert str(Path.cwd()) not in {place for _, place in found}


def test_a_tournament_on_a_cluster_has_the_files_of_one_here(nodes: Nodes, tmp_path: Path) -> None:
    common = ["tournament", "MA1", "nearest", "HRL0", "--games", "2", "--no-record"]
    for name, where in (("here", []), ("there", ["--cluster", nodes[0]])):
        assert parse([*common, "--output", str(tmp_path / name), *where]).run() == 0

    here, there = (contents(tmp_path / name / "matches") for name in ("here", "there"))
    assert len(here) == 6
    assert here == there


def test_errors_of_workers_are_ours(nodes: Nodes) -> None:
    with pytest.raises(ClusterError, match=r": ZeroDivisionError: .*zero$"), working_on(nodes[0]) as jobs:
        run_jobs(_divide, [1, 0, 1], jobs, "quotient")


def _divide(number: int) -> float:
    return 1 / number


def test_a_job_whose_process_is_lost_again_and_again_is_an_error(nodes: Nodes) -> None:
    with pytest.raises(ClusterError, match=f"the cluster at {nodes[0]}: "), working_on(nodes[0], 1) as jobs:
        run_jobs(os._exit, [1], jobs, "end")


def test_a_league_ends_the_same_though_a_machine_dies(
    whole: League, starters: dict[str, Path], tmp_path: Path, nodes: Nodes
) -> None:
    """The last test of this file: one machine fewer is left."""
    address, (_, _, third) = nodes
    league = League.create(tmp_path, replace(whole.settings, iterations=1), starters)
    begun, died = threading.Event(), threading.Event()

    def kill_at_work() -> None:
        begun.wait(WORK_S)
        left = third.jobs()
        until(lambda: bool(third.jobs() - left), WORK_S)
        third.kill()
        died.set()

    killer = threading.Thread(target=kill_at_work)
    killer.start()
    with working_on(address) as jobs:
        league.run(jobs, after=lambda k: begun.set() if k == 0 else None)
    killer.join()

    assert died.is_set()
    assert contents(league.iteration(0)) == contents(whole.iteration(0))
    assert contents(league.iteration(1)) == contents(whole.iteration(1))
