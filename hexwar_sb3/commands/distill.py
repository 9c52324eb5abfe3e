"""`hexwar distill`: several policies of one camp into one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from hexwar_sb3.commands.output import compile_first, print_json
from hexwar_sb3.commands.settings import Json, Seed
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.seeds import Purpose, seed_for

if TYPE_CHECKING:
    from hexwar_sb3.players.frozen import FrozenPolicy

TEACHERS = "run folders or policy folders"
N_ENVS = 32  # games of a teacher side by side


@dataclass(frozen=True, kw_only=True)
class Distill:
    """Let teachers play, and one student learn what they do; write the student's policy."""

    teachers: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="POLICY...", help=TEACHERS)
    ]
    output: Path = Path("distilled")  # folder of the student's policy
    # camp that the teachers play; else the one of their training
    side: Literal["red", "blue", "both"] | None = None
    opponents: tuple[str, ...] = ("MA1", "MA2")  # of the teachers: bots' names or policy folders
    games: int = 400  # that each teacher plays
    epsilon: float = 0.05  # probability of a random task in these games
    updates: int = 3_000  # of the student
    tau: float = 0.1  # temperature of choices: small is sharp
    seed: Seed = 0
    json: Json = False

    def run(self) -> int:
        """Teach, then save."""
        from hexwar_sb3.algorithms.qmix import QMIX
        from hexwar_sb3.commands.selfplay import policy_folder
        from hexwar_sb3.envs.registration import make_vec_env
        from hexwar_sb3.evaluation.matches import CAMPS
        from hexwar_sb3.folders import holding
        from hexwar_sb3.league.distil import Lessons, distill
        from hexwar_sb3.league.member import as_member
        from hexwar_sb3.league.work import env_settings
        from hexwar_sb3.players.frozen import FrozenPolicy
        from hexwar_sb3.players.terms import trained_terms
        from hexwar_sb3.rules.ruleset import default_rules

        lessons = Lessons(games=self.games, epsilon=self.epsilon, updates=self.updates, tau=self.tau)
        if not self.teachers:
            raise ConfigError("name a teacher: a run folder or a policy folder")
        seed_for(Purpose.TRAINING, self.seed)
        folders = [policy_folder(Path(teacher)) for teacher in self.teachers]
        teachers = [FrozenPolicy.load(folder, rules=default_rules().hash) for folder in folders]
        found = [trained_terms(teacher) for teacher in teachers]
        if any(other != found[0] for other in found):
            raise ConfigError(f"the teachers were trained in different ways: {found}")
        side = self.side or common_side(teachers, self.teachers)
        terms, camps = found[0], CAMPS if side == "both" else (side,)
        how = Evaluation(terms=terms, camps=camps)
        compile_first(*self.opponents, scenario=terms.scenario)
        how.check_fit(teachers, camps)
        how.check_opponents(self.opponents)
        env = {**env_settings(terms, N_ENVS), "side": side, "opponent": list(self.opponents)}
        student = QMIX(
            "TaskPolicy",
            make_vec_env("HexWarTask-v0", seed=self.seed, lower=teachers[0].lower, **env),
            seed=self.seed,
        )
        with holding(self.output, "policy"):
            losses = distill(teachers, student, env, lessons, self.seed)
            names = ", ".join(Path(teacher).name for teacher in self.teachers)
            as_member(student, side=side, teachers=names, **terms.about()).save(self.output)
        figures = {"policy": str(self.output), "teachers": list(self.teachers), "loss": losses[-1]}
        if self.json:
            print_json(figures)
        else:
            print(f"policy: {self.output}; its choices differ from its teachers' by {losses[-1]:.3f} (KL)")
        return 0


def common_side(teachers: Sequence[FrozenPolicy], names: Sequence[str]) -> str:
    """The camp that all teachers were trained in.

    Raises:
        ConfigError: they were trained in different ones.
    """
    sides = [teacher.about.get("side", "both") for teacher in teachers]
    if len(set(sides)) > 1:
        told = ", ".join(f"{name} {side}" for name, side in zip(names, sides, strict=True))
        raise ConfigError(
            f"the teachers were trained as different camps ({told}); --side says which they play"
        )
    return sides[0]
