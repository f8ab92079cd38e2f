"""Contact detection and one step of a robot on the ground, as values and functions of the state."""

from surefoot.stepping.derivative import StepCotangents, StepDerivative, StepTangents, step_derivative
from surefoot.stepping.detection import Contacts
from surefoot.stepping.knot import Knot
from surefoot.stepping.options import StepOptions
from surefoot.stepping.state import Impact, State, Step
from surefoot.stepping.stepper import Stepper

__all__ = [
    "Contacts",
    "Impact",
    "Knot",
    "State",
    "Step",
    "StepCotangents",
    "StepDerivative",
    "StepOptions",
    "StepTangents",
    "Stepper",
    "step_derivative",
]
