from .files import load_map as load_map
from .files import load_scenario as load_scenario
from .files import save_map as save_map
from .files import save_scenario as save_scenario
from .picture import map_picture as map_picture
