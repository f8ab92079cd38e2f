"""Compiled pieces of whole-body control: feet's kinematics, constraint rows, tasks, elimination.

Notation: a (nv,) accelerations, f contact forces, w = G f the generalised force of the ground on the
floating base (6,). Dynamics of the base and rigid contacts are E a = e + [w; 0]; the tasks ask for the
least ½ aᵀ H a - cᵀ a. Eliminating a leaves a quadratic in w alone, see `eliminate`.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import cholesky, product, solve_columns, solve_lower
from surefoot.base.numerics.points import point_jacobian
from surefoot.base.numerics.vectors import Three, cross


@inline_kernel
def _three(x: FloatArray, at: int) -> Three:
    return x[at], x[at + 1], x[at + 2]


@kernel
def feet_motion(
    jacobian: FloatArray,
    variation: FloatArray,
    support: BoolArray,
    v: FloatArray,
    rotations: FloatArray,
    places: FloatArray,
    middles: FloatArray,
    centres: FloatArray,
    twists: FloatArray,
    drifts: FloatArray,
) -> None:
    """Fill centres (n, 3), twists (n, 6) and drifts (n, 6) of the feet, world axes.

    The drift is the classical acceleration of the centre, and the angular one, at zero joint
    acceleration: spatial acceleration at the world's origin, moved to the centre, plus ω x v of the
    centre, which is where classical and spatial acceleration differ.

    Parameters
    ----------
    jacobian, variation
        (6, nv) Pinocchio's data.J and data.dJ: columns are twists at the world's origin.
    support
        (n, nv) which velocity components move each foot.
    v
        (nv,).
    rotations, places
        (n, 3, 3), (n, 3) frames of the feet.
    middles
        (n, 3) centres in the feet's frames.
    """
    count, nv = support.shape
    for k in range(count):
        # Spatial velocity J v, and acceleration J̇ v at zero v̇, both of the foot's body at the world's
        # origin: data.J has columns of every joint, of which only the foot's ancestors move it.
        twist, spatial = np.zeros(6), np.zeros(6)
        for j in range(nv):
            if support[k, j]:
                for i in range(6):
                    twist[i] += jacobian[i, j] * v[j]
                    spatial[i] += variation[i, j] * v[j]
        for i in range(3):
            centres[k, i] = places[k, i]
            for j in range(3):
                centres[k, i] += rotations[k, i, j] * middles[k, j]
        # Both fields at the centre: v + ω x c, and v̇ + ω̇ x c.
        turn = cross(_three(twist, 3), _three(centres[k], 0))
        swerve = cross(_three(spatial, 3), _three(centres[k], 0))
        for i in range(3):
            twists[k, i], twists[k, 3 + i] = twist[i] + turn[i], twist[3 + i]
        # Spatial acceleration is the rate at a place fixed in the world; that of the material point adds ω x
        # v.
        bend = cross(_three(twist, 3), _three(twists[k], 0))
        for i in range(3):
            drifts[k, i], drifts[k, 3 + i] = spatial[i] + swerve[i] + bend[i], spatial[3 + i]


@inline_kernel
def _turning_rows(jacobian: FloatArray, support: BoolArray, out: FloatArray) -> None:
    """Fill out (3, nv) with the rows of a foot's angular velocity, world axes."""
    for i in range(3):
        for j in range(jacobian.shape[1]):
            out[i, j] = jacobian[3 + i, j] if support[j] else 0.0


@kernel
def contact_rows(
    jacobian: FloatArray,
    support: BoolArray,
    flat: BoolArray,
    stance: BoolArray,
    centres: FloatArray,
    twists: FloatArray,
    drifts: FloatArray,
    arms: FloatArray,
    gaps: FloatArray,
    normals: FloatArray,
    baumgarte: tuple[float, float, float, float],
    rows: FloatArray,
    wanted: FloatArray,
) -> int:
    """Fill the rows of rigid contacts, J a = wanted, and return how many there are.

    A point foot is a sphere that rolls: v + ω x arm = 0 with the arm from its centre to the ground
    fixed in the world, so its rows differentiate to a_centre + α x arm, with no centripetal term. A
    flat foot has its sole's six rows. Baumgarte: a stiffness [1/s²] for the gap along the normal, and the
    rates [1/s] at which what is left of the velocity decays, of a sole's along the normal, and of its turn.

    The Jacobian is (6, nv) and `support` (n, nv), as for `numerics.points.point_jacobian`; flat and stance
    are (n,) masks; centres, arms (n, 3) and gaps (n,) [m], twists (n, 6) [m/s, rad/s] and drifts (n, 6)
    [m/s², rad/s²] of the feet, normals (n, 3), all in world axes. Filled: rows (.., nv) and wanted (..,).
    """
    at = 0
    stiffness, damping, sinking, turning = baumgarte
    for k in range(stance.shape[0]):
        if not stance[k]:
            continue
        # The constraint is asked for as v̇ + damping v + stiffness gap n = 0 (Baumgarte): held on
        # accelerations alone, what integration loses would stay as slip and as depth.
        point = centres[k] + arms[k]
        point_jacobian(jacobian, support[k], point, rows[at : at + 3])
        arm = _three(arms[k], 0)
        slip, drift = cross(_three(twists[k], 3), arm), cross(_three(drifts[k], 3), arm)
        # Positive above the ground: it enters below with a minus, as an acceleration towards the ground. A
        # sole's normal velocity decays at its own rate, so along the normal the difference of the rates is
        # added.
        push = stiffness * gaps[k]
        if flat[k]:
            for i in range(3):
                push += (sinking - damping) * normals[k, i] * (twists[k, i] + slip[i])
        for i in range(3):
            left = damping * (twists[k, i] + slip[i]) + push * normals[k, i]
            wanted[at + i] = -(drifts[k, i] + drift[i]) - left
        at += 3
        if flat[k]:
            _turning_rows(jacobian, support[k], rows[at : at + 3])
            for i in range(3):
                wanted[at + i] = -drifts[k, 3 + i] - turning * twists[k, 3 + i]
            at += 3
    return at


@kernel
def _add_rows(H: FloatArray, c: FloatArray, rows: FloatArray, wanted: FloatArray, weight: float) -> None:
    """Add weight ½ ||rows a - wanted||² to ½ aᵀ H a - cᵀ a."""
    nv = H.shape[0]
    for r in range(rows.shape[0]):
        for i in range(nv):
            s = weight * rows[r, i]
            if s != 0.0:
                c[i] += s * wanted[r]
                for j in range(nv):
                    H[i, j] += s * rows[r, j]


@kernel
def base_tasks(
    M: FloatArray,
    nle: FloatArray,
    rotation: FloatArray,
    mass: float,
    gravity: float,
    com_acceleration: FloatArray,
    turn_acceleration: FloatArray,
    weights: FloatArray,
    joint_acceleration: FloatArray,
    joint_weights: FloatArray,
    H: FloatArray,
    c: FloatArray,
) -> None:
    """Set H and c to the tasks of the base and the joints.

    The acceleration of the centre of mass is read off the dynamics' first three rows, which are
    m Rᵀ (c̈ - gravity); the base's angular acceleration is the state's own. `weights` is (2,):
    linear and angular.
    """
    nv = M.shape[0]
    H[:] = 0.0
    c[:] = 0.0
    rows, wanted = np.empty((3, nv)), np.empty(3)
    for i in range(3):
        drift = 0.0
        for k in range(3):
            drift += rotation[i, k] * nle[k] / mass
        # c̈ = R (M a + nle)_lin / m + g with g = (0, 0, -gravity): rows a = c̈ - g - R nle_lin / m
        wanted[i] = com_acceleration[i] - drift + (gravity if i == 2 else 0.0)
        for j in range(nv):
            rows[i, j] = (
                rotation[i, 0] * M[0, j] + rotation[i, 1] * M[1, j] + rotation[i, 2] * M[2, j]
            ) / mass
    _add_rows(H, c, rows, wanted, weights[0])
    for i in range(3):
        # In the state's own axes ω̇ is Rᵀ α: the turning of the axes adds ω x ω = 0. No row of M is needed,
        # so the task stays diagonal in H.
        local = 0.0
        for k in range(3):
            local += rotation[k, i] * turn_acceleration[k]
        H[3 + i, 3 + i] += weights[1]
        c[3 + i] += weights[1] * local
    for j in range(6, nv):
        H[j, j] += joint_weights[j - 6]
        c[j] += joint_weights[j - 6] * joint_acceleration[j - 6]


@kernel
def swing_tasks(
    jacobian: FloatArray,
    support: BoolArray,
    flat: BoolArray,
    stance: BoolArray,
    centres: FloatArray,
    drifts: FloatArray,
    wanted: FloatArray,
    weight: float,
    turn_weight: float,
    H: FloatArray,
    c: FloatArray,
) -> None:
    """Add the tasks of the feet in the air: (n, 6) wanted acceleration of centre, turn [m/s², rad/s²]."""
    nv = jacobian.shape[1]
    rows = np.empty((3, nv))
    for k in range(stance.shape[0]):
        if stance[k]:
            continue
        # The task is J a + drift = wanted: the drift is known and goes to the right.
        point_jacobian(jacobian, support[k], centres[k], rows)
        _add_rows(H, c, rows, wanted[k, :3] - drifts[k, :3], weight)
        if flat[k]:
            _turning_rows(jacobian, support[k], rows)
            _add_rows(H, c, rows, wanted[k, 3:] - drifts[k, 3:], turn_weight)


@kernel
def _reduce_cost(
    H: FloatArray, c: FloatArray, offset: FloatArray, gain: FloatArray, root: FloatArray, target: FloatArray
) -> bool:
    """Fill root and target so that a = offset + gain w costs ½ ||rootᵀ w - target||²; see `eliminate`."""
    nv = H.shape[0]
    # ½ aᵀ H a - cᵀ a at a = offset + gain w: Hessian gainᵀ H gain, gradient gainᵀ (H offset - c) at w = 0.
    HX = np.empty((nv, 6))
    product(H, gain, HX)
    root[:] = 0.0
    trace = 0.0
    for i in range(6):
        s = 0.0
        for j in range(nv):
            s += HX[j, i] * offset[j] - gain[j, i] * c[j]
        target[i] = -s
        for k in range(6):
            for j in range(nv):
                root[i, k] += gain[j, i] * HX[j, k]
        trace += root[i, i]
    for i in range(6):
        # Where constraints leave a wrench nothing to accelerate, gain loses rank and the Hessian is singular:
        # a shift of the size of rounding keeps the factor.
        root[i, i] += 1e-12 * trace
    if not cholesky(root):
        return False
    # ½ ||Lᵀ w - t||² has the gradient L (Lᵀ w - t): t is L⁻¹ of the negative one.
    solve_lower(root, target)
    for i in range(6):
        for k in range(i + 1, 6):
            root[i, k] = 0.0
    return True


@kernel
def eliminate(
    H: FloatArray, c: FloatArray, E: FloatArray, e: FloatArray, offset: FloatArray, gain: FloatArray,
    root: FloatArray, target: FloatArray,
) -> bool:  # fmt: skip
    """Eliminate the accelerations: fill a = offset + gain w, and the cost ½ ||rootᵀ w - target||².

    For a given w the best a minimises ½ aᵀ H a - cᵀ a subject to E a = e + [w; 0]; with
    S = E H⁻¹ Eᵀ it is H⁻¹ (c + Eᵀ S⁻¹ (e + [w; 0] - E H⁻¹ c)). Put back, the cost is a quadratic in w
    with the Hessian gainᵀ H gain = root rootᵀ.

    Parameters
    ----------
    H, c
        (nv, nv), (nv,) tasks.
    E, e
        (r, nv), (r,) constraints; the first six rows are the base's dynamics.
    offset, gain, root, target
        Results: (nv,), (nv, 6), (6, 6) lower triangular, (6,).

    Returns
    -------
    bool
        False if a factorisation failed (input that is not finite).
    """
    nv, r = H.shape[0], E.shape[0]
    L = H.copy()
    if not cholesky(L):
        return False
    Y, free = np.empty((nv, r)), np.empty((nv, 1))
    for j in range(nv):
        for i in range(r):
            Y[j, i] = E[i, j]
        free[j, 0] = c[j]
    solve_columns(L, Y)  # H⁻¹ Eᵀ
    solve_columns(L, free)  # H⁻¹ c
    # The answer is affine in w, which enters the first six constraints alone: one factor of S serves their
    # six unit vectors (the gain) and the known right-hand side (the offset).
    S, B = np.empty((r, r)), np.zeros((r, 7))
    product(E, Y, S)
    trace = 0.0
    for i in range(r):
        trace += S[i, i]
    for i in range(r):
        B[i, 6] = e[i]
        for j in range(nv):
            B[i, 6] -= E[i, j] * free[j, 0]
        S[i, i] += 1e-13 * trace  # contacts may repeat one another; dynamics then hold to rounding
        if i < 6:
            B[i, i] = 1.0
    if not cholesky(S):
        return False
    solve_columns(S, B)  # S⁻¹ [e_1 ... e_6, e - E H⁻¹ c]: gain and offset side by side
    X = np.empty((nv, 7))
    product(Y, B, X)
    for j in range(nv):
        offset[j] = free[j, 0] + X[j, 6]
        for i in range(6):
            gain[j, i] = X[j, i]
    return _reduce_cost(H, c, offset, gain, root, target)


@kernel
def place_points(
    frames: FloatArray, foot: IntArray, rotations: FloatArray, places: FloatArray, offsets: FloatArray,
    radii: FloatArray, normals: FloatArray, arms: FloatArray, point_frames: FloatArray, points: FloatArray,
) -> None:  # fmt: skip
    """Fill the feet's normals and arms (n, 3), and frames (p, 3, 3) and places (p, 3) of the contact points.

    Parameters
    ----------
    frames
        (n, 3, 3) rotation_world_contact of each foot's ground.
    foot
        (p,) which foot carries each point.
    rotations, places
        (n, 3, 3), (n, 3) frames of the feet, world axes [m].
    offsets, radii
        (p, 3) of the points' centres in their foot's frame; (n,) of the feet's spheres [m].
    """
    for k in range(len(radii)):
        for i in range(3):
            # The lowest point of a sphere along the ground's normal touches, whatever way the foot is turned.
            normals[k, i] = frames[k, i, 2]
            arms[k, i] = -radii[k] * frames[k, i, 2]
    for j in range(len(foot)):
        k = foot[j]
        for i in range(3):
            total = places[k, i] + arms[k, i]
            for a in range(3):
                total += rotations[k, i, a] * offsets[j, a]
                point_frames[j, i, a] = frames[k, i, a]
            points[j, i] = total
