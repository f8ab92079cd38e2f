"""Contact detection and one step of a robot on the ground, as values and functions of the state."""

from surefoot.mechanics.dynamics.derivative.step_derivative import StepDerivative as StepDerivative
from surefoot.mechanics.dynamics.derivative.step_derivative import step_derivative as step_derivative
from surefoot.mechanics.dynamics.detection import Contacts as Contacts
from surefoot.mechanics.dynamics.knot import Knot as Knot
from surefoot.mechanics.dynamics.knot import KnotStep as KnotStep
from surefoot.mechanics.dynamics.momentum_knot import MomentumKnot as MomentumKnot
from surefoot.mechanics.dynamics.options import StepOptions as StepOptions
from surefoot.mechanics.dynamics.state import State as State
from surefoot.mechanics.dynamics.state import Step as Step
from surefoot.mechanics.dynamics.stepper import Stepper as Stepper
