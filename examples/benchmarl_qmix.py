"""BenchMARL's QMIX on the PettingZoo view: eight games of red against MA1, half a minute.

    pip install benchmarl; python examples/benchmarl_qmix.py

Pieces see their own features and task rows, the mixer the state; raise the numbers of `config` for a training.
"""

from benchmarl.algorithms import QmixConfig
from benchmarl.environments.pettingzoo.common import PettingZooClass
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models import MlpConfig
from torchrl.envs import FlattenObservation, PettingZooWrapper

from hexwar_sb3.envs import hexwar_task_v0


class HexWar(PettingZooClass):
    """One camp as BenchMARL's group "red"; its config is the settings of the env."""

    def get_env_fun(self, num_envs, continuous_actions, seed, device):
        def make():
            game = hexwar_task_v0.parallel_env(camps="red", **self.config)
            return PettingZooWrapper(
                game,
                categorical_actions=True,
                use_mask=True,
                return_state=True,
                group_map={"red": game.possible_agents},
                seed=seed,
                device=device,
            )

        return make

    def get_env_transforms(self, env):
        return [FlattenObservation(-2, -1, in_keys=[("red", "observation", "tasks")])]

    def supports_discrete_actions(self):
        return True

    def has_state(self):
        return True

    def has_render(self, env):
        return False

    def max_steps(self, env):
        return 1800 // self.config.get("decision_ticks", 75)


config = ExperimentConfig.get_from_yaml()
config.max_n_frames, config.off_policy_collected_frames_per_batch = 192, 96
config.off_policy_n_envs_per_worker, config.off_policy_n_optimizer_steps = 2, 4
config.off_policy_memory_size, config.off_policy_train_batch_size = 500, 32
config.evaluation_interval, config.evaluation_episodes, config.render = 96, 1, False
config.loggers, config.create_json = [], False
Experiment(
    task=HexWar("HEXWAR", {"opponent": "MA1", "reward": "net"}),
    algorithm_config=QmixConfig.get_from_yaml(),
    model_config=MlpConfig.get_from_yaml(),
    critic_model_config=MlpConfig.get_from_yaml(),
    seed=0,
    config=config,
).run()
