"""A robot in the air, integrated to fourth order: what momentum it keeps, and how shape turns it.

Runge-Kutta-Munthe-Kaas [1]_: the classical fourth-order step in the tangent coordinates ξ of
q = q₀ ⊕ ξ, with ξ̇ = (d(q₀ ⊕ ξ)/dξ)⁻¹ v, so that orientations stay orientations and the order holds on the
rotation group. The rigid world's first-order steps would let the momentum drift by far more than the effects
looked for here.

References
----------
.. [1] H. Munthe-Kaas, "High order Runge-Kutta methods on manifolds", Applied Numerical Mathematics 29, 1999.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.centroidal import base_velocity_for, momentum

Control = Callable[[float, FloatArray, FloatArray], FloatArray]
"""Function of time [s], q and v that returns (joints,) torques [N m] or joint accelerations [rad/s^2]."""
Rates = Callable[[float, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Function of time [s], q and v that returns how fast q moves and v changes: (nv,) each."""
Shape = Callable[[float], tuple[FloatArray, FloatArray]]
"""Function of time [s] that returns the (joints,) joint positions [rad] and velocities [rad/s]."""

STAGES = ((0.0, 1.0, 0.5), (0.5, 2.0, 0.5), (0.5, 2.0, 1.0), (1.0, 1.0, 0.0))
"""The classical fourth-order scheme: time of a slope, its weight, and the share of the step to the next."""


@dataclass(frozen=True)
class FlightRecord:
    """A flight, step by step.

    Attributes
    ----------
    time
        (n,) [s].
    q, v
        (n, nq) and (n, nv) in Pinocchio's order.
    momentum
        (n, 6) [linear; angular] about the centre of mass, world axes.
    com
        (n, 3) centre of mass [m].
    """

    time: FloatArray
    q: FloatArray
    v: FloatArray
    momentum: FloatArray
    com: FloatArray


def fly(
    robot: Robot,
    q: FloatArray,
    v: FloatArray,
    seconds: float,
    *,
    torque: Control | None = None,
    joint_acceleration: Control | None = None,
    dt: float = 1e-3,
) -> FlightRecord:
    """Integrate the equations of motion of a robot that touches nothing.

    Parameters
    ----------
    robot, q, v
        Robot, (nq,) configuration and (nv,) velocity at the start.
    seconds
        Length of the flight.
    torque
        Motor torques (then the articulated-body algorithm gives the motion), or
    joint_acceleration
        accelerations that the motors enforce (then the base follows from its six equations of motion).
    dt
        Step [s].

    Raises
    ------
    ProblemError
        If both or neither of torque and joint_acceleration are given, or the base is fixed.
    """
    import pinocchio

    if (torque is None) == (joint_acceleration is None):
        raise ProblemError("give either torque or joint_acceleration")
    if not robot.floating:
        raise ProblemError(f"{robot.name} has a fixed base and does not fly")
    model, data = robot.model, robot.model.createData()

    def by_torque(t: float, at: FloatArray, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        assert torque is not None
        effort = np.concatenate([np.zeros(6), torque(t, at, speed)])
        return speed, np.array(pinocchio.aba(model, data, at, speed, effort))

    def by_acceleration(t: float, at: FloatArray, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        assert joint_acceleration is not None
        joints = np.asarray(joint_acceleration(t, at, speed), dtype=np.float64)
        # Nothing pushes the base: its six rows M_bb a_b + M_bj a_j + h_b = 0 give a_b for accelerations of
        # the joints.
        M = np.array(pinocchio.crba(model, data, at))[:6]
        M[:, :6] = np.triu(M[:, :6]) + np.triu(M[:, :6], 1).T
        bias = pinocchio.nonLinearEffects(model, data, at, speed)[:6]
        return speed, np.concatenate([np.linalg.solve(M[:, :6], -bias - M[:, 6:] @ joints), joints])

    rates = by_torque if torque is not None else by_acceleration
    steps, h = _steps(seconds, dt)
    states = [(robot.configuration(q), finite_array("v", v, (model.nv,)))]
    for k in range(steps):
        states.append(_munthe_kaas(robot, *states[-1], rates, k * h, h))
    return _to_log(robot, h, states)


def follow_shape(
    robot: Robot,
    q: FloatArray,
    shape: Shape,
    seconds: float,
    *,
    carried: FloatArray | None = None,
    gravity: bool = False,
    dt: float = 1e-3,
) -> FlightRecord:
    """Integrate the base under a prescribed shape and a conserved momentum: kinematics only, no forces.

    Parameters
    ----------
    robot, q
        Robot and (nq,) configuration [m, -, rad] at the start; its joints are replaced by the shape's.
    shape
        Joint positions and velocities over time.
    carried
        (6,) momentum at the start [linear; angular] [N s, N m s]; None for zero.
    gravity
        Whether gravity takes its part of the linear momentum.
    """
    steps, h = _steps(seconds, dt)
    start = np.zeros(6) if carried is None else finite_array("carried", carried, (6,))
    weight = -robot.mass * GRAVITY if gravity else 0.0

    def velocity(t: float, at: FloatArray) -> FloatArray:
        full = at.copy()
        full[7:], rates = shape(t)
        # Angular momentum about the centre of mass is kept whatever gravity does.
        h_now = start + np.array([0.0, 0.0, weight * t, 0.0, 0.0, 0.0])
        return np.concatenate([base_velocity_for(robot, full, rates, h_now), rates])

    def rates(t: float, at: FloatArray, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        return velocity(t, at), np.zeros_like(speed)  # what is left of v is not used

    now = robot.configuration(q)
    now[7:] = shape(0.0)[0]
    states = [(now, velocity(0.0, now))]
    for k in range(steps):
        now, _ = _munthe_kaas(robot, *states[-1], rates, k * h, h)
        now[7:] = shape((k + 1) * h)[0]
        states.append((now, velocity((k + 1) * h, now)))
    return _to_log(robot, h, states)


def _steps(seconds: float, dt: float) -> tuple[int, float]:
    length = real_number("seconds", seconds, low=0.0)
    steps = max(1, round(length / real_number("dt", dt, low=1e-7)))
    return steps, length / steps


def _tangent_rate(robot: Robot, q: FloatArray, xi: FloatArray, v: FloatArray) -> FloatArray:
    """Return ξ̇ for q ⊕ ξ to move with v; only the base's group is curved."""
    import pinocchio

    D = pinocchio.dIntegrate(robot.model, q, xi, pinocchio.ArgumentPosition.ARG1)
    out = v.copy()
    out[:6] = np.linalg.solve(D[:6, :6], v[:6])
    return out


def _munthe_kaas(
    robot: Robot, q: FloatArray, v: FloatArray, rates: Rates, t: float, h: float
) -> tuple[FloatArray, FloatArray]:
    """Return q and v one step later, for what they change by at a time, a place and a velocity."""
    import pinocchio

    xi, speed = np.zeros_like(v), v
    total_xi, total_v = np.zeros_like(v), np.zeros_like(v)
    for when, weight, share in STAGES:
        at = np.array(pinocchio.integrate(robot.model, q, xi))
        way, slope_v = rates(t + when * h, at, speed)
        slope_xi = _tangent_rate(robot, q, xi, way)
        total_xi, total_v = total_xi + weight * slope_xi, total_v + weight * slope_v
        xi, speed = share * h * slope_xi, v + share * h * slope_v
    q_next = np.array(pinocchio.integrate(robot.model, q, h / 6.0 * total_xi))
    return q_next, v + h / 6.0 * total_v


def _to_log(robot: Robot, h: float, states: list[tuple[FloatArray, FloatArray]]) -> FlightRecord:
    kept = [momentum(robot, q, v) for q, v in states]
    return FlightRecord(
        h * np.arange(len(states), dtype=np.float64),
        np.array([q for q, _ in states]),
        np.array([v for _, v in states]),
        np.array([k.vector for k in kept]),
        np.array([k.com for k in kept]),
    )
