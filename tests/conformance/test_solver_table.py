"""Every solver on every family of problems: what it must solve, and that it never claims what it lacks.

The certificate is computed here once more, in plain NumPy from the definition, so that neither a solver nor
the package's own residuals vouch for themselves.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.contacts import problem_set

TOL = 1e-8

# solver -> (law, cones) -> share of the robot-scale families that it must solve to 1e-8 (measured, see docs).
# A new solver is one line here.
TABLE = {
    "auto": {
        ("coulomb", "exact"): 1.0,
        ("convex", "exact"): 1.0,
        ("coulomb", "k"): 1.0,
        ("convex", "k"): 1.0,
    },
    "nsgs": {("coulomb", "exact"): 0.9, ("convex", "exact"): 0.75},
    "newton": {
        ("coulomb", "exact"): 0.85,
        ("convex", "exact"): 0.6,
        ("coulomb", "k"): 0.85,
        ("convex", "k"): 0.8,
    },
    "admm": {
        ("coulomb", "exact"): 0.95,
        ("convex", "exact"): 0.8,
        ("coulomb", "k"): 0.95,
        ("convex", "k"): 0.95,
    },
    "interior_point": {("coulomb", "exact"): 0.8, ("convex", "exact"): 1.0},
    "lemke": {("coulomb", "k"): 0.95},
    "distribution": {("convex", "exact"): 1.0},
    "daqp": {("convex", "k"): 0.95},
}
LIMIT = {"nsgs": 20_000, "admm": 4000, "newton": 15}
"""Iterations allowed here, to keep the table quick; the others have their own."""


@cache
def family_problems() -> tuple[tuple[str, sf.ContactProblem], ...]:
    """One problem of each robot-scale family."""
    return tuple((p.name, p.problem) for p in problem_set("robot", seed=5, copies=0.25))


@cache
def large_problems() -> tuple[tuple[str, sf.ContactProblem], ...]:
    """(family, problem) of each large family; heaps settle for a second before they are one."""
    return tuple((p.family, p.problem) for p in problem_set("large", copies=0.01))


def velocity_error(problem: sf.ContactProblem, forces: np.ndarray) -> float:
    """The velocity error, written from the definition, for problems in one part without normal bounds."""
    if not np.isfinite(forces).all():
        return np.nan
    u = (problem.G @ forces.ravel() + problem.g).reshape(-1, 3)
    worst = 0.0
    for k in range(problem.contacts):
        i = slice(3 * k, 3 * k + 3)
        mu, shifted = float(problem.mu[k]), u[k].copy()
        cone = sf.FrictionCone(mu)
        nearest = (
            cone.project if problem.facets is None else cone.polyhedral(problem.facets, problem.fit).project
        )
        if problem.law == "coulomb" and problem.facets is None:
            shifted[2] += mu * np.hypot(*u[k, :2])
        elif problem.law == "coulomb":
            shifted[2] += max(-cone.polyhedral(problem.facets or 8, problem.fit).rays[:, :2] @ u[k, :2])
        w = np.linalg.norm(problem.G[i, i], 2)
        gap = shifted if w == 0.0 else w * (forces[k] - nearest(forces[k] - shifted / w))
        worst = max(worst, float(np.linalg.norm(gap)))
    return worst / float(np.linalg.norm(problem.g.reshape(-1, 3), axis=1).max())


def test_the_table_is_complete() -> None:
    assert set(sf.solver_names()) - set(TABLE) == set(), "a registered solver has no line in the table"


CASES = [(name, law, cones) for name, row in TABLE.items() for law, cones in row]


@pytest.mark.parametrize(("name", "law", "cones"), CASES, ids=["-".join(c) for c in CASES])
def test_solves_its_share_and_claims_no_more(name: str, law: str, cones: str) -> None:
    if name == "daqp":
        pytest.importorskip("daqp")
    solved = total = 0
    for label, base in family_problems():
        problem = base.replace(law=law) if cones == "exact" else base.replace(law=law, facets=6)
        found = sf.solve(problem, name, TOL, max_iterations=LIMIT.get(name), max_time=5.0)
        gap = velocity_error(problem, found.forces)
        if found.solved:
            assert gap <= 1.01 * TOL + 1e-13, (label, gap)
        else:
            worst = found.residuals.worst
            assert not worst <= 0.99 * TOL, (
                f"{label}: solved to {worst:.1e}, but the status is {found.status}"
            )
        assert found.residuals.velocity_error == pytest.approx(gap, rel=0.01, abs=1e-11), label
        assert np.isfinite(found.forces).all()
        assert np.allclose(found.velocities, problem.velocity(found.forces), atol=1e-12, equal_nan=True)
        solved += found.solved
        total += 1
    assert solved >= TABLE[name][law, cones] * total, f"{name} solved {solved} of {total}"


def hard_problems() -> dict[str, sf.ContactProblem]:
    """Problems that tempt a solver to claim too much: contradictory, singular, badly scaled, insoluble."""
    rng = np.random.default_rng(11)
    J = rng.normal(size=(12, 5))
    spread = np.repeat(10.0 ** np.array([-6.0, 0.0, 3.0, 6.0]), 3)
    wedge = np.zeros((6, 3))
    wedge[2], wedge[5] = [0, 0, 1.0], [0, 0, -1.0]  # a mass pressed from both sides: no velocity is allowed
    wedge[0], wedge[1], wedge[3], wedge[4] = np.eye(3)[0], np.eye(3)[1], np.eye(3)[0], -np.eye(3)[1]
    return {
        "zero G, approaching": sf.ContactProblem(np.zeros((3, 3)), [0.0, 0.0, -1.0], 0.5),
        "normal row missing": sf.ContactProblem(np.diag([1.0, 1.0, 0.0]), [1.0, 0.0, -1.0], 0.5),
        "squeezed beyond reach": sf.ContactProblem(wedge @ wedge.T, [0, 0, -1.0, 0, 0, -1.0], 0.5),
        "rank 5 of 12": sf.ContactProblem(J @ J.T, J @ rng.normal(size=5), 0.9),
        "scales of 1e12": sf.ContactProblem(
            spread[:, None] * (J @ J.T + 0.01 * np.eye(12)) * spread, spread * rng.normal(size=12), 0.7
        ),
        "steep friction": sf.ContactProblem(J @ J.T + 1e-6 * np.eye(12), J @ rng.normal(size=5), 30.0),
    }


@pytest.mark.parametrize("case", list(hard_problems()))
@pytest.mark.parametrize("name", list(TABLE))
def test_no_claim_without_a_solution(name: str, case: str) -> None:
    base = hard_problems()[case]
    tried = 0
    for law in ("coulomb", "convex"):
        for facets in (None, 6):
            problem = base.replace(law=law, facets=facets)
            if name not in sf.solver_names(problem):
                continue
            tried += 1
            found = sf.solve(problem, name, TOL, max_iterations=LIMIT.get(name, 200), max_time=2.0)
            if np.linalg.norm(problem.G, 2) == 0.0:
                assert not found.solved  # nothing moves, and nothing can be solved
                continue
            gap = velocity_error(problem, found.forces)
            if found.solved:
                assert gap <= 1.01 * TOL + 1e-13
            if found.status is sf.Status.ALMOST:
                assert gap <= 1.01e3 * TOL
    if tried == 0 and name not in sf.solver_names():
        pytest.skip("its package is not installed")
    assert tried > 0


@pytest.mark.parametrize("name", ["auto", "nsgs", "admm", "newton"])
@pytest.mark.sampled(2)
def test_time_is_bounded(name: str) -> None:
    problem = large_problems()[0][1]
    sf.solve(problem, name, max_iterations=1)  # compile
    found = sf.solve(problem, name, 0.0, max_time=0.05)
    assert found.solve_time < 1.0
    assert found.solved == (found.residuals.velocity_error == 0.0)


def test_zero_iterations_and_zero_time_are_survived() -> None:
    problem = family_problems()[0][1]
    for name in ("auto", "nsgs", "admm", "newton"):
        assert sf.solve(problem, name, max_iterations=0).forces.shape == (problem.contacts, 3)
        assert sf.solve(problem, name, max_time=0.0).forces.shape == (problem.contacts, 3)
    assert sf.solve(sf.ContactProblem(np.zeros((0, 0)), [], 0.5)).solved


@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_contacts_that_are_all_off_carry_nothing(law: str) -> None:
    problem = sf.ContactProblem(np.eye(6), [1.0, 0.0, -1.0] * 2, 0.5, normal_max=0.0, law=law)
    for name in ("auto", "nsgs", "admm", "newton"):
        found = sf.solve(problem, name).raise_if_failed()
        assert not found.forces.any()


def test_a_wrong_warm_start_is_named() -> None:
    with pytest.raises(sf.SurefootError, match="warm_start must have shape"):
        sf.solve(family_problems()[0][1], warm_start=[0.0, 1.0])  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["auto", "nsgs", "admm", "newton"])
def test_bounds_on_iterations_and_time_are_kept(name: str) -> None:
    """Also where one compiled call takes sweeps and Newton steps, and other methods come after it."""
    problems = [problem for _, problem in family_problems()]
    problems += [problem for family, problem in large_problems() if family == "stack-heavy-top-80"]
    for most in (0, 1, 3, 10, 50):
        for problem in problems:
            assert sf.solve(problem, name, 1e-300, max_iterations=most).iterations <= most
    hard = max(problems, key=lambda p: p.contacts)
    assert sf.solve(hard, name, 1e-300, max_time=0.0).status is sf.Status.MAX_TIME


@pytest.mark.parametrize("name", list(TABLE))
def test_claims_on_bounds_and_bilateral_contacts_are_kept(name: str) -> None:
    """A solver takes bounds, compliance and bilateral contacts and gets them right, or refuses with names."""
    rng = np.random.default_rng(4)
    J = rng.normal(size=(9, 12))
    g = np.tile([0.3, 0.0, -1.0], 3)
    law = "convex" if name in ("distribution", "daqp") else "coulomb"
    facets = 6 if name in ("lemke", "daqp") else None
    variants = {
        "bounds": {"normal_min": [0.0, 0.02, 0.0], "normal_max": [0.05, 1.0, np.inf]},
        "bilateral": {"bilateral": np.array([False, True, False])},
        "frictionless": {"mu": [0.5, 0.0, 0.5]},
        "off": {"normal_max": [np.inf, 0.0, np.inf]},
        "compliance": {"compliance": 0.5},
    }
    for label, change in variants.items():
        arguments = {"mu": 0.5, "law": law, "facets": facets} | change
        problem = sf.ContactProblem(J @ J.T, g, **arguments)  # type: ignore[arg-type]
        if name not in sf.solver_names(problem):
            with pytest.raises(sf.ProblemError, match=r"solvers that do: .*auto"):
                sf.solve(problem, name)
            continue
        found = sf.solve(problem, name, 1e-8, max_time=5.0)
        assert found.solved, (label, found.status, found.residuals.velocity_error)
        if label == "off":
            assert not found.forces[1].any()
        if label == "bilateral":
            assert np.abs(found.velocities[1]).max() < 1e-6
        if label == "frictionless":
            assert np.abs(found.forces[1, :2]).max() < 1e-9
