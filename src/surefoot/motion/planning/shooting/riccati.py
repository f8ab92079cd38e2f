"""The backward pass: a Riccati recursion with bounds on the inputs, and the box program at every knot.

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

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel
from surefoot.base.numerics.cholesky import cholesky, solve_columns

BOX_STEPS, HALVINGS = 40, 30
"""Newton steps of a box program, and halvings of one."""
BOX_TOLERANCE = 1e-10
"""Gradient of free inputs, relative to the largest entry of g, at which a box program is solved."""


@kernel
def solve_box(
    H: FloatArray, g: FloatArray, low: FloatArray, high: FloatArray, x: FloatArray
) -> tuple[bool, IntArray, FloatArray]:
    """Minimise ½ xᵀ H x + gᵀ x within low <= x <= high by projected Newton steps.

    Parameters
    ----------
    H, g
        (m, m) positive definite and (m,).
    low, high
        (m,) with low <= high.
    x
        (m,) to start from, and filled.

    Returns
    -------
    bool, (f,), (f, f)
        Whether it is solved, else H is not definite or the steps ran out; the indices of unknowns between
        their bounds, and the Cholesky factor of H on these.
    """
    x[:] = np.minimum(np.maximum(x, low), high)
    slope = H @ x + g
    value, size = 0.5 * np.dot(x, slope + g), np.abs(g).max()
    for _ in range(BOX_STEPS):
        # The active set of this iterate: inputs at a bound that the gradient pushes further out. Newton's
        # step is that of the others, and projected: it may meet new bounds without a search for which comes
        # first [1].
        held = ((x <= low) & (slope > 0.0)) | ((x >= high) & (slope < 0.0))
        free = np.flatnonzero(~held)
        L = np.ascontiguousarray(H[free][:, free])
        if not cholesky(L):
            return False, free, L
        if free.size == 0 or np.abs(slope[free]).max() <= BOX_TOLERANCE * size:
            return True, free, L
        step = -slope[free].reshape(-1, 1)
        solve_columns(L, step)
        share, found = 1.0, False
        for _ in range(HALVINGS):
            trial = x.copy()
            trial[free] = np.minimum(np.maximum(x[free] + share * step[:, 0], low[free]), high[free])
            ahead = H @ trial + g
            # Armijo's rule along the projected path.
            drop, after = np.dot(slope, trial - x), 0.5 * np.dot(trial, ahead + g)
            found = after <= value + 0.1 * drop or drop > -1e-15 * abs(value)  # or as far as rounding lets it
            if found:
                break
            share *= 0.5
        if not found:
            return False, free, L
        x[:], slope, value = trial, ahead, after
    return False, free, L


@kernel
def backward_pass(
    dynamics: tuple[FloatArray, FloatArray, FloatArray],
    costs: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    box: tuple[FloatArray, FloatArray],
    damping: float, gains: FloatArray, steps: FloatArray, slopes: FloatArray, predicted: FloatArray,
) -> bool:  # fmt: skip
    """Run the Riccati recursion over N knots; return whether every box program was solved.

    Parameters
    ----------
    dynamics
        A (N, 2n, 2n) and B (N, 2n, m), and the gaps (N, 2n): where each knot's step ends less where the next
        knot starts.
    costs
        Gradients (N + 1, 2n) and Hessians (N + 1, 2n, 2n) by the states; (N, m) and (N, m, m) by the inputs.
    box
        Bounds (N, m) on the inputs' steps.
    damping
        Weight of ½ ||du||², added at every knot.
    gains, steps, slopes
        To be filled: K (N, m, 2n), k (N, m), and the value's gradient (N + 1, 2n) at every knot. The steps
        that they hold are where the box programs start.
    predicted
        (2,) to be filled: change of the cost for a share a of the step is a predicted[0] + ½ a² predicted[1].
    """
    A, B, gaps = dynamics
    lx, lxx, lu, luu = costs
    N, m = steps.shape
    V = lxx[N].copy()
    slopes[N] = lx[N]
    predicted[:] = 0.0
    gains[:] = 0.0
    for k in range(N - 1, -1, -1):
        # the cost-to-go by state and input, Q of [1]
        # The slope of the value where the knot ends: from where the next one starts it changes by V times the
        # gap.
        ahead = slopes[k + 1] + V @ gaps[k]
        VA, VB = V @ A[k], V @ B[k]
        Qu, Qux = lu[k] + B[k].T @ ahead, B[k].T @ VA
        Quu = luu[k] + damping * np.eye(m) + B[k].T @ VB
        # the inputs' step and gains
        solved, free, L = solve_box(Quu, Qu, box[0][k], box[1][k], steps[k])
        if not solved:
            return False
        answer = Qux[free]
        solve_columns(L, answer)
        gains[k][free] = -answer
        # Inputs that are held have no gain: feedback would push them through their bounds, or hold them off.
        predicted[0] += np.dot(Qu, steps[k])
        predicted[1] += np.dot(steps[k], Quu @ steps[k])
        # the value before it
        # Kᵀ Q_uu K + Kᵀ Q_ux = 0 and Kᵀ (Q_uu k + Q_u) = 0 by the two solves above, so one product is left of
        # each. The mean with the transpose keeps rounding from growing over the horizon.
        V = lxx[k] + A[k].T @ VA + Qux.T @ gains[k]
        V = 0.5 * (V + V.T)
        slopes[k] = lx[k] + A[k].T @ ahead + Qux.T @ steps[k]
    return True
