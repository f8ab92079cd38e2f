"""The direct method: motions with their contacts from one NLP, robots' dynamics as CasADi expressions."""

from surefoot.planning.direct.contact_rows import Facets, GivenModes, RoundCone
from surefoot.planning.direct.guess import Guess
from surefoot.planning.direct.motions import finer, rest_to_rest
from surefoot.planning.direct.planar import planar_biped, planar_hopper
from surefoot.planning.direct.planner import DirectPlan, plan_direct, plan_with_modes
from surefoot.planning.direct.problem import DirectProblem, Weights, Window
from surefoot.planning.direct.symbolic_body import SymbolicBody

__all__ = [
    "DirectPlan",
    "DirectProblem",
    "Facets",
    "GivenModes",
    "Guess",
    "RoundCone",
    "SymbolicBody",
    "Weights",
    "Window",
    "finer",
    "plan_direct",
    "plan_with_modes",
    "planar_biped",
    "planar_hopper",
    "rest_to_rest",
]
