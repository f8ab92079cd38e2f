"""Judges of a sole that share no arithmetic with it, and soles and wrenches to judge."""

from __future__ import annotations

from decimal import Decimal, localcontext
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray


class ClarabelSole:
    """Least normal force of a wrench, by Clarabel on the forces of the corners.

    Parameters
    ----------
    corners
        (k, 2) [m].
    mu, radius
        Friction coefficient [-] and torsional radius [m].
    tol
        Clarabel's gap and feasibility.
    """

    def __init__(self, corners: FloatArray, mu: float, radius: float = 0.0, tol: float = 1e-10) -> None:
        import clarabel
        from scipy import sparse

        self.centre = corners.mean(axis=0)
        q = corners - self.centre
        self.length = float(np.hypot(*q.T).max())
        q = q / self.length
        k, self.size = len(q), 4 if radius > 0.0 else 3
        d = self.size
        give = np.zeros((5, d * k))
        for i, (x, y) in enumerate(q):
            # f_n, t_x, t_y and the pad's moment over its radius
            block = [
                [0, 1, 0, 0],
                [0, 0, 1, 0],
                [y, 0, 0, 0],
                [-x, 0, 0, 0],
                [0, -y, x, radius / self.length],
            ]
            give[:, d * i : d * i + d] = np.array(block)[:, :d]
        cone = -np.eye(d * k)
        for i in range(k):
            cone[d * i, d * i] = -mu
        self.cost = np.zeros(d * k)
        self.cost[::d] = 1.0
        self.rows = sparse.csc_matrix(np.vstack([give, cone]))
        self.none = sparse.csc_matrix((d * k, d * k))
        self.cones: list[Any] = [clarabel.ZeroConeT(5), *[clarabel.SecondOrderConeT(d)] * k]
        self.settings = clarabel.DefaultSettings()
        self.settings.verbose = False
        self.settings.tol_gap_abs = self.settings.tol_gap_rel = self.settings.tol_feas = tol
        self.solver = clarabel.DefaultSolver

    def least(self, wrench: FloatArray) -> float:
        """Return the least normal force [N] of the wrench (6,) with moments about the mean of the corners."""
        w = self.counted(wrench)
        size = float(np.linalg.norm(w))
        if size == 0.0:
            return 0.0
        right = np.concatenate([w / size, np.zeros(len(self.cost))])
        found = self.solver(self.none, self.cost, self.rows, right, self.cones, self.settings).solve()
        return size * float(found.obj_val)

    def counted(self, wrench: FloatArray) -> FloatArray:
        """Return (f_x, f_y, m_x, m_y, m_z) about the centre, moments over the length: (5,) [N]."""
        f, m = wrench[:3], wrench[3:] - np.cross([*self.centre, 0.0], wrench[:3])
        return np.concatenate([f[:2], m / self.length])


def least_in_digits(
    corners: FloatArray, mu: float, wrench: FloatArray, radius: float = 0.0, digits: int = 50
) -> tuple[Decimal, Decimal]:
    """Return bounds from below and above on the least normal force [N], in so many decimal digits.

    Both are proofs: a velocity that no corner resists more than a newton is followed by a logarithmic barrier
    until the gap is 1e-20 of the wrench, and the gradient of the barrier is a set of corner forces, 2 k / t
    above it (S. Boyd, L. Vandenberghe, "Convex Optimization", section 11.6).
    """
    with localcontext() as context:
        context.prec = digits
        places = [[Decimal(float(c)) for c in corner] for corner in corners]
        k = len(places)
        cx: Any = sum(p[0] for p in places) / k
        cy: Any = sum(p[1] for p in places) / k
        q = [(p[0] - cx, p[1] - cy) for p in places]
        w = [Decimal(float(c)) for c in wrench]
        length = max((x * x + y * y).sqrt() for x, y in q)
        b = [
            w[0], w[1], (w[3] - cy * w[2]) / length, (w[4] + cx * w[2]) / length,
            (w[5] - cx * w[1] + cy * w[0]) / length,
        ]  # fmt: skip
        square: Any = sum(c * c for c in b)
        size = square.sqrt()
        if size == 0:
            return Decimal(0), Decimal(0)
        b = [c / size for c in b]
        m, r = Decimal(float(mu)), Decimal(float(radius)) / length
        corners_over = [_corner_rows(x / length, y / length, m, r) for x, y in q]
        y: list[Any] = [Decimal(0)] * 5
        t = Decimal(10)
        while 2 * k / t > Decimal("1e-20"):
            t *= 200
            y = _centred(y, t, b, corners_over)
        low = sum(c * v for c, v in zip(b, y, strict=True))
        return size * low, size * (low + 2 * k / t)


def _corner_rows(x: Any, y: Any, mu: Any, radius: Any) -> tuple[list[Any], list[list[Any]], list[list[Any]]]:
    """Return a, C and the lower triangle of 2 (a aᵀ - Cᵀ C) of the corner at (x, y), over the length.

    A newton there resists v = (d, eta, w) with a . v and ||C v|| = mu ||(d + w z x q, r w)||.
    """
    zero = Decimal(0)
    a = [zero, zero, y, -x, zero]
    C = [[mu, zero, zero, zero, -mu * y], [zero, mu, zero, zero, mu * x], [zero] * 4 + [mu * radius]]
    second = [[2 * (a[i] * a[j] - sum(c[i] * c[j] for c in C)) for j in range(i + 1)] for i in range(5)]
    return a, C, second


def _centred(y: list[Any], t: Any, b: list[Any], corners: list[Any]) -> list[Any]:
    """Return the minimiser of -t b.y - sum log((1 - a.y)² - ||C y||²), by damped Newton steps."""
    for _ in range(300):
        gradient = [-t * c for c in b]
        hessian = [[Decimal(0)] * 5 for _ in range(5)]
        for a, C, second in corners:
            s = 1 - a[2] * y[2] - a[3] * y[3]
            u0, u1 = C[0][0] * y[0] + C[0][4] * y[4], C[1][1] * y[1] + C[1][4] * y[4]
            u2 = C[2][4] * y[4]
            share = 1 / (s * s - u0 * u0 - u1 * u1 - u2 * u2)
            # of -log det: minus its gradient over det
            f = -2 * share
            g = [f * u0 * C[0][0], f * u1 * C[1][1], f * s * a[2], f * s * a[3]]
            g.append(f * (u0 * C[0][4] + u1 * C[1][4] + u2 * C[2][4]))
            for i in range(5):
                gradient[i] -= g[i]
                row, own, constant = hessian[i], g[i], second[i]
                for j in range(i + 1):
                    row[j] += own * g[j] - constant[j] * share
        step = _solved(hessian, [-c for c in gradient])
        decrement = -sum(c * d for c, d in zip(gradient, step, strict=True))
        size = 1 / (1 + decrement.sqrt()) if decrement > Decimal("0.05") else Decimal(1)
        y = [v + size * d for v, d in zip(y, step, strict=True)]
        if decrement < Decimal("1e-20"):
            return y
    raise ArithmeticError("the barrier was not followed")


def _solved(H: list[list[Any]], y: list[Any]) -> list[Any]:
    """Return the solution of a definite system whose lower triangle is H, by Cholesky."""
    for j in range(5):
        H[j][j] = (H[j][j] - sum(H[j][n] ** 2 for n in range(j))).sqrt()
        for i in range(j + 1, 5):
            H[i][j] = (H[i][j] - sum(H[i][n] * H[j][n] for n in range(j))) / H[j][j]
    x = list(y)
    for i in range(5):
        x[i] = (x[i] - sum(H[i][n] * x[n] for n in range(i))) / H[i][i]
    for i in range(4, -1, -1):
        x[i] = (x[i] - sum(H[n][i] * x[n] for n in range(i + 1, 5))) / H[i][i]
    return x


def random_sole(rng: np.random.Generator, number: int) -> tuple[FloatArray, float]:
    """Return corners (k, 2) [m], not about the frame's origin, and a friction coefficient."""
    if number % 2 == 0:
        half = 0.5 * rng.uniform([0.1, 0.03], [0.35, 0.2])
        corners = half * np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])
    else:
        turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, rng.integers(5, 9)))[::-1]
        corners = np.column_stack([0.12 * np.cos(turn), 0.05 * np.sin(turn)])
    return corners + rng.uniform(-0.03, 0.03, 2), float(rng.choice([0.1, 0.4, 0.6, 0.9, 1.5, 4.0]))


def random_wrenches(
    rng: np.random.Generator, judge: ClarabelSole, mu: float, count: int, finest: float = 1e-9
) -> FloatArray:
    """Return wrenches (count, 6), every third of them within 1e-2 to `finest` of the border, log-uniformly.

    Those have the normal force that Clarabel finds least, and that share of the wrench's size more or less.
    """
    out = np.empty((count, 6))
    for i in range(count):
        size = 10.0 ** rng.uniform(-2, 3)
        f = rng.normal(size=3) * [mu, mu, 1.0]
        m = rng.normal(size=3) * judge.length * [0.7, 0.7, 0.7 * mu]
        if rng.random() < 0.3:  # little of some: faces and edges of the cone
            m *= rng.integers(0, 2, 3)
            f[:2] *= rng.integers(0, 2, 2)
        f[2] = abs(f[2]) * rng.uniform(0.5, 3.0) if rng.random() < 0.9 else f[2]
        arm = np.array([*judge.centre, 0.0])
        if i % 3 == 0:
            least = judge.least(np.concatenate([f, m + np.cross(arm, f)]))
            # keeping the moments about the centre
            f[2] = least + rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(np.log10(finest), -2) * (least + 1.0)
        out[i] = size * np.concatenate([f, m + np.cross(arm, f)])
    return out
