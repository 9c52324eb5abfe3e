"""MaskablePPO on the task env, small: it learns by the masks, stops after its games and leaves a page."""

from __future__ import annotations

import json
from pathlib import Path

from sb3_contrib import MaskablePPO

from hexwar_sb3.commands.task_ppo import TaskPpo


def test_a_training_leaves_a_page_and_a_model_that_plays(tmp_path: Path) -> None:
    settings = TaskPpo(
        games=4,
        n_envs=2,
        n_steps=24,
        eval_freq=2,
        eval_games=1,
        final_games=1,
        constant_plans=False,
        runs=tmp_path,
    )

    assert settings.run() == 0

    folder = tmp_path / "task_ppo_1"
    page = json.loads((folder / "page.json").read_text(encoding="utf-8"))
    assert {row["player"] for row in page["rows"]} == {"untrained", "trained"}
    assert page["n_timesteps"] == 4 * 24
    assert "What MaskablePPO learned" in (folder / "page.txt").read_text(encoding="utf-8")
    assert MaskablePPO.load(folder / "best_model.zip").num_timesteps >= 0
