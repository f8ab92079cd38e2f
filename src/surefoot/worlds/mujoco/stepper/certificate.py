"""What a step was asked to do, and what was solved in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypedDict

from surefoot.contact import Status


class StepperOptions(TypedDict, total=False):
    """Options of `MujocoStepper` that others hand on."""

    restitution: float
    share: float
    soft: str | Sequence[str]
    tol: float


class StepCertificate(NamedTuple):
    """What was solved in a step.

    Attributes
    ----------
    status
        SOLVED to the tolerance, ALMOST to 1e-6, STALLED: the step's constraints are MuJoCo's soft ones.
    velocity_error
        Largest over the connected parts: error of the laws over the speed at which rows would move without
        impulses [-].
    speed
        The largest such speed [m/s].
    blocks
        Contacts, limits, equalities and dry joints.
    iterations
        Newton steps, all parts together.
    violation
        Largest penetration and error of an equality at the step's start [m, rad].
    """

    status: Status
    velocity_error: float
    speed: float
    blocks: int
    iterations: int
    violation: float
