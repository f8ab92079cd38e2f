"""What a motion costs, as values: states, torques, feet near the ground, joints beyond their bounds.

Every term is half a weighted sum of squares over the knots::

    state       ½ e(x)ᵀ diag(w) e(x)                   e: see `StateCost`; also at the last knot
    torques     ½ (u - u_w)ᵀ R (u - u_w)
    slip        ½ w c(gap)² ||v_t||²,                  c² = 1 / (1 + exp(gap / width))
    landing     ½ w c(gap)² v_n²
    bounds      ½ w max(0, q - q_max, q_min - q)²      and of the joints' speeds
    coupling    ½ zᵀ C z,                              z = (joints less the wanted ones, their speeds)

The slip term makes a foot that has to move tangentially lift first, the role of foot slip and clearance in
Kim et al. [1]_; coupling and R tie legs together, their symmetric control cost. None of the terms says
when a foot touches.

References
----------
.. [1] G. Kim, D. Kang, J.-H. Kim, S. Hong, H.-W. Park, "Contact-implicit model predictive control:
   controlling diverse quadruped motions without pre-planned contact modes or trajectories", IJRR 2024, arXiv
   2312.08961.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, real_number, semidefinite
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot
from surefoot.motion.planning.shooting.cost_terms import (
    FootTable,
    JointTable,
    StateTable,
    Tables,
    TorqueTable,
)


@dataclass(frozen=True)
class StateCost:
    """Distance of states from wanted ones.

    The residuals e of a free flyer are its place less the wanted one in world axes [m], the rotation vector
    of R_wantedᵀ R [rad], and its velocities less the wanted ones in its own axes; of joints, plain
    differences.

    Attributes
    ----------
    weights
        (2nv,) or (N, 2nv) of the residuals at the knots' starts.
    terminal
        (2nv,) of the last state; None for the weights of the last knot.
    q
        (nq,) or (N + 1, nq) wanted configuration; None for the nominal one.
    v
        (nv,) or (N + 1, nv) wanted velocity, that of a free flyer in world axes.
    """

    weights: ArrayLike
    terminal: ArrayLike | None = None
    q: ArrayLike | None = None
    v: ArrayLike = 0.0

    def table(self, robot: Robot, knots: int) -> StateTable:
        """Return the weights, and the wanted q and v at N + 1 states."""
        nq, nv = int(robot.model.nq), int(robot.model.nv)
        weights = np.empty((knots + 1, 2 * nv))
        weights[:-1] = _spread("state weights", self.weights, (knots, 2 * nv), low=0.0)
        last = weights[-2] if self.terminal is None else self.terminal
        weights[-1] = _spread("terminal weights", last, (2 * nv,), low=0.0)
        q = robot.configuration(None) if self.q is None else self.q
        return weights, _spread("q", q, (knots + 1, nq)), _spread("v", self.v, (knots + 1, nv))


@dataclass(frozen=True)
class TorqueCost:
    """Squared torques, less wanted ones.

    Attributes
    ----------
    weights
        A number or (m,) [1/(N m)²].
    matrix
        (m, m) added to them: what ties torques together; symmetric and positive semidefinite.
    wanted
        (m,) or (N, m) [N m].
    """

    weights: ArrayLike = 1e-4
    matrix: ArrayLike | None = None
    wanted: ArrayLike = 0.0

    def table(self, robot: Robot, knots: int) -> TorqueTable:
        """Return R, and the wanted torques at N knots."""
        m = robot.joints
        R = np.diag(_spread("torque weights", self.weights, (m,), low=0.0))
        if self.matrix is not None:
            R = R + semidefinite("torque matrix", self.matrix, m)
        if m and np.linalg.eigvalsh(R)[0] <= 0.0:
            raise ProblemError("torque weights must be positive: the inputs' Hessian has no inverse without")
        return R, _spread("wanted torques", self.wanted, (knots, m))


@dataclass(frozen=True)
class FootCost:
    """What contact points do near the ground.

    Attributes
    ----------
    slip
        A number, (p,) or (N, p): weight of tangential speed near the ground [s²/m²].
    width
        Gap over which the weight of a slip falls off [m].
    landing
        A number, (p,) or (N, p): weight of normal speed near the ground [s²/m²].
    landing_width
        Gap over which that falls off [m]. A foot that comes down within a knot is seen only before it.
    """

    slip: ArrayLike = 0.0
    width: float = 0.02
    landing: ArrayLike = 0.0
    landing_width: float = 0.02

    def table(self, robot: Robot, knots: int) -> FootTable:
        """Return the weights and the widths."""
        shape = knots, len(robot.contact_points)
        weights = np.empty((knots, 2, shape[1]))
        weights[:, 0] = _spread("slip", self.slip, shape, low=0.0)
        weights[:, 1] = _spread("landing", self.landing, shape, low=0.0)
        widths = {"width": self.width, "landing_width": self.landing_width}
        return weights, np.array([real_number(name, width, low=1e-6) for name, width in widths.items()])


@dataclass(frozen=True)
class JointCost:
    """Joints beyond their bounds, and their coupling.

    Attributes
    ----------
    position_weight, speed_weight
        Of what is beyond the robot's own limits [1/rad²], [s²/rad²].
    coupling
        (2m, 2m) C on (joints less the wanted ones, joint speeds), symmetric and positive semidefinite.
    """

    position_weight: float = 0.0
    speed_weight: float = 0.0
    coupling: ArrayLike | None = None

    def table(self, robot: Robot) -> JointTable:
        """Return bounds, weights and coupling."""
        m, model = robot.joints, robot.model
        given = {"position_weight": self.position_weight, "speed_weight": self.speed_weight}
        weights = np.repeat([real_number(name, value, low=0.0) for name, value in given.items()], m)
        low, high = (x[model.nq - m :] for x in (model.lowerPositionLimit, model.upperPositionLimit))
        most = model.velocityLimit[model.nv - m :]
        bounds = np.array([np.r_[low, -most], np.r_[high, most]])
        C = np.zeros((0, 0)) if self.coupling is None else semidefinite("coupling", self.coupling, 2 * m)
        return bounds, weights, C


@dataclass(frozen=True)
class Costs:
    """What a motion costs; the parts of the sum.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> tables = Costs(StateCost(np.ones(36))).tables(load_robot("go2"), knots=20)
    >>> tables.state[0].shape, tables.torque[0].shape
    ((21, 36), (12, 12))
    """

    state: StateCost
    torque: TorqueCost = field(default_factory=TorqueCost)
    feet: FootCost = field(default_factory=FootCost)
    joints: JointCost = field(default_factory=JointCost)

    def tables(self, robot: Robot, knots: int) -> Tables:
        """Return the costs as arrays over N knots.

        Raises
        ------
        ProblemError
            For arrays that do not fit the robot or the horizon, are not finite, or weights below zero.
        """
        return Tables(
            self.state.table(robot, knots), self.torque.table(robot, knots), self.feet.table(robot, knots),
            self.joints.table(robot),
        )  # fmt: skip


def _spread(name: str, value: ArrayLike, shape: tuple[int, ...], low: float = -np.inf) -> FloatArray:
    """Return a value as an array of a shape, repeated along the leading axes that it lacks."""
    array = finite_array(name, value)
    if array.ndim and array.shape != shape[len(shape) - array.ndim :]:
        fits = " or ".join(str(shape[k:]) for k in range(len(shape)))
        raise ProblemError(f"{name} must be a number or have shape {fits}, got {array.shape}")
    if array.size and array.min() < low:
        raise ProblemError(f"{name} must be >= {low:g}, got {array.min():g}")
    return np.ascontiguousarray(np.broadcast_to(array, shape)).copy()
