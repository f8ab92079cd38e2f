"""The group SE_k(3) of a rotation and k vectors: velocity, position and feet in one matrix.

An element is held as its upper rows, (3, 3 + k): [R | x_1 ... x_k]; the whole matrix has the identity below.
A vector of its algebra is (3 + 3k,), φ in [rad]: [φ; ρ_1; ...; ρ_k]. With S the cross product by φ and
Γ_m(φ) = Σ_j S^j / (j + m)! the exponential is

    exp(ξ) = [Γ_0(φ) | Γ_1(φ) ρ_1 ... Γ_1(φ) ρ_k],

and Γ_1, Γ_2 integrate a rotating acceleration once and twice, exactly for a constant turn rate [1]_.

References
----------
.. [1] R. Hartley, M. Ghaffari, R. M. Eustice, J. W. Grizzle, "Contact-aided invariant extended Kalman
   filtering for robot state estimation", IJRR 39(4), 2020, section 6 and appendix.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel
from surefoot.base.numerics.vectors import times


@kernel
def gammas(phi: FloatArray, out: FloatArray) -> None:
    """Fill out (3, 3, 3) with Γ_0, Γ_1 and Γ_2 of a rotation vector (3,) [rad].

    Γ_m = I / m! + c_{m+1} S + c_{m+2} S² with c_m = Σ_j (-θ²)^j / (2j + m)!; c_3 and c_4 are summed as series
    where their closed forms cancel, the others follow from c_m = 1/m! - θ² c_{m+2}.
    """
    x, y, z = phi[0], phi[1], phi[2]
    square = x * x + y * y + z * z
    # θ - sin θ and θ²/2 + cos θ - 1 lose all digits for small angles; ten terms of the series are exact below
    # one radian.
    if square < 1.0:
        third = fourth = 0.0
        for j in range(9, -1, -1):  # Horner: terms are products of -θ² / ((2j + m) (2j + m - 1))
            third = 1.0 - square * third / ((2 * j + 5) * (2 * j + 4))
            fourth = 1.0 - square * fourth / ((2 * j + 6) * (2 * j + 5))
        third, fourth = third / 6.0, fourth / 24.0
    else:
        angle = math.sqrt(square)
        third = (angle - math.sin(angle)) / (angle * square)
        fourth = (0.5 * square + math.cos(angle) - 1.0) / (square * square)
    second = 0.5 - square * fourth
    first = 1.0 - square * third
    for m in range(3):
        whole = 0.5 if m == 2 else 1.0
        odd = first if m == 0 else second if m == 1 else third
        even = second if m == 0 else third if m == 1 else fourth
        G = out[m]
        G[0, 0] = whole - even * (y * y + z * z)
        G[1, 1] = whole - even * (x * x + z * z)
        G[2, 2] = whole - even * (x * x + y * y)
        G[0, 1], G[1, 0] = even * x * y - odd * z, even * x * y + odd * z
        G[0, 2], G[2, 0] = even * x * z + odd * y, even * x * z - odd * y
        G[1, 2], G[2, 1] = even * y * z - odd * x, even * y * z + odd * x


@kernel
def move(X: FloatArray, xi: FloatArray) -> None:
    """Replace X (3, 3 + k) by exp(ξ) X, ξ (3 + 3k,), its rotation in [rad]."""
    G = np.empty((3, 3, 3))
    gammas(xi[:3], G)
    for j in range(X.shape[1]):
        a, b, c = times(G[0], (X[0, j], X[1, j], X[2, j]))
        if j >= 3:
            u, v, w = times(G[1], (xi[3 * j - 6], xi[3 * j - 5], xi[3 * j - 4]))
            a, b, c = a + u, b + v, c + w
        X[0, j], X[1, j], X[2, j] = a, b, c
