"""The direct method: motions with their contacts from one NLP, robots' dynamics as CasADi expressions."""

from surefoot.planning.direct.planner import DirectPlan, plan_direct, plan_with_modes
from surefoot.planning.direct.problem import DirectProblem, Weights
from surefoot.planning.transcription.contact_rows import Facets, GivenModes
from surefoot.planning.transcription.guess import Guess
from surefoot.planning.transcription.planar import planar_hopper
from surefoot.planning.transcription.touches import BodyTouch
from surefoot.planning.transcription.window import StateWindow
from surefoot.robot.symbolic_body import SymbolicBody

__all__ = [
    "BodyTouch",
    "DirectPlan",
    "DirectProblem",
    "Facets",
    "GivenModes",
    "Guess",
    "StateWindow",
    "SymbolicBody",
    "Weights",
    "plan_direct",
    "plan_with_modes",
    "planar_hopper",
]
