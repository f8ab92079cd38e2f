"""Compiled pieces of the standing controller: grasp map, PD wrench, swing-foot impedance.

They have loops and no `@`, for which Numba loads SciPy's linear algebra at the first call, a tenth of a
second.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import cholesky, solve_columns, solve_lower, solve_upper
from surefoot.base.numerics.points import point_jacobian
from surefoot.base.numerics.rotations import log_between
from surefoot.base.numerics.vectors import Three, cross, times


@kernel
def grasp_map_of_points(
    rotations: FloatArray,
    places: FloatArray,
    point_foot: IntArray,
    centres: FloatArray,
    radii: FloatArray,
    frames: FloatArray,
    com: FloatArray,
    out: FloatArray,
) -> FloatArray:
    """Fill the (6, 3p) grasp map about `com` and return the (p, 3) contact points in world axes.

    A point lies below its sphere's centre along the ground's normal, the third column of its frame.
    """
    count = point_foot.shape[0]
    points = np.empty((count, 3))
    for k in range(count):
        foot = point_foot[k]
        for i in range(3):
            points[k, i] = places[foot, i] - radii[k] * frames[k, i, 2]
            for j in range(3):
                points[k, i] += rotations[foot, i, j] * centres[k, j]
        # Column of a unit force along each contact axis: [axis; arm x axis], moments about the centre of
        # mass.
        arm = points[k, 0] - com[0], points[k, 1] - com[1], points[k, 2] - com[2]
        for j in range(3):
            axis, column = (frames[k, 0, j], frames[k, 1, j], frames[k, 2, j]), 3 * k + j
            out[0, column], out[1, column], out[2, column] = axis
            out[3, column], out[4, column], out[5, column] = cross(arm, axis)
    return points


@kernel
def foot_impedance(
    jacobian: FloatArray,
    support: BoolArray,
    mass_matrix: FloatArray,
    v: FloatArray,
    place: FloatArray,
    miss: FloatArray,
    velocity: FloatArray,
    omega: float,
) -> FloatArray:
    """Return torques of a critically damped impedance at a foot, as heavy as the leg feels there.

    Parameters
    ----------
    jacobian
        (6, nv) Pinocchio's data.J: each column the joint's twist at the world's origin.
    support
        (nv,) which velocity components move the foot.
    mass_matrix
        (nv, nv).
    v
        (nv,) velocity.
    place, miss, velocity
        (3,) the foot, how far it is from its target, and the target's velocity, world axes.
    omega
        Natural frequency [rad/s].
    """
    nv = jacobian.shape[1]
    # The foot's velocity counts the base's, since its target is fixed in the world; the torques are the leg's
    # alone, and so is the inertia: the base is taken to stand still.
    legs = np.flatnonzero(support[6:]) + 6
    J, moving = np.empty((3, nv)), support.copy()
    moving[:6] = True
    point_jacobian(jacobian, moving, place, J)
    count = legs.shape[0]
    leg_mass, answer, mobility, force = (
        np.empty((count, count)),
        np.empty((count, 3)),
        np.empty((3, 3)),
        np.empty(3),
    )
    for i in range(count):
        for k in range(3):
            answer[i, k] = J[k, legs[i]]
        for j in range(count):
            a, b = min(legs[i], legs[j]), max(legs[i], legs[j])
            leg_mass[i, j] = mass_matrix[a, b]  # Pinocchio fills the upper triangle
    out = np.zeros(nv - 6)
    if not cholesky(leg_mass):
        return out
    solve_columns(leg_mass, answer)
    # J M⁻¹ Jᵀ of the leg alone: its inverse is the mass that the foot feels
    trace = 0.0
    for i in range(3):
        now = 0.0
        for j in range(nv):
            now += J[i, j] * v[j]
        force[i] = omega * omega * miss[i] + 2.0 * omega * (velocity[i] - now)
        for k in range(3):
            mobility[i, k] = 0.0
            for j in range(count):
                mobility[i, k] += J[i, legs[j]] * answer[j, k]
        trace += mobility[i, i]
    for i in range(3):
        mobility[i, i] += 1e-3 * trace  # a stretched leg has no mobility along itself
    # F = Λ (ω² e + 2 ω ė) with Λ = (J M⁻¹ Jᵀ)⁻¹, then τ = Jᵀ F: the foot answers as a unit mass on a
    # critically damped spring along every axis, however the leg is bent.
    if not cholesky(mobility):
        return out
    solve_lower(mobility, force)
    solve_upper(mobility, force)
    for i in range(count):
        for k in range(3):
            out[legs[i] - 6] += J[k, legs[i]] * force[k]
    return out


@inline_kernel
def _apply_base_matrix(R: FloatArray, A: FloatArray, x: Three) -> Three:
    """Return R A Rᵀ x: a (3, 3) matrix of base axes acts on a vector of world axes."""
    a, b, c = x
    own = (
        R[0, 0] * a + R[1, 0] * b + R[2, 0] * c,
        R[0, 1] * a + R[1, 1] * b + R[2, 1] * c,
        R[0, 2] * a + R[1, 2] * b + R[2, 2] * c,
    )
    return times(R, times(A, own))


@kernel
def pd_wrench(
    rotation: FloatArray,
    wanted_rotation: FloatArray,
    q: FloatArray,
    v: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
    inertia_base: FloatArray,
    mass: float,
    omega: float,
    omega_turn: float,
    gravity: float,
    integral: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the PD law's wrench about the centre of mass, and its position part, both (6,).

    Critically damped with natural frequencies `omega` and `omega_turn` [rad/s]; gravity is
    compensated and the integral wrench added. The second result, stiffness times error, is what the
    integral term accumulates.

    Parameters
    ----------
    rotation, wanted_rotation
        (3, 3) of the base, now and wanted.
    q, v
        State in Pinocchio's order.
    position, velocity, acceleration
        (3,) wanted for the base, world axes.
    inertia_base
        (3, 3) of the whole robot about its centre of mass, base axes [kg m²].
    """
    miss, wrench, pull = np.empty(3), np.empty(6), np.empty(6)
    log_between(wanted_rotation, rotation, miss)
    linear, angular = times(rotation, (v[0], v[1], v[2])), times(rotation, (v[3], v[4], v[5]))
    # force m (ω² e + 2 ω ė + p̈ + g), moment I (ω² e - 2 ω w): critically damped in the body's own inertia
    turn = omega_turn * omega_turn
    stiff = _apply_base_matrix(rotation, inertia_base, (turn * miss[0], turn * miss[1], turn * miss[2]))
    damped = _apply_base_matrix(rotation, inertia_base, angular)
    for i in range(3):
        pull[i] = mass * omega * omega * (position[i] - q[i])
        pull[3 + i] = stiff[i]
        wrench[i] = integral[i] + pull[i]
        wrench[i] += mass * (2.0 * omega * (velocity[i] - linear[i]) + acceleration[i])
        wrench[3 + i] = integral[3 + i] + pull[3 + i] - 2.0 * omega_turn * damped[i]
    wrench[2] += mass * gravity
    return wrench, pull


@kernel
def within_limits(torques: FloatArray, limits: FloatArray) -> tuple[FloatArray, bool]:
    """Return torques (j,) cut to ± limits [N m], and whether all were finite."""
    out, finite = np.empty(torques.size), True
    for j in range(torques.size):
        out[j] = min(max(torques[j], -limits[j]), limits[j])
        finite = finite and np.isfinite(torques[j])
    return out, finite
