"""Flat feet over time: which stand, how they are turned, and where their corners touch the ground."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import rotation_exp, rotation_log
from surefoot.mechanics import Robot, Terrain, sole_plane
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.swing import minimum_jerk
from surefoot.motion.walking.walking_feet import Feet

TURN_FIRST, TURN_LAST = 0.1, 0.9
"""A foot turns between these shares of its swing: it lifts and lands without turning."""
DAMPED = 0.2
"""Largest share of a velocity that the damping of a sole takes off in one step."""


class Soles:
    """The state machine of `Feet`, with what flat feet have beyond points.

    Parameters
    ----------
    robot
        With flat feet; in its nominal pose they are level and point ahead.
    schedule
        When they should stand.
    terrain
        The ground that is believed in.
    clearance, descent
        Height of the swing [m], and speed towards the ground at its end [m/s].
    centres, rotations
        (n, 3), (n, 3, 3) where the feet are and how their frames are turned, at the start.

    Attributes
    ----------
    feet
        `Feet`; its centres are the middles of the soles.
    point_foot
        (p,) index of each corner's foot.
    corners
        (p, 3) where the corners of each foot touched the ground last [m].
    """

    def __init__(
        self,
        robot: Robot,
        schedule: ContactSchedule,
        terrain: Terrain,
        clearance: float,
        descent: float,
        centres: FloatArray,
        rotations: FloatArray,
    ) -> None:
        points = robot.contact_points
        self.terrain = terrain
        self.point_foot, self._radii = points.foot, points.foot_radii
        self._arms = points.centres - points.middles[points.foot]
        self._level = level_rotations(robot)
        self.feet = Feet(schedule, terrain, points.foot_radii, clearance, descent, centres)
        self._start, self._goal = rotations.copy(), rotations.copy()
        self.corners = np.empty((len(self.point_foot), 3))
        for k in range(len(centres)):
            self._rest(k, centres, rotations)

    def update(self, time: float, sensed: BoolArray, centres: FloatArray, rotations: FloatArray) -> bool:
        """Move on to a time of the schedule [s]; return whether a foot has lifted or landed.

        `sensed` (n,) says which feet feel the ground; centres (n, 3) [m], rotations (n, 3, 3) are theirs.
        """
        before = self.feet.stance.copy()
        changed = self.feet.update(time, sensed, centres)
        for k in np.flatnonzero(self.feet.stance != before):
            if self.feet.stance[k]:
                self._rest(int(k), centres, rotations)
            else:
                self._start[k] = self._goal[k] = rotations[k]
        return changed

    def _rest(self, k: int, centres: FloatArray, rotations: FloatArray) -> None:
        """Take the ground under a foot that has landed."""
        yaw = self.heading(rotations[k], k)
        frame, _ = self.ground(k, centres[k, :2], yaw)
        feet, own = self.feet, self.point_foot == k
        feet.frames[k] = frame
        feet.ground[k] = centres[k] - self._radii[k] * frame[:, 2]
        self.corners[own] = centres[k] + self._arms[own] @ rotations[k].T - self._radii[k] * frame[:, 2]

    def heading(self, rotation: FloatArray, k: int) -> float:
        """Return where the toes of a foot point [rad] whose frame is turned by (3, 3) `rotation`."""
        ahead = rotation @ self._level[k].T[:, 0]
        return math.atan2(float(ahead[1]), float(ahead[0]))

    def ground(self, k: int, xy: FloatArray, yaw: float) -> tuple[FloatArray, float]:
        """Return frame (3, 3) and height [m] of a sole that is put down at xy (2,); see `sole_plane`."""
        corners = self._arms[self.point_foot == k] @ self._level[k].T
        return sole_plane(self.terrain, corners, xy, yaw, float(self._radii[k]))

    def aim(self, k: int, place: FloatArray, yaw: float, latest: float | None = None) -> None:
        """Set where a foot in the air will touch: (2,) place of its middle [m], and its heading [rad].

        `latest` as for `Feet.aim`.
        """
        feet = self.feet
        old = feet.target[k].copy()
        feet.aim(k, place, latest)
        if (feet.target[k] == old).all():  # too late to change
            return
        frame, height = self.ground(k, feet.target[k, :2], yaw)
        feet.apex[k] += max(height - feet.target[k, 2], 0.0)
        feet.target[k, 2] = height
        feet.frames[k] = frame
        self._goal[k] = frame @ self._level[k]

    def spread(self, k: int, place: FloatArray, yaw: float) -> FloatArray:
        """Return where the corners of a sole at (2,) place, with a heading [rad], touch: (c, 3) [m]."""
        frame, height = self.ground(k, place, yaw)
        middle = np.array([place[0], place[1], height]) - self._radii[k] * frame[:, 2]
        return np.asarray(middle + (self._arms[self.point_foot == k] @ self._level[k].T) @ frame.T)

    def turning(self, k: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return how a foot in the air should be turned: (3, 3), (3,) [rad/s], (3,) [rad/s²], world axes."""
        feet = self.feet
        length = TURN_LAST - TURN_FIRST
        s, ds, dds = minimum_jerk((float(feet.share[k]) - TURN_FIRST) / length)
        # Along the shortest turn, at a rate of constant direction: ω and its rate are then those of the
        # share.
        whole = rotation_log(self._goal[k] @ self._start[k].T)
        turned = rotation_exp(s * whole) @ self._start[k]
        time = length * float(feet.duration[k])
        return turned, whole * (ds / time), whole * (dds / (time * time))


def sole_damping(rates: tuple[float, float], omega: float, dt: float) -> tuple[float, float]:
    """Return rates [1/s] at which soles that carry come to rest, slow enough for steps of `dt` [s].

    Parameters
    ----------
    rates
        Along the normal, and turning, in units of omega.
    omega
        sqrt(g / h) [1/s].
    dt
        Time between steps of the controller [s].

    Examples
    --------
    >>> sole_damping((16.0, 40.0), 4.0, 1e-3)
    (64.0, 160.0)
    >>> sole_damping((16.0, 40.0), 4.0, 2e-3)
    (64.0, 100.0)
    """
    most = DAMPED / dt
    return min(rates[0] * omega, most), min(rates[1] * omega, most)


def level_rotations(robot: Robot) -> FloatArray:
    """Return how each foot's frame is turned when its sole is level and its toes point ahead: (n, 3, 3)."""
    import pinocchio

    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, robot.nominal)
    return np.array([data.oMf[foot.frame].rotation for foot in robot.feet])
