"""Flat feet over time: which stand, how they are turned, and where their corners touch the ground."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.discrete_damping import DELAYED
from surefoot.base.spatial import rotation_exp, rotation_log
from surefoot.mechanics import Robot, Terrain, sole_plane
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.biped.biped_settings import BIPED_WALK
from surefoot.motion.walking.foot_phases import FeetContact, FootArray
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.swing import minimum_jerk
from surefoot.motion.walking.walking_feet import Feet, FeetModel, SwingRequest


class Soles:
    """What does not change about the soles of a walk: `FeetModel`, with what flat feet have beyond points.

    No method changes the feet that it is given: each returns those that it has made of them.

    Parameters
    ----------
    robot
        With flat feet; in its nominal pose they are level and point ahead.
    terrain
        The ground that is planned on.
    clearance, descent
        Height of the swing [m], and speed towards the ground at its end [m/s].

    Attributes
    ----------
    model
        Of the feet, whose centres are the middles of the soles.
    point_foot
        (p,) index of each corner's foot.
    """

    def __init__(self, robot: Robot, terrain: Terrain, clearance: float, descent: float) -> None:
        points = robot.contact_points
        self.terrain = terrain
        self.point_foot, self._radii = points.foot, points.foot_radii
        self._arms = points.centres - points.middles[points.foot]
        self._level = level_rotations(robot)
        self.model = FeetModel(terrain, points.foot_radii, clearance, descent)

    def standing(self, centres: FloatArray, rotations: FloatArray) -> tuple[Feet, FloatArray]:
        """Return feet that stand, and where their corners touch the ground: (p, 3) [m].

        Centres (n, 3) [m] and rotations (n, 3, 3) are those of the feet's frames.
        """
        foot, corners = self.model.standing(centres).foot, np.empty((len(self.point_foot), 3))
        foot["lift_rotation"] = foot["land_rotation"] = rotations
        for k in range(len(centres)):
            self._rest(foot, corners, k, centres, rotations)
        return Feet(foot), corners

    def advance(
        self, feet: Feet, corners: FloatArray, schedule: ContactSchedule, clock: GaitClock,
        contact: FeetContact, centres: FloatArray, rotations: FloatArray,
    ) -> tuple[Feet, FloatArray, bool]:  # fmt: skip
        """Return feet and corners at a time of a schedule, and whether a foot has lifted or landed.

        Parameters
        ----------
        feet, schedule, clock, contact, centres
            As for `FeetModel.advance`.
        corners
            (p, 3) where the corners touched the ground last [m].
        rotations
            (n, 3, 3) of the feet's frames.
        """
        before = feet.stance
        feet, changed = self.model.advance(feet, schedule, clock, contact, centres)
        turned = np.flatnonzero(feet.stance != before).tolist()
        if not turned:
            return feet, corners, changed
        foot, corners = feet.foot, corners.copy()
        for k in turned:
            if feet.stance[k]:
                self._rest(foot, corners, k, centres, rotations)
            else:
                foot[k]["lift_rotation"] = foot[k]["land_rotation"] = rotations[k]
        return Feet(foot), corners, changed

    def _rest(
        self, feet: FootArray, corners: FloatArray, k: int, centres: FloatArray, rotations: FloatArray
    ) -> None:
        """Write the ground under a foot that has landed."""
        yaw = self.heading(rotations[k], k)
        frame, _ = self.ground(k, centres[k, :2], yaw)
        foot, own = feet[k], self.point_foot == k
        foot["frame"] = frame
        foot["ground"] = centres[k] - self._radii[k] * frame[:, 2]
        corners[own] = centres[k] + self._arms[own] @ rotations[k].T - self._radii[k] * frame[:, 2]

    def heading(self, rotation: FloatArray, k: int) -> float:
        """Return where the toes of a foot point [rad] whose frame is turned by (3, 3) `rotation`."""
        ahead = rotation @ self._level[k].T[:, 0]
        return math.atan2(float(ahead[1]), float(ahead[0]))

    def ground(self, k: int, xy: FloatArray, yaw: float) -> tuple[FloatArray, float]:
        """Return frame (3, 3) and height [m] of a sole that is put down at xy (2,); see `sole_plane`."""
        corners = self._arms[self.point_foot == k] @ self._level[k].T
        return sole_plane(self.terrain, corners, xy, yaw, float(self._radii[k]))

    def aimed(
        self, feet: Feet, k: int, place: FloatArray, yaw: float, request: SwingRequest,
        latest: float | None = None,
    ) -> Feet:  # fmt: skip
        """Return feet of which one in the air goes to a (2,) place of its middle [m], with a heading [rad].

        Request and latest as for `FeetModel.aimed`.
        """
        aimed = self.model.aimed(feet, k, place, request, latest)
        if (aimed.target[k] == feet.target[k]).all():  # too late to change
            return aimed
        foot = aimed.foot[k]
        frame, height = self.ground(k, foot["target"][:2], yaw)
        foot["apex"] += max(height - foot["target"][2], 0.0)
        foot["target"][2] = height
        foot["frame"], foot["land_rotation"] = frame, frame @ self._level[k]
        return Feet(aimed.foot)

    def spread(self, k: int, place: FloatArray, yaw: float) -> FloatArray:
        """Return where the corners of a sole at (2,) place, with a heading [rad], touch: (c, 3) [m]."""
        frame, height = self.ground(k, place, yaw)
        middle = np.array([place[0], place[1], height]) - self._radii[k] * frame[:, 2]
        return np.asarray(middle + (self._arms[self.point_foot == k] @ self._level[k].T) @ frame.T)

    def turning(self, feet: Feet, k: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return how a foot in the air should be turned: (3, 3), (3,) [rad/s], (3,) [rad/s²], world axes."""
        foot = feet.foot[k]
        length = BIPED_WALK.turn_until - BIPED_WALK.turn_from
        s, ds, dds = minimum_jerk((float(foot["share"]) - BIPED_WALK.turn_from) / length)
        # Along the shortest turn, at a rate of constant direction: ω and its rate are then those of the
        # share.
        whole = rotation_log(foot["land_rotation"] @ foot["lift_rotation"].T)
        turned = rotation_exp(s * whole) @ foot["lift_rotation"]
        time = length * float(foot["duration"])
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
    most = DELAYED / dt
    return min(rates[0] * omega, most), min(rates[1] * omega, most)


def level_rotations(robot: Robot) -> FloatArray:
    """Return how each foot's frame is turned when its sole is level and its toes point ahead: (n, 3, 3)."""
    import pinocchio

    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, robot.nominal)
    return np.array([data.oMf[foot.frame].rotation for foot in robot.feet])
