"""The residuals against their definition, written out once more with SciPy instead of closed forms."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.optimize import minimize

import surefoot as sf
from surefoot.contact.cones.polyhedral import FrictionPyramid
from surefoot.contact.problem.residuals import residuals


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
def test_velocity_error_is_its_definition(law: str, facets: int | None, fit: str) -> None:
    rng = np.random.default_rng(7)
    for _ in range(6):
        J = rng.normal(size=(6, 6))
        G, g, mu = J @ J.T, rng.normal(size=6), rng.uniform(0.2, 1.0, size=2)
        low, high = np.array([0.0, 0.4]), np.array([np.inf, 1.5])
        problem = sf.ContactProblem(G, g, mu, low, high, law, facets, fit)  # type: ignore[arg-type]
        force = rng.normal(size=(2, 3))
        u = (G @ force.ravel() + g).reshape(-1, 3)
        start = (g + G[:, 5] * 0.4).reshape(-1, 3)  # at the admissible forces nearest to zero
        speed = np.linalg.norm(start, axis=1).max()
        errors = []
        for k in range(2):
            pyramid = None if facets is None else FrictionPyramid(float(mu[k]), facets, fit)  # type: ignore[arg-type]
            shifted = u[k].copy()
            if law == "coulomb":
                slip = u[k, :2]
                shifted[2] += mu[k] * np.hypot(*slip) if pyramid is None else max(-pyramid.rays[:, :2] @ slip)
            rows = None if pyramid is None else pyramid.halfspaces
            w = np.linalg.norm(G[3 * k : 3 * k + 3, 3 * k : 3 * k + 3], 2)
            gap = force[k] - nearest(force[k] - shifted / w, float(mu[k]), low[k], high[k], rows)
            errors.append(w * np.linalg.norm(gap) / speed)
        assert sf.residuals(problem, force).velocity_error == pytest.approx(max(errors), rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("copies", [1, 60])
@pytest.mark.parametrize("mu", [1e8, 1e18])
@pytest.mark.long
def test_friction_without_end_excuses_no_fall_and_no_slip(mu: float, copies: int) -> None:
    """De Saxcé's shift mu ||u_t|| leaves of a fall 1 / mu in the distance to K*, and drowns a force."""
    for kind, rest in ((sf.contact_sets.Point(mu), []), (sf.contact_sets.SoftFinger(mu, 0.02), [0.0])):
        g = np.tile([1.0, 0.3, -1.0, *rest], copies)
        problem = sf.ContactProblem(np.eye(g.size), g, contacts=[kind] * copies)
        for height in (0.0, 1.0):  # it falls; it slides without friction
            assert sf.residuals(problem, [[0.0, 0.0, height, *rest]] * copies).velocity_error > 0.4
        for solver in ("auto", "admm", "newton"):
            found = sf.solve(problem, solver)
            assert not found.solved or np.abs(found.velocities).max() < 1e-8


def test_bilateral_contacts_want_no_velocity_and_take_any_force() -> None:
    G, g = np.diag([1.0, 2.0, 4.0]), np.array([1.0, -2.0, 4.0])
    problem = sf.ContactProblem(G, g, 0.3, bilateral=np.array([True]))
    exact = sf.residuals(problem, -(g / np.diag(G)).reshape(1, 3))
    assert max(exact.velocity_error, exact.penetration_velocity) < 1e-15
    nothing = sf.residuals(problem, np.zeros((1, 3)))
    assert nothing.velocity_error == pytest.approx(1.0)
    assert nothing.penetration_velocity == pytest.approx(np.linalg.norm(g))


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e200])
@pytest.mark.parametrize("copies", [1, 50])
def test_what_is_not_a_number_makes_every_number_nan(bad: float, copies: int) -> None:
    """One force that is not finite, or whose velocity is not, spoils all: no number may look like a pass."""
    G = 1e200 * np.eye(3) if bad == 1e200 else np.eye(3)
    problem = sf.ContactProblem(np.kron(np.eye(copies), G), -np.ones(3 * copies), 0.5)
    forces = np.zeros((copies, 3))
    forces[0, 2] = bad
    found = dataclasses.astuple(sf.residuals(problem, forces))
    assert np.isnan(found).all()


def test_many_contacts_and_few_are_judged_alike() -> None:
    """Few contacts take the compiled path, many the product with G: one number for the same problem."""
    rng = np.random.default_rng(3)
    J = rng.normal(size=(9, 9))
    block, g = J @ J.T, rng.normal(size=9)
    few = sf.ContactProblem(block, g, 0.5)
    many = sf.ContactProblem(np.kron(np.eye(12), block), np.tile(g, 12), 0.5)
    force = rng.normal(size=(3, 3))
    a, b = sf.residuals(few, force), sf.residuals(many, np.tile(force, (12, 1)))
    assert a.velocity_error == pytest.approx(b.velocity_error, rel=1e-9)
    assert a.dissipation == pytest.approx(b.dissipation, rel=1e-12)


def test_runaway_forces_do_not_look_like_a_solution() -> None:
    """No force moves a zero row of G; a scale with the forces in it would fall without bound as they grow."""
    problem = sf.ContactProblem(np.diag([1.0, 1.0, 0.0]), [1.0, 0.0, -0.05], 0.5)
    for size in (10.0, 1e6, 1e12, 1e18):
        found = sf.residuals(problem, [[-1.0, 0.0, size]])
        assert found.velocity_error == pytest.approx(0.05 / np.hypot(1.0, 0.05), rel=1e-6)
        assert found.penetration_velocity == 0.05


def test_forces_too_large_to_tell_prove_nothing() -> None:
    """Two walls squeeze a mass: huge forces whose velocities are rounding, whatever they come to."""
    J = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0], [0, -1, 0], [0, 0, -1]])
    problem = sf.ContactProblem(J @ J.T, [0, 0, -1.0, 0, 0, -1.0], 0.5)
    found = sf.residuals(problem, [[0.0, 0.0, 1e16], [0.0, 0.0, 1e16]])
    assert found.rounding > 1.0
    assert found.worst > 1.0


def test_parts_are_judged_by_their_own_speed() -> None:
    """A part at rest in all but a millimetre a second is not excused by a fast one beside it."""
    problem = sf.ContactProblem(np.eye(6), [0, 0, -1e3, 0, 0, -1e-3], 0.5)
    found = sf.residuals(problem, [[0, 0, 1e3], [0, 0, 0.0]])
    assert found.velocity_error == pytest.approx(1.0)


def test_energy_gap_is_that_of_the_convex_program() -> None:
    """λ·u less its least over the admissible forces, by sampling them; zero at a solution and for Coulomb."""
    rng = np.random.default_rng(8)
    J = rng.normal(size=(6, 6))
    G, g, mu = J @ J.T, rng.normal(size=6), np.array([0.4, 0.7])
    low, high = np.array([0.1, 0.0]), np.array([2.0, 1.5])
    problem = sf.ContactProblem(G, g, mu, low, high, "convex")
    angle = np.linspace(0.0, 2.0 * np.pi, 2001)
    force = np.array([[0.1, 0.2, 0.9], [-0.3, 0.1, 0.8]])
    u = (G @ force.ravel() + g).reshape(2, 3)
    gaps, energy = [], 0.0
    speed = np.linalg.norm((g + 0.1 * G[:, 2]).reshape(2, 3), axis=1).max()
    for k in range(2):
        rim = np.column_stack([mu[k] * np.cos(angle), mu[k] * np.sin(angle), np.ones_like(angle)])
        least = min(float((z * rim @ u[k]).min()) for z in (low[k], high[k]))
        gaps.append(float(force[k] @ u[k]) - least)
        energy += speed**2 / np.linalg.norm(G[3 * k : 3 * k + 3, 3 * k : 3 * k + 3], 2)
    assert sf.residuals(problem, force).energy_gap == pytest.approx(max(gaps) / energy, rel=1e-5)
    assert sf.residuals(problem.replace(law="coulomb"), force).energy_gap == 0.0
    assert sf.solve(problem, tol=1e-10).residuals.energy_gap < 1e-10


@pytest.mark.parametrize("bound", [1.0, 1e-3, 1e-150, 1e-300])
def test_friction_on_a_contact_that_nothing_moves_is_judged_at_any_bound(bound: float) -> None:
    """A bound of 1e-300 N is reached like any other, and what slides there is opposed: squares vanish."""
    G = np.zeros((6, 6))
    G[:3, :3] = np.eye(3)
    slides = np.array([-0.3, 0.4, -0.2])
    problem = sf.ContactProblem(
        G, np.concatenate([[0.0, 0.0, -1.0], slides]), 0.5, normal_max=np.array([np.inf, bound])
    )
    lawful = np.array([[0.0, 0.0, 1.0], [0.3 * bound, -0.4 * bound, bound]])
    assert residuals(problem, lawful).velocity_error < 1e-14
    for wrong in ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-0.3, 0.4, 1.0], [0.4, 0.3, 1.0]):
        forces = np.array([[0.0, 0.0, 1.0], bound * np.array(wrong)])
        assert residuals(problem, forces).velocity_error > 0.1
    found = sf.solve(problem)
    assert found.solved or bound == 1e-300  # for which no solver has the digits: none says that it has
    if found.solved:
        assert found.forces / [[1.0], [bound]] == pytest.approx(lawful / [[1.0], [bound]], abs=1e-7)
