from .final import compare as compare
from .objective import Common as Common
from .pictures import draw_study as draw_study
from .study import StudySpec as StudySpec
from .study import best_trial as best_trial
from .study import run_study as run_study
