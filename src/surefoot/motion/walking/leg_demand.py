"""What a gait asks of a robot's joints at a speed: joint speeds and torques, predicted from the model.

A foot that carries goes back under its hip at the body's speed; in the air it comes forward again on the
path of `even_swing`. The leg's Jacobian along that path gives the joints' speeds; its transpose, at the
places of a stance, the torques for the foot's share of the weight. The body is taken to move steadily at its
nominal height; what tracking adds is left to the shares of the limits that callers allow. The places are
solved for once a robot and a height (`LegTable`), so a velocity that is new costs a walking robot no step.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import kernel
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.motion.gaits.adaptive_gait import Pace
from surefoot.motion.walking.pace_settings import SPEED_LIMITS
from surefoot.motion.walking.swing import LAND, ramped_step, smooth_bump

LINES, ALONG, UPWARDS, SIDE = 16, 15, 5, 0.85
"""Lines of the table over half a turn, places of each (odd), those upwards, and its reach in body heights."""
MIDDLE = ALONG // 2
"""Index of the places below the nominal ones."""
HIGHEST = 0.3
"""Highest place of the table, in heights of the body."""
SAMPLES, SWEEP = 33, 9
"""Instants of a swing, and of a stance."""
SOLVED, ROUNDS = 2e-4, 8
"""Distance to which a leg must reach a place of the table [m], and Newton steps until then."""


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
        self.robot, legs = robot, table_of(robot, height)
        # Velocity of each foot's place under the body: v + ω x r. A stance foot goes back at it.
        about = legs.centres[:, :2] - legs.centres[:, :2].mean(axis=0)
        x, y, turn = (float(v) for v in velocity)
        moves = np.column_stack([x - turn * about[:, 1], y + turn * about[:, 0]])
        self.rates = np.linalg.norm(moves, axis=1)
        heads = np.divide(
            moves, self.rates[:, None], out=np.zeros_like(moves), where=self.rates[:, None] > 0.0
        )
        heads[self.rates == 0.0, 0] = 1.0
        self._grid = legs.grid
        self._gain, self._lever, self._weight = legs.along(heads)
        self._own = np.abs(np.nan_to_num(self._lever)).max(axis=(0, 3)) > 0.0  # (n, joints)

    def speeds(self, pace: Pace, times: float = 1.0) -> FloatArray:
        """Return the largest speed of each joint in a cycle: (joints,) [rad/s], infinite beyond its reach.

        Parameters
        ----------
        pace
            Timing and swing.
        times
            The velocity over the one given at construction.
        """
        timing = pace.stance_time, pace.period, pace.clearance
        return largest_speeds(self._gain, self._grid, swing_path(), times * self.rates, timing)

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
        # The force over a stance is a parabola, lower at the ends by `stance_ends`; its mean carries the
        # weight on the share of the period that the foot stands.
        half = 0.5 * times * self.rates * pace.stance_time
        far = self._grid[0] * np.abs(np.arange(ALONG) - MIDDLE)[:, None]  # (ALONG, 1)
        push = factor * self.robot.mass * GRAVITY / (len(self.rates) * pace.duty)
        share = push * (1.0 - SPEED_LIMITS.stance_ends * np.minimum(far / np.maximum(half, 1e-9), 1.0) ** 2)
        found = np.abs((self._lever @ up) * share[:, :, None] + self._weight)
        counts = (far <= np.maximum(half, self._grid[0]))[:, :, None] & self._own
        return np.asarray(np.where(counts, np.nan_to_num(found, nan=np.inf), 0.0).max(axis=(0, 1)))


@kernel
def largest_speeds(
    gain: FloatArray,
    grid: tuple[float, float],
    path: FloatArray,
    rates: FloatArray,
    timing: tuple[float, float, float],
) -> FloatArray:
    """Return the largest speeds of joints in a cycle: (joints,) [rad/s], infinite beyond their reach.

    Parameters
    ----------
    gain
        (ALONG, n, UPWARDS, joints, 2) motion of the joints per motion of a foot along its way and upwards.
    grid
        Distances of these places [m].
    path
        (SAMPLES, 5) share of a swing's time; shares of the way and of the clearance, with their derivatives.
    rates
        (n,) speeds of the feet under the body [m/s].
    timing
        Time on the ground, period [s] and clearance [m].
    """
    stance, period, clearance = timing
    air, most = period - stance, np.zeros(gain.shape[3])
    for k, rate in enumerate(rates):
        for m in range(len(path) + SWEEP):
            along, high, forth, up = (2.0 * (m - len(path)) / (SWEEP - 1) - 1.0), 0.0, -rate, 0.0
            # First the stance, from the front of the sweep to its back at the body's speed.
            along *= 0.5 * rate * stance
            if m < len(path):
                # In the air the foot covers a whole stride over the ground while the body goes on: both in
                # body axes.
                share, way = path[m, 0], rate * period
                along = path[m, 1] * way - share * air * rate - 0.5 * rate * stance
                high, forth = path[m, 3] * clearance, path[m, 2] * way / air - rate
                up = path[m, 4] * clearance / air
            # Bilinear in the table; NaN of places that the leg does not reach spreads, and counts as infinite
            # speed.
            u, w = along / grid[0] + MIDDLE, high / grid[1]
            if u < 0.0 or u > ALONG - 1 or w > UPWARDS - 1:
                return np.full_like(most, np.inf)
            i, j = min(int(u), ALONG - 2), min(int(w), UPWARDS - 2)
            a, b = u - i, w - j
            for joint in range(len(most)):
                speed = 0.0
                for axis, motion in enumerate((forth, up)):
                    near = (1.0 - b) * gain[i, k, j, joint, axis] + b * gain[i, k, j + 1, joint, axis]
                    far = (1.0 - b) * gain[i + 1, k, j, joint, axis] + b * gain[i + 1, k, j + 1, joint, axis]
                    speed += ((1.0 - a) * near + a * far) * motion
                if np.isnan(speed):
                    return np.full_like(most, np.inf)
                most[joint] = max(most[joint], abs(speed))
    return most


@cache
def swing_path() -> FloatArray:
    """Return the path of `even_swing` for `largest_speeds`: (SAMPLES, 5)."""
    rows = []
    for share in np.linspace(0.0, 1.0, SAMPLES):
        step, bump = ramped_step(share / LAND), smooth_bump(share)
        rows.append([share, step[0], step[1] / LAND, bump[0], bump[1]])
    return np.array(rows)


@lru_cache(4)
def table_of(robot: Robot, height: float) -> LegTable:
    """Return the table of a robot's legs at a height [m]; made once."""
    return LegTable(robot, height)


class LegTable:
    """Joints' motion and load for feet on lines through the nominal places; NaN where a leg does not reach.

    Attributes
    ----------
    centres
        (n, 3) nominal places of the feet [m].
    grid
        Distances of the places along a line and upwards [m].
    gain
        (LINES, ALONG, n, UPWARDS, joints, 3) motion of the joints per motion of a foot [rad/m].
    lever
        (LINES, ALONG, n, joints, 3) torques of the joints per force of the ground [m].
    weight
        (LINES, ALONG, n, joints) torques of the joints against the weight of the legs [N m].
    """

    def __init__(self, robot: Robot, height: float) -> None:
        n, joints = len(robot.feet), robot.joints
        self.centres = robot.foot_positions(robot.nominal)
        self.grid = SIDE * height / MIDDLE, HIGHEST * height / (UPWARDS - 1)
        self.gain = np.full((LINES, ALONG, n, UPWARDS, joints, 3), np.nan)
        self.lever = np.full((LINES, ALONG, n, joints, 3), np.nan)
        self.weight = np.zeros((LINES, ALONG, n, joints))
        self._bind(robot)
        for line in range(LINES):
            # Outwards from below the hip, each place from the joints of its neighbour: Newton's method stays
            # on the same branch of the knee.
            for way in (range(MIDDLE, ALONG), range(MIDDLE, -1, -1)):
                q = robot.nominal
                for place in way:
                    q = self._fill(q, line, place)

    def _bind(self, robot: Robot) -> None:
        """Take the robot's model, with a frame at the centre of each foot."""
        import pinocchio

        self._pin: Any = pinocchio
        self._model: Any = robot.model.copy()
        self._joints, self._feet = robot.joints, []
        for foot in robot.feet:
            frame = self._model.frames[foot.frame]
            place = frame.placement * pinocchio.SE3(np.eye(3), foot.centre)
            kind, name = pinocchio.FrameType.OP_FRAME, f"{foot.name} centre"
            self._feet.append(self._model.addFrame(pinocchio.Frame(name, frame.parentJoint, place, kind)))
        self._data = self._model.createData()

    def _fill(self, q: FloatArray, line: int, i: int) -> FloatArray:
        """Solve for the places above one on the ground from joints nearby; return its joints."""
        angle, along = np.pi * line / LINES, self.grid[0] * (i - MIDDLE)
        place = self.centres + along * np.array([np.cos(angle), np.sin(angle), 0.0])
        start = up = q
        for z in range(UPWARDS):
            up, reached, J = self._reach(up, place)
            turned = np.swapaxes(J, 1, 2)
            if z == 0:
                start = up
                self.lever[line, i] = np.where(reached[:, None, None], -turned, np.nan)
                self.weight[line, i] = self._pin.computeGeneralizedGravity(self._model, self._data, up)[6:]
            # J' (J J')^-1: the least joint motion that moves the foot so
            motion = turned @ np.linalg.inv(J @ turned + 1e-9 * np.eye(3))
            self.gain[line, i, :, z] = np.where(reached[:, None, None], motion, np.nan)
            place[:, 2] += self.grid[1]
        return start

    def along(self, heads: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return gain, lever and weight along each foot's (n, 2) direction: (ALONG, n, ...).

        Between two lines they are interpolated; the gain is per motion along the direction and upwards.
        """
        feet, forth = np.arange(len(heads)), np.arange(ALONG)[:, None]
        turns = np.arctan2(heads[:, 1], heads[:, 0]) * (LINES / np.pi) % (2 * LINES)
        found: list[Any] = [0.0, 0.0, 0.0]
        for corner in (np.floor(turns), np.floor(turns) + 1.0):
            share = 1.0 - np.abs(turns - corner)
            back, line = np.divmod(corner.astype(int), LINES)
            place = np.where(back % 2, ALONG - 1 - forth, forth)  # a line's other end
            for k, table in enumerate((self.gain, self.lever, self.weight)):
                rows = table[line, place, feet]
                part = share.reshape(-1, *(1,) * (rows.ndim - 2))
                found[k] = found[k] + np.where(part > 0.0, part * rows, 0.0)
        ahead = np.einsum("inkjd,nd->inkj", found[0][..., :2], heads)
        return np.stack([ahead, found[0][..., 2]], axis=-1), found[1], found[2]

    def _look(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the feet's centres (n, 3) and their Jacobians (n, 3, joints) at a configuration."""
        pin, model, data = self._pin, self._model, self._data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobians = [pin.getFrameJacobian(model, data, i, world)[:3, 6:] for i in self._feet]
        return np.array([data.oMf[i].translation for i in self._feet]), np.array(jacobians)

    def _reach(self, q: FloatArray, wanted: FloatArray) -> tuple[FloatArray, BoolArray, FloatArray]:
        """Return the configuration near q with the feet at (n, 3) places, which reach, and Jacobians."""
        now = q.copy()
        for _ in range(ROUNDS):
            places, jacobians = self._look(now)
            miss = wanted - places
            if np.abs(miss).max() < SOLVED:
                break
            stacked = jacobians.reshape(-1, self._joints)
            # Levenberg's damping, and steps cut to 0.3 rad: near the end of a leg's reach the Jacobian loses
            # rank.
            damped = stacked.T @ stacked + 1e-9 * np.eye(self._joints)
            step = np.linalg.solve(damped, stacked.T @ miss.ravel())
            now[7:] += np.minimum(np.maximum(step, -0.3), 0.3)
        else:
            places, jacobians = self._look(now)
        close = np.abs(wanted - places).max(axis=1) < 2.0 * SOLVED
        own = np.abs(jacobians).max(axis=1) > 0.0
        low, high = self._model.lowerPositionLimit[7:], self._model.upperPositionLimit[7:]
        within = (now[7:] > low - 1e-3) & (now[7:] < high + 1e-3)
        reached = np.asarray(close & (within | ~own).all(axis=1))
        stuck = own[~reached].any(axis=0)  # legs that do not get there stay where they were
        now[7:][stuck] = q[7:][stuck]
        return now, reached, jacobians
