"""What a gait asks of a robot's joints at a speed: joint speeds and torques, predicted from the model.

A foot that carries goes back under its hip at the body's speed; in the air it comes forward again on the
path of `even_swing`. The leg's Jacobian along that path gives the joints' speeds; its transpose, at the
places of a stance, the torques for the foot's share of the weight. The body is taken to move steadily at its
nominal height; what tracking adds is left to the shares of the limits that callers allow.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.swing import LAND, ramped_step, smooth_bump
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY
from surefoot.stance.adaptive_gait import Pace

ALONG, UPWARDS, SIDE = 15, 5, 0.85
"""Places of the table along the ground (odd) and upwards; how far it reaches, in heights of the body."""
HIGHEST = 0.3
"""Highest place of the table, in heights of the body."""
ENDS = 0.7
"""Share by which the force of a foot is lower at the ends of its stance than in the middle."""
SAMPLES = 33
"""Instants of a swing."""
SOLVED = 2e-4
"""Distance to which a leg must reach a place of the table [m]."""


class LegDemand:
    """Joint speeds and torques of a robot whose feet go along given directions.

    Parameters
    ----------
    robot
        With a floating base and point feet.
    velocity
        (3,) forward, left [m/s] and turn rate [rad/s]: its direction counts, not its size.
    height
        Of the body above the ground [m].

    Attributes
    ----------
    rates
        (n,) speed of each foot under the body at this velocity [m/s].
    """

    def __init__(self, robot: Robot, velocity: FloatArray, height: float) -> None:
        self.robot, self._height = robot, height
        centres = robot.foot_positions(robot.nominal)
        about = centres[:, :2] - centres[:, :2].mean(axis=0)
        x, y, turn = (float(v) for v in velocity)
        moves = np.column_stack([x - turn * about[:, 1], y + turn * about[:, 0]])
        self.rates = np.linalg.norm(moves, axis=1)
        heads = np.divide(
            moves, self.rates[:, None], out=np.zeros_like(moves), where=self.rates[:, None] > 0.0
        )
        heads[self.rates == 0.0, 0] = 1.0
        self._s = np.linspace(-SIDE, SIDE, ALONG) * height
        self._z = np.linspace(0.0, HIGHEST, UPWARDS) * height
        self._tabulate(centres, heads)
        shares = np.linspace(0.0, 1.0, SAMPLES)
        steps, bumps = (np.array([f(s) for s in g])[:, :2] for f, g in
                        ((ramped_step, shares / LAND), (smooth_bump, shares)))  # fmt: skip
        self._shares, self._step, self._bump = shares, steps / [1.0, LAND], bumps

    def _tabulate(self, centres: FloatArray, heads: FloatArray) -> None:
        """Solve for the joints at every place of the table, outwards from the nominal pose."""
        n, joints = len(centres), self.robot.joints
        self._gain = np.full((ALONG, UPWARDS, n, joints, 2), np.nan)
        self._lever = np.full((ALONG, n, joints, 3), np.nan)
        self._weight = np.zeros((ALONG, joints))
        middle = ALONG // 2
        legs = _Legs(self.robot)
        axes = np.zeros((n, 3, 2))
        axes[:, :2, 0], axes[:, 2, 1] = heads, 1.0
        for way in (range(middle, ALONG), range(middle, -1, -1)):
            q = self.robot.nominal.copy()
            for i in way:
                up = q
                for j in range(UPWARDS):
                    place = centres + np.column_stack([self._s[i] * heads, np.full(n, self._z[j])])
                    up, reached, jacobians = legs.reach(up, place)
                    if j == 0:
                        q = up
                        self._lever[i] = np.where(
                            reached[:, None, None], -np.swapaxes(jacobians, 1, 2), np.nan
                        )
                        self._weight[i] = legs.gravity(up)
                    # J' (J J')^-1: the least joint motion that moves the foot so
                    square = jacobians @ np.swapaxes(jacobians, 1, 2) + 1e-9 * np.eye(3)
                    motion = np.swapaxes(jacobians, 1, 2) @ np.linalg.solve(square, axes)
                    self._gain[i, j] = np.where(reached[:, None, None], motion, np.nan)

    def speeds(self, pace: Pace, times: float = 1.0) -> FloatArray:
        """Return the largest speed of each joint in a cycle: (joints,) [rad/s], infinite beyond its reach.

        Parameters
        ----------
        pace
            Timing and swing.
        times
            The velocity over the one given at construction.
        """
        rates = times * self.rates
        half = 0.5 * rates * pace.stance_time
        swing = pace.period - pace.stance_time
        way = rates * pace.period
        along = -half + np.outer(self._step[:, 0], way) - np.outer(self._shares * swing, rates)
        speed = np.outer(self._step[:, 1], way) / swing - rates
        high = np.outer(self._bump[:, 0], np.full(len(rates), pace.clearance))
        rise = np.outer(self._bump[:, 1], np.full(len(rates), pace.clearance)) / swing
        sweep = np.linspace(-1.0, 1.0, 9)[:, None] * half
        flat = np.zeros_like(sweep)
        places = np.vstack([along, sweep]), np.vstack([high, flat])
        moves = np.vstack([speed, flat - rates]), np.vstack([rise, flat])
        gain = self._at(*places)
        found = np.abs(gain[..., 0] * moves[0][..., None] + gain[..., 1] * moves[1][..., None])
        return np.asarray(np.where(np.isnan(found), np.inf, found).max(axis=(0, 1)))

    def _at(self, along: FloatArray, high: FloatArray) -> FloatArray:
        """Return the joints' motion per motion of the feet at (S, n) places: (S, n, joints, 2)."""
        u = (along - self._s[0]) / (self._s[1] - self._s[0])
        w = high / (self._z[1] - self._z[0])
        outside = (u < 0.0) | (u > ALONG - 1) | (w > UPWARDS - 1)
        i, j = np.clip(u.astype(int), 0, ALONG - 2), np.clip(w.astype(int), 0, UPWARDS - 2)
        a, b = (u - i)[..., None, None], (w - j)[..., None, None]
        k = np.broadcast_to(np.arange(along.shape[1]), along.shape)
        g = self._gain
        out = (1 - a) * ((1 - b) * g[i, j, k] + b * g[i, j + 1, k])
        out = out + a * ((1 - b) * g[i + 1, j, k] + b * g[i + 1, j + 1, k])
        return np.where(outside[..., None, None], np.nan, out)

    def torques(self, pace: Pace, times: float, up: FloatArray, factor: float) -> FloatArray:
        """Return the largest torque of each joint in a stance: (joints,) [N m], infinite beyond its reach.

        Parameters
        ----------
        pace, times
            As for `speeds`.
        up
            (3,) the vertical in the body's axes: along it acts the ground's force on average.
        factor
            Force in the middle of a stance over its mean.
        """
        n = len(self.rates)
        push = factor * self.robot.mass * GRAVITY / (n * pace.duty)
        half = 0.5 * times * self.rates * pace.stance_time
        inside = np.abs(self._s)[:, None] <= half + (self._s[1] - self._s[0])  # (ALONG, n)
        inside &= np.abs(self._s)[:, None] <= np.maximum(half, self._s[ALONG // 2 + 1])
        part = np.clip(np.abs(self._s)[:, None] / np.maximum(half, 1e-9), 0.0, 1.0)  # (ALONG, n)
        share = push * (1.0 - ENDS * part * part)
        found = np.abs((self._lever @ up) * share[:, :, None] + self._weight[:, None, :])
        found = np.where(np.isnan(found), np.inf, found)
        own = np.abs(np.nan_to_num(self._lever)).max(axis=(0, 3)) > 0.0  # (n, joints)
        return np.asarray(np.where(inside[:, :, None] & own, found, 0.0).max(axis=(0, 1)))


class _Legs:
    """Places of a robot's feet and their Jacobians in the joints, the base held."""

    def __init__(self, robot: Robot) -> None:
        import pinocchio

        self.pin: Any = pinocchio
        self.robot, self.data = robot, robot.model.createData()
        self.ids = [robot.model.getFrameId(f.name) for f in robot.feet]
        self.low, self.high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]

    def look(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the feet's centres (n, 3) and their Jacobians (n, 3, joints) at a configuration."""
        pin, model, data = self.pin, self.robot.model, self.data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        places, jacobians = [], []
        for frame, foot in zip(self.ids, self.robot.feet, strict=True):
            arm = data.oMf[frame].rotation @ foot.centre
            J = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)[:, 6:]
            places.append(data.oMf[frame].translation + arm)
            jacobians.append(J[:3] - pin.skew(arm) @ J[3:])
        return np.array(places), np.array(jacobians)

    def reach(self, q: FloatArray, wanted: FloatArray) -> tuple[FloatArray, BoolArray, FloatArray]:
        """Return the configuration near q with the feet at (n, 3) places, which reach, and Jacobians."""
        now = q.copy()
        for _ in range(8):
            places, jacobians = self.look(now)
            miss = wanted - places
            if np.abs(miss).max() < SOLVED:
                break
            stacked = jacobians.reshape(-1, self.robot.joints)
            damped = stacked.T @ stacked + 1e-9 * np.eye(self.robot.joints)
            step = np.linalg.solve(damped, stacked.T @ miss.ravel())
            now[7:] += np.clip(step, -0.3, 0.3)
        else:
            places, jacobians = self.look(now)
        close = np.abs(wanted - places).max(axis=1) < 2.0 * SOLVED
        within = (now[7:] > self.low - 1e-3) & (now[7:] < self.high + 1e-3)
        own = np.abs(jacobians).max(axis=1) > 0.0
        reached = np.asarray(close & (within | ~own).all(axis=1))
        return (now if bool(reached.all()) else q), reached, jacobians

    def gravity(self, q: FloatArray) -> FloatArray:
        """Return the joints' torques against gravity on the legs alone: (joints,) [N m]."""
        return np.array(self.pin.computeGeneralizedGravity(self.robot.model, self.data, q)[6:])
