"""A knot of the exact step in symbols, and rows with their bounds: what every method writes its program with.

Semi-implicit Euler as `dynamics.MomentumKnot` takes it, written as inverse dynamics of the joints
(no mass matrix is inverted) and momentum of the whole robot::

    RNEA(q, v, (v⁺ - v) / dt, f) = tau        for the joints
    A_G(q) v⁺ - A_G(q ⊖ dt v) v = dt ([m g; 0] + Σ [f; (p - c) x f])
    q⁺ = q ⊕ dt v⁺                            but for the base's place: c(q⁺) = c(q) + dt p⁺ / m
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.libraries import import_casadi
from surefoot.mechanics import Robot, Terrain, free_momentum_rows
from surefoot.motion.planning.symbolic.rigid_body import SymbolicBody
from surefoot.motion.planning.symbolic.rotations import rotate
from surefoot.motion.planning.transcription.nlp import Expression, Sides

Row: TypeAlias = tuple[Expression, ArrayLike, ArrayLike]
"""A column (m, 1) of SX, and its bounds: a number, (m,) or (knots, m); infinite where it does not matter."""


class SymbolicKnot:
    """The state before and after a knot of a robot on a plane, and what the step says of them.

    Parameters
    ----------
    robot, terrain
        Who moves, on which plane.
    dt
        Length of the knot [s].

    Attributes
    ----------
    body
        The robot's dynamics.
    x, after
        (nq + nv, 1) SX symbols: q and v at the knot's start, and at its end.
    q, v, q_after, v_after
        Their parts.
    frame, height
        (3, 3) rotation_world_contact of the plane, and its distance from the origin along its normal
        [m]; of ground in steps upright and 0.
    """

    def __init__(self, robot: Robot, terrain: Terrain, dt: float) -> None:
        ca = import_casadi()
        self.robot, self.dt = robot, dt
        self.body = body = SymbolicBody(robot.model, robot.contact_points)
        self.x, self.after = ca.SX.sym("x", body.nq + body.nv), ca.SX.sym("after", body.nq + body.nv)
        self.q, self.v = self.x[: body.nq], self.x[body.nq :]
        self.q_after, self.v_after = self.after[: body.nq], self.after[body.nq :]
        self.frame = np.asarray(terrain.frame([0.0, 0.0]))
        self.height = float(terrain.height([0.0, 0.0])) * self.frame[2, 2] if terrain.planar else 0.0
        self._rows = list(free_momentum_rows(robot.model))
        self._turn, self._local = body.base_turn(self.q), body.at_origin(self.q)
        self._com, self._linear, self._angular = body.momentum(self._local, self.v_after)

    def world(self, forces: Expression) -> Expression:
        """Return (3, p) in world axes what is (3, p) in contact axes."""
        return import_casadi().mtimes(import_casadi().DM(self.frame), forces)

    def missing_effort(self, forces: Expression, torques: Expression) -> Expression:
        """Return what forces (3, p), world axes [N], and torques (joints, 1) lack of the motion (nv, 1)."""
        ca, change = import_casadi(), (self.v_after - self.v) / self.dt
        effort = self.body.inverse_dynamics(self.q, self.v, change, forces, self.frame[:, 2])
        missing = effort - ca.vertcat(ca.SX.zeros(self.robot.base_dof), torques)
        if not self._rows:
            return missing
        n, body, turn = len(self._rows), self.body, self._turn
        # in the base's axes at the start, which turned from those where the way there began
        # Momentum balance in place of the base's rows, see `dynamics.momentum_knot`: (p⁺ - p⁻) / dt less
        # forces and weight, and about the centre of mass the moments of forces.
        before = body.momentum(body.at_origin(body.integrate(self.q, -self.dt * self.v)), self.v)[1:]
        linear, angular = (rotate(part, -self.dt * self._spin(self.v)) for part in before)
        pushes = ca.mtimes(turn.T, forces)
        down = ca.mtimes(turn.T, ca.DM(np.outer(self.frame[:, 2], self.robot.contact_points.radii)))
        arms = body.sphere_centres(self._local) - down - ca.repmat(self._com, 1, body.points)
        weight = ca.mtimes(turn.T, ca.DM(self.robot.mass * np.array(self.robot.model.gravity.linear)))
        turning = sum(ca.cross(arms[:, k], pushes[:, k]) for k in range(body.points))
        rate = ca.vertcat(self._linear - linear, self._angular - angular) / self.dt
        gained = rate - ca.vertcat(ca.sum2(pushes) + weight, turning)
        motors = ca.vertcat(ca.SX.zeros(self.robot.base_dof), torques)[:n]
        return ca.vertcat(gained[self._rows] - motors, missing[n:])

    def missed_way(self) -> Expression:
        """Return (nq, 1) q⁺ less q ⊕ dt v⁺, of the base's place what the centre of mass is off."""
        ca, body = import_casadi(), self.body
        missed = self.q_after - body.integrate(self.q, self.dt * self.v_after)
        if not self._rows:
            return missed
        ahead = body.momentum(body.at_origin(self.q_after), self.v_after)[0]
        # c(q⁺) = c(q) + dt p⁺ / m, in the base's axes at the start: the base's own way and what the shape
        # adds.
        shape = rotate(ahead, self.dt * self._spin(self.v_after)) - self._com
        slides = [row for row in self._rows if row < 3]
        moved = ca.SX.zeros(3)
        for place, row in enumerate(slides):
            moved[row] = self.q_after[place] - self.q[place]
        off = ca.mtimes(self._turn.T, moved) + shape - self.dt / self.robot.mass * self._linear
        for place, row in enumerate(slides):
            missed[place] = off[row]
        return missed

    def _spin(self, v: Expression) -> Expression:
        """Return the base's rate of turning (3, 1) in its axes, none where it is no free flyer."""
        return v[3:6] if self.robot.floating else import_casadi().SX.zeros(3)

    def gaps(self, q: Expression) -> Expression:
        """Return the gaps (1, p) of the contact points at (nq, 1) q [m]."""
        ca = import_casadi()
        above = ca.DM(self.robot.contact_points.radii + self.height).T
        return ca.mtimes(ca.DM(self.frame[:, 2:].T), self.body.sphere_centres(q)) - above

    def point_speeds(self, q: Expression, v: Expression) -> Expression:
        """Return the contact points' velocities (3, p) at (nq, 1) q and (nv, 1) v, contact axes [m/s]."""
        ca = import_casadi()
        return ca.mtimes(ca.DM(self.frame.T), self.body.point_velocities(q, v, self.frame[:, 2]))


def stack_rows(rows: Sequence[Row], knots: int) -> tuple[Expression, Sides]:
    """Return rows one below the other (m, 1), and their bounds (knots, m)."""
    sizes = [(knots, int(row.shape[0])) for row, _, _ in rows]
    low = [np.broadcast_to(least, size) for (_, least, _), size in zip(rows, sizes, strict=True)]
    high = [np.broadcast_to(most, size) for (_, _, most), size in zip(rows, sizes, strict=True)]
    return import_casadi().vertcat(*(row for row, _, _ in rows)), (np.hstack(low), np.hstack(high))
