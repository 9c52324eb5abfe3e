from .batch import Engine as Engine
from .game import Game as Game
from .picture import game_picture as game_picture
from .picture import save_game_picture as save_game_picture
from .replay import Replay as Replay
from .view import SideView as SideView
from .world import World as World
from .world import load_world as load_world
