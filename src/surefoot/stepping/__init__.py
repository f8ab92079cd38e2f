"""Contact detection and one step of a robot on the ground, as values and functions of the state."""

from surefoot.stepping.derivative import StepDerivative as StepDerivative
from surefoot.stepping.derivative import step_derivative as step_derivative
from surefoot.stepping.detection import Contacts as Contacts
from surefoot.stepping.knot import Knot as Knot
from surefoot.stepping.momentum_knot import MomentumKnot as MomentumKnot
from surefoot.stepping.options import StepOptions as StepOptions
from surefoot.stepping.state import State as State
from surefoot.stepping.state import Step as Step
from surefoot.stepping.stepper import Stepper as Stepper
