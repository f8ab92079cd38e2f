"""52.7.2 Quadratic programs of a whole-body controller, and how well they are solved.

min x·P x / 2 + q·x with A x = b and C x <= d; P is positive definite. Any solver will do, as long as it is
accurate: a solver's default tolerance may not be.
求解器不限，但要足够精确：求解器的默认容差未必够。
"""

import numpy as np


def violation(A, b, C, d, x):
    """Return by how much x breaks the constraint that it breaks most; zero if it breaks none.

    返回 x 违反最多的约束的违反量；不违反则为零。
    """
    return max(np.abs(A @ x - b).max(initial=0.0), (C @ x - d).max(initial=0.0))


def solve(P, q, A, b, C, d):
    """Return the minimiser, with all constraints and the optimum to within 1e-6. 返回最优解，精度 1e-6。"""
    n, m, k = len(q), len(b), len(d)
    x, y = np.zeros(n), np.zeros(m)
    s, z = np.maximum(1.0, d), np.ones(k)
    for _ in range(100):
        errors = P @ x + q + A.T @ y + C.T @ z, A @ x - b, C @ x + s - d
        gap = s @ z / k
        if max(gap, *(np.abs(e).max(initial=0.0) for e in errors)) < 1e-10:
            break
        H = np.block([[P + C.T * (z / s) @ C, A.T], [A, np.zeros((m, m))]])

        def direction(target):
            right = errors[0] + C.T @ ((z * errors[2] + target - s * z) / s)
            step = np.linalg.solve(H, -np.r_[right, errors[1]])
            ds = -errors[2] - C @ step[:n]
            return step[:n], step[n:], ds, (target - s * z - z * ds) / s

        dx, dy, ds, dz = direction(0.0)
        reach = _reach(s, ds, z, dz)
        centring = ((s + reach * ds) @ (z + reach * dz) / k / gap) ** 3
        dx, dy, ds, dz = direction(centring * gap)
        reach = 0.99 * _reach(s, ds, z, dz)
        x, y, s, z = x + reach * dx, y + reach * dy, s + reach * ds, z + reach * dz
    return x


def _reach(s, ds, z, dz):
    both, change = np.r_[s, z], np.r_[ds, dz]
    falling = change < 0.0
    return min(1.0, (-both[falling] / change[falling]).min(initial=1.0))
