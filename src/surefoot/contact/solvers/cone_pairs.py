"""Pairs of points inside second-order cones, one pair a contact: scaling, directions, longest steps.

A contact's cone is x_3 >= ||(x_1, x_2)||, axis last. A point is kept with its distance to the border,
d = x_3 - ||(x_1, x_2)||, which near the border cannot be had from the point: the difference would lose it.
The scaling of Nesterov and Todd is the symmetric W with W y = W⁻¹ x = l; P = W².

Source: Y. Nesterov, M. Todd, "Primal-dual interior-point methods for self-scaled cones", SIOPT 8, 1998; L.
Vandenberghe, "The CVXOPT linear and quadratic cone program solvers", 2010, section 4 (formulas of W).
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel


@inline_kernel
def _determinant(point: FloatArray, border: float) -> float:
    """Return x_3² - x_1² - x_2² of a point whose distance to the border is known."""
    return border * (border + 2.0 * math.sqrt(point[0] ** 2 + point[1] ** 2))


@inline_kernel
def _product(x: FloatArray, dx: float, y: FloatArray, dy: float) -> float:
    """Return x · y of two points of the cone, without loss where they are opposite borders' rays."""
    p, q = math.sqrt(x[0] ** 2 + x[1] ** 2), math.sqrt(y[0] ** 2 + y[1] ** 2)
    apart = p * q
    if p > 0.0 and q > 0.0:
        # p q + x̄ ȳ of unit vectors a, b is |a + b|² / 2
        apart *= 0.5 * ((x[0] / p + y[0] / q) ** 2 + (x[1] / p + y[1] / q) ** 2)
    total: float = dx * y[2] + p * dy + apart
    return total


@kernel
def scale_pairs(
    x: FloatArray, dx: FloatArray, y: FloatArray, dy: FloatArray, share: float,
    axes: FloatArray, scaled: FloatArray, weights: FloatArray,
) -> float:  # fmt: skip
    """Fill the scalings of all pairs (n, 3), and return the mean of x · y.

    Filled are axes (n, 4): w and the factor η with W = η (W of w); scaled (n, 3): l; weights (n, 3, 3): P
    S⁻¹, where S = I - share e_3 (ȳ / ||ȳ||, 0)ᵀ is the shift's derivative.
    """
    total = 0.0
    for k in range(len(x)):
        a, b = math.sqrt(_determinant(x[k], dx[k])), math.sqrt(_determinant(y[k], dy[k]))
        dot = _product(x[k], dx[k], y[k], dy[k])
        total += dot
        g = math.sqrt(0.5 * (1.0 + dot / (a * b)))
        u, v = (x[k, 0] / a - y[k, 0] / b) / (2.0 * g), (x[k, 1] / a - y[k, 1] / b) / (2.0 * g)
        w = math.sqrt(1.0 + u * u + v * v)
        eta = math.sqrt(a / b)
        axes[k, 0], axes[k, 1], axes[k, 2], axes[k, 3] = u, v, w, eta
        p, q = x[k, 2] / a, y[k, 2] / b
        root = math.sqrt(a * b)
        s = root / (p + q + 2.0 * g)
        for i in range(2):
            scaled[k, i] = s * ((g + p) * y[k, i] / b + (g + q) * x[k, i] / a)
        scaled[k, 2] = root * g
        # P = η² (2 w wᵀ - J), J = diag(-1, -1, 1)
        e = eta * eta
        weights[k, 0, 0], weights[k, 1, 1] = e * (2.0 * u * u + 1.0), e * (2.0 * v * v + 1.0)
        weights[k, 2, 2] = e * (2.0 * w * w - 1.0)
        weights[k, 0, 1] = weights[k, 1, 0] = e * 2.0 * u * v
        weights[k, 0, 2] = weights[k, 2, 0] = e * 2.0 * u * w
        weights[k, 1, 2] = weights[k, 2, 1] = e * 2.0 * v * w
        size = math.sqrt(y[k, 0] ** 2 + y[k, 1] ** 2)
        if share > 0.0 and size > 0.0:
            for i in range(3):
                weights[k, i, 0] += share * weights[k, i, 2] * y[k, 0] / size
                weights[k, i, 1] += share * weights[k, i, 2] * y[k, 1] / size
    return total / len(x)


@kernel
def weigh_rows(weights: FloatArray, rows: FloatArray, out: FloatArray) -> None:
    """Fill out (3n, r) with each contact's weights (3, 3) times its rows."""
    for k in range(len(weights)):
        i = 3 * k
        for a in range(3):
            p, q, s = weights[k, a, 0], weights[k, a, 1], weights[k, a, 2]
            for j in range(rows.shape[1]):
                out[i + a, j] = p * rows[i, j] + q * rows[i + 1, j] + s * rows[i + 2, j]


@inline_kernel
def apply_scaling(axes: FloatArray, sign: float, v: FloatArray) -> tuple[float, float, float]:
    """Return W v (sign 1), or W⁻¹ v (sign -1), of axes (4,) and a vector (3,)."""
    a, b, w, eta = sign * axes[0], sign * axes[1], axes[2], axes[3]
    if sign < 0.0:
        eta = 1.0 / eta
    along = a * v[0] + b * v[1]
    lift = v[2] + along / (1.0 + w)
    return eta * (v[0] + lift * a), eta * (v[1] + lift * b), eta * (w * v[2] + along)


@kernel
def aim_pairs(
    axes: FloatArray, scaled: FloatArray, before: FloatArray, after: FloatArray, centre: float, mixed: float,
    out: FloatArray,
) -> None:  # fmt: skip
    r"""Fill out (n, 3) with c = W (l \\ r): what dx + P dy is to be.

    r = centre e - l∘l - mixed (W⁻¹ before)∘(W after), with steps of x and y that were tried before; `∘` is
    the cone's product.
    """
    r = np.empty(3)
    for k in range(len(out)):
        x, y, z = scaled[k, 0], scaled[k, 1], scaled[k, 2]
        r[0], r[1], r[2] = -2.0 * z * x, -2.0 * z * y, centre - (x * x + y * y + z * z)
        if mixed != 0.0:
            a, b, c = apply_scaling(axes[k], -1.0, before[k])
            p, q, s = apply_scaling(axes[k], 1.0, after[k])
            r[0] -= mixed * (c * p + s * a)
            r[1] -= mixed * (c * q + s * b)
            r[2] -= mixed * (a * p + b * q + c * s)
        # the determinant of l is sqrt(det x det y) > 0; of l itself little is lost, it is central
        size = math.sqrt(x * x + y * y)
        r[2] = (z * r[2] - x * r[0] - y * r[1]) / ((z - size) * (z + size))
        r[0], r[1] = (r[0] - r[2] * x) / z, (r[1] - r[2] * y) / z
        out[k, 0], out[k, 1], out[k, 2] = apply_scaling(axes[k], 1.0, r)


@kernel
def finish_direction(
    axes: FloatArray, y: FloatArray, share: float, aim: FloatArray, moved: FloatArray,
    step_x: FloatArray, step_y: FloatArray,
) -> None:  # fmt: skip
    """Fill the steps (n, 3): dy = S⁻¹ moved, dx = aim - P dy."""
    for k in range(len(y)):
        p, q, s = moved[k, 0], moved[k, 1], moved[k, 2]
        size = math.sqrt(y[k, 0] ** 2 + y[k, 1] ** 2)
        if share > 0.0 and size > 0.0:
            s += share * (y[k, 0] * p + y[k, 1] * q) / size
        step_y[k, 0], step_y[k, 1], step_y[k, 2] = p, q, s
        u, v, w, e = axes[k, 0], axes[k, 1], axes[k, 2], axes[k, 3] ** 2
        along = 2.0 * (u * p + v * q + w * s)
        step_x[k, 0] = aim[k, 0] - e * (along * u + p)
        step_x[k, 1] = aim[k, 1] - e * (along * v + q)
        step_x[k, 2] = aim[k, 2] - e * (along * w - s)


@kernel
def longest_step(points: FloatArray, borders: FloatArray, steps: FloatArray) -> float:
    """Return the longest multiple of the steps (n, 3) that leaves no cone, at most 1e3."""
    length = 1e3
    for k in range(len(points)):
        size = math.sqrt(points[k, 0] ** 2 + points[k, 1] ** 2)
        own = math.sqrt(steps[k, 0] ** 2 + steps[k, 1] ** 2)
        along = (points[k, 0] * steps[k, 0] + points[k, 1] * steps[k, 1]) / size if size > 0.0 else own
        # det(x + t d) = a + 2 t b + t² c
        a = borders[k] * (borders[k] + 2.0 * size)
        b = borders[k] * steps[k, 2] + size * (steps[k, 2] - along)
        c = (steps[k, 2] - own) * (steps[k, 2] + own)
        if size == 0.0:
            b = borders[k] * steps[k, 2]
        square = b * b - a * c
        if square >= 0.0 and math.sqrt(square) > b:
            length = min(length, a / (math.sqrt(square) - b))
    return length


@kernel
def move_points(
    points: FloatArray, borders: FloatArray, steps: FloatArray, length: float, out: FloatArray,
    out_borders: FloatArray,
) -> bool:  # fmt: skip
    """Fill out (n, 3) with points + length steps and (n,) distances to the border; tell if all are inside."""
    inside = True
    for k in range(len(points)):
        a, b, d = length * steps[k, 0], length * steps[k, 1], length * steps[k, 2]
        size = math.sqrt(points[k, 0] ** 2 + points[k, 1] ** 2)
        out[k, 0], out[k, 1] = points[k, 0] + a, points[k, 1] + b
        after = math.sqrt(out[k, 0] ** 2 + out[k, 1] ** 2)
        grown = 2.0 * (points[k, 0] * a + points[k, 1] * b) + a * a + b * b
        if size + after > 0.0:
            grown /= size + after
        out_borders[k] = borders[k] + (d - grown)
        out[k, 2] = after + out_borders[k]
        inside = inside and out_borders[k] > 0.0
    return inside


@kernel
def centrality(x: FloatArray, dx: FloatArray, y: FloatArray, dy: FloatArray) -> float:
    """Return the least sqrt(det x det y) of pairs (n, 3) over the mean of x · y: 1 on the central path."""
    least, total = np.inf, 0.0
    for k in range(len(x)):
        least = min(least, _determinant(x[k], dx[k]) * _determinant(y[k], dy[k]))
        total += _product(x[k], dx[k], y[k], dy[k])
    return math.sqrt(least) * len(x) / total if total > 0.0 else 0.0
