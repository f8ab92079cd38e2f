"""A contact sequence: who touches where, for how long, with which cone, and which forces are meant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number, whole_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, check_name, count_of
from surefoot.contact import Fit
from surefoot.mechanics.robot.outlines import inner_rectangle
from surefoot.mechanics.stance import HalfSpaces, SoleContact, Stance


@dataclass(frozen=True, eq=False)
class SequencePhase:
    """A time during which the same frames touch the ground.

    Attributes
    ----------
    duration
        [s], positive.
    stance
        The contacts, each named by the frame that touches; without any in flight.
    forces
        (dim,) what the contacts are meant to carry, stacked, in contact frames [N, N m]; None where nothing
        is meant, and in flight.

    Raises
    ------
    ProblemError
        For a duration that is not positive, and forces that do not fit the stance.
    """

    duration: float
    stance: Stance
    forces: FloatArray | None = None

    def __post_init__(self) -> None:
        length = real_number("duration", self.duration, low=0.0)
        if not 0.0 < length < math.inf:
            raise ProblemError(f"the duration of a phase must be positive and finite [s], got {length:g}")
        object.__setattr__(self, "duration", length)
        if self.forces is not None and not self.stance.dim:
            object.__setattr__(self, "forces", None)
        elif self.forces is not None:
            object.__setattr__(self, "forces", finite_array("forces", self.forces, (self.stance.dim,)))

    @property
    def names(self) -> tuple[str, ...]:
        """The frames that touch."""
        return self.stance.names


@dataclass(frozen=True, eq=False, repr=False)
class ContactSequence(Drawn):
    """Phases in a row, and how their cones become half-spaces.

    Attributes
    ----------
    phases
        In the order of time, at least one.
    frames
        Every frame that may touch; those that a phase does not name are in the air.
    robot
        Its name.
    mass
        Of the robot [kg]; 0 where it is not known.
    facets
        Sides of the friction pyramids, at least 3.
    fit
        "inner" or "outer".

    Raises
    ------
    ProblemError
        For no phases, a contact whose frame is not in `frames`, a frame twice in a phase, or values out of
        range.

    Examples
    --------
    >>> from surefoot.mechanics.stance import PointContact
    >>> feet = [PointContact((x, y, 0.0), name=n) for n, x, y in (("L", 0.0, 0.1), ("R", 0.0, -0.1))]
    >>> phases = [SequencePhase(0.3, Stance(feet)), SequencePhase(0.2, Stance(feet[:1]))]
    >>> sequence = ContactSequence(phases, ("L", "R"), robot="biped", mass=30.0)
    >>> sequence.duration, sequence.touching(0.4)
    (0.5, ('L',))
    """

    phases: Sequence[SequencePhase]
    frames: Sequence[str]
    robot: str = ""
    mass: float = 0.0
    facets: int = 8
    fit: Fit = "inner"

    def __post_init__(self) -> None:
        object.__setattr__(self, "phases", tuple(self.phases))
        object.__setattr__(self, "frames", tuple(map(str, self.frames)))
        object.__setattr__(self, "mass", real_number("mass", self.mass, low=0.0, high=1e12))
        whole_number("facets", self.facets, low=3)
        check_name("fit", self.fit, get_args(Fit))
        if not self.phases:
            raise ProblemError("a contact sequence needs at least one phase")
        if len(set(self.frames)) != len(self.frames):
            raise ProblemError(f"the frames must differ, got {', '.join(self.frames)}")
        for k, phase in enumerate(self.phases):
            for name in phase.names:
                check_name("frame", name, self.frames, f"phases[{k}]")
            if len(set(phase.names)) != len(phase.names):
                raise ProblemError(f"phases[{k}] has a frame twice: {', '.join(phase.names)}")

    def __repr__(self) -> str:
        return f"ContactSequence({self.robot!r}, {len(self.phases)} phases, {len(self.frames)} frames)"

    def __str__(self) -> str:
        who = f" of {self.robot}" if self.robot else ""
        touch = ", ".join(self.frames[:8]) + (" ..." if len(self.frames) > 8 else "")
        phases = count_of(len(self.phases), "phase")
        return f"Contact sequence{who}: {phases} in {self.duration:.4g} s; what may touch: {touch}."

    @property
    def duration(self) -> float:
        """Length of all phases [s]."""
        return float(sum(phase.duration for phase in self.phases))

    @property
    def switching(self) -> FloatArray:
        """(phases + 1,) when phases begin and end, from 0 [s]."""
        return np.concatenate([[0.0], np.cumsum([phase.duration for phase in self.phases])])

    def phase_at(self, time: float) -> int:
        """Return the phase of a time [s]: the later one at a switch, the nearest outside."""
        last = len(self.phases) - 1
        return int(np.clip(np.searchsorted(self.switching, time, side="right") - 1, 0, last))

    def touching(self, time: float) -> tuple[str, ...]:
        """Return the frames that touch at a time [s]."""
        return self.phases[self.phase_at(time)].names

    def halfspaces(self, phase: int) -> HalfSpaces:
        """Return the half-spaces of a phase's stacked forces, in contact frames."""
        return self.phases[phase].stance.halfspaces(self.facets, self.fit)


def rectangle_of(contact: SoleContact) -> tuple[float, float]:
    """Return length and width [m] of a contact's sole, of any other polygon those of a rectangle inside it.

    The rectangle is about the contact's frame: the largest one in the polygon, made even about the frame.

    Raises
    ------
    ProblemError
        For a sole that does not reach to all sides of its frame.
    """
    length, width = contact.sole.length, contact.sole.width
    if length is not None and width is not None:
        return length, width
    low, high = inner_rectangle(contact.sole.corners)
    half = np.minimum(-low, high)
    if not (half > 0.0).all():
        raise ProblemError(f"no rectangle about the frame of {contact.name} is inside its {contact.sole!r}")
    return 2.0 * float(half[0]), 2.0 * float(half[1])
