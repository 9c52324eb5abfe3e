"""Where jobs are done, as far as no cluster is needed (tests/league/test_cluster.py has one)."""

from __future__ import annotations

import socket
from importlib.util import find_spec
from pathlib import Path

import joblib
import pytest

from hexwar_sb3.cli import parse
from hexwar_sb3.errors import ClusterError, ConfigError
from hexwar_sb3.evaluation import cluster
from hexwar_sb3.evaluation.cluster import HERE, RayTasks, is_elsewhere, working_on
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import make_player

needs_ray = pytest.mark.skipif(find_spec("ray") is None, reason="ray is not installed")


def test_without_a_cluster_jobs_stay_on_this_machine() -> None:
    with working_on(None) as jobs:
        assert jobs == 1
        assert not is_elsewhere()
    with working_on(None, 3) as jobs:
        assert jobs == 3


@pytest.mark.parametrize("name", ["loky", "threading", "multiprocessing", "sequential"])
def test_backends_of_joblib_are_of_this_machine(name: str) -> None:
    with joblib.parallel_config(name):
        assert not is_elsewhere()


def test_a_task_of_ray_is_done_elsewhere_even_if_it_is_the_only_one() -> None:
    assert RayTasks not in HERE
    assert RayTasks(side_by_side=1).effective_n_jobs(1) > 1  # else joblib would do it in this process


def test_without_ray_it_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "find_spec", lambda _: None)

    with pytest.raises(ConfigError, match=r'pip install "hexwar-sb3\[ray\]"'), working_on("127.0.0.1:6379"):
        pass


@needs_ray
@pytest.mark.parametrize(
    "address", ["", "auto", "host", "host:", ":1", "host:0", "host:70000", "ray://host:1"]
)
def test_an_address_is_a_host_and_a_port(address: str) -> None:
    with pytest.raises(ConfigError, match="a cluster's address is HOST:PORT"), working_on(address):
        pass


@needs_ray
def test_where_nobody_listens_it_says_so_at_once() -> None:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{one.getsockname()[1]}"

    with pytest.raises(ClusterError, match=f"the cluster at {address}: "), working_on(address):
        pass


@needs_ray
@pytest.mark.parametrize(
    "command",
    ["tournament MA1 nearest", "exploit MA1", "selfplay one", "experiments seeds", "experiments table1"],
)
def test_every_command_that_hands_jobs_over_asks_the_cluster(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    policy = make_player("HRL0")
    assert isinstance(policy, FrozenPolicy)
    policy.save("one")
    with pytest.raises(ConfigError, match="a cluster's address is HOST:PORT, got 'nowhere'"):
        parse([*command.split(), "--cluster", "nowhere"]).run()
