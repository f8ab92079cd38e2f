"""The backward pass: a Riccati recursion with bounds on the inputs, and the box program at every knot.

State tangents are dx = (dq, dv), each of length n. A semi-implicit step gives::

    dv⁺ = A_v dx + B_v du,    dq⁺ = S dq + dt W dv⁺

with S and W, the derivatives of the way, equal to the identity outside the first b rows (six of a free
flyer), which hold w columns: b of a plain step, all n where the base's place follows the centre of mass. So
the quadratic of the value behind the step is first written in (dq, dv⁺), and only products with A_v and B_v
are left: a third of the work of dense A and B.

At every knot the input's step k solves the box program ``min ½ kᵀ Q_uu k + Q_uᵀ k, low <= k <= high``, and
the gains K answer with the inputs that are free there: control-limited DDP [1]_. Gaps of open knots enter the
value's gradient as in [2]_.

References
----------
.. [1] Y. Tassa, N. Mansard, E. Todorov, "Control-limited differential dynamic programming", ICRA 2014.
.. [2] C. Mastalli, W. Merkt, J. Marti-Saumell, H. Ferrolho, J. Solà, N. Mansard, S. Vijayakumar, "A
   feasibility-driven approach to control-limited DDP", Autonomous Robots 46, 2022.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.numerics.cholesky import cholesky, product, solve_lower, solve_upper

BOX_STEPS, HALVINGS = 40, 30
"""Newton steps of a box program, and halvings of one."""
BOX_TOLERANCE = 1e-10
"""Gradient of free inputs, relative to the largest entry of g, at which a box program is solved."""


@inline_kernel
def _slope(H: FloatArray, g: FloatArray, x: FloatArray, out: FloatArray) -> float:
    """Fill out with H x + g and return ½ xᵀ H x + gᵀ x."""
    value = 0.0
    for i in range(g.size):
        total = 0.0
        for j in range(g.size):
            total += H[i, j] * x[j]
        out[i] = total + g[i]
        value += x[i] * (0.5 * total + g[i])
    return value


@inline_kernel
def _factor_free(H: FloatArray, free: IntArray, count: int, L: FloatArray) -> bool:
    """Fill the leading block of L with the Cholesky factor of H on the free indices."""
    for i in range(count):
        for j in range(i + 1):
            L[i, j] = H[free[i], free[j]]
    return cholesky(L[:count, :count])


@kernel
def solve_box(
    H: FloatArray, g: FloatArray, low: FloatArray, high: FloatArray, x: FloatArray, free: IntArray,
    L: FloatArray,
) -> int:  # fmt: skip
    """Minimise ½ xᵀ H x + gᵀ x within low <= x <= high by projected Newton steps.

    Parameters
    ----------
    H, g
        (m, m) positive definite and (m,).
    low, high
        (m,) with low <= high.
    x
        (m,) to start from, and filled.
    free
        (m,) to be filled: the first entries are the indices of unknowns between their bounds.
    L
        (m, m) whose leading block is filled with the Cholesky factor of H on these.

    Returns
    -------
    int
        How many are free; -1 if H is not definite there or the steps ran out.
    """
    m = g.size
    slope, trial, step = np.empty(m), np.empty(m), np.empty(m)
    size, count = 0.0, -1
    for i in range(m):
        x[i] = min(max(x[i], low[i]), high[i])
        size = max(size, abs(g[i]))
    value = _slope(H, g, x, slope)
    for _ in range(BOX_STEPS):
        count, worst = 0, 0.0
        for i in range(m):
            if not ((x[i] <= low[i] and slope[i] > 0.0) or (x[i] >= high[i] and slope[i] < 0.0)):
                free[count] = i
                count += 1
                worst = max(worst, abs(slope[i]))
        if not _factor_free(H, free, count, L):
            return -1
        if worst <= BOX_TOLERANCE * size:
            return count
        for i in range(count):
            step[i] = -slope[free[i]]
        solve_lower(L[:count, :count], step[:count])
        solve_upper(L[:count, :count], step[:count])
        share, found = 1.0, False
        for _ in range(HALVINGS):
            drop = 0.0
            for i in range(m):
                trial[i] = x[i]
            for i in range(count):
                j = free[i]
                trial[j] = min(max(x[j] + share * step[i], low[j]), high[j])
                drop += slope[j] * (trial[j] - x[j])
            after = _slope(H, g, trial, slope)
            if after <= value + 0.1 * drop or drop > -1e-15 * abs(value):
                found = True
                break
            _slope(H, g, x, slope)
            share *= 0.5
        if not found:
            return -1
        for i in range(m):
            x[i] = trial[i]
        if after >= value:  # rounding: this is as far as it goes
            value = after
            continue
        value = after
    return -1


@inline_kernel
def _behind(V: FloatArray, moved: FloatArray, dt: float, out: FloatArray) -> None:
    """Fill out with Tᵀ V, rows of (dq⁺, dv⁺) written by those of (dq, dv⁺): T = [S, dt W; 0, 1]."""
    n, b = V.shape[0] // 2, moved.shape[1]
    for i in range(n, 2 * n):
        for j in range(V.shape[1]):
            out[i, j] = V[i, j]
    for i in range(n):
        own = 1.0 if i >= b else 0.0
        for j in range(V.shape[1]):
            out[i, j] = own * V[i, j]
            out[n + i, j] += own * dt * V[i, j]
    for i in range(moved.shape[2]):
        for k in range(b):
            s, w = moved[0, k, i], dt * moved[1, k, i]
            for j in range(V.shape[1]):
                out[i, j] += s * V[k, j]
                out[n + i, j] += w * V[k, j]


@inline_kernel
def _transpose(A: FloatArray, out: FloatArray) -> None:
    for i in range(A.shape[0]):
        for j in range(A.shape[1]):
            out[j, i] = A[i, j]


@inline_kernel
def _carry_back(V: FloatArray, moved: FloatArray, dt: float, half: FloatArray, turned: FloatArray) -> None:
    """Replace the symmetric V by Tᵀ V T."""
    _behind(V, moved, dt, half)
    _transpose(half, turned)
    _behind(turned, moved, dt, V)


@inline_kernel
def _add_transposed(M: FloatArray, x: FloatArray, out: FloatArray) -> None:
    """Add Mᵀ x to out."""
    for i in range(x.size):
        s = x[i]
        for j in range(out.size):
            out[j] += s * M[i, j]


@inline_kernel
def _inputs(
    V: FloatArray, Av: FloatArray, Bv: FloatArray, M: FloatArray, back: FloatArray, Qux: FloatArray,
    Quu: FloatArray,
) -> None:  # fmt: skip
    """Fill M with V_vv A_v + [V_vq, 0], Q_ux with B_vᵀ M and Q_uu with B_vᵀ V_vv B_v, from V in (dq, dv⁺)."""
    n = Av.shape[0]
    product(V[n:, n:], Av, M)
    for i in range(n):
        for j in range(n):
            M[i, j] += V[n + i, j]
    product(Bv.T, M, Qux)
    product(Bv.T, V[n:, n:], back)
    product(back, Bv, Quu)


@inline_kernel
def _answer(
    Qux: FloatArray, free: IntArray, count: int, L: FloatArray, Y: FloatArray, gains: FloatArray
) -> None:
    """Fill Y with L⁻¹ Q_ux and the gains with -Q_uu⁻¹ Q_ux, of the free inputs; the others' gains are 0."""
    width = Qux.shape[1]
    for i in range(gains.shape[0]):
        for j in range(width):
            gains[i, j] = 0.0
    for i in range(count):
        for j in range(width):
            Y[i, j] = Qux[free[i], j]
        for k in range(i):
            s = L[i, k]
            for j in range(width):
                Y[i, j] -= s * Y[k, j]
        s = 1.0 / L[i, i]
        for j in range(width):
            Y[i, j] *= s
    for i in range(count - 1, -1, -1):
        r = free[i]
        for j in range(width):
            gains[r, j] = -Y[i, j]
        for k in range(i + 1, count):
            s, other = L[k, i], free[k]
            for j in range(width):
                gains[r, j] -= s * gains[other, j]
        s = 1.0 / L[i, i]
        for j in range(width):
            gains[r, j] *= s


@inline_kernel
def _value_before(
    V: FloatArray, Av: FloatArray, M: FloatArray, X: FloatArray, lxx: FloatArray, Y: FloatArray, count: int
) -> None:
    """Replace V, in (dq, dv⁺), by l_xx + [V_qq, 0] + A_vᵀ M + Mᵀ A_v less V_vv's share, less Yᵀ Y."""
    n, twice = Av.shape
    for i in range(n):  # A_vᵀ V_vv A_v counts once: half here, half in the transpose
        for j in range(n):
            M[i, j] += V[n + i, j]
        for j in range(twice):
            M[i, j] *= 0.5
    product(Av.T, M, X)
    for i in range(twice):
        for j in range(i + 1):
            total = lxx[i, j] + X[i, j] + X[j, i]
            if i < n:
                total += V[i, j]
            V[i, j] = total
    for k in range(count):
        for i in range(twice):
            s = Y[k, i]
            for j in range(i + 1):
                V[i, j] -= s * Y[k, j]
    for i in range(twice):
        for j in range(i):
            V[j, i] = V[i, j]


@inline_kernel
def _slope_ahead(
    V: FloatArray, slope: FloatArray, gap: FloatArray, moved: FloatArray, dt: float, out: FloatArray
) -> None:
    """Fill out with Tᵀ (slope + V gap): the value's gradient behind the step, in (dq, dv⁺)."""
    twice, b = slope.size, moved.shape[1]
    n = twice // 2
    reached = np.empty(twice)
    for i in range(twice):
        reached[i] = slope[i]
        for j in range(twice):
            reached[i] += V[i, j] * gap[j]
    for i in range(n):
        own = 1.0 if i >= b else 0.0
        out[i], out[n + i] = own * reached[i], reached[n + i] + own * dt * reached[i]
    for i in range(moved.shape[2]):
        for k in range(b):
            out[i] += moved[0, k, i] * reached[k]
            out[n + i] += dt * moved[1, k, i] * reached[k]


@inline_kernel
def _complete(
    Quu: FloatArray, Qu: FloatArray, luu: FloatArray, lu: FloatArray, Bv: FloatArray, ahead: FloatArray,
    damping: float,
) -> None:  # fmt: skip
    """Add the knot's own cost and the damping to Q_uu, and fill Q_u."""
    for i in range(Qu.size):
        for j in range(i + 1):
            Quu[i, j] = Quu[j, i] = 0.5 * (Quu[i, j] + Quu[j, i]) + luu[i, j]
        Quu[i, i] += damping
        Qu[i] = lu[i]
    _add_transposed(Bv, ahead, Qu)


@inline_kernel
def _expect(Quu: FloatArray, Qu: FloatArray, step: FloatArray, predicted: FloatArray) -> None:
    """Add what a knot's step changes of the cost."""
    for i in range(step.size):
        predicted[0] += Qu[i] * step[i]
        for j in range(step.size):
            predicted[1] += step[i] * Quu[i, j] * step[j]


@kernel
def backward_pass(
    dynamics: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    costs: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    box: tuple[FloatArray, FloatArray],
    damping: float, dt: float, gains: FloatArray, steps: FloatArray, slopes: FloatArray,
    predicted: FloatArray,
) -> bool:  # fmt: skip
    """Run the Riccati recursion over N knots; return whether every box program was solved.

    Parameters
    ----------
    dynamics
        A (N, 2n, 2n) and B (N, 2n, m), whose lower halves are read; S and W (N, 2, b, w); and the gaps
        (N, 2n): where each knot's step ends less where the next knot starts.
    costs
        Gradients (N + 1, 2n) and Hessians (N + 1, 2n, 2n) by the states; (N, m) and (N, m, m) by the inputs.
    box
        Bounds (N, m) on the inputs' steps.
    damping
        Weight of ½ ||du||², added at every knot.
    dt
        Length of a knot [s].
    gains, steps, slopes
        To be filled: K (N, m, 2n), k (N, m), and the value's gradient (N + 1, 2n) at every knot. The steps
        that they hold are where the box programs start.
    predicted
        (2,) to be filled: change of the cost for a share a of the step is a predicted[0] + ½ a² predicted[1].
    """
    A, B, moved, gaps = dynamics
    lx, lxx, lu, luu = costs
    N, m, twice = steps.shape[0], steps.shape[1], lx.shape[1]
    n = twice // 2
    V, half, turned, X = np.empty((4, twice, twice))
    M, ahead, back = np.empty((n, twice)), np.empty(twice), np.empty((m, n))
    Quu, Qux, Qu = np.empty((m, m)), np.empty((m, twice)), np.empty(m)
    free, L, Y = np.empty(m, dtype=np.int64), np.empty((m, m)), np.empty((m, twice))
    V[:], slopes[N] = lxx[N], lx[N]
    predicted[0] = predicted[1] = 0.0
    for k in range(N - 1, -1, -1):
        Av, Bv, slope = A[k, n:], B[k, n:], slopes[k]
        # the value behind the step, and with it the cost-to-go by state and input
        _slope_ahead(V, slopes[k + 1], gaps[k], moved[k], dt, ahead)
        _carry_back(V, moved[k], dt, half, turned)
        _inputs(V, Av, Bv, M, back, Qux, Quu)
        _complete(Quu, Qu, luu[k], lu[k], Bv, ahead[n:], damping)
        # the inputs' step and gains
        count = solve_box(Quu, Qu, box[0][k], box[1][k], steps[k], free, L)
        if count < 0:
            return False
        _answer(Qux, free, count, L, Y, gains[k])
        _expect(Quu, Qu, steps[k], predicted)
        # the value before it
        _value_before(V, Av, M, X, lxx[k], Y, count)
        for i in range(twice):
            slope[i] = lx[k, i] + (ahead[i] if i < n else 0.0)
        _add_transposed(Av, ahead[n:], slope)
        _add_transposed(Qux, steps[k], slope)
    return True
