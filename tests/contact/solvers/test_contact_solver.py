"""The real-time path against the general one, and on input that should never make it raise."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.contacts import problem_set


def four_contacts() -> list[sf.ContactProblem]:
    return [p.problem for p in problem_set("robot", seed=3) if p.problem.contacts == 4]


@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_answers_are_those_of_solve(law: str) -> None:
    """The same kernel on the same numbers: bit for bit, cold; and the certificate is the problem's own."""
    for base in four_contacts():
        p = base.replace(law=law)
        found = sf.ContactSolver(4, p.mu, law, tol=1e-9, warm_start=False).solve(p.G, p.g)  # type: ignore[arg-type]
        expected = sf.solve(p, tol=1e-9)
        assert found.status is expected.status is sf.Status.SOLVED
        assert np.array_equal(found.forces, expected.forces)
        assert np.array_equal(found.velocities, expected.velocities)
        assert found.residuals == expected.residuals == sf.residuals(p, found.forces)
        assert found.iterations == expected.iterations
        assert found.velocity_error == found.residuals.velocity_error


@pytest.mark.parametrize(
    "settings",
    [
        {"normal_min": [0.0, 0.02, 0.0], "normal_max": [0.05, 1.0, np.inf]},
        {"bilateral": np.array([False, True, False])},
        {"mu": [0.5, 0.0, 0.5]},
        {"normal_max": [np.inf, 0.0, np.inf]},
        {"compliance": 0.5},
        {"facets": 6, "fit": "outer"},
        {"law": "convex", "facets": 4},
    ],
)
def test_every_setting_is_that_of_the_problem(settings: dict[str, object]) -> None:
    J = np.random.default_rng(4).normal(size=(9, 12))
    G, g = J @ J.T, np.tile([0.3, 0.0, -1.0], 3)
    arguments = {"mu": 0.5} | settings
    found = sf.ContactSolver(3, **arguments).solve(G, g)  # type: ignore[arg-type]
    problem = sf.ContactProblem(G, g, **arguments)  # type: ignore[arg-type]
    assert found.solved
    assert np.allclose(found.forces, sf.solve(problem).forces, atol=1e-7)
    assert found.residuals == sf.residuals(problem, found.forces)


def test_warm_starts_and_their_end() -> None:
    p = next(p for p in four_contacts() if sf.solve(p).iterations > 3)
    solver = sf.ContactSolver(4, p.mu)
    first = solver.solve(p.G, p.g)
    again = solver.solve(p.G, p.g)
    assert again.iterations <= first.iterations
    assert not np.shares_memory(first.forces, again.forces)
    solver.reset()
    assert solver.solve(p.G, p.g).iterations == first.iterations
    out = np.empty((11, 3))
    found = solver.solve(p.G, p.g, out=out)
    assert np.shares_memory(found.forces, out)


@pytest.mark.parametrize("wild", [1e6, 1e12, 1e100])
def test_a_wild_call_leaves_no_start(wild: float) -> None:
    """Forces of another size are no start: the next call takes as long as a fresh one."""
    p = next(p for p in four_contacts() if sf.solve(p).iterations > 3)
    solver = sf.ContactSolver(4, p.mu)
    fresh = solver.solve(p.G, p.g).iterations
    for G, g in ((p.G, wild * p.g), (p.G / wild, p.g)):
        assert solver.solve(G, g).solved
        assert solver.solve(p.G, p.g).iterations == fresh
        assert solver.solve(p.G, 1.01 * p.g).iterations < fresh


@pytest.mark.parametrize("most", [0, 1, 2, 3, 5])
def test_all_methods_together_take_the_iterations_that_are_allowed(most: int) -> None:
    """What the compiled call leaves unsolved goes on by other methods, on what is left of the same budget."""
    for p in four_contacts():
        found = sf.ContactSolver(4, p.mu, tol=1e-13, max_iterations=most).solve(p.G, p.g)
        assert found.iterations <= most


def test_hard_input_is_answered_and_forgotten() -> None:
    """NaN, infinity, overflow: a status, finite forces, and the next call is not spoilt."""
    p = four_contacts()[0]
    solver = sf.ContactSolver(4, p.mu, max_iterations=2000)
    good = solver.solve(p.G, p.g).forces.copy()
    for bad in (np.nan, np.inf):
        for G, g in ((np.full((12, 12), bad), p.g), (p.G, np.full(12, bad))):
            found = solver.solve(G, g)
            assert found.status is sf.Status.INVALID
            assert not found.forces.any()
            assert np.isnan(found.velocity_error)
    for scale in (1e-300, 1e300):
        assert np.isfinite(solver.solve(scale * p.G, p.g).forces).all()
    assert np.allclose(solver.solve(p.G, p.g).forces, good, atol=1e-6)


def test_single_precision_and_lists_are_read() -> None:
    p = four_contacts()[0]
    solver = sf.ContactSolver(4, p.mu, tol=1e-6, warm_start=False)
    rough = solver.solve(p.G.astype(np.float32), p.g.astype(np.float32))  # type: ignore[arg-type]
    assert rough.solved
    assert np.allclose(rough.velocities, solver.solve(p.G, p.g).velocities, atol=1e-5)
    assert solver.solve(np.asfortranarray(p.G), p.g.tolist()).solved  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("G", "g", "words"),
    [
        (np.eye(11), np.zeros(12), r"G must have shape \(12, 12\), got \(11, 11\)"),
        (np.eye(12), np.zeros((4, 3)), r"g must have shape \(12,\), got \(4, 3\)"),
        (np.eye(12) + np.triu(np.ones((12, 12)), 1), np.zeros(12), "G must be symmetric"),
        (-np.eye(12), np.zeros(12), "positive semidefinite"),
    ],
)
def test_what_is_no_problem_is_named(G: np.ndarray, g: np.ndarray, words: str) -> None:
    with pytest.raises(sf.ProblemError, match=words):
        sf.ContactSolver(4, 0.5).solve(G, g)


def test_one_solver_per_thread() -> None:
    """Threads with a solver each answer what one thread does: nothing is shared, and the lock is released."""
    problems = four_contacts()
    expected = [sf.ContactSolver(4, p.mu, warm_start=False).solve(p.G, p.g).forces for p in problems]
    found: list[list[np.ndarray]] = [[], []]

    def work(into: list[np.ndarray]) -> None:
        for p in problems:
            into.append(sf.ContactSolver(4, p.mu, warm_start=False).solve(p.G, p.g).forces)

    threads = [threading.Thread(target=work, args=(into,)) for into in found]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for answers in found:
        assert all(np.array_equal(a, b) for a, b in zip(answers, expected, strict=True))


def test_a_solver_that_is_at_work_is_refused_to_another_thread() -> None:
    """Its memory has one user: threads that share a solver are answered rightly or refused, never wrongly."""
    problems = [p.replace(mu=0.6) for p in four_contacts()]
    expected = [sf.solve(p).velocities for p in problems]
    solver = sf.ContactSolver(4, 0.6, warm_start=False)
    wrong, refused = list[int](), list[str]()

    def work() -> None:
        for turn in range(1500):
            k = turn % len(problems)
            try:
                found = solver.solve(problems[k].G, problems[k].g)
            except sf.ProblemError as error:
                refused.append(str(error))
            else:
                wrong.extend([k] * (not np.allclose(found.velocities, expected[k], atol=1e-6)))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
    assert all("at work in another thread" in words for words in refused)
    solver._turn.clear()  # as while a call of another thread is in the compiled part
    with pytest.raises(sf.ProblemError, match="at work in another thread"):
        solver.solve(problems[0].G, problems[0].g)
