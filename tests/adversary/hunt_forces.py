"""Hunt for force distributions under torque limits whose `force_error` is below their true error.

    python tests/adversary/hunt_forces.py --count 100000

The truth is the solution of the optimality conditions with the active set read from the answer, by Newton's
method in plain NumPy; it counts only where its multipliers and slacks have the right signs, which proves it.
"""

import argparse
import sys

import numpy as np

import surefoot as sf

MU, LOW, HIGH = 0.6, 5.0, 250.0
NEAR = 1e-5
"""How near to its end a cone, a bound [N] or a row [N·m] counts as active at first."""


def draw(rng):
    """Return grasp map, wrench, Jacobian (12, 12), offset and limit (12,), and the weight of the forces."""
    feet = np.array([[0.2, 0.15], [0.2, -0.15], [-0.2, 0.15], [-0.2, -0.15]]) + rng.normal(0.0, 0.03, (4, 2))
    A = np.zeros((6, 12))
    for k, foot in enumerate(feet):
        x, y, z = *foot, -0.3
        A[:3, 3 * k : 3 * k + 3] = np.eye(3)
        A[3:, 3 * k : 3 * k + 3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    wrench = np.array([0.0, 0.0, 160.0, 0.0, 0.0, 0.0]) + rng.normal(size=6) * np.repeat([40.0, 8.0], 3)
    J = np.zeros((12, 12))
    for k in range(4):
        J[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = rng.normal(size=(3, 3)) * 0.2
    return A, wrench, J, rng.normal(size=12), np.full(12, rng.uniform(4.0, 16.0)), 10.0 ** rng.uniform(-5, -2)


def truth(A, wrench, J, offset, limit, weight, start):
    """Return the optimal forces (12,), proven by their multipliers; None where that fails."""
    H, h = A.T @ A + weight * np.eye(12), -A.T @ wrench
    rows = np.vstack([J.T, -J.T])
    ends = np.concatenate([limit - offset, limit + offset])
    pick = np.eye(12)[2::3]
    rows, ends = np.vstack([rows, -pick, pick]), np.concatenate([ends, np.full(4, -LOW), np.full(4, HIGH)])
    cone = [k for k in range(4) if cone_value(start, k)[0] > -NEAR]
    held = np.flatnonzero(rows @ start - ends > -NEAR)
    for _ in range(12):
        found = newton(H, h, rows[held], ends[held], cone, start.copy())
        if found is None:
            return None
        x, m = found
        if (m > -1e-9).all():
            broken = (rows @ x - ends > 1e-9).any() or any(cone_value(x, k)[0] > 1e-9 for k in range(4))
            return None if broken else x
        worst = int(np.argmin(m))  # let go of what pulls the wrong way
        if worst < len(cone):
            del cone[worst]
        else:
            held = np.delete(held, worst - len(cone))
    return None


def cone_value(x, k):
    """Return ||f_t|| - mu f_z of contact k, its gradient (12,) and its Hessian (12, 12)."""
    f, gradient, hessian = x[3 * k : 3 * k + 3], np.zeros(12), np.zeros((12, 12))
    size = max(float(np.hypot(f[0], f[1])), 1e-300)
    e = f[:2] / size
    gradient[3 * k : 3 * k + 3] = *e, -MU
    hessian[3 * k : 3 * k + 2, 3 * k : 3 * k + 2] = (np.eye(2) - np.outer(e, e)) / size
    return size - MU * f[2], gradient, hessian


def newton(H, h, rows, ends, cone, x):
    """Solve the conditions with these constraints as equations; return forces and multipliers, or None."""
    count = len(cone) + len(rows)
    m = np.zeros(count)
    for _ in range(60):
        values = [cone_value(x, k) for k in cone]
        C = np.array([*(v[1] for v in values), *rows]).reshape(count, 12)
        K = H + sum((m[i] * v[2] for i, v in enumerate(values)), np.zeros((12, 12)))
        gap = np.concatenate([[v[0] for v in values], rows @ x - ends])
        whole = np.block([[K, C.T], [C, np.zeros((count, count))]])
        if np.linalg.cond(whole) > 1e12:
            return None
        step = np.linalg.solve(whole, -np.concatenate([H @ x + h + C.T @ m, gap]))
        x, m = x + step[:12], m + step[12:]
        if np.abs(step[:12]).max() <= 1e-11 * np.abs(x).max():
            return x, m
    return None


def hunt(count, seed=0):
    """Return [(claimed, true)] of the binding draws whose truth is proven, and how many are false."""
    rng, found, false = np.random.default_rng(seed), [], []
    for k in range(count):
        A, wrench, J, offset, limit, weight = draw(rng)
        distributor = sf.ForceDistributor(MU, LOW, HIGH, 1.0, weight, torque_limit=limit)
        f = distributor.solve(A, wrench, jacobian=J, torque_offset=offset)
        if not np.isfinite(distributor.force_error) or distributor.torque_excess < -1e-3:
            continue
        best = truth(A, wrench, J, offset, limit, weight, f.ravel())
        if best is None:
            continue
        found.append((distributor.force_error, float(np.linalg.norm(f.ravel() - best))))
        # 1e-9: where Newton on the truth itself stops, in newtons
        if found[-1][1] > found[-1][0] + 1e-9:
            false.append((k, *found[-1]))
    return np.array(found), false


def main():
    """Hunt, and exit with 1 if a bound is false."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    found, false = hunt(given.count, given.seed)
    claimed, true = found.T
    print(f"{given.count} drawn, {len(found)} bind and are proven, {len(false)} bounds are false")
    print(f"claimed: median {np.median(claimed):.1e} N, worst {claimed.max():.1e} N")
    print(f"true:    median {np.median(true):.1e} N, worst {true.max():.1e} N")
    for row in false[:20]:
        print("draw {}: claimed {:.1e} N, true {:.1e} N".format(*row))
    return 1 if false else 0


if __name__ == "__main__":
    sys.exit(main())
