"""Centroidal motions over a mode schedule: centre of mass, angular momentum, contact forces, footholds.

The robot is its mass and an inertia that turns with it; forces are constant over a knot, so that its motion
under them is known exactly::

    c⁺ = c + dt v + dt²/2 a        v⁺ = v + dt a        a = Σ f / m + g
    h⁺ = h + dt Σ (p - c̄) x f      c̄ = c + dt v / 2 + dt² a / 6, the mean of c over the knot
    R⁺ = R exp(dt I⁻¹ R̄ᵀ h̄)        h̄ = (h + h⁺) / 2, R̄ half-way: of second order

Feet that stand have a foothold on the ground that stays while they do and is within a box about its place
below the hip, and forces inside the exact friction cone. Angular momentum is a cost, and within a bound if
one is given; nothing forces it to zero.

References
----------
.. [1] D. Orin, A. Goswami, S.-H. Lee, "Centroidal dynamics of a humanoid robot", Autonomous Robots 35, 2013.
.. [2] H. Dai, A. Valenzuela, R. Tedrake, "Whole-body motion planning with centroidal dynamics and full
   kinematics", Humanoids 2014.
.. [3] A. Winkler, C. Bellicoso, M. Hutter, J. Buchli, "Gait and trajectory optimization for legged systems
   through phase-based end-effector parameterization", RA-L 3, 2018.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.direct.blocks import Block, pack
from surefoot.planning.schedule.centroidal_problem import CentroidalProblem
from surefoot.planning.schedule.search import Sides
from surefoot.planning.transcription.forms import import_casadi
from surefoot.spatial import GRAVITY, rotation_from_quaternion

ROUND = 1e-3
"""Rounds the cone's tip from inside, as a share of m g: sqrt(f_t² + ROUND²) <= mu f_n."""
STATE = 13
"""Numbers of a state before the footholds: c (3), quaternion (4), velocity (3), momentum / mass (3)."""


def centroidal_block(problem: CentroidalProblem) -> Block:
    """Return the block of a problem's knots: x = (c, quaternion, v, h / m, footholds), u = forces / m g."""
    ca, n, dt, mass = import_casadi(), problem.schedule.feet, problem.dt, problem.mass
    x, after = (ca.SX.sym(name, STATE + 2 * n) for name in ("x", "after"))
    u = ca.SX.sym("u", 3 * n)
    c, turn, v, h = x[:3], x[3:7], x[7:10], x[10:13]
    c_after, turn_after, v_after, h_after = after[:3], after[3:7], after[7:10], after[10:13]
    frame, origin = ca.DM(problem.frame), ca.DM(problem.origin)
    shares = ca.reshape(u, 3, n)
    forces = GRAVITY * ca.mtimes(frame, shares)  # per mass
    places = ca.mtimes(frame[:, :2], ca.reshape(x[STATE:], 2, n)) + ca.repmat(origin, 1, n)
    a = ca.sum2(forces) - ca.DM([0.0, 0.0, GRAVITY])
    mean = c + 0.5 * dt * v + dt * dt / 6.0 * a
    torque = ca.SX.zeros(3)
    for i in range(n):
        torque += ca.cross(places[:, i] - mean, forces[:, i])
    inverse = ca.DM(np.linalg.inv(problem.inertia / mass))
    middle = 0.5 * (h + h_after)
    halfway = _turned(turn, 0.5 * dt * ca.mtimes(inverse, ca.mtimes(_matrix(turn).T, middle)))
    spin = ca.mtimes(inverse, ca.mtimes(_matrix(halfway).T, middle))
    below = [
        ca.mtimes(_matrix(t).T, places - ca.repmat(centre, 1, n)) - ca.DM(problem.stand.T)
        for t, centre in ((turn, c), (turn_after, c_after))
    ]
    size = ca.sqrt(shares[0, :] ** 2 + shares[1, :] ** 2 + ROUND**2)
    rows = ca.vertcat(
        (c_after - c) / dt - v - 0.5 * dt * a, turn_after - _turned(turn, dt * spin), v_after - v - dt * a,
        h_after - h - dt * torque, after[STATE:] - x[STATE:], (problem.mu * shares[2, :] - size).T,
        ca.reshape(below[0], 3 * n, 1), ca.reshape(below[1], 3 * n, 1),
    )  # fmt: skip
    w, data, nothing = problem.weights, ca.SX.sym("data", 7 + n), ca.SX.sym("nothing", 0)
    reference, stands = data[:7], data[7:]
    cost = w.position * ca.sumsqr(c_after - reference[:3])
    cost += w.orientation * ca.sumsqr(turn_after - reference[3:])
    cost += w.velocity * ca.sumsqr(v_after) + w.force * ca.sumsqr(u)
    cost += w.momentum * ca.sumsqr(h_after - ca.DM(problem.momentum / mass))
    cost += w.foothold * ca.dot(stands, ca.sum1(below[0][:2, :] ** 2).T)
    return Block(x, u, after, nothing, rows, dt * cost, data)


def centroidal_rows(problem: CentroidalProblem) -> Sides:
    """Return the bounds (knots, m) of the rows in their units; infinite where a row does not matter."""
    n, stance = problem.schedule.feet, problem.stance
    least = np.zeros((problem.knots, STATE + 9 * n))
    most = least.copy()
    stays = np.vstack([stance[:-1] & stance[1:], np.zeros((1, n), dtype=bool)])
    moves = ~np.repeat(stays, 2, axis=1)
    at, cone, box = STATE, STATE + 2 * n, STATE + 3 * n
    least[:, at:cone][moves], most[:, at:cone][moves] = -np.inf, np.inf
    least[:, cone:box][~stance] = -np.inf
    most[:, cone:box] = np.inf
    inside = np.tile(np.where(stance[:, :, None], problem.reach, np.inf).reshape(problem.knots, -1), 2)
    inside[0, : 3 * n] = np.inf  # the start is given
    least[:, box:], most[:, box:] = -inside, inside
    return least, most


def centroidal_variables(problem: CentroidalProblem) -> Sides:
    """Return the bounds of all variables (V,) in their units, in the order of the NLP."""
    n, N, stance = problem.schedule.feet, problem.knots, problem.stance
    bound = problem.momentum_bound / problem.mass
    low = np.full((N + 1, STATE + 2 * n), -np.inf)
    high = -low
    low[1:, 10:13], high[1:, 10:13] = -bound, bound
    scale = np.concatenate([np.ones(3), np.full(3, problem.mass)])
    for k, window in problem.windows.items():
        window.narrow(low[k, :STATE], high[k, :STATE], 7, scale)
    low[0, :STATE] = high[0, :STATE] = np.concatenate([problem.pose, problem.velocity / scale])
    feet = ((problem.feet - problem.origin) @ problem.frame[:, :2]).ravel()
    standing = np.repeat(stance[0], 2)
    low[0, STATE:][standing] = high[0, STATE:][standing] = feet[standing]
    force = np.where(np.repeat(stance, 3, axis=1), np.inf, 0.0)
    least, most = -force, force
    least[:, 2::3] = stance * (problem.force_min / problem.weight)
    most[:, 2::3] = np.where(stance, problem.force_max / problem.weight, 0.0)
    return pack(low, least), pack(high, most)


def centroidal_start(problem: CentroidalProblem) -> FloatArray:
    """Return variables (V,) to start from, each in its unit.

    They are the reference, with the weight on the feet that stand, and footholds below the hips.
    """
    n, N, stance = problem.schedule.feet, problem.knots, problem.stance
    com, quaternion = problem.reference[:, :3], problem.reference[:, 3:]
    speed = np.vstack([problem.velocity[:3], np.diff(com, axis=0) / problem.dt])
    turned = np.array([rotation_from_quaternion(t) for t in quaternion])
    places = com[:, None] + np.einsum("kij,nj->kni", turned, problem.stand)
    flat = ((places - problem.origin) @ problem.frame[:, :2]).reshape(N + 1, 2 * n)
    momentum = np.zeros((N + 1, 3))
    states = np.hstack([com, quaternion, speed, momentum, flat])
    forces = np.zeros((N, n, 3))
    forces[:, :, 2] = stance / np.maximum(stance.sum(axis=1, keepdims=True), 1)
    return pack(states, forces.reshape(N, -1))


def _matrix(quaternion: Any) -> Any:
    """Return the rotation of a quaternion in symbols."""
    ca = import_casadi()
    x, y, z, w = (quaternion[k] for k in range(4))
    return ca.vertcat(
        ca.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        ca.horzcat(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        ca.horzcat(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


def _turned(quaternion: Any, rotation: Any) -> Any:
    """Return a quaternion after a turn by a rotation vector in body axes, in symbols."""
    ca = import_casadi()
    square = ca.sumsqr(rotation) + 1e-16  # the root has a slope at zero
    angle = ca.sqrt(square)
    s, c = ca.sin(0.5 * angle) / angle * rotation, ca.cos(0.5 * angle)
    v, w = quaternion[:3], quaternion[3]
    return ca.vertcat(w * s + c * v + ca.cross(v, s), w * c - ca.dot(v, s))
