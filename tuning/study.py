"""A study: trials one after the other in each of some processes, on one storage; trials whose process died come again."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from shutil import make_archive
from socket import gethostname
from tempfile import TemporaryDirectory
from time import sleep
from typing import Any, TypeAlias

import optuna
from filelock import FileLock
from optuna.artifacts import FileSystemArtifactStore, upload_artifact
from optuna.distributions import (
    BaseDistribution,
    CategoricalDistribution,
    IntDistribution,
    distribution_to_json,
)
from optuna.exceptions import ExperimentalWarning, StorageInternalError
from optuna.storages import BaseStorage
from optuna.trial import BaseTrial, FrozenTrial, TrialState
from sqlalchemy.exc import SQLAlchemyError

from hexwar_sb3.algorithms.preset_file import load_preset, save_preset
from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.checks import check_whole
from hexwar_sb3.errors import ConfigError, FileFormatError, HexWarError, UnknownNameError, shortened
from hexwar_sb3.evaluation.opponents import with_weights
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.files import UNFINISHED, check_held, replacing
from hexwar_sb3.folders import holding, work_for_holder
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.players.player import BotPlayer, make_player
from hexwar_sb3.processes import end_with_parent, keep_memory, start_python
from hexwar_sb3.tuning.objective import Common, check, objective
from hexwar_sb3.tuning.samplers import SAMPLERS, make_sampler
from hexwar_sb3.tuning.space import Space, checked_point, first_point, short, space_of
from hexwar_sb3.tuning.store import JOURNAL, database_errors, open_storage
from hexwar_sb3.tuning.trials import check_trials
from hexwar_sb3.tuning.workers import WORKER, bury, ended, this_process

STORAGE = "HEXWAR_STUDY_STORAGE"  # environment of a study's processes: URL of its database
PRESET_FILE = "preset.json"  # of a study that was begun with one
TOLD = ("also", "preset", "sampler", "pruner")  # beside what all trials have in common
MAXIMIZE = optuna.study.StudyDirection.MAXIMIZE
POLL_S = 0.5
MOST_LOST = 3  # processes one after the other that end before they have a trial
REASON, REASON_LENGTH = "reason", 200  # attribute of a trial that failed by itself; characters
PRUNERS: dict[str, Callable[[], optuna.pruners.BasePruner]] = {
    "halving": partial(optuna.pruners.SuccessiveHalvingPruner, min_resource=1, reduction_factor=2),
    "median": partial(optuna.pruners.MedianPruner, n_startup_trials=5, n_warmup_steps=0),
    "none": optuna.pruners.NopPruner,
}
"""Steps are trainings, and all trials have the same seeds (`objective`): means at one step are over equal seeds.

"halving" looks after 1, 2, 4, ... trainings: a trial goes on if its mean so far is in the better half of all that came as
far until then, itself among them. "median" looks after each one, once five trials are completed: a trial goes on if its
mean so far, or an earlier one of its own, is no worse than the median of theirs after as many.
"""
Say = Callable[[str], object]
Worker: TypeAlias = "subprocess.Popen[bytes]"


@dataclass(frozen=True, kw_only=True)
class StudySpec:
    """All that a process needs to work on a study."""

    folder: Path  # gets journal, policies, artifacts
    storage: str | None = None  # URL of a database instead of the journal
    also: tuple[str, ...] = ()  # settings to search beside alpha, beta and Delta-t
    preset: str = "default"  # whose other settings all trials have
    sampler: str = "tpe"
    pruner: str = "halving"
    common: Common = field(default_factory=Common)

    def __post_init__(self) -> None:
        """Check the names.

        Raises:
            UnknownNameError: there is no such sampler, pruner, preset, setting or player.
            ConfigError: hot spots are searched, and a policy plays; the preset has another lower level, or a value
                outside of the space.
        """
        for what, name, known in (("sampler", self.sampler, SAMPLERS), ("pruner", self.pruner, PRUNERS)):
            if name not in known:
                raise UnknownNameError(what, name, known)
        preset = load_preset(self.preset)
        first_point(preset, self.space)
        if preset.lower != "learned":
            raise ConfigError(
                f"alpha and beta act through a lower level that learns; the preset's is {preset.lower}"
            )
        for what, players in (
            ("opponents", with_weights(self.common.opponents)),
            ("panel", self.common.panel),
        ):
            for player in players:
                if not isinstance(make_player(player), BotPlayer) and "spots" in self.also:
                    raise ConfigError(
                        f"{what}: {player} knows the hot spots of its training alone: leave it or spots out"
                    )

    @property
    def space(self) -> Space:
        """What is searched."""
        return space_of(self.also)

    def meaning(self) -> dict[str, Any]:
        """What must be equal for trials to be of one study, as JSON values."""
        hashes = provenance(self.common.scenario)
        del hashes["software"]
        space = {name: json.loads(distribution_to_json(one)) for name, one in self.space.items()}
        found = {"space": space, **asdict(self.common), "preset": asdict(load_preset(self.preset)), **hashes}
        return dict(json.loads(json.dumps(found)))

    def values(self) -> dict[str, Any]:
        """What `known_spec` reads, as JSON values."""
        found = {name: value for name, value in asdict(self).items() if name not in ("folder", "storage")}
        own = self.preset if self.preset in PRESETS else PRESET_FILE
        return dict(json.loads(json.dumps({**found, "preset": own})))

    def trial(self, number: int) -> Path:
        """Folder of a trial's preset and policies."""
        return self.folder / "trials" / str(number)

    def policies(self, number: int) -> Path:
        """Folder of a trial's policies, by the seeds of their trainings."""
        return self.trial(number) / "policies"

    def lock(self, number: int) -> Path:
        """File that the process of a trial holds."""
        return self.trial(number) / "lock"

    @property
    def own(self) -> Path:
        """Folder that one process at a time holds: the study's, or this machine's in it, where several share a database."""
        return self.folder if self.storage is None else self.folder / "machines" / gethostname()

    def load(self) -> optuna.Study:
        """Open the study."""
        return optuna.load_study(
            study_name=study_name(self.folder, self.storage),
            storage=open_storage(self.folder, self.storage),
            sampler=make_sampler(self.sampler, self.common.seed),
            pruner=PRUNERS[self.pruner](),
        )


def study_name(folder: Path, storage: str | None) -> str:
    """Name of a study in its storage: a journal has one study and may be moved, a database many."""
    return "study" if storage is None else folder.name


def known_spec(folder: Path, storage: str | None = None) -> StudySpec:
    """Read what a study was begun with.

    Raises:
        ConfigError: there is no such study, or it is not one of ours.
        FileFormatError: the journal is broken.
    """
    if storage is None and not (folder / JOURNAL).is_file():
        raise ConfigError(f"there is no study in {folder}")
    name, place = study_name(folder, storage), "its database" if storage else str(folder)
    attributes = _attributes(open_storage(folder, storage), name, place)
    if not isinstance(attributes.get("spec"), dict):
        raise ConfigError(f"there is no study {name!r} of `hexwar tune` in {place}")
    values = dict(attributes["spec"])
    common = read_fields(Common, values.pop("common", None), place, place="common", whole=True)
    found = read_fields(StudySpec, values, place, place="spec")
    if set(found) != set(TOLD):
        raise FileFormatError(place, "spec", found=", ".join(found), expected=", ".join(TOLD))
    preset = found["preset"]
    if preset not in (*PRESETS, PRESET_FILE):
        expected = f"one of {', '.join((*PRESETS, PRESET_FILE))}"
        raise FileFormatError(place, "spec.preset", found=preset, expected=expected)
    if preset == PRESET_FILE:
        found["preset"] = str(folder / PRESET_FILE)
    return StudySpec(folder=folder, storage=storage, common=Common(**common), **found)


def _attributes(storage: BaseStorage, name: str, place: str) -> dict[str, Any]:
    """What is said of a study in its storage; nothing if there is none of this name."""
    with _named(place):
        known = optuna.get_all_study_summaries(storage, include_best_trial=False)
    return next((one.user_attrs for one in known if one.study_name == name), {})


@contextmanager
def _named(place: str) -> Iterator[None]:
    """Say of what lies in a storage, perhaps a stranger's, that Optuna cannot read it.

    Raises:
        FileFormatError: it cannot.
    """
    try:
        yield
    except (HexWarError, OSError, SQLAlchemyError, StorageInternalError):
        raise
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
        raise FileFormatError(place, "study", found=found, expected="a study of `hexwar tune`") from error


def begin(spec: StudySpec, points: Iterable[object] = ()) -> optuna.Study:
    """Make the study with the paper's point first in line, or open it.

    Args:
        spec: the study; sampler and pruner may differ from those that it was begun with.
        points: further ones that come next, unless they were there; a setting that is not said is sampled.

    Raises:
        ConfigError: a study of that name searches another space, its trials are of another kind, it is not ours, or
            a point lies outside.
    """
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    coming = [checked_point(point, spec.space) for point in points]
    with _named(str(spec.folder)):
        study = _opened(spec)
        trials, direction = study.get_trials(deepcopy=False), study.direction
        known = study.user_attrs.get("meaning")
    meaning = spec.meaning()
    if known is None and (direction != MAXIMIZE or any(one.state != TrialState.WAITING for one in trials)):
        raise ConfigError(f"{spec.folder}: the study {study.study_name!r} is not one of `hexwar tune`")
    if known is not None and known != meaning:
        raise ConfigError(f"{spec.folder} holds another study: {_difference(known, meaning)}")
    check_trials(trials, spec.space, study.study_name)
    if known is None:
        coming = [first_point(load_preset(spec.preset), spec.space), *coming]
    if spec.preset not in PRESETS and not (spec.folder / PRESET_FILE).exists():
        save_preset(spec.folder / PRESET_FILE, load_preset(spec.preset), {"copy of": spec.preset})
    for point in coming:
        study.enqueue_trial(point, skip_if_exists=True)
    if study.user_attrs.get("spec") != spec.values():
        study.set_user_attr("spec", spec.values())
    if known is None:
        study.set_user_attr("meaning", meaning)
    return study


def _opened(spec: StudySpec) -> optuna.Study:
    """The study as it lies there, or a new one; a journal gets a line even of a creation that finds it there."""
    name, storage = study_name(spec.folder, spec.storage), open_storage(spec.folder, spec.storage)
    if name in optuna.get_all_study_names(storage):
        return optuna.load_study(study_name=name, storage=storage)
    return optuna.create_study(study_name=name, storage=storage, direction="maximize", load_if_exists=True)


def run_study(
    spec: StudySpec, n_trials: int, workers: int = 1, say: Say = print, points: Iterable[object] = ()
) -> optuna.Study:
    """Go on until a study has so many trials that ended, each in a process of its own.

    A trial whose process died fails, and its point comes again, once.

    Args:
        spec: the study.
        n_trials: of the whole study: completed, pruned, or failed by themselves.
        workers: trials side by side.
        say: told of every trial that ends.
        points: to try next, as of `begin`.

    Raises:
        ConfigError: no trial can be made as the study is set up, or processes cannot even begin one.
        BusyError: another process works on the study.
        FileNotFoundError: its folder was removed meanwhile.
        KeyboardInterrupt: it was stopped; what was running comes again.
    """
    check_whole("n_trials", n_trials, least=1)
    check_whole("workers", workers, least=1)
    if spec.storage is not None or not (spec.folder / JOURNAL).exists():
        check(load_preset(spec.preset), spec.common)
    with holding(spec.own, "study"):
        return _go_on(spec, begin(spec, points), n_trials, workers, say)


def _go_on(spec: StudySpec, study: optuna.Study, n_trials: int, workers: int, say: Say) -> optuna.Study:
    running, lost = list[Worker](), list[int]()
    told = {one.number for one in study.get_trials(deepcopy=False) if one.state.is_finished()}
    with _stopping(running, study, spec):
        while True:
            bury(study, spec.lock)
            trials = study.get_trials(deepcopy=False)
            _tell_new(trials, told, say)
            under_way = [one for one in trials if one.state == TrialState.RUNNING]
            mine = {_process(one): one for one in under_way}
            beginning = [one for one in running if (gethostname(), one.pid) not in mine]
            if len(running) < workers and ended(trials) + len(under_way) + len(beginning) < n_trials:
                running.append(_start(spec))
            elif running or under_way:  # others, too, may work on it, by its database
                sleep(POLL_S)
                _let_go(running, study, lost)
            else:
                return study


def best_trial(study: optuna.Study) -> FrozenTrial:
    """The completed trial that reached most.

    Raises:
        ConfigError: there is none.
    """
    return completed(study)[0]


def completed(study: optuna.Study, numbers: Sequence[int] = ()) -> list[FrozenTrial]:
    """Completed trials by number; where none is said, the one that reached most.

    Raises:
        ConfigError: there is none, or not of that number.
    """
    done = {one.number: one for one in study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))}
    if not done:
        raise ConfigError(f"{study.study_name}: no trial was completed")
    if missing := [number for number in numbers if number not in done]:
        raise ConfigError(
            f"{study.study_name}: trial {missing[0]} was not completed; these were: {', '.join(map(str, done))}"
        )
    best = max(done.values(), key=lambda one: (one.value, -one.number))
    return [done[number] for number in dict.fromkeys(numbers)] or [best]


def work(folder: Path) -> None:
    """Make one trial: what a process of a study does. A trial that raises fails, with its reason; the study goes on."""
    optuna.logging.set_verbosity(optuna.logging.CRITICAL)  # the study says what fails
    warnings.simplefilter("ignore", ExperimentalWarning)
    spec = known_spec(folder, os.environ.get(STORAGE))
    with ExitStack() as held:
        spec.load().optimize(partial(_trial, spec, held), n_trials=1, catch=(Exception,))


def _start(spec: StudySpec) -> Worker:
    """Start a process that makes a trial. The URL may hold a password: no argument, which others see."""
    storage = {} if spec.storage is None else {STORAGE: spec.storage}
    return start_python(["-m", "hexwar_sb3.tuning.study", str(spec.folder)], storage)


def _trial(spec: StudySpec, held: ExitStack, trial: optuna.Trial) -> float:
    folder = spec.trial(trial.number)
    check_held(spec.folder)
    folder.mkdir(parents=True, exist_ok=True)
    held.enter_context(FileLock(spec.lock(trial.number)))
    trial.set_user_attr(WORKER, this_process())
    try:
        point = {name: suggest(trial, name, one) for name, one in spec.space.items()}
        preset = load_preset(spec.preset).changed(point)
        save_preset(folder / "preset.json", preset, {"study": spec.folder.name, "trial": trial.number})
        try:
            return objective(trial, preset, spec.common, spec.policies(trial.number))
        finally:
            _keep_artifacts(spec, trial)
    except optuna.TrialPruned:
        raise
    except Exception as error:
        trial.set_user_attr(REASON, f"{type(error).__name__}: {error}"[:REASON_LENGTH])
        with replacing(folder / "error.txt") as temporary:
            temporary.write_text(traceback.format_exc(), encoding="utf-8", errors="backslashreplace")
        raise


def _keep_artifacts(spec: StudySpec, trial: optuna.Trial) -> None:
    """Make a trial's preset its artifact, and all its policies another."""
    base, folder, policies = spec.folder / "artifacts", spec.trial(trial.number), spec.policies(trial.number)
    base.mkdir(exist_ok=True)
    with TemporaryDirectory(prefix=UNFINISHED, dir=folder) as place:  # who is killed leaves nothing elsewhere
        files = [str(folder / "preset.json")]
        if policies.is_dir():
            files.append(make_archive(f"{place}/policies", "zip", policies))
        for file in files:
            upload_artifact(
                artifact_store=FileSystemArtifactStore(base_path=str(base)),
                file_path=file,
                study_or_trial=trial,
            )


def suggest(trial: BaseTrial, name: str, distribution: BaseDistribution) -> Any:
    """Draw a setting's value."""
    if isinstance(distribution, CategoricalDistribution):
        return trial.suggest_categorical(name, distribution.choices)
    ends = distribution.low, distribution.high  # type: ignore[attr-defined]
    if isinstance(distribution, IntDistribution):
        return trial.suggest_int(name, *ends, log=distribution.log)
    return trial.suggest_float(name, *ends, log=distribution.log)  # type: ignore[attr-defined]


def in_words(trial: FrozenTrial) -> str:
    """One line on a trial."""
    point = ", ".join(f"{name} {short(value)}" for name, value in trial.params.items())
    what = {
        TrialState.COMPLETE: f"{trial.value:+.3f}" if trial.value is not None else "",
        TrialState.PRUNED: f"pruned after training {len(trial.intermediate_values)}",
        TrialState.FAIL: trial.user_attrs.get(REASON, "failed"),
        TrialState.RUNNING: "its process is gone",
    }
    return f"trial {trial.number}: {what.get(trial.state, '')} ({point})"


def _process(trial: FrozenTrial) -> tuple[str, int] | None:
    """Host and number of the process that works on a trial."""
    worker = trial.user_attrs.get(WORKER)
    return None if worker is None else (worker["host"], worker["pid"])


def _tell_new(trials: list[FrozenTrial], told: set[int], say: Say) -> None:
    """Say what became of the trials that ended since the last time."""
    for trial in trials:
        if trial.state.is_finished() and trial.number not in told:
            told.add(trial.number)
            say(in_words(trial))


def _let_go(running: list[Worker], study: optuna.Study, lost: list[int]) -> None:
    """Forget the processes that ended; `lost` are the exit codes of those since the last one that had a trial.

    Raises:
        ConfigError: several one after the other had none.
    """
    for process in [one for one in running if one.poll() is not None]:
        running.remove(process)
        if (gethostname(), process.pid) in map(_process, study.get_trials(deepcopy=False)):
            lost.clear()
        else:
            lost.append(process.returncode)
        if len(lost) == MOST_LOST:
            raise ConfigError(f"{MOST_LOST} processes ended before they had a trial, with exit codes {lost}")


@contextmanager
def _stopping(running: list[Worker], study: optuna.Study, spec: StudySpec) -> Iterator[None]:
    """End the processes where the block ends early; their points come again. SIGTERM counts as Ctrl-C."""
    first = threading.current_thread() is threading.main_thread()  # signals are its own
    before = signal.signal(signal.SIGTERM, signal.default_int_handler) if first else None
    try:
        yield
    except BaseException:
        for process in running:
            process.kill()
        for process in running:
            process.wait()
        bury(study, spec.lock)
        raise
    finally:
        if first:
            signal.signal(signal.SIGTERM, before)


def _difference(known: Any, own: Any, name: str = "") -> str:
    """What differs, by name."""
    if isinstance(known, dict) and isinstance(own, dict):
        names = [key for key in {**known, **own} if known.get(key) != own.get(key)]
        return ", ".join(
            _difference(known.get(key), own.get(key), f"{name}.{key}".strip(".")) for key in names
        )
    found, asked = ("nothing" if one is None else str(one)[:60] for one in (known, own))
    return shortened(f"{name} {found}, not {asked}")


if __name__ == "__main__":
    end_with_parent()
    keep_memory()
    try:
        with database_errors():
            work_for_holder(Path(sys.argv[1]))
            work(Path(sys.argv[1]))
    except (HexWarError, OSError) as stopped:
        sys.exit(f"{stopped}")
