"""Tosses whose recording was levelled one by one: their common axes, found again.

Such a recording lifts every toss until its lowest corner ends at height zero. Resting places then lie level
however the board slopes in the axes of the camera, and a toss that travels touches it too high or too low.
What points down is known by free flight. The board's slope is to begin with that of what stays on it on the
way, its height over that of the end. A toss whose end is the origin has the board below it whatever the slope
is, so that this can be fitted further; in other tosses, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray
from surefoot.records.identification.ground_plane import GroundPlane, GroundPoints, without_outliers
from surefoot.records.identification.thrown_body import ThrownBody
from surefoot.records.identification.thrown_body_tree import sphere_places
from surefoot.records.identification.tosses import Tosses

SAME = 1e-6
"""Heights of the ends that differ by less were made alike [m]."""
HIGH, ENOUGH = 0.25, 10
"""Height above the end [widths] that is free flight however the board slopes, and frames that count."""
STEADY, NEAR, FAR = 0.01, 0.2, 0.2
"""What changes its least height by less than the first, within the second of that of the end and farther from
there than the third slides on the board; in widths."""
AROUND = 5
"""Frames in which it must."""


@dataclass(frozen=True)
class Levelling:
    """How the tosses of a recording stood before they were levelled.

    Attributes
    ----------
    body
        What was thrown, before it is fitted.
    turn
        From the recorded axes to upright ones.
    touches
        In upright axes, a place of each toss where it touched, less that where it ended [m].
    """

    body: ThrownBody
    turn: Rotation
    touches: GroundPoints

    @property
    def note(self) -> str:
        """What to know about it, in a line."""
        return (
            "every toss was lifted until it ends at the same height: axes are turned by "
            f"{np.degrees(self.turn.magnitude()):.2f} deg until free flight falls straight, and the ground's "
            "slopes are fitted"
        )

    def upright(self, tosses: Tosses) -> Tosses:
        """Return the tosses in upright axes, each with the place where it ended for origin.

        There the board has one height under all of them, however it slopes.
        """
        turned = _turn(tosses, self.turn)
        ends = _lowest(sphere_places(self.body.tree, turned.poses[turned.starts[1:] - 1]))
        turned.states[:, :3] -= np.repeat(ends, turned.frames, axis=0)
        return turned


def find_levelled(tosses: Tosses, body: ThrownBody) -> Levelling | None:
    """Return how tosses stood before they were levelled; None if the ends of all do not lie equally high."""
    ends = _lowest(sphere_places(body.tree, tosses.poses[tosses.starts[1:] - 1]))
    if np.ptp(ends[:, 2]) > SAME:
        return None
    fall = _fall(tosses, body)
    turn = GroundPlane(0.0, -fall[:2] / fall[2]).rotation.inv()
    return Levelling(body, turn, _touches(_turn(tosses, turn), body))


def _lowest(corners: FloatArray) -> FloatArray:
    """Return the lowest (N, 3) of (N, k, 3) corners."""
    return np.asarray(corners[np.arange(len(corners)), corners[:, :, 2].argmin(axis=1)])


def _turn(tosses: Tosses, turn: Rotation) -> Tosses:
    """Return tosses in axes that are turned; angular velocities are the body's own already."""
    states, at = tosses.states.copy(), 7 + tosses.joints
    for k in (0, at):
        states[:, k : k + 3] = turn.apply(states[:, k : k + 3])
    states[:, 3:7] = (turn * Rotation.from_quat(states[:, 3:7])).as_quat()
    return Tosses(states, tosses.starts, tosses.dt, tosses.ids, tosses.cube)


def _fall(tosses: Tosses, body: ThrownBody) -> FloatArray:
    """Return the acceleration (3,) of free fall [m/s²]: the median toss's; along -z where none flies long."""
    tree, n = body.tree, body.tree.masses.size
    places = sphere_places(
        tree._replace(links=np.arange(n), points=tree.centres, radii=np.zeros(n)), tosses.poses
    )
    middle = np.einsum("nik,i->nk", places, tree.masses / tree.masses.sum())
    height = _lowest(sphere_places(tree, tosses.poses))[:, 2]
    falls = []
    for a, b in zip(tosses.starts[:-1], tosses.starts[1:], strict=True):
        low = height[a:b] < height[b - 1] + HIGH * body.width
        frames = int(np.argmax(np.append(low, True)))
        if frames >= ENOUGH:
            t = tosses.dt * np.arange(frames)
            falls.append(2.0 * np.polyfit(t, middle[a : a + frames], 2)[0])
    return np.median(falls, axis=0) if falls else np.array([0.0, 0.0, -1.0])


def _touches(tosses: Tosses, body: ThrownBody) -> GroundPoints:
    """Return the mean place of each toss where a corner slid, less that where the toss ended."""
    places, count = _lowest(sphere_places(body.tree, tosses.poses)), len(tosses)
    owner, height = np.repeat(np.arange(count), tosses.frames), places[:, 2]
    off = places - places[tosses.starts[1:] - 1][owner]
    steady = maximum_filter1d(height, AROUND) - minimum_filter1d(height, AROUND) < STEADY * body.width
    far = np.linalg.norm(off[:, :2], axis=1) > FAR * body.width
    on = steady & far & (np.abs(off[:, 2]) < NEAR * body.width)
    rows = np.bincount(owner, on, count)
    points = [np.bincount(owner, on * off[:, k], count) / np.maximum(rows, 1.0) for k in range(3)]
    use = rows > 0.0 if on.any() else np.ones(count, dtype=bool)  # nothing slides: level as gravity has it
    return without_outliers(GroundPoints(np.stack(points, axis=1), use, resting=True))
