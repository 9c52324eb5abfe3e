from .distil import Lessons as Lessons
from .distil import distill as distill
from .league import League as League
from .settings import LEARNER as LEARNER
from .settings import LeagueSettings as LeagueSettings
