"""What the frames before the first touch say: how a toss begins, and how noisy the recording is.

Recorded velocities are differences of noisy poses. In free flight a motion has as many numbers as its first
state; they are fitted to all frames before the first touch, by Gauss-Newton steps on simulated flights of the
body as it is known, and a simulation starts from the fit. What a change of the body does to the fit is taken
from the same derivatives: one more flight, and no new fit.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.records.identification import thrown_body_impact as layout
from surefoot.records.identification.ground_plane import GroundPlane
from surefoot.records.identification.thrown_body_step import throw
from surefoot.records.identification.thrown_body_tree import FallingBody
from surefoot.records.identification.tosses import Tosses, pose_differences

FEWEST, MOST = 4, 40
"""Frames that a fit needs, and those it takes."""
ENOUGH = 8
"""Frames from which a toss has a say in the noise."""
TURNS, HALVINGS, SAME = 12, 8, 1e-3
"""Gauss-Newton steps, halvings of one that fits a toss worse, and the share of a fit that ends them."""
STEPS = 2
"""Of the simulation between frames."""
SKY = np.array([0.0, 0.0, 1e3])
"""Flights are simulated far above everything that they could touch [m]."""


def flying_frames(tosses: Tosses, corners: FloatArray, plane: GroundPlane, width: float) -> IntArray:
    """Return (B,) the number of frames before one of (N, k, 3) corners first comes close to the ground."""
    down = plane.above(corners).min(axis=1) < plane.clear * width
    out = np.empty(len(tosses), dtype=np.int64)
    for k, (a, b) in enumerate(zip(tosses.starts[:-1], tosses.starts[1:], strict=True)):
        out[k] = int(np.argmax(down[a:b])) if down[a:b].any() else b - a
    return np.minimum(out, MOST)


class TossFlight:
    """The first states of tosses, from all their frames before the first touch.

    Parameters
    ----------
    tosses
        What was recorded.
    frames
        (B,) frames before the first touch; of tosses with too few the recorded velocities are taken.
    tree, gravity
        The body, and [m/s²].

    Attributes
    ----------
    starts
        (B, nq + nv) first states in world axes, see `TossScene`.
    covariance
        (B, 2 nv, 2 nv) of their errors, for noise of one in each coordinate (m, rad).
    used
        (B,) frames that were used.
    position_noise, rotation_noise
        Standard deviation of a recorded coordinate [m] and angle about an axis [rad]; 0 if none flies long.
    """

    def __init__(self, tosses: Tosses, frames: IntArray, tree: FallingBody, gravity: float) -> None:
        self._tosses, self._nv = tosses, 6 + tosses.joints
        self.used = np.where(frames >= FEWEST, frames, 0)
        counts = np.maximum(self.used, 1)
        self._counts, self._owner = counts, np.repeat(np.arange(len(tosses)), counts)
        self._rows = np.concatenate(
            [a + np.arange(n) for a, n in zip(tosses.starts[:-1], counts, strict=True)]
        )
        self.starts = self._guess()
        for _ in range(TURNS):
            if self._descend(self._derive(tree, gravity), tree, gravity):
                break
        off = self._off(self.starts, tree, gravity)
        long = self.used >= ENOUGH
        free = np.maximum(counts - 2, 1)
        sums = np.stack([np.bincount(self._owner, (off[:, c] ** 2).sum(axis=1)) for c in _KINDS], axis=1)
        # the median toss: a few tosses lose a fiducial for a frame
        noise = np.sqrt(np.median((sums / (3.0 * free[:, None]))[long], axis=0)) if long.any() else (0.0, 0.0)
        self.position_noise, self.rotation_noise = float(noise[0]), float(noise[1])

    def corrected(self, tree: FallingBody, gravity: float) -> FloatArray:
        """Return the first states (B, nq + nv) of another body, by one more Gauss-Newton step."""
        return self._add_change(self.starts, self._change(self._off(self.starts, tree, gravity)))

    def _change(self, off: FloatArray) -> FloatArray:
        """Return the Gauss-Newton step (B, 2 nv) for (rows, nv) differences; 0 where too few frames fly."""
        return np.where(self.used[:, None] == 0, 0.0, -self._explain(off))

    def _descend(self, off: FloatArray, tree: FallingBody, gravity: float) -> bool:
        """Take for every toss so much of the Gauss-Newton step as fits it better; return if all are at rest.

        A body that is not known yet bends long flights so much that whole steps throw some of them away.
        `off` are the (rows, nv) differences of now.
        """
        change, before = self._change(off), self._squares(off)
        for _ in range(HALVINGS):
            ahead = self._add_change(self.starts, change)
            after = self._squares(self._off(ahead, tree, gravity))
            worse = ~(after <= before)
            if not worse.any():
                break
            change[worse] *= 0.5
        self.starts = np.where(worse[:, None], self.starts, ahead)
        return bool((after > (1.0 - SAME) * before).all())

    def _squares(self, off: FloatArray) -> FloatArray:
        """Return the sums of squares (B,) of (rows, nv) differences."""
        return np.asarray(np.bincount(self._owner, (off**2).sum(axis=1), len(self.starts)))

    def apart(self, poses: FloatArray) -> FloatArray:
        """Return how far the first states (B, 2 nv) of other motions are, from poses in the rows used."""
        return self._explain(pose_differences(poses, self._tosses.poses[self._rows]))

    def _explain(self, off: FloatArray) -> FloatArray:
        """Return the change of the first states (B, 2 nv) that explains (rows, nv) differences best."""
        moment = np.zeros((len(self.starts), 2 * self._nv))
        np.add.at(moment, self._owner, np.einsum("nik,ni->nk", self._J, off))
        return np.asarray(np.einsum("bkl,bl->bk", self.covariance, moment))

    def deviations(self, noise: tuple[float, float]) -> FloatArray:
        """Return the standard deviations (B, 2 nv) of first states for noise of places [m], turns [rad]."""
        gain = self.covariance[self._owner] @ np.swapaxes(self._J, 1, 2) * self._sizes(noise)
        squares = np.zeros((len(self.starts), 2 * self._nv))
        np.add.at(squares, self._owner, np.square(gain).sum(axis=2))
        return np.sqrt(squares)

    def shaken(
        self, starts: FloatArray, noise: tuple[float, float], random: np.random.Generator
    ) -> FloatArray:
        """Return first states (B, nq + nv) with errors as noise of places [m], turns [rad] makes them.

        Every row is shaken, and explained: the covariance of the first states, of which a flight of a few
        frames tells some hardly at all, has no factor that rounding leaves alone.
        """
        rows = random.normal(size=(len(self._rows), self._nv)) * self._sizes(noise)
        return self._add_change(starts, self._explain(rows))

    def _sizes(self, noise: tuple[float, float]) -> FloatArray:
        """Return the standard deviations (nv,) of a row's differences."""
        return np.repeat(noise, [3, self._nv - 3])

    def _guess(self) -> FloatArray:
        """Return first states with mean velocities for velocities."""
        tosses, nv = self._tosses, self._nv
        first = tosses.starts[:-1]
        last = first + np.maximum(self.used, 2) - 1
        t = ((last - first) * tosses.dt)[:, None]
        states, nq = tosses.states, nv + 1
        turn = Rotation.from_quat(states[first, 3:7])
        out = np.concatenate([tosses.poses[first], states[first, nq:]], axis=1)
        out[:, nq + 3 : nq + 6] = turn.apply(states[first, nq + 3 : nq + 6])
        steps = Rotation.from_quat(states[first + 1, 3:7]) * turn.inv()
        flies = self.used > 0
        out[flies, nq + 3 : nq + 6] = steps.as_rotvec()[flies] / tosses.dt
        out[flies, nq : nq + 3] = ((states[last, :3] - states[first, :3]) / t)[flies]
        out[flies, nq + 6 :] = ((states[last, 7:nq] - states[first, 7:nq]) / t)[flies]
        return out

    def _derive(self, tree: FallingBody, gravity: float) -> FloatArray:
        """Find the derivatives by the first states; return the (rows, nv) differences of now."""
        nv, count = self._nv, len(self.starts)
        here = self._off(self.starts, tree, gravity)
        self._J = np.empty((*here.shape, 2 * nv))
        for k in range(2 * nv):
            step = 1e-4 if k < nv else 1e-3
            change = np.zeros((count, 2 * nv))
            change[:, k] = step
            self._J[:, :, k] = (self._off(self._add_change(self.starts, change), tree, gravity) - here) / step
        # Normal equations of each toss on its own, of noise alike in metres and radians.
        square = np.zeros((count, 2 * nv, 2 * nv))
        np.add.at(square, self._owner, np.einsum("nik,nil->nkl", self._J, self._J))
        square += 1e-12 * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(2 * nv)
        self.covariance = np.linalg.inv(square)
        return here

    def _off(self, starts: FloatArray, tree: FallingBody, gravity: float) -> FloatArray:
        """Return (rows, nv) simulated less recorded poses [m, rad]."""
        poses, high = np.empty((len(self._rows), self._nv + 1)), starts.copy()
        high[:, :3] += SKY
        down = np.array([0.0, 0.0, -gravity])
        throw(tree, np.zeros(layout.SIZE), down, high, self._counts, self._tosses.dt, STEPS, poses)
        recorded = self._tosses.poses[self._rows]
        lost = ~np.isfinite(poses).all(axis=1)  # a step that went too far
        poses[lost] = recorded[lost] + np.eye(self._nv + 1)[0]
        poses[~lost, :3] -= SKY
        return pose_differences(poses, recorded)

    def _add_change(self, starts: FloatArray, change: FloatArray) -> FloatArray:
        """Return states with (B, 2 nv) added, turns in world axes."""
        out = starts.copy()
        out[:, :3] += change[:, :3]
        turned = Rotation.from_rotvec(change[:, 3:6]) * Rotation.from_quat(starts[:, 3:7])
        out[:, 3:7] = turned.as_quat()
        out[:, 7:] += change[:, 6:]
        return out


_KINDS = (slice(0, 3), slice(3, 6))
