from .features import feature_index as feature_index
from .hotspots import VisitCount as VisitCount
from .hotspots import hot_spots as hot_spots
from .picture import spots_picture as spots_picture
from .spots_file import HotSpots as HotSpots
