from .encounters import Encounters as Encounters
from .match import MatchGames as MatchGames
from .match import play_games as play_games
from .recording import record_game as record_game
