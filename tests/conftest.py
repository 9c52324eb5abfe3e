"""What all tests share: kernels are compiled once, before the tests run side by side."""

from __future__ import annotations

import os

import pytest


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile what nearly every test needs before workers start, so that they do not all compile the same."""
    workers = getattr(session.config.option, "numprocesses", None)
    if workers and "PYTEST_XDIST_WORKER" not in os.environ:
        from hexwar_sb3.envs.registration import make_vec_env
        from hexwar_sb3.evaluation.matches import play_match

        play_match("MA1", "MA2", games=1)
        env = make_vec_env(n_envs=1, privileged_state=True)
        obs = env.reset()
        env.step(obs["action_mask"].argmax(axis=-1))  # type: ignore[call-overload]  # a Dict env gives a dict
