from .frozen import FrozenPolicy as FrozenPolicy
from .frozen_lower import FrozenLower as FrozenLower
from .frozen_lower import make_lower as make_lower
from .player import Player as Player
from .player import make_player as make_player
from .terms import Terms as Terms
from .terms import trained_terms as trained_terms
