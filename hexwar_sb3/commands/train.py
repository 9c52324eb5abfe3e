"""`hexwar train`."""

from __future__ import annotations

from dataclasses import dataclass, replace

from hexwar_sb3.algorithms.preset_file import save_preset
from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.commands.output import compile_first, typed
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.train_settings import TrainSettings, settings_from


@dataclass(frozen=True, kw_only=True)
class Train(TrainSettings):
    """Train both levels of a commander in turn, then say what was learned.

    Settings without a value are the preset's.
    """

    def run(self) -> int:
        """Train, or go on with a training."""
        from hexwar_sb3.commands.training import go_on, make_env, new_model, train
        from hexwar_sb3.folders import holding

        self.check()
        if self.resume is not None:
            folder = RunFolder(self.resume)
            settings = settings_from(folder)
            settings = replace(settings, progress=self.progress, json=self.json, resume=self.resume)
            with holding(folder.path, "run"):
                compile_first()
                return train(settings, go_on(settings, folder), folder)
        if self.learns_from_replays:
            compile_first()  # they are played again first
        # A wrong setting shows here, before anything is compiled or written.
        model = new_model(self, make_env(self))
        compile_first()
        self.evaluation().check_opponents(self.named_opponents)
        folder = RunFolder.new(self.runs, self.name)
        with holding(folder.path, "run"):
            folder.write_config(replace(self, opponents=self.met), typed())
            if self.preset not in PRESETS:
                save_preset(folder.preset, self.loaded, {"copy of": self.preset})
                return train(replace(self, preset=str(folder.preset)), model, folder)
            return train(self, model, folder)
