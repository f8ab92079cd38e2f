"""Which velocities a robot can walk at, and with which timing: bounds by joint speeds, torques and friction.

For every commanded velocity the legs' joint speeds and torques are predicted (`leg_demand`). A gait by name
hurries as far as that is needed: its feet spend less of a shorter cycle on the ground and are lifted less, so
that joints stay below their limits; a gait with given times stays as it is. What no timing can do is slowed
to the fastest velocity in that direction that is possible, and the note says which joint stands in the way.
On a slope, and on stairs, the ground takes a part of the friction: what is left bounds the speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, Terrain
from surefoot.motion.gaits.adaptive_gait import Pace
from surefoot.motion.walking.leg_demand import LegDemand
from surefoot.motion.walking.pace_settings import SPEED_LIMITS
from surefoot.motion.walking.walking_body import VelocityCommand, slowed_note

HURRIES = np.linspace(0.0, 1.0, 21)
"""How far a gait may hurry, tried in turn."""
FRACTIONS = np.linspace(0.1, 1.0, 10)
"""Parts of a commanded velocity for which the timing is found."""
COMMANDS_KEPT = 3
"""Commands whose speeds a gait stays ready for."""


def hurried(pace: Pace, share: float, least_duty: float = SPEED_LIMITS.hurried_duty) -> Pace:
    """Return the pace of a gait that hurries by a share between 0 and 1.

    Clearance and time on the ground give way first, then the period.

    Examples
    --------
    >>> hurried(Pace(0.4, 0.55, 0.1), 0.0)
    Pace(period=0.4, duty=0.55, clearance=0.1)
    """
    if share <= 0.0:
        return pace
    duty = pace.duty + share * (min(least_duty, pace.duty) - pace.duty)
    square = share * share
    period = pace.period * (1.0 + square * (SPEED_LIMITS.hurried_period - 1.0))
    return Pace(period, duty, pace.clearance * (1.0 + share * (SPEED_LIMITS.hurried_clearance - 1.0)))


@dataclass(frozen=True)
class LeggedBody:
    """Whom the gait is for, and where.

    Attributes
    ----------
    robot
        With point feet.
    height, clearance
        Of its centre of mass above the ground, and of a swing at ease [m].
    terrain, mu
        The ground and its friction, as the controller believes.
    """

    robot: Robot
    height: float
    clearance: float
    terrain: Terrain
    mu: float


@dataclass(frozen=True)
class GroundLimit:
    """What the ground leaves for motion.

    Attributes
    ----------
    up
        (3,) the vertical in the axes of a body that stands along the ground.
    fastest
        Speed that friction and steps allow [m/s]; infinite on level ground.
    reason
        Why, for a message.
    """

    up: FloatArray
    fastest: float
    reason: str


@dataclass(frozen=True)
class Limited:
    """A command within limits, and the hurry that its speeds need.

    Attributes
    ----------
    command
        To walk at.
    notes
        A line for everything that was slowed.
    sizes, hurry
        (k,) rising sizes of velocities (see `size_of`) [m/s], and how far the gait hurries there, 0 to 1.
    """

    command: VelocityCommand
    notes: list[str]
    sizes: FloatArray
    hurry: FloatArray

    def hurry_at(self, size: float) -> float:
        """Return how far the gait hurries at a velocity of a size [m/s]."""
        return float(np.interp(size, self.sizes, self.hurry))


class Limits(Remembering):
    """What a robot's legs can do with a gait's timing on a ground.

    Parameters
    ----------
    body
        Whose legs, and where.
    pace
        The gait's own.
    adaptable
        Whether the gait may hurry.
    least_duty
        Share of the time on the ground that a foot keeps in the greatest hurry.
    """

    MEMORY = ("_last",)

    def __init__(
        self, body: LeggedBody, pace: Pace, adaptable: bool, least_duty: float = SPEED_LIMITS.hurried_duty
    ) -> None:
        self.robot, self.height, self.pace, self.least_duty = body.robot, body.height, pace, least_duty
        self.hurries = HURRIES if adaptable else HURRIES[:1]
        self.terrain, self.mu = body.terrain, body.mu
        self._last: list[Limited] = []
        centres = body.robot.foot_positions(body.robot.nominal)[:, :2]
        self.radius = float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).max())

    @property
    def ground(self) -> GroundLimit:
        """What the ground leaves."""
        return ground_left(self.terrain, self.mu, self.height)

    def size_of(self, velocity: FloatArray) -> float:
        """Return how large a (3,) velocity is at the feet: its length plus what turning adds [m/s]."""
        return float(math.hypot(velocity[0], velocity[1]) + abs(velocity[2]) * self.radius)

    def limit(self, command: VelocityCommand) -> Limited:
        """Return a command slowed to what is possible."""
        values, notes = command.values.copy(), []
        sizes, hurry = np.zeros(1), np.zeros(1)
        for row, time in zip(values, command.times, strict=True):
            if not row.any():
                continue
            table = LegDemand(self.robot, row, self.height)
            share, reason = self._share(table, self.size_of(row))
            if share < 1.0:
                notes.append(f"{slowed_note(row, time, share)}; {reason}")
                row *= share
            more = self._needed(table, share, self.size_of(row))
            grid = np.union1d(sizes, FRACTIONS * self.size_of(row))
            ends = np.append(0.0, FRACTIONS * self.size_of(row)), np.append(0.0, more)
            hurry = np.maximum(np.interp(grid, sizes, hurry), np.interp(grid, *ends))
            sizes = grid
        slowed = replace(command, values=values)
        limited = Limited(slowed, notes, sizes, np.maximum.accumulate(hurry))
        self._last = [limited, *self._last[: COMMANDS_KEPT - 1]]
        return limited

    def slowed(self, command: VelocityCommand) -> VelocityCommand:
        """Return another command slowed to what is possible, and ready the gait for its speeds."""
        return self.limit(command).command

    def hurried(self, share: float) -> Pace:
        """Return the gait's pace when it hurries by a share between 0 and 1."""
        return hurried(self.pace, share, self.least_duty)

    def pace_at(self, velocity: FloatArray) -> Pace:
        """Return the pace at a (3,) velocity [m/s, m/s, rad/s] of one of the last commands."""
        size = self.size_of(velocity)
        return self.hurried(max(limited.hurry_at(size) for limited in self._last))

    def _needed(self, table: LegDemand, share: float, size: float) -> FloatArray:
        """Return how far the gait must hurry at `FRACTIONS` of a share of a velocity, of a size: (10,)."""
        out, at, root = [], 0, math.sqrt(GRAVITY * self.height)
        most = min(SPEED_LIMITS.brisk, self.hurries[-1]) if self.terrain.planar else 0.0
        for part in FRACTIONS:
            # Hurry grows with the speed: the search for a larger part goes on where that for the smaller one
            # ended.
            while at + 1 < len(self.hurries):
                speeds = table.speeds(self.hurried(self.hurries[at]), share * float(part))
                if use_of(speeds, self.robot.speed_limits).max() <= SPEED_LIMITS.timing_speed:
                    break
                at += 1
            brisk = np.interp(
                part * size / root, (SPEED_LIMITS.brisk_from, SPEED_LIMITS.brisk_to), (0.0, most)
            )
            out.append(max(self.hurries[at], brisk))
        return np.array(out)

    def use(self, table: LegDemand, pace: Pace, times: float) -> tuple[float, float, int]:
        """Return the shares of joint speed and torque limits that a pace needs, and the joint in the way."""
        speeds = use_of(table.speeds(pace, times), self.robot.speed_limits)
        torques = self._torques(table, pace, times)
        worst = (
            speeds
            if speeds.max() / SPEED_LIMITS.most_speed >= torques.max() / SPEED_LIMITS.most_torque
            else torques
        )
        return float(speeds.max()), float(torques.max()), int(worst.argmax())

    def _torques(self, table: LegDemand, pace: Pace, times: float) -> FloatArray:
        """Return the shares of the torque limits that a pace needs: (joints,)."""
        torques = table.torques(pace, times, self.ground.up, SPEED_LIMITS.force_factor)
        return use_of(torques, self.robot.effort_limits)

    def _share(self, table: LegDemand, size: float) -> tuple[float, str]:
        """Return the largest share of a velocity that is possible, and what stands in the way of more."""
        most, reason = 1.0, ""
        if size > self.ground.fastest:
            most, reason = self.ground.fastest / size, self.ground.reason
        if self._possible(table, most):
            return most, reason
        low, high = 0.0, most
        for _ in range(12):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._possible(table, middle) else (low, middle)
        return low, self._reason(table, high)

    def _possible(self, table: LegDemand, times: float) -> bool:
        """Return whether some timing keeps joint speeds and torques within their shares."""
        for share in self.hurries[::-1]:
            pace = self.hurried(share)
            fits = use_of(table.speeds(pace, times), self.robot.speed_limits).max() <= SPEED_LIMITS.most_speed
            if fits and self._torques(table, pace, times).max() <= SPEED_LIMITS.most_torque:
                return True
        return False

    def _reason(self, table: LegDemand, times: float) -> str:
        """Return which joint stands in the way of a velocity."""
        speed, torque, joint = self.use(table, self.hurried(self.hurries[-1]), times)
        if not math.isfinite(max(speed, torque)):
            return "its legs do not reach that far"
        name = self.robot.joint_names[joint]
        if speed / SPEED_LIMITS.most_speed >= torque / SPEED_LIMITS.most_torque:
            used, most, what = speed, SPEED_LIMITS.most_speed, "speed"
        else:
            used, most, what = torque, SPEED_LIMITS.most_torque, "torque"
        return f"{name} would need {100.0 * used:.0f} % of its {what} ({100 * most:.0f} % allowed)"


def use_of(wanted: FloatArray, limits: FloatArray) -> FloatArray:
    """Return (n,) shares of limits: none of one that is not known, infinite where no leg gets there.

    Examples
    --------
    >>> use_of(np.array([2.0, 2.0, np.inf]), np.array([4.0, np.inf, np.inf]))
    array([0.5, 0. , inf])
    """
    shares = np.full(wanted.shape, np.inf)
    np.divide(wanted, limits, out=shares, where=np.isfinite(wanted))
    return shares


def ground_left(terrain: Terrain, mu: float, height: float) -> GroundLimit:
    """Return what a ground leaves for motion, with the friction mu [-] that may be used, at a height [m].

    Walking multiplies the force along a slope: the share tan(slope) of the normal force that standing
    needs grows by v / (`slope_speed` sqrt(g h)) (fitted to Go2's walks on 15, 20 and 25 degrees), and may
    not exceed mu. Stairs are taken at up to `step_speed` h sqrt(g / rise) (fitted to Go2's walks on steps of
    5 to 15 cm with treads of 20 to 50 cm): the body leans along them, and feet must be lifted in time.
    """
    steepness = terrain.steepness
    if steepness <= 1e-9:
        return GroundLimit(np.array([0.0, 0.0, 1.0]), math.inf, "")
    if terrain.highest_step > 0.0 and not terrain.planar:
        fastest = step_speed(terrain, height)
        reason = f"steps of {1e3 * terrain.highest_step:.0f} mm are taken at up to {fastest:.2g} m/s"
        if steepness > SPEED_LIMITS.steep_stairs:
            most = SPEED_LIMITS.steep_stairs
            reason = f"stairs of steepness {steepness:.2f} are too steep (up to {most:g} is well)"
        return GroundLimit(np.array([0.0, 0.0, 1.0]), fastest, reason)
    fastest = slope_speed(steepness, mu, height)
    lean = steepness / math.hypot(1.0, steepness)
    left = 100.0 * max(1.0 - steepness / mu, 0.0) if mu > 0.0 else 0.0
    reason = (
        f"the ground's slope of {steepness:.2f} leaves {left:.0f} % of the friction {mu:.2f} that may be used"
    )
    return GroundLimit(np.array([lean, 0.0, math.sqrt(1.0 - lean * lean)]), fastest, reason)


def slope_speed(steepness: float, mu: float, height: float) -> float:
    """Return how fast friction mu [-] lets a body of a height [m] walk on a slope: `ground_left` [m/s]."""
    if steepness <= 1e-9:
        return math.inf
    return SPEED_LIMITS.slope_speed * math.sqrt(GRAVITY * height) * max(mu / steepness - 1.0, 0.0)


def step_speed(terrain: Terrain, height: float) -> float:
    """Return how fast a body of a height [m] may take the stairs of a ground, see `ground_left` [m/s]."""
    fastest = SPEED_LIMITS.step_speed * height * math.sqrt(GRAVITY / terrain.highest_step)
    steep = (SPEED_LIMITS.steepest_stairs - terrain.steepness) / (
        SPEED_LIMITS.steepest_stairs - SPEED_LIMITS.steep_stairs
    )
    return fastest * min(max(steep, 0.0), 1.0)
