"""The interior point on Coulomb's law: walls that other methods leave, and what it must not claim."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.solvers import auto, central_path, interior_point, strategies
from surefoot.contact.solvers.polish import polish
from surefoot.contact.solvers.redundant_contacts import where_redundant
from surefoot.contact.solvers.solver import SolverSettings

SETTINGS = SolverSettings(1e-8)


def sheet(contacts: int, seed: int, law: str = "coulomb") -> sf.ContactProblem:
    """A body on many contacts with a floor, thrown at it: rank 6, whatever their number."""
    rng = np.random.default_rng(seed)
    rows = []
    for x, y in rng.uniform(-1.0, 1.0, size=(contacts, 2)):
        rows.append(np.hstack([np.eye(3), [[0.0, 0.3, y], [-0.3, 0.0, -x], [-y, x, 0.0]]]))
    J = np.vstack(rows) * np.array([1.0, 1.0, 1.0, 2.0, 2.0, 1.5])
    velocity = rng.normal(size=6) * [1.0, 1.0, 0.0, 0.3, 0.3, 0.5]
    velocity[2] = -1.0
    return sf.ContactProblem(J @ J.T, J @ velocity, 0.4, law=law)


def natural_error(problem: sf.ContactProblem, forces: np.ndarray) -> float:
    """The largest violation of Coulomb's law, from its definition."""
    u = (problem.G @ forces.ravel() + problem.g).reshape(-1, 3)
    worst = 0.0
    for f, v, mu in zip(forces, u, problem.mu, strict=True):
        size, speed = np.hypot(*f[:2]), np.hypot(*v[:2])
        worst = max(worst, size - mu * f[2], -f[2], -v[2], abs(f[2] * v[2]))
        if speed > 1e-5 and f[2] > 1e-5:  # slides: the force opposes it, at the cone's border
            worst = max(worst, float(np.linalg.norm(f[:2] + mu * f[2] * v[:2] / speed)))
    return worst


@pytest.mark.parametrize("seed", range(6))
def test_redundant_contacts_obey_coulombs_law(seed: int) -> None:
    problem = sheet(40, seed)
    found = sf.solve(problem, "interior_point")
    assert found.solved
    assert natural_error(problem, found.forces) <= 3e-7


def test_the_convex_law_has_the_velocities_of_another_method() -> None:
    problem = sheet(12, 1, "convex")
    own, other = (sf.solve(problem, name).raise_if_failed() for name in ("interior_point", "distribution"))
    np.testing.assert_allclose(own.velocities, other.velocities, atol=1e-7)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_units_change_nothing(scale: float) -> None:
    plain = sheet(20, 2)
    other = sf.ContactProblem(scale * plain.G, scale**2 * plain.g, 0.4)
    found = sf.solve(plain, "interior_point"), sf.solve(other, "interior_point")
    assert found[0].solved
    assert found[1].solved
    np.testing.assert_allclose(found[1].velocities / scale**2, found[0].velocities, atol=1e-6)


def test_frictionless_and_idle_contacts_are_taken() -> None:
    problem = sheet(10, 3)
    mu = np.full(10, 0.4)
    mu[:4] = 0.0
    G = problem.G.copy()
    G[27:] = G[:, 27:] = 0.0  # the last meets nothing
    g = problem.g.copy()
    g[27:] = 0.0
    found = sf.solve(sf.ContactProblem(G, g, mu), "interior_point").raise_if_failed()
    np.testing.assert_allclose(found.forces[:4, :2], 0.0, atol=1e-12)
    np.testing.assert_array_equal(found.forces[9], 0.0)


def test_only_redundant_contacts_are_tried_in_auto() -> None:
    J = np.random.default_rng(0).normal(size=(30, 40))
    full = sf.ContactProblem(J @ J.T, J @ np.ones(40), 0.5)
    assert where_redundant(full, SETTINGS, None) is None
    bounded = sheet(10, 0).replace(normal_max=np.full(10, 50.0))
    assert where_redundant(bounded, SETTINGS, None) is None
    assert where_redundant(sheet(10, 0).polyhedral(6), SETTINGS, None) is None
    answer = where_redundant(sheet(10, 0), SETTINGS, None)
    assert answer is not None
    assert answer.iterations > 0


def test_iterations_and_time_are_kept() -> None:
    problem = sheet(40, 4)
    assert sf.solve(problem, "interior_point", max_iterations=3).iterations <= 3
    late = sf.solve(problem, "interior_point", max_time=0.0)
    assert not late.solved
    assert np.isfinite(late.forces).all()


def test_a_good_warm_start_is_never_made_worse() -> None:
    problem = sheet(40, 5)
    good = sf.solve(problem, "auto", 1e-8).raise_if_failed().forces
    found = sf.solve(problem, "interior_point", 1e-12, warm_start=good, max_iterations=2)
    assert sf.residuals(problem, found.forces).worst <= sf.residuals(problem, good).worst


@pytest.mark.parametrize(
    ("wall", "step"), [("wall of 11", 0), ("wall of 11", 19), ("wall of 23", 0), ("wall of 23", 9)]
)
def test_a_wall_of_bricks_is_solved(wall: str, step: int) -> None:
    """144 contacts of rank 136: the central path turns, sweeps and Newton end at 1e-5 after a second."""
    pytest.importorskip("mujoco")
    from benchmarks.problems.stacked_scenes import SCENES, steps

    given = list(steps(SCENES[wall], step + 1))[-1].problem
    problem = sf.ContactProblem(given.G, given.g, given.mu)
    found = sf.solve(problem)
    assert found.solved
    assert found.iterations < 6000


@pytest.mark.long
@pytest.mark.parametrize("known", [True, False])
def test_a_wall_of_60_bricks_is_solved(known: bool) -> None:
    """Its path winds for thousands of steps, and nothing else comes below 9e-6."""
    pytest.importorskip("mujoco")
    from benchmarks.problems.stacked_scenes import SCENES, steps

    given = next(steps(SCENES["wall of 60"], 1)).problem
    problem = given if known else sf.ContactProblem(given.G, given.g, given.mu)
    found = sf.solve(problem, tol=1e-6)
    assert found.solved
    assert natural_error(problem, found.forces) <= 1e-4


def test_polish_ends_where_it_comes_no_nearer() -> None:
    problem = sheet(20, 6)
    good = sf.solve(problem, "auto", 1e-10).raise_if_failed().forces
    start = good + 1e-6 * np.random.default_rng(0).normal(size=good.shape)
    before = sf.residuals(problem, start).worst
    found = polish(problem, SolverSettings(1e-9), start)
    assert sf.residuals(problem, found.forces).worst < 1e-2 * before
    stuck = polish(problem, SolverSettings(0.0), start)
    assert stuck.iterations < 20_000
    assert polish(problem, SolverSettings(1e-9, 70), start).iterations <= 70


def test_auto_asks_it_before_the_slow_methods() -> None:
    names = [stage.name for stage in strategies.CONES["coulomb"]]
    assert names.index(strategies.INTERIOR) < names.index("newton")
    assert auto.LOOKS[strategies.INTERIOR] is where_redundant


def test_shifts_that_run_away_end_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces of 1e190 leave a shift that is no number: least squares of such raise an error."""
    monkeypatch.setattr(central_path.CentralPath, "find_shift", lambda path: np.full(len(path.mu), np.inf))
    monkeypatch.setattr(interior_point, "IDLE_SHIFTS", 99)
    found = sf.solve(sheet(40, 4), "interior_point", 1e-14)
    assert np.isfinite(found.forces).all()


def test_a_matrix_of_zeros_is_left_alone(capfd: pytest.CaptureFixture[str]) -> None:
    """LAPACK complained on the terminal of a factor without columns."""
    problem = sf.ContactProblem(np.zeros((6, 6)), [0.1, 0.0, -1.0, 0.0, 0.0, 1.0], 0.5)
    assert not sf.solve(problem, "interior_point").solved
    assert capfd.readouterr() == ("", "")
