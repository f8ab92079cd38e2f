"""The single-rigid-body model of a horizon: from states, feet and frames to the program that is solved.

The body's motion is written as its error against a reference. Six axes, [position; orientation], along a
heading frame that is fixed over the horizon, and for each axis a double integrator driven by the
accelerations that the contact forces give::

    linear acceleration   Σ f / m
    angular acceleration  (R I Rᵀ)⁻¹ Σ (foot - centre of mass) x f

integrated exactly over a step. So that the model is linear, the body's orientation in its inertia is the
reference's, and the centre of mass in the levers is a guess of its mean over each step: from its error now,
whose velocity is expected to die out. Dropped: the gyroscopic torque, and products of errors with angular
velocities.

References
----------
.. [1] J. Di Carlo, P. Wensing, B. Katz, G. Bledt, S. Kim, "Dynamic locomotion in the MIT Cheetah 3 through
   convex model-predictive control", IROS 2018.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.rotations import log_between
from surefoot.base.numerics.vectors import cross, times
from surefoot.base.spatial import GRAVITY
from surefoot.contact import costates, newton, tracking
from surefoot.motion.control.control_settings import BODY_CONTROL

GOOD, NOT_FINITE, NOT_ROTATION = 0, 1, 2
"""What `build` found in its input."""
CALM = BODY_CONTROL.calm_time
"""A setting, as compiled code folds it."""


class Given(NamedTuple):
    """The input of a plan; motions are rows position, linear and angular velocity, world axes.

    Attributes
    ----------
    contacts, feet, frames
        (N, n), (N, n, 3), (N, n, 3, 3).
    bounds
        (N, n, 3) friction, least and largest normal force.
    rotation, motion
        (3, 3) each, of the body.
    ref_rotation, reference
        (N + 1, 3, 3) each; the same of the reference.
    """

    contacts: BoolArray
    feet: FloatArray
    frames: FloatArray
    bounds: FloatArray
    rotation: FloatArray
    motion: FloatArray
    ref_rotation: FloatArray
    reference: FloatArray


class SingleBody(NamedTuple):
    """What is moved, and what its errors cost.

    Attributes
    ----------
    mass, inverse
        Mass [kg]; (3, 3) inverse of the inertia in body axes.
    weights, terminal, dt
        (2, 6) on the errors of place and of rate; the factor on them in the last step; length of a step [s].
    rho
        Weight of the forces.
    outside, fading
        (6,) force and moment about the centre of mass from outside, world axes, now [N, N m], and the time
        constant with which they fade [s], infinite for no such thing.
    """

    mass: float
    inverse: FloatArray
    weights: FloatArray
    terminal: float
    dt: float
    rho: float
    outside: FloatArray
    fading: float


@kernel
def build(
    given: Given, body: SingleBody, sway: FloatArray
) -> tuple[
    int, IntArray, IntArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray
]:  # fmt: skip
    """Return the program of a horizon.

    Parameters
    ----------
    given, body
        See there.
    sway
        (N, 3) centre of mass minus its reference, mean over each step, for the levers.

    Returns
    -------
    tuple
        Verdict on the input, step and foot of every contact, M, bounds and wanted forces as
        `dual_newton.horizon.newton` wants them, q (N, 6), the drift (N + 1, 2, 6) whose first row is the
        error now and whose row k + 1 is what step k adds by itself, and the (3, 3) heading frame.
    """
    contacts, feet, frames, bounds, rotation, motion, ref_rotation, reference = given
    mass, inverse, weights, terminal, dt, _, outside, fading = body
    N, n = contacts.shape
    count = 0
    for k in range(N):
        for i in range(n):
            if contacts[k, i]:
                count += 1
    step, foot = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    M, limits, centre = np.empty((count, 3, 6)), np.empty((count, 3)), np.empty((count, 3))
    # One frame for all steps: between frames that turn, a step would mix the axes' errors, and the
    # integrators would not be six on their own. The heading halfway is off by the least.
    heading = _heading_frame(ref_rotation[N // 2])
    drift = _free_motion(rotation, motion, ref_rotation, reference, heading, dt)
    if fading < math.inf:
        _add_wrench(outside, fading, mass, inverse, ref_rotation, heading, dt, drift)
    # q of ½ aᵀ P a + qᵀ a is the cost's slope at a = 0: the costates along the motion without forces, which
    # has gravity, the reference and the error now in it.
    q, nothing = np.empty((N, 6)), np.zeros((N, 6))
    costates(weights, terminal, dt, predict(drift, nothing, dt)[1:], nothing, q)
    lever = np.empty(3)
    verdict = GOOD
    at = 0
    for k in range(N):
        standing = 0
        for i in range(n):
            if contacts[k, i]:
                standing += 1
        for i in range(n):
            if not contacts[k, i]:
                continue
            step[at], foot[at] = k, i
            if not _is_rotation(frames[k, i]):
                verdict = NOT_ROTATION
            for a in range(3):
                limits[at, a] = bounds[k, i, a]
                # Wanted is an even share of the weight, straight up in the world: Rᵀ e_z m g / n. The lever
                # is from where the centre of mass is expected halfway through the step.
                centre[at, a] = mass * GRAVITY / standing * frames[k, i, 2, a]
                lever[a] = feet[k, i, a] - 0.5 * (reference[k, 0, a] + reference[k + 1, 0, a]) - sway[k, a]
            _fill_columns(lever, frames[k, i], ref_rotation[k], heading, mass, inverse, M[at])
            at += 1
    # Whatever is not finite in state, reference, feet or frames has come into one of these, frames of NaN
    # too, which pass for rotations above.
    if not (_all_finite(q.ravel()) and _all_finite(M.ravel()) and _all_finite(drift.ravel())):
        verdict = NOT_FINITE
    return verdict, step, foot, M, limits, centre, q, drift, heading


@inline_kernel
def _all_finite(x: FloatArray) -> bool:
    """Return whether no entry of a flat array is NaN or infinite."""
    total = 0.0
    for k in range(x.size):
        total += x[k] - x[k]
    return total == 0.0


@kernel
def expected_sway(motion: FloatArray, reference: FloatArray, dt: float) -> FloatArray:
    """Return the (N, 3) sway for `build` if the velocity error dies out within `CALM` and its place stays."""
    N = reference.shape[0] - 1
    out = np.empty((N, 3))
    for k in range(N):
        # ∫ exp(-t / CALM) dt up to the middle of the step: the way that a unit of velocity error still goes.
        reach = CALM * (1.0 - math.exp(-(k + 0.5) * dt / CALM))
        for a in range(3):
            out[k, a] = motion[0, a] - reference[0, 0, a] + reach * (motion[1, a] - reference[0, 1, a])
    return out


@inline_kernel
def _heading_frame(R: FloatArray) -> FloatArray:
    """Return the frame with z up and x along the heading of a rotation (3, 3)."""
    c, s = R[0, 0], R[1, 0]
    length = math.sqrt(c * c + s * s)
    if length < 1e-6:
        c, s, length = 1.0, 0.0, 1.0
    out = np.zeros((3, 3))
    out[0, 0], out[0, 1] = c / length, -s / length
    out[1, 0], out[1, 1] = s / length, c / length
    out[2, 2] = 1.0
    return out


@inline_kernel
def _is_rotation(R: FloatArray) -> bool:
    """Return whether the columns are orthonormal and right-handed, to 1e-6; True for NaN."""
    worst = 0.0
    for a in range(3):
        for b in range(a, 3):
            d = R[0, a] * R[0, b] + R[1, a] * R[1, b] + R[2, a] * R[2, b] - (1.0 if a == b else 0.0)
            worst = max(worst, abs(d))
    triple = R[0, 2] * (R[1, 0] * R[2, 1] - R[2, 0] * R[1, 1])
    triple += R[1, 2] * (R[2, 0] * R[0, 1] - R[0, 0] * R[2, 1])
    triple += R[2, 2] * (R[0, 0] * R[1, 1] - R[1, 0] * R[0, 1])
    return not (worst > 1e-6 or triple < 0.0)


@inline_kernel
def _fill_columns(
    lever: FloatArray, frame: FloatArray, R: FloatArray, heading: FloatArray, mass: float,
    inverse: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill the (3, 6) accelerations along the heading's axes of a unit force along each frame axis."""
    arm = lever[0], lever[1], lever[2]
    for a in range(3):
        f = frame[0, a], frame[1, a], frame[2, a]
        # (R I Rᵀ)⁻¹ (r x f) with the reference's R: with the body's own the accelerations would not be linear
        # in the forces and the state.
        turn = times(R, times(inverse, times(R.T, cross(arm, f))))
        f, turn = times(heading.T, f), times(heading.T, turn)
        for j in range(3):
            out[a, j], out[a, 3 + j] = f[j] / mass, turn[j]


@kernel
def _free_motion(
    rotation: FloatArray, motion: FloatArray, ref_rotation: FloatArray, reference: FloatArray,
    heading: FloatArray, dt: float,
) -> FloatArray:  # fmt: skip
    """Return the error now and what every step adds to it without contact forces, see `build`."""
    N = reference.shape[0] - 1
    world = np.empty((N + 1, 2, 6))
    turn = np.empty(3)
    # Errors are the state less the reference; the attitude's is the rotation vector of R R_refᵀ, world axes.
    log_between(rotation, ref_rotation[0], turn)
    for a in range(3):
        world[0, 0, a], world[0, 0, 3 + a] = motion[0, a] - reference[0, 0, a], turn[a]
        world[0, 1, a] = motion[1, a] - reference[0, 1, a]
        world[0, 1, 3 + a] = motion[2, a] - reference[0, 2, a]
    for k in range(N):
        log_between(ref_rotation[k + 1], ref_rotation[k], turn)
        for a in range(3):
            fall = -GRAVITY if a == 2 else 0.0
            # what the reference does not do by itself in a step: e' = e + dt ė + (r + dt ṙ + dt² g / 2 - r')
            world[k + 1, 0, a] = (
                reference[k, 0, a] - reference[k + 1, 0, a] + dt * reference[k, 1, a] + 0.5 * dt * dt * fall
            )
            world[k + 1, 1, a] = reference[k, 1, a] - reference[k + 1, 1, a] + dt * fall
            # The same of turns, whose rotation vectors are added up: products of errors with turn rates are
            # dropped, and so is the gyroscopic torque.
            world[k + 1, 0, 3 + a] = dt * reference[k, 2, a] - turn[a]
            world[k + 1, 1, 3 + a] = reference[k, 2, a] - reference[k + 1, 2, a]
    out = np.zeros((N + 1, 2, 6))
    for k in range(N + 1):
        for s in range(2):
            for j in range(3):
                for a in range(3):
                    out[k, s, j] += heading[a, j] * world[k, s, a]
                    out[k, s, 3 + j] += heading[a, j] * world[k, s, 3 + a]
    return out


@kernel
def predict(drift: FloatArray, accelerations: FloatArray, dt: float) -> FloatArray:
    """Return the (N + 1, 2, 6) errors under (N, 6) accelerations."""
    out = drift.copy()
    for k in range(accelerations.shape[0]):
        for j in range(6):
            a = accelerations[k, j]
            out[k + 1, 0, j] = out[k, 0, j] + dt * out[k, 1, j] + 0.5 * dt * dt * a + drift[k + 1, 0, j]
            out[k + 1, 1, j] = out[k, 1, j] + dt * a + drift[k + 1, 1, j]
    return out


@kernel
def _add_wrench(
    wrench: FloatArray, fading: float, mass: float, inverse: FloatArray, rotations: FloatArray,
    heading: FloatArray, dt: float, drift: FloatArray,
) -> None:  # fmt: skip
    """Add what a wrench from outside does to the drift, see `build`; `rotations` are the reference's."""
    for k in range(drift.shape[0] - 1):
        # Held over a step as the forces are, at its value halfway; it accelerates as they do, its moment in
        # the place of r x f.
        share = math.exp(-(k + 0.5) * dt / fading)
        R = rotations[k]
        f = wrench[0], wrench[1], wrench[2]
        turn = times(R, times(inverse, times(R.T, (wrench[3], wrench[4], wrench[5]))))
        f, turn = times(heading.T, f), times(heading.T, turn)
        for j in range(3):
            for axis, a in ((j, f[j] / mass), (3 + j, turn[j])):
                drift[k + 1, 0, axis] += 0.5 * dt * dt * share * a
                drift[k + 1, 1, axis] += dt * share * a


@kernel
def finish(
    step: IntArray, foot: IntArray, M: FloatArray, force: FloatArray, drift: FloatArray, frames: FloatArray,
    heading: FloatArray, reference: FloatArray, dt: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Return forces in contact frames and in world axes, the predicted motion and orientation errors.

    Both forces are (N, n, 3) [N], zero in swing; the motion (N + 1, 3, 3) rows position, linear and angular
    velocity, the errors (N + 1, 3) rotation vectors [rad], world axes. Arguments as `build` returns them,
    with (c, 3) forces of all contacts.
    """
    N, n = frames.shape[:2]
    forces, world = np.zeros((N, n, 3)), np.zeros((N, n, 3))
    accelerations = np.zeros((N, 6))
    for i in range(step.size):
        k, leg = step[i], foot[i]
        for a in range(3):
            forces[k, leg, a] = force[i, a]
            for j in range(6):
                # a = M f, summed over the feet of a step; the wrench from outside is in the drift already.
                accelerations[k, j] += M[i, a, j] * force[i, a]
            for b in range(3):
                world[k, leg, b] += frames[k, leg, b, a] * force[i, a]
    # The motion is the reference plus its error, back from the heading's axes to the world's.
    errors = predict(drift, accelerations, dt)
    motion, turn = reference.copy(), np.zeros((N + 1, 3))
    for k in range(N + 1):
        for b in range(3):
            for a in range(3):
                motion[k, 0, b] += heading[b, a] * errors[k, 0, a]
                motion[k, 1, b] += heading[b, a] * errors[k, 1, a]
                motion[k, 2, b] += heading[b, a] * errors[k, 1, 3 + a]
                turn[k, b] += heading[b, a] * errors[k, 0, 3 + a]
    return forces, world, motion, turn


@kernel
def plan_forces(
    given: Given, body: SingleBody, points: FloatArray, tol: float, patience: int, limit: int
) -> tuple[int, int, float, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the verdict on the input, the steps, the error bound [N] and what `finish` does.

    Parameters
    ----------
    given, body
        See there.
    points
        (N, n, 3) guess of the points, see `dual_newton.horizon.newton`; those of the answer on return.
    tol, patience, limit
        As for `newton`.
    """
    reference, dt = given.reference, body.dt
    sway = expected_sway(given.motion, reference, dt)
    verdict, step, foot, M, limits, centre, q, drift, heading = build(given, body, sway)
    # Of input that is not GOOD no program is solved: the forces stay zero, and their bound infinite.
    count, error, force = 0, math.inf, np.zeros((step.size, 3))
    if verdict == GOOD:
        cost = tracking(body.weights, body.terminal, dt, given.contacts.shape[0])
        count, error = newton(
            cost, q, step, foot, M, limits, centre, body.rho, tol, patience, limit, points, force
        )
        if not math.isfinite(error):
            verdict = NOT_FINITE
    forces, world, planned, turn = finish(step, foot, M, force, drift, given.frames, heading, reference, dt)
    return verdict, count, error, forces, world, planned, turn
