"""The residuals against their definition, written out once more with SciPy instead of closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

import surefoot as sf


def nearest(x: np.ndarray, mu: float, low: float, high: float, rows: np.ndarray | None) -> np.ndarray:
    """Project by a general-purpose optimiser: onto the cone, or onto the half-spaces `rows`."""
    limits = [{"type": "ineq", "fun": lambda f: f[2] - low}]
    if high < np.inf:
        limits.append({"type": "ineq", "fun": lambda f: high - f[2]})
    if rows is None:
        limits.append({"type": "ineq", "fun": lambda f: mu * f[2] - np.sqrt(f[0] ** 2 + f[1] ** 2 + 1e-30)})
    else:
        limits.append({"type": "ineq", "fun": lambda f: -rows @ f})
    inside = np.array([0.0, 0.0, max(low, min(high, abs(x[2]) + 1.0))])
    found = minimize(
        lambda f: 0.5 * np.sum((f - x) ** 2), inside, jac=lambda f: f - x, constraints=limits, method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 200},
    )  # fmt: skip
    return np.asarray(found.x)


@pytest.mark.parametrize("law", ["coulomb", "convex"])
@pytest.mark.parametrize(
    ("facets", "fit"), [(None, "inner"), (4, "inner"), (4, "outer"), (5, "inner"), (5, "outer")]
)
def test_natural_map_is_its_definition(law: str, facets: int | None, fit: str) -> None:
    rng = np.random.default_rng(7)
    for _ in range(6):
        J = rng.normal(size=(6, 6))
        G, g, mu = J @ J.T, rng.normal(size=6), rng.uniform(0.2, 1.0, size=2)
        low, high = np.array([0.0, 0.4]), np.array([np.inf, 1.5])
        problem = sf.ContactProblem(G, g, mu, low, high, law, facets, fit)  # type: ignore[arg-type]
        force = rng.normal(size=(2, 3))
        u = (G @ force.ravel() + g).reshape(-1, 3)
        rho = 1.0 / np.linalg.norm(G, 2)
        gap = []
        for k in range(2):
            pyramid = None if facets is None else sf.FrictionPyramid(float(mu[k]), facets, fit)  # type: ignore[arg-type]
            shifted = u[k].copy()
            if law == "coulomb":
                limit = (
                    mu[k] * np.hypot(*u[k, :2]) if pyramid is None else max(-pyramid.rays[:, :2] @ u[k, :2])
                )
                shifted[2] += limit
            rows = None if pyramid is None else pyramid.halfspaces
            gap.append(force[k] - nearest(force[k] - rho * shifted, float(mu[k]), low[k], high[k], rows))
        reach = rho * np.linalg.norm(g)  # forces that do nothing against g are measured by g alone
        scale = reach if np.linalg.norm(gap) > 0.1 * reach else max(np.linalg.norm(force), reach)
        expected = np.linalg.norm(gap) / scale
        assert sf.residuals(problem, force).natural_map == pytest.approx(expected, rel=1e-5, abs=1e-7)


def test_bilateral_contacts_want_no_velocity_and_take_any_force() -> None:
    G, g = np.diag([1.0, 2.0, 4.0]), np.array([1.0, -2.0, 4.0])
    problem = sf.ContactProblem(G, g, 0.3, bilateral=np.array([True]))
    exact = sf.residuals(problem, -(g / np.diag(G)).reshape(1, 3))
    assert exact.natural_map < 1e-15
    assert exact.penetration_velocity < 1e-15
    nothing = sf.residuals(problem, np.zeros((1, 3)))
    assert nothing.natural_map == pytest.approx(1.0)
    assert nothing.penetration_velocity == pytest.approx(np.linalg.norm(g))


def test_nan_is_never_a_pass() -> None:
    problem = sf.ContactProblem(np.eye(3), -np.ones(3), 0.5)
    found = sf.residuals(problem, [[np.nan, 0.0, 1.0]])
    assert not found.natural_map <= 1e300


def test_many_contacts_and_few_are_judged_alike() -> None:
    """Few contacts take the compiled path, many the product with G: one number for the same problem."""
    rng = np.random.default_rng(3)
    J = rng.normal(size=(9, 9))
    block, g = J @ J.T, rng.normal(size=9)
    few = sf.ContactProblem(block, g, 0.5)
    many = sf.ContactProblem(np.kron(np.eye(12), block), np.tile(g, 12), 0.5)
    force = rng.normal(size=(3, 3))
    a, b = sf.residuals(few, force), sf.residuals(many, np.tile(force, (12, 1)))
    assert a.natural_map == pytest.approx(b.natural_map, rel=1e-9)
    assert a.dissipation == pytest.approx(b.dissipation, rel=1e-12)


def test_runaway_forces_do_not_look_like_a_solution() -> None:
    """No force moves a zero G; the plain quotient would fall without bound as the forces grow."""
    problem = sf.ContactProblem(np.diag([1.0, 1.0, 0.0]), [0.0, 0.0, -1.0], 0.5)
    for size in (1.0, 1e6, 1e12, 1e18):
        assert sf.residuals(problem, [[0.0, 0.0, size]]).natural_map >= 1.0


def test_close_forces_are_measured_by_their_size() -> None:
    problem = sf.ContactProblem(np.diag([1.0, 1.0, 1e-3]), [0.0, 0.0, -1.0], 0.5)
    force = np.array([[0.0, 0.0, 990.0]])  # 1 % of the free velocity is left
    assert sf.residuals(problem, force).natural_map == pytest.approx(0.01 / 990.0, rel=1e-9)
