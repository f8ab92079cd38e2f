"""Products of 3-D Lorentz cones and half-lines: vectors of them and their Nesterov-Todd scaling.

A scaling W takes z to the same point as its inverse takes x: lam = W z = W^-1 x. L. Vandenberghe, "The CVXOPT
linear and quadratic cone program solvers" (2010), section 4.
"""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel


@inline_kernel
def step_to_boundary(x: FloatArray, d: FloatArray, lorentz: int) -> float:
    """Return the largest step a with x + a d in the cone, x (m,) inside; infinity when no step leaves it."""
    longest = math.inf
    for k in range(lorentz):
        i = 3 * k
        side = math.sqrt(x[i + 1] * x[i + 1] + x[i + 2] * x[i + 2])  # hypot costs four times as much
        c = (x[i] - side) * (x[i] + side)
        # the first s > 0 with det(x + s d) = c + 2 b s + a s² = 0, where det(v) = v0² - v1² - v2²
        b = x[i] * d[i] - x[i + 1] * d[i + 1] - x[i + 2] * d[i + 2]
        a = d[i] * d[i] - d[i + 1] * d[i + 1] - d[i + 2] * d[i + 2]
        disc = max(0.0, b * b - a * c)  # never negative but for rounding: x is inside
        # c over the sum of root and -b instead of their difference over a: nothing cancels near the boundary,
        # where c is small, and a = 0 needs no case of its own. For the same reason c is a product, no
        # difference of squares.
        bottom = math.sqrt(disc) - b
        if bottom > 0.0:
            longest = min(longest, c / bottom)
    for i in range(3 * lorentz, x.size):
        if d[i] < 0.0:
            longest = min(longest, -x[i] / d[i])
    return longest


@inline_kernel
def scale(x: FloatArray, z: FloatArray, lorentz: int, v: FloatArray, eta: FloatArray) -> bool:
    """Fill the Nesterov-Todd scaling W = eta (2 v v' - J), W z = W^-1 x; False if x or z is outside.

    x, z, v are (m,), eta is (lorentz,); half-lines have W = v.
    """
    for k in range(lorentz):
        i = 3 * k
        hx = math.sqrt(x[i + 1] * x[i + 1] + x[i + 2] * x[i + 2])
        hz = math.sqrt(z[i + 1] * z[i + 1] + z[i + 2] * z[i + 2])
        det_x = (x[i] - hx) * (x[i] + hx)
        det_z = (z[i] - hz) * (z[i] + hz)
        if not (det_x > 0.0 and det_z > 0.0):
            return False
        # x and z are brought to determinant one; w is the point halfway, v its square root (section 4)
        sx, sz = 1.0 / math.sqrt(det_x), 1.0 / math.sqrt(det_z)
        dot = (x[i] * z[i] + x[i + 1] * z[i + 1] + x[i + 2] * z[i + 2]) * sx * sz
        half = 0.5 / math.sqrt(0.5 * (1.0 + dot))
        w0 = half * (x[i] * sx + z[i] * sz)
        w1 = half * (x[i + 1] * sx - z[i + 1] * sz)
        w2 = half * (x[i + 2] * sx - z[i + 2] * sz)
        root = 1.0 / math.sqrt(2.0 * (w0 + 1.0))
        v[i], v[i + 1], v[i + 2] = (w0 + 1.0) * root, w1 * root, w2 * root
        eta[k] = math.sqrt(sz / sx)
    for i in range(3 * lorentz, x.size):
        if not (x[i] > 0.0 and z[i] > 0.0):
            return False
        v[i] = math.sqrt(x[i] / z[i])
    return True


@inline_kernel
def apply(
    v: FloatArray, eta: FloatArray, lorentz: int, inverse: bool, d: FloatArray, out: FloatArray
) -> None:
    """Set out (m,) = W d, or W^-1 d, of the scaling (v, eta) of `scale`; W^-1 = (2 J v v' J - J) / eta."""
    sign = -1.0 if inverse else 1.0
    for k in range(lorentz):
        i = 3 * k
        e = 1.0 / eta[k] if inverse else eta[k]
        # W^-1 is W of J v and 1 / eta: J turns the sign of the last two.
        a, b, c = v[i], sign * v[i + 1], sign * v[i + 2]
        dot = 2.0 * (a * d[i] + b * d[i + 1] + c * d[i + 2])
        out[i] = e * (dot * a - d[i])
        out[i + 1] = e * (dot * b + d[i + 1])
        out[i + 2] = e * (dot * c + d[i + 2])
    for i in range(3 * lorentz, d.size):
        out[i] = d[i] / v[i] if inverse else d[i] * v[i]


@inline_kernel
def corrector_target(
    lam: FloatArray, dx: FloatArray, dz: FloatArray, sigma_mu: float, lorentz: int, out: FloatArray
) -> None:
    r"""Set out (m,) = lam \ (sigma_mu e - lam o lam - dx o dz), all in scaled coordinates.

    o is the Jordan product (u.v, u0 v1 + v0 u1, u0 v2 + v0 u2) and \ its inverse: sections 2 and 5.
    """
    for k in range(lorentz):
        i = 3 * k
        a, b, c = lam[i], lam[i + 1], lam[i + 2]
        r0 = sigma_mu - (a * a + b * b + c * c)
        r0 -= dx[i] * dz[i] + dx[i + 1] * dz[i + 1] + dx[i + 2] * dz[i + 2]
        r1 = -2.0 * a * b - (dx[i] * dz[i + 1] + dz[i] * dx[i + 1])
        r2 = -2.0 * a * c - (dx[i] * dz[i + 2] + dz[i] * dx[i + 2])
        # Solve lam o out = r: the arrow matrix of lam, with the determinant lam_0 (lam_0² - |lam_t|²).
        h = math.sqrt(b * b + c * c)
        out[i] = (a * r0 - b * r1 - c * r2) / ((a - h) * (a + h))
        out[i + 1] = (r1 - b * out[i]) / a
        out[i + 2] = (r2 - c * out[i]) / a
    for i in range(3 * lorentz, lam.size):
        out[i] = (sigma_mu - dx[i] * dz[i]) / lam[i] - lam[i]
