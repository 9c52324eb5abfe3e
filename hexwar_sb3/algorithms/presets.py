"""Named settings of QMIX for the task env."""

from __future__ import annotations

from typing import Any

PRESETS: dict[str, dict[str, Any]] = {
    "default": {},
    # Section IV to the letter: learning rate 0.1, a = 0.1, epsilon 0.5 minus 0.01 every 100 episodes down to 0.05;
    # no n-step returns, no sticky exploration. With Adam such a learning rate learns nothing.
    "paper": {
        "learning_rate": 0.1,
        "tau": 0.1,
        "n_steps": 1,
        "stickiness": 0.0,
        "exploration_initial_eps": 0.5,
        "exploration_final_eps": 0.05,
        "exploration_episodes": 4_500,
        "exploration_every": 100,
    },
}
"""Arguments of `QMIX` that differ from its defaults."""
