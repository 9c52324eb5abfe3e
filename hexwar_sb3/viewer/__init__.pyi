from .events import save_events as save_events
from .gif import save_gif as save_gif
from .moment import save_moment as save_moment
from .page import replay_page as replay_page
from .page import save_page as save_page
from .show import Shown as Shown
from .show import show as show
from .story import stories as stories
