"""52.7: forces shared over feet, and the accuracy of quadratic programs."""

from __future__ import annotations

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near, short

PROPERTIES = Properties()
holds = PROPERTIES.holds


def _stance(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, float, np.ndarray, int]:
    """Return feet, centre of mass, mu, a wrench that pyramids can give, and their number of sides."""
    signs = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    feet = np.column_stack([signs * [0.2, 0.15] + rng.normal(size=(4, 2)) * 0.02, np.zeros(4)])
    com, mu, k = np.array([0.0, 0.0, 0.3]), rng.uniform(0.4, 0.9), int(rng.choice([4, 8, 16]))
    forces = (rng.dirichlet(np.full(k, 0.3), size=4) @ _corners(k, mu)) * rng.uniform(15, 80, 4)[:, None]
    wrench = np.r_[forces.sum(axis=0), np.cross(feet - com, forces).sum(axis=0)]
    return feet, com, mu, wrench, k


def _corners(k: int, mu: float) -> np.ndarray:
    turn = 2 * np.pi * np.arange(k) / k
    return np.column_stack([mu * np.cos(turn), mu * np.sin(turn), np.ones(k)])


def _least(feet: np.ndarray, com: np.ndarray, mu: float, wrench: np.ndarray, k: int) -> float:
    """Return the least norm of forces, as weights of the pyramids' edges (NNLS)."""
    from scipy.optimize import nnls

    edges = _corners(k, mu)
    force = np.hstack([edges.T] * len(feet))
    moment = np.hstack([np.cross(p - com, edges).T for p in feet])
    blocks = np.kron(np.eye(len(feet)), edges.T)
    heavy = 1e4
    weights, _ = nnls(
        np.vstack([heavy * force, heavy * moment, blocks]), np.r_[heavy * wrench, np.zeros(len(blocks))]
    )
    return float(np.linalg.norm(blocks @ weights))


@holds("52.7.1", "use is one on the edge of the cone and zero along the normal")
def _check_use(answer: Answer, rng: np.random.Generator) -> None:
    mu, share, turn = rng.uniform(0.2, 1), rng.uniform(0, 1.5, 5), rng.uniform(0, 2 * np.pi, 5)
    normal = rng.uniform(5, 200, 5)
    side = share * mu * normal
    forces = np.column_stack([side * np.cos(turn), side * np.sin(turn), normal])
    near(answer.numbers((5,), "use", forces, mu), share, "the use")
    found = answer.number("closest", forces, mu)
    expect(found == np.argmax(share), f"it says foot {found:g}; the shares are {short(share)}")


@holds("52.7.1", "the forces give the wrench", 8)
def _check_balance(answer: Answer, rng: np.random.Generator) -> None:
    feet, com, mu, wrench, k = _stance(rng)
    forces = answer.numbers((4, 3), "distribute", feet, com, mu, wrench, k)
    given = np.r_[forces.sum(axis=0), np.cross(feet - com, forces).sum(axis=0)]
    near(given, wrench, "their wrench", 1e-4)


@holds("52.7.1", "each force is within the inner pyramid of k sides", 8)
def _check_within(answer: Answer, rng: np.random.Generator) -> None:
    from scipy.optimize import nnls

    feet, com, mu, wrench, k = _stance(rng)
    forces = answer.numbers((4, 3), "distribute", feet, com, mu, wrench, k)
    for foot, force in enumerate(forces):
        outside = nnls(_corners(k, mu).T, force)[1]
        expect(outside < 1e-3, f"force {foot}, {short(force)}, is {outside:.3g} N outside of its pyramid")


@holds("52.7.1", "no other such forces have a smaller sum of squares", 8)
def _check_smallest(answer: Answer, rng: np.random.Generator) -> None:
    feet, com, mu, wrench, k = _stance(rng)
    norm = float(np.linalg.norm(answer.numbers((4, 3), "distribute", feet, com, mu, wrench, k)))
    least = _least(feet, com, mu, wrench, k)
    expect(norm < least * (1 + 1e-4), f"their norm is {norm:.6g} N, and {least:.6g} N would do")


def _program(rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Return P, q, A, b, C, d of a feasible program whose inequalities bind."""
    n = int(rng.integers(6, 16))
    root = rng.normal(size=(n, n))
    A, C = rng.normal(size=(n // 3, n)), rng.normal(size=(2 * n, n))
    inside = rng.normal(size=n)
    spare = rng.uniform(0, 0.5, 2 * n) * rng.integers(2, size=2 * n) + 0.01
    return root @ root.T + 0.1 * np.eye(n), rng.normal(size=n) * 10, A, A @ inside, C, C @ inside + spare


@holds("52.7.2", "the violation is that of the constraint that is broken most, equalities too")
def _check_violation(answer: Answer, rng: np.random.Generator) -> None:
    _, _, A, b, C, d = _program(rng)
    x = rng.normal(size=A.shape[1])
    worst = 0.0
    for row, right in zip(A, b, strict=True):
        worst = max(worst, abs(float(row @ x - right)))
    for row, right in zip(C, d, strict=True):
        worst = max(worst, float(row @ x - right))
    near(answer.number("violation", A, b, C, d, x), worst, "the violation")
    kept = answer.number("violation", A[:0], b[:0], C, C @ x + 1.0, x)
    near(kept, 0.0, "the violation where nothing is broken")


@holds("52.7.2", "the answer breaks no constraint by more than 1e-6")
def _check_feasible(answer: Answer, rng: np.random.Generator) -> None:
    P, q, A, b, C, d = _program(rng)
    x = answer.numbers(q.shape, "solve", P, q, A, b, C, d)
    broken = max(np.abs(A @ x - b).max(), (C @ x - d).max())
    expect(broken < 1e-6, f"a constraint is broken by {broken:.3g}")


@holds("52.7.2", "constraints that bind hold the answer: no direction lowers the cost")
def _check_optimal(answer: Answer, rng: np.random.Generator) -> None:
    from scipy.optimize import nnls

    P, q, A, b, C, d = _program(rng)
    x = answer.numbers(q.shape, "solve", P, q, A, b, C, d)
    binding = C[C @ x > d - 1e-6]
    pulls = np.vstack([A, -A, binding]).T
    left = nnls(pulls, -(P @ x + q))[1]
    scale = max(1.0, float(np.linalg.norm(q)))
    expect(left < 1e-5 * scale, f"the slope of the cost that nothing holds is {left:.3g}")
