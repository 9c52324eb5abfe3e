from .album import Album as Album
from .album import Clip as Clip
from .gif import save_gif as save_gif
from .page import replay_page as replay_page
from .page import save_page as save_page
from .show import Shown as Shown
from .show import show as show
from .story import stories as stories
