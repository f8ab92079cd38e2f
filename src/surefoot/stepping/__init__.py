"""Contact detection and one step of a robot on the ground, as values and functions of the state."""

from surefoot.stepping.derivative import StepDerivative, step_derivative
from surefoot.stepping.detection import Contacts
from surefoot.stepping.knot import Knot
from surefoot.stepping.momentum_knot import MomentumKnot
from surefoot.stepping.options import StepOptions
from surefoot.stepping.state import State, Step
from surefoot.stepping.stepper import Stepper

__all__ = [
    "Contacts",
    "Knot",
    "MomentumKnot",
    "State",
    "Step",
    "StepDerivative",
    "StepOptions",
    "Stepper",
    "step_derivative",
]
