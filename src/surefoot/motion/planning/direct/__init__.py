"""The direct method: motions with their contacts from one NLP, robots' dynamics as CasADi expressions."""

from surefoot.motion.planning.direct.direct_planner import DirectPlan as DirectPlan
from surefoot.motion.planning.direct.direct_planner import plan_direct as plan_direct
from surefoot.motion.planning.direct.direct_planner import plan_with_modes as plan_with_modes
from surefoot.motion.planning.symbolic.rigid_body import SymbolicBody as SymbolicBody
from surefoot.motion.planning.transcription.contact_pairs import PlanarContactPair as PlanarContactPair
from surefoot.motion.planning.transcription.contact_rows import Facets as Facets
from surefoot.motion.planning.transcription.contact_rows import GivenModes as GivenModes
from surefoot.motion.planning.transcription.direct_problem import DirectProblem as DirectProblem
from surefoot.motion.planning.transcription.direct_problem import Weights as Weights
from surefoot.motion.planning.transcription.initial_guess import Guess as Guess
from surefoot.motion.planning.transcription.planar import planar_hopper as planar_hopper
from surefoot.motion.planning.transcription.state_window import StateWindow as StateWindow
