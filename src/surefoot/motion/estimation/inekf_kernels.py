"""The arithmetic of the contact-aided right-invariant filter: covariance along the motion, corrections, feet.

The state is X = [R | v | p | d_1 ... d_n] (3, 5 + n) with biases (6,): gyro, accelerometer. Its error is
X̂ X⁻¹ = exp(ξ), world axes, and the biases' own, in the order [φ; v; p; d_1 ... d_n; gyro; accelerometer]; P
is its covariance, N = 15 + 3n. Feet that do not touch have rows and columns of zeros. Equations: [1]_.

References
----------
.. [1] R. Hartley, M. Ghaffari, R. M. Eustice, J. W. Grizzle, "Contact-aided invariant extended Kalman
   filtering for robot state estimation", IJRR 39(4), 2020.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import cholesky, solve_lower
from surefoot.base.numerics.vectors import times
from surefoot.base.spatial import GRAVITY
from surefoot.motion.estimation.extended_poses import gammas, move


@inline_kernel
def _transit(x: FloatArray, X: FloatArray, on: BoolArray, h: float, last: int) -> None:
    """Replace x (N,) by Φ x, Φ = exp(A h) = I + A h + A² h²/2 + A³ h³/6 (A is nilpotent).

    Only the entries up to `last` are wanted, block by block.
    """
    n = on.shape[0]
    R, m = X[:, :3], 9 + 3 * n
    h2, h3 = 0.5 * h * h, h * h * h / 6.0
    # The biases' errors in world axes. A is that of the error of a right-invariant filter with biases: φ' =
    # -R b_g, v' = g x φ - v x R b_g - R b_a, p' = v - p x R b_g, d' = -d x R b_g.
    a, b, c = times(R, (x[m], x[m + 1], x[m + 2]))
    d, e, f = times(R, (x[m + 3], x[m + 4], x[m + 5]))
    # g x y = GRAVITY (y_y, -y_x, 0)
    # From the last block to the first: each reads those before it as they were.
    if last >= 6:
        px, py, pz = h * X[0, 4] + h2 * X[0, 3], h * X[1, 4] + h2 * X[1, 3], h * X[2, 4] + h2 * X[2, 3]
        x[6] += h * x[3] + h2 * (GRAVITY * x[1] - d) - (py * c - pz * b) - h3 * GRAVITY * b
        x[7] += h * x[4] - h2 * (GRAVITY * x[0] + e) - (pz * a - px * c) + h3 * GRAVITY * a
        x[8] += h * x[5] - h2 * f - (px * b - py * a)
    if last >= 3:
        vx, vy, vz = h * X[0, 3], h * X[1, 3], h * X[2, 3]
        x[3] += h * (GRAVITY * x[1] - d) - (vy * c - vz * b) - h2 * GRAVITY * b
        x[4] += -h * (GRAVITY * x[0] + e) - (vz * a - vx * c) + h2 * GRAVITY * a
        x[5] += -h * f - (vx * b - vy * a)
    a, b, c = h * a, h * b, h * c
    for k in range(n):
        if on[k] and last >= 9 + 3 * k:
            X0, Y0, Z0, j = X[0, 5 + k], X[1, 5 + k], X[2, 5 + k], 9 + 3 * k
            x[j] -= Y0 * c - Z0 * b
            x[j + 1] -= Z0 * a - X0 * c
            x[j + 2] -= X0 * b - Y0 * a
    x[0] -= a
    x[1] -= b
    x[2] -= c


@inline_kernel
def _transport(P: FloatArray, X: FloatArray, on: BoolArray, h: float) -> None:
    """Replace P by Φ P Φᵀ, see `_transit`; rows of feet that do not touch are zero and stay so."""
    N, n = P.shape[0], on.shape[0]
    # Rows first, P Φᵀ, then columns, Φ (P Φᵀ): Φ has few entries, and no product of matrices is formed.
    columns = P.T
    for turn in range(2):
        for i in range(N):
            if i < 9 or i >= 9 + 3 * n or on[(i - 9) // 3]:
                if turn == 0:
                    _transit(P[i], X, on, h, N)
                else:  # what is above the diagonal suffices
                    _transit(columns[i], X, on, h, i)
    for i in range(N):
        for j in range(i):
            P[i, j] = P[j, i]


@inline_kernel
def _add_noise(P: FloatArray, X: FloatArray, on: BoolArray, densities: FloatArray, h: float) -> None:
    """Add Ad_X Cov Ad_Xᵀ h to P; see `propagate` for the densities."""
    n = on.shape[0]
    m = 9 + 3 * n
    G = np.zeros((3, m))  # how the gyro's noise moves the group: [I; v x; p x; d x], transposed
    for r in range(3):
        G[r, r] = 1.0
    for k in range(2 + n):
        if k < 2 or on[k - 2]:
            x, y, z, j = X[0, 3 + k], X[1, 3 + k], X[2, 3 + k], 3 + 3 * k
            G[1, j], G[2, j] = -z, y
            G[0, j + 1], G[2, j + 1] = z, -x
            G[0, j + 2], G[1, j + 2] = -y, x
    # Only the gyro's noise couples blocks: as a turn of the body it turns v, p and d about the world's
    # origin. All noise is alike along its three axes, so R Cov Rᵀ = Cov, and the rest goes on the diagonal.
    q = densities[0] * h
    for k in range(3 + n):
        if k < 3 or on[k - 3]:
            for i in range(3 * k, 3 * k + 3):
                a, b, c = q * G[0, i], q * G[1, i], q * G[2, i]
                for j in range(m):
                    P[i, j] += a * G[0, j] + b * G[1, j] + c * G[2, j]
    for r in range(3):
        P[3 + r, 3 + r] += densities[1] * h
        P[m + r, m + r] += densities[2] * h
        P[m + 3 + r, m + 3 + r] += densities[3] * h
        for k in range(n):
            if on[k]:
                P[9 + 3 * k + r, 9 + 3 * k + r] += densities[4 + k] * h


@inline_kernel
def _march(X: FloatArray, bias: FloatArray, gyro: FloatArray, accelerometer: FloatArray, h: float) -> None:
    """Move the state on by h [s] under a constant turn rate and specific force, body axes."""
    G, phi, R = np.empty((3, 3, 3)), np.empty(3), X[:, :3].copy()
    for r in range(3):
        phi[r] = (gyro[r] - bias[r]) * h
    gammas(phi, G)
    force = accelerometer - bias[3:]
    # p + h v + h² (R Γ_2 f + g / 2), v + h (R Γ_1 f + g), R Γ_0, in this order: each reads what was before.
    u = times(R, times(G[1], (force[0], force[1], force[2])))
    w = times(R, times(G[2], (force[0], force[1], force[2])))
    for r in range(3):
        g = -GRAVITY if r == 2 else 0.0
        X[r, 4] += h * X[r, 3] + h * h * (w[r] + 0.5 * g)
        X[r, 3] += h * (u[r] + g)
        for s in range(3):
            X[r, s] = R[r, 0] * G[0, 0, s] + R[r, 1] * G[0, 1, s] + R[r, 2] * G[0, 2, s]


@kernel
def propagate(
    X: FloatArray, bias: FloatArray, P: FloatArray, on: BoolArray, gyro: FloatArray,
    accelerometer: FloatArray, densities: FloatArray, h: float,
) -> None:  # fmt: skip
    """Move state and covariance on by h [s] under a constant turn rate and specific force (3,), body axes.

    `densities` (4 + n,) are variances per second of white noise in: turn rate, specific force, the two
    biases' walks, and each foot's place. P becomes Φ (P + Ad_X Cov Ad_Xᵀ h) Φᵀ.
    """
    _add_noise(P, X, on, densities, h)
    _transport(P, X, on, h)
    _march(X, bias, gyro, accelerometer, h)


@kernel
def foresee(X: FloatArray, bias: FloatArray, gyros: FloatArray, accelerometers: FloatArray, h: float) -> None:
    """Move the state alone on by steps of h [s], one for each row of the (m, 3) readings; see `propagate`."""
    for i in range(gyros.shape[0]):
        _march(X, bias, gyros[i], accelerometers[i], h)


@inline_kernel
def _add_turned(R: FloatArray, spread: FloatArray, S: FloatArray) -> None:
    """Add R N Rᵀ to S, both (3, 3)."""
    for r in range(3):
        a = R[r, 0] * spread[0, 0] + R[r, 1] * spread[1, 0] + R[r, 2] * spread[2, 0]
        b = R[r, 0] * spread[0, 1] + R[r, 1] * spread[1, 1] + R[r, 2] * spread[2, 1]
        c = R[r, 0] * spread[0, 2] + R[r, 1] * spread[1, 2] + R[r, 2] * spread[2, 2]
        for s in range(3):
            S[r, s] += a * R[s, 0] + b * R[s, 1] + c * R[s, 2]


@inline_kernel
def _innovation(
    X: FloatArray, P: FloatArray, k: int, place: FloatArray, S: FloatArray, z: FloatArray
) -> None:
    """Fill z = R y - (d_k - p), add its covariance by the state, H P Hᵀ, H = [.. -I (p) .. I (d_k) ..], to S.

    Only what lies in the lower triangles is read and filled.
    """
    R, j = X[:, :3], 9 + 3 * k
    # z = -H ξ to first order, and H has no R in it: this is what makes the filter invariant. exp(K z) X̂
    # takes the error off.
    z[0], z[1], z[2] = times(R, (place[0], place[1], place[2]))
    for r in range(3):
        z[r] += X[r, 4] - X[r, 5 + k]
        for s in range(r + 1):
            S[r, s] += P[j + r, j + s] - P[j + r, 6 + s] - P[j + s, 6 + r] + P[6 + r, 6 + s]


@inline_kernel
def _gain(P: FloatArray, j: int, L: FloatArray, W: FloatArray) -> None:
    """Fill W (N, 3) with P Hᵀ L⁻ᵀ, so that P - K S Kᵀ = P - W Wᵀ is symmetric; the foot's rows begin at j."""
    for i in range(P.shape[0]):
        for r in range(3):  # of P the lower triangle
            p = P[i, 6 + r] if i >= 6 + r else P[6 + r, i]
            d = P[i, j + r] if i >= j + r else P[j + r, i]
            W[i, r] = d - p
        W[i, 0] = W[i, 0] / L[0, 0]
        W[i, 1] = (W[i, 1] - L[1, 0] * W[i, 0]) / L[1, 1]
        W[i, 2] = (W[i, 2] - L[2, 0] * W[i, 0] - L[2, 1] * W[i, 1]) / L[2, 2]


@kernel
def correct(
    X: FloatArray, bias: FloatArray, P: FloatArray, on: BoolArray, places: FloatArray, spreads: FloatArray,
    gate: float, distances: FloatArray, innovations: FloatArray, used: BoolArray,
) -> int:  # fmt: skip
    """Correct with where the feet are seen from the body; return how many were believed.

    A foot is believed if its squared Mahalanobis distance, before any correction, is at most `gate`.

    `places` (n, 3) [m] are measured in body axes, `spreads` (n, 3, 3) [m²] say how well; `distances` (n,),
    `used` (n,) and the whitened `innovations` (n, 3), L⁻¹ z with S = L Lᵀ, are filled. Feet are taken one by
    one (their noise is independent), the state is moved once by exp of the sum: for linear errors this is the
    one correction with all rows.
    """
    N, n, count = P.shape[0], on.shape[0], 0
    delta, W = np.zeros(N), np.empty((N, 3))
    S, z, seen = np.empty((3, 3)), np.empty(3), np.zeros((n, 3, 3))
    for k in range(n):
        used[k], distances[k] = False, 0.0
        innovations[k, 0] = innovations[k, 1] = innovations[k, 2] = 0.0
        if on[k]:
            _add_turned(X[:, :3], spreads[k], seen[k])
            S[:] = seen[k]
            _innovation(X, P, k, places[k], S, z)
            distances[k] = np.inf
            if cholesky(S):
                solve_lower(S, z)
                distances[k] = z[0] * z[0] + z[1] * z[1] + z[2] * z[2]
                innovations[k, 0], innovations[k, 1], innovations[k, 2] = z[0], z[1], z[2]
            used[k] = distances[k] <= gate
    for k in range(n):
        if not used[k]:
            continue
        # The covariance is that after the feet before, and so is the innovation, less what they have
        # corrected already.
        S[:] = seen[k]
        _innovation(X, P, k, places[k], S, z)
        j = 9 + 3 * k
        for r in range(3):
            z[r] -= delta[j + r] - delta[6 + r]
        cholesky(S)
        solve_lower(S, z)
        _gain(P, j, S, W)
        for i in range(N):
            a, b, c = W[i, 0], W[i, 1], W[i, 2]
            delta[i] += a * z[0] + b * z[1] + c * z[2]
            if i < 9 or i >= 9 + 3 * n or on[(i - 9) // 3]:
                for s in range(i + 1):
                    P[i, s] -= a * W[s, 0] + b * W[s, 1] + c * W[s, 2]
        count += 1
    if count:
        for i in range(N):
            for s in range(i):
                P[s, i] = P[i, s]
        _move_all(X, bias, delta)
    return count


@inline_kernel
def _move_all(X: FloatArray, bias: FloatArray, delta: FloatArray) -> None:
    """Apply a correction (N,) to group and biases, and keep R a rotation (one Newton step)."""
    m = delta.shape[0] - 6
    move(X, delta[:m])
    for r in range(6):
        bias[r] += delta[m + r]
    # R (3 - RᵀR) / 2: rounding of thousands of products would make R stretch.
    R, half = X[:, :3].copy(), np.empty(3)
    for r in range(3):
        for b in range(3):
            half[b] = 0.5 * (R[r, 0] * R[b, 0] + R[r, 1] * R[b, 1] + R[r, 2] * R[b, 2])
        for s in range(3):
            X[r, s] = 1.5 * R[r, s] - half[0] * R[0, s] - half[1] * R[1, s] - half[2] * R[2, s]


@kernel
def correct_height(
    X: FloatArray, bias: FloatArray, P: FloatArray, k: int, normal: FloatArray, excess: float,
    variance: float, gate: float,
) -> bool:  # fmt: skip
    """Correct with a foot's known distance from a plane; return whether it was believed.

    `excess` is nᵀ d_k less the distance that is known [m], with the plane's normal n (3,) in world axes. From
    d = d̂ + δφ x d̂ + δd the row is [(d̂ x n)ᵀ on φ, nᵀ on d_k].
    """
    N, j = P.shape[0], 9 + 3 * k
    nx, ny, nz = normal[0], normal[1], normal[2]
    x, y, z = X[0, 5 + k], X[1, 5 + k], X[2, 5 + k]
    a, b, c = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
    # P Hᵀ and H P Hᵀ + R of the one row: d̂ x n on the turn, the normal on the foot; six entries, the rest of
    # H is zero.
    column = np.empty(N)
    for i in range(N):
        p = P[i]
        column[i] = a * p[0] + b * p[1] + c * p[2] + nx * p[j] + ny * p[j + 1] + nz * p[j + 2]
    S = a * column[0] + b * column[1] + c * column[2] + variance
    S += nx * column[j] + ny * column[j + 1] + nz * column[j + 2]
    # By the squared innovation, as of feet's places; written so that NaN is not believed.
    if not excess * excess <= gate * S:
        return False
    for i in range(N):
        for s in range(N):
            # (I - K H) P of one row is P less this outer product: symmetric to the last bit, which (I - K H)
            # P multiplied out would not be.
            P[i, s] -= column[i] * column[s] / S
    _move_all(X, bias, column * (-excess / S))
    return True


@kernel
def forget_foot(P: FloatArray, k: int) -> None:
    """Take foot k out of the covariance P (N, N): its rows and columns, of any unit, become zero."""
    for r in range(9 + 3 * k, 12 + 3 * k):
        for i in range(P.shape[0]):
            P[r, i] = P[i, r] = 0.0


@kernel
def add_foot(X: FloatArray, P: FloatArray, k: int, place: FloatArray, spread: FloatArray) -> None:
    """Put foot k where it is seen from the body, place (3,) [m] with covariance (3, 3): d = p + R y.

    Its error is that of p and R times the measurement's: no Jacobian depends on the state.
    """
    R, j = X[:, :3], 9 + 3 * k
    # With d = p + R y the error of d is that of p, so rows and columns are copied (the foot's own block with
    # the second), and R N Rᵀ of the measurement y on the diagonal is all that is new.
    u = times(R, (place[0], place[1], place[2]))
    for r in range(3):
        X[r, 5 + k] = X[r, 4] + u[r]
        for i in range(P.shape[0]):
            P[j + r, i] = P[6 + r, i]
    for i in range(P.shape[0]):
        for r in range(3):
            P[i, j + r] = P[i, 6 + r]
    _add_turned(R, spread, P[j : j + 3, j : j + 3])


@kernel
def observe_feet(
    X: FloatArray, bias: FloatArray, P: FloatArray, on: BoolArray, places: FloatArray, spreads: FloatArray,
    touching: BoolArray, landed: BoolArray, walks: FloatArray, densities: FloatArray, gate: float,
    distances: FloatArray, innovations: FloatArray, used: BoolArray,
) -> None:  # fmt: skip
    """Forget feet that have left, correct with those that stand, and add those that are new or slid.

    `touching` and `landed` (n,) say which feet touch and which may still move; the first two of `walks` are
    the variances per second of a foot's place when it stands and when it has landed, which go to `densities`
    (4 + n,) [m²/s]. The rest is as in `correct`.
    """
    for k in range(on.shape[0]):
        # Before the correction, so that a foot which has left says nothing more; feet that are new or slid
        # come after it: they are placed by the state, and tell nothing of it yet.
        if on[k] and not touching[k]:
            forget_foot(P, k)
            on[k] = False
        densities[4 + k] = walks[1] if landed[k] else walks[0]
    correct(X, bias, P, on, places, spreads, gate, distances, innovations, used)
    for k in range(on.shape[0]):
        if touching[k] and not used[k]:
            add_foot(X, P, k, places[k], spreads[k])
            on[k] = True
