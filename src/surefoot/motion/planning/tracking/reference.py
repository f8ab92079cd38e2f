"""A planned motion as what a tracking controller follows: states, forces and contacts at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.base.loaded import PLANNED, loaded_feet
from surefoot.base.numerics.phases import runs_of
from surefoot.base.spatial import (
    GRAVITY,
    quaternion_from_rotation,
    rotation_about,
    rotation_from_quaternion,
    rotation_log,
)
from surefoot.mechanics import Robot
from surefoot.records import Log


@dataclass(frozen=True)
class Sample:
    """What is planned at one instant; world axes.

    Attributes
    ----------
    q, v
        (nq,), (nv,) Pinocchio's order.
    forces
        (p, 3) [N].
    stance
        (n,) which feet stand.
    com, com_velocity, com_acceleration
        (3,) of the centre of mass.
    rotation, turn_rate, turn_acceleration
        (3, 3), (3,), (3,) of the base.
    """

    q: FloatArray
    v: FloatArray
    forces: FloatArray
    stance: BoolArray
    com: FloatArray
    com_velocity: FloatArray
    com_acceleration: FloatArray
    rotation: FloatArray
    turn_rate: FloatArray
    turn_acceleration: FloatArray


class Reference:
    """A planned motion on flat ground, from time 0.

    Parameters
    ----------
    robot
        Who moves.
    time
        (N + 1,) of the states [s], increasing.
    q, v
        (N + 1, nq), (N + 1, nv) Pinocchio's order.
    forces
        (N, p, 3) of the ground on the contact points, world axes [N]; a last row more is left out.
    stance
        (N, n) which feet stand; None for those that the forces load.

    Raises
    ------
    ProblemError
        For arrays that do not fit each other or the robot, or times that do not increase.
    """

    def __init__(
        self,
        robot: Robot,
        time: FloatArray,
        q: FloatArray,
        v: FloatArray,
        forces: FloatArray,
        stance: BoolArray | None = None,
    ) -> None:
        self.robot = robot
        self.time = finite_array("time", time, (None,))
        rows = len(self.time)
        if rows < 2 or not (np.diff(self.time) > 0.0).all():
            raise ProblemError(f"times must increase, and be two or more, got {rows}")
        self.time = self.time - self.time[0]
        points = robot.contact_points
        self.q = finite_array("q", q, (rows, robot.model.nq))
        self.v = finite_array("v", v, (rows, robot.model.nv))
        self.forces = finite_array("forces", np.asarray(forces)[: rows - 1], (rows - 1, len(points), 3))
        if stance is None:
            loads = np.stack(
                [self.forces[:, points.foot == k, 2].sum(axis=1) for k in range(len(robot.feet))], axis=1
            )
            self.stance: BoolArray = loaded_feet(loads, robot.mass * GRAVITY, PLANNED)
        else:
            self.stance = np.asarray(stance, dtype=bool)[: rows - 1]
        if self.stance.shape != (rows - 1, len(robot.feet)):
            raise ProblemError(
                f"stance must have shape ({rows - 1}, {len(robot.feet)}), got {self.stance.shape}"
            )
        self._set_body()

    @classmethod
    def of(cls, plan: Log, robot: Robot) -> Reference:
        """Return the motion of a plan; its contact frames are taken for the world's, as on flat ground.

        Raises
        ------
        ProblemError
            If the log does not hold what a plan holds.
        """
        for name in ("time", "q", "v", "forces"):
            if name not in plan:
                raise ProblemError(f"a plan needs the channel {name!r}; it has: {', '.join(plan.arrays)}")
        dt = float(plan.fact("dt"))
        time = np.append(plan["time"], plan["time"][-1] + dt)
        q, v = np.vstack([plan["q"], plan.fact("end_q")]), np.vstack([plan["v"], plan.fact("end_v")])
        return cls(robot, time, q, v, plan["forces"])

    def _set_body(self) -> None:
        """Compute centre of mass and base of every state, and their accelerations from each to the next."""
        import pinocchio

        model, data = self.robot.model, self.robot.model.createData()
        rows = len(self.time)
        self.com, self.com_velocity = np.empty((rows, 3)), np.empty((rows, 3))
        self.feet = np.empty((rows, len(self.robot.feet), 3))
        for k in range(rows):
            self.com[k] = pinocchio.centerOfMass(model, data, self.q[k], self.v[k], False)
            self.com_velocity[k] = data.vcom[0]
            self.feet[k] = self.robot.foot_positions(self.q[k])
        self.rotation = rotation_from_quaternion(self.q[:, 3:7])
        self.turn_rate = np.einsum("kij,kj->ki", self.rotation, self.v[:, 3:6])
        step = np.diff(self.time)[:, None]
        self.com_acceleration = self.forces.sum(axis=1) / self.robot.mass - [0.0, 0.0, GRAVITY]
        self.turn_acceleration = np.diff(self.turn_rate, axis=0) / step

    def feet_at(self, time: float) -> tuple[FloatArray, FloatArray]:
        """Return centres (n, 3) and velocities (n, 3) of the feet at a time [m, m/s]."""
        k, share = self._place(time)
        step = self.feet[k + 1] - self.feet[k]
        return self.feet[k] + share * step, step / (self.time[k + 1] - self.time[k])

    def place_on(self, feet: FloatArray, time: float = 0.0, which: BoolArray | None = None) -> Reference:
        """Return the motion moved along the ground and turned about the vertical, to match feet at a time.

        The move is the best in the mean square (Procrustes in the plane).

        Parameters
        ----------
        feet
            (n, 3) where they are [m].
        time
            When [s].
        which
            (n,) the feet that count; None for all.
        """
        chosen = np.ones(len(feet), dtype=bool) if which is None else which
        own, there = self.feet_at(time)[0][chosen, :2], feet[chosen, :2]
        a, b = own - own.mean(axis=0), there - there.mean(axis=0)
        # Least squares over rotations in the plane: the angle of Σ conj(a) b, of places as complex numbers.
        turn = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
        R = rotation_about([0.0, 0.0, 1.0], turn)
        q = self.q.copy()
        q[:, :3] = self.q[:, :3] @ R.T
        shift = there.mean(axis=0) - (R[:2, :2] @ own.mean(axis=0))
        q[:, :2] += shift
        for k, rotation in enumerate(R @ self.rotation):
            q[k, 3:7] = quaternion_from_rotation(rotation)
        return Reference(self.robot, self.time, q, self.v, self.forces @ R.T, self.stance)

    @property
    def duration(self) -> float:
        """Length of the motion [s]."""
        return float(self.time[-1])

    @property
    def start(self) -> FloatArray:
        """(nq,) the first configuration."""
        return np.array(self.q[0])

    @property
    def begins_standing(self) -> bool:
        """Whether a foot stands at the start."""
        return bool(self.stance[0].any())

    def airborne_phases(self) -> list[tuple[float, float]]:
        """Return start and end of every phase in which no foot is in stance [s]."""
        off = np.asarray(~self.stance.any(axis=1))
        return [(float(self.time[a]), float(self.time[b])) for a, b in runs_of(off)]

    def _place(self, time: float) -> tuple[int, float]:
        """Return the knot that a time falls into, and the share of it that is over."""
        k = min(max(int(np.searchsorted(self.time, time, side="right")) - 1, 0), len(self.time) - 2)
        share = (time - self.time[k]) / (self.time[k + 1] - self.time[k])
        return k, float(min(max(share, 0.0), 1.0))

    def attitude_at(self, time: float) -> FloatArray:
        """Return the base's attitude (3, 3) at a time [s]."""
        k, share = self._place(time)
        step = rotation_log(self.rotation[k + 1] @ self.rotation[k].T)
        angle = float(np.linalg.norm(step))
        turn = rotation_about(step / angle, share * angle) if angle > 0.0 else np.eye(3)
        return np.asarray(turn @ self.rotation[k])

    def at(self, time: float) -> Sample:
        """Return what is planned at a time [s]; before the start and after the end the motion holds still."""
        import pinocchio

        k, share = self._place(time)

        def mixed(values: FloatArray) -> FloatArray:
            return np.asarray((1.0 - share) * values[k] + share * values[k + 1])

        q = np.asarray(pinocchio.interpolate(self.robot.model, self.q[k], self.q[k + 1], share))
        v, over = mixed(self.v), time > self.time[-1]
        rest = 0.0 if over else 1.0
        return Sample(
            q, rest * v, self.forces[k], self.stance[k], mixed(self.com),
            rest * mixed(self.com_velocity), rest * self.com_acceleration[k],
            rotation_from_quaternion(q[3:7]), rest * mixed(self.turn_rate), rest * self.turn_acceleration[k],
        )  # fmt: skip
