from .cooperative import as_parallel as as_parallel
from .flat_env import FlatEnv as FlatEnv
from .joint_action import JointActionEnv as JointActionEnv
from .parallel import parallel_env as parallel_env
from .registration import make_vec_env as make_vec_env
from .registration import register_envs as register_envs
from .route_env import RouteEnv as RouteEnv
from .task_env import TaskEnv as TaskEnv
