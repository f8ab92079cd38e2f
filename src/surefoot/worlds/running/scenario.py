"""What happens to a robot in a run, as a value: disturbances, faults, where it starts, when it has fallen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number, whole_number
from surefoot.base.errors import ProblemError, shown
from surefoot.mechanics import Terrain
from surefoot.records import Ending
from surefoot.worlds.interface.world import World
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.sensors import SensorModel
from surefoot.worlds.running.walk_terrain import start_pose

START_SPEED = 0.01
"""Standard deviation of the seeded disturbance of the base's velocity at the start [m/s]."""
LONGEST = 1e6
"""Longest run [s]: eleven days."""
START_DEPTH = 1e-5
"""A robot that starts this deep in the ground has no foot in the air by rounding [m]."""


@dataclass(frozen=True)
class Push:
    """A (3,) force on the base in world axes [N], from `start` for `duration` [s]."""

    start: float
    force: tuple[float, float, float]
    duration: float


@dataclass(frozen=True)
class Ice:
    """The ground's friction becomes `mu` at `start` [s]."""

    start: float
    mu: float


@dataclass(frozen=True)
class IcePatch:
    """The ground's friction is `mu` where x and y lie from `lower` to `upper` [m], each (x, y)."""

    lower: tuple[float, float]
    upper: tuple[float, float]
    mu: float

    def __post_init__(self) -> None:
        numbers = (*self.lower, *self.upper)
        rising = all(a < b for a, b in zip(self.lower, self.upper, strict=True))
        if not (rising and all(map(math.isfinite, numbers))):
            raise ProblemError(
                f"a patch of ice reaches from (x0, y0) to a larger (x1, y1) [m], got {numbers}"
            )
        real_number("mu of a patch of ice", self.mu, low=0.0)


@dataclass(frozen=True)
class Fall:
    """When a robot counts as fallen.

    Attributes
    ----------
    height
        Its base is below this share of the height over the ground that it started with ...
    tilt
        ... or its vertical axis leans this far from the ground's normal [rad].
    """

    height: float = 0.4
    tilt: float = math.radians(60.0)

    def happened(self, q: FloatArray, height: float, terrain: Terrain) -> Ending | None:
        """Return FELL or INVALID when the (nq,) state says so, else None.

        Parameters
        ----------
        q
            (nq,) configuration, Pinocchio's order.
        height
            Of the base over the ground at the start [m].
        terrain
            The ground.
        """
        numbers = q.tolist()
        if not all(map(math.isfinite, numbers)):
            return Ending.INVALID
        if numbers[2] - float(terrain.height(q[:2])) < self.height * height:
            return Ending.FELL
        # the base's vertical axis is the last column of its rotation
        x, y, z, w = numbers[3:7]
        square = x * x + y * y + z * z + w * w
        up = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w + z * z - x * x - y * y
        along = sum(a * b for a, b in zip(up, terrain.normal(q[:2]).tolist(), strict=True))
        return Ending.FELL if along < math.cos(self.tilt) * square else None


STANDING_FALL = Fall(0.5, math.radians(50.0))
"""When a robot that should stand still counts as fallen."""


@dataclass(frozen=True)
class Scenario:
    """What happens to the robot; what it carries belongs to the world, what it is given to the controller.

    Attributes
    ----------
    duration
        Length of the run [s].
    mu
        Friction of the ground [-] at the start; None for the world's own.
    pushes, ice
        What disturbs it.
    patches
        Where the ground's friction is another.
    seed
        Seed of every random number of the run; None for no disturbance at the start.
    faults
        What is wrong with sensors and motors.
    start
        (nq,) configuration to start from [m, -, rad]; None for one that stands on the world's terrain.
    velocity
        (nv,) velocity to start with [m/s, rad/s]; None for rest.
    depth
        How deep in the ground it starts [m], see `START_DEPTH`.
    fall
        When it has fallen, and the run ends.
    sensors
        What the robot has to estimate its state from; None for a controller that is given the true state.
    scanner
        What it sees the ground with; None for a robot that sees nothing.
    """

    duration: float
    mu: float | None = None
    pushes: Sequence[Push] = ()
    ice: Sequence[Ice] = ()
    seed: int | None = None
    faults: Faults | None = None
    start: FloatArray | None = None
    depth: float = 0.0
    fall: Fall = Fall()
    sensors: SensorModel | None = None
    scanner: RangeSensor | None = None
    patches: Sequence[IcePatch] = ()
    velocity: FloatArray | None = None

    def __post_init__(self) -> None:
        real_number("duration of a scenario", self.duration, low=1e-9, high=LONGEST)
        if self.mu is not None:
            real_number("mu of a scenario", self.mu, low=0.0)
        for name, kind in (("pushes", Push), ("ice", Ice), ("patches", IcePatch)):
            given = getattr(self, name)
            if not isinstance(given, Sequence) or not all(isinstance(one, kind) for one in given):
                raise ProblemError(
                    f"{name} of a scenario must be a list of {kind.__name__}, got {shown(given)}"
                )
        for push in self.pushes:
            finite_array("force of a push", push.force, (3,))
            real_number("start of a push", push.start, low=0.0)
            real_number("duration of a push", push.duration, low=0.0)
        for change in self.ice:
            real_number("start of ice", change.start, low=0.0)
            real_number("mu of ice", change.mu, low=0.0)
        if self.seed is not None:
            whole_number("seed of a scenario", self.seed)

    def steps(self, dt: float) -> int:
        """Return the number of steps of length `dt` [s], at least one."""
        return max(1, round(self.duration / dt))

    def begin(self, world: World) -> tuple[FloatArray, FloatArray | None]:
        """Return where a run starts: (nq,) q [m, -, rad] and (nv,) v [m/s, rad/s], None for rest."""
        q = np.array(start_pose(world.robot, world.terrain) if self.start is None else self.start)
        q[:3] -= self.depth * world.terrain.normal(q[:2])
        if self.seed is None:
            return q, self.velocity
        v = np.array(np.zeros(world.robot.model.nv) if self.velocity is None else self.velocity)
        v[:3] += START_SPEED * np.random.default_rng(self.seed).normal(size=3)
        return q, v


def push_at(pushes: Sequence[Push], time: float) -> FloatArray | None:
    """Return the sum (3,) of the pushes at a time [N], or None."""
    total = None
    for push in pushes:
        if push.start - 1e-9 <= time < push.start + push.duration - 1e-9:
            total = np.asarray(push.force) if total is None else total + np.asarray(push.force)
    return total
