"""The direct method: motions with their contacts from one NLP, robots' dynamics as CasADi expressions."""

from surefoot.planning.direct.planner import DirectPlan as DirectPlan
from surefoot.planning.direct.planner import plan_direct as plan_direct
from surefoot.planning.direct.planner import plan_with_modes as plan_with_modes
from surefoot.planning.direct.problem import DirectProblem as DirectProblem
from surefoot.planning.direct.problem import Weights as Weights
from surefoot.planning.transcription.contact_rows import Facets as Facets
from surefoot.planning.transcription.contact_rows import GivenModes as GivenModes
from surefoot.planning.transcription.guess import Guess as Guess
from surefoot.planning.transcription.planar import planar_hopper as planar_hopper
from surefoot.planning.transcription.touches import PlanarTouch as PlanarTouch
from surefoot.planning.transcription.window import StateWindow as StateWindow
from surefoot.robot.symbolic_body import SymbolicBody as SymbolicBody
