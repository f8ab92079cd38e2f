"""Batches answer as one problem at a time does, and their gradients are `ContactDerivative`'s."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.batch.cpu_fallback import solve_on_host
from surefoot.contact.batch.kernel import contact_blocks, contact_vjp, solve_contacts
from surefoot.contact.derivative.solution_derivative import ContactDerivative


def problems(count: int = 40, contacts: int = 4, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    m = 3 * contacts
    J = rng.normal(size=(count, m, m + 4))
    g = rng.normal(size=(count, m))
    g[:, 2::3] -= 0.5
    return J @ J.transpose(0, 2, 1) / m, g


LAWS: list[dict[str, Any]] = [
    {"mu": 0.6},
    {"mu": 0.6, "law": "convex"},
    {"mu": [0.0, 0.3, 0.6, 0.9], "normal_min": [0.0, 0.1, 0.2, 0.0], "normal_max": [np.inf, 0.4, 0.5, 0.0]},
    {"mu": 0.5, "law": "convex", "normal_min": 0.1, "normal_max": 0.5},
    {"mu": 0.5, "bilateral": np.array([True, False, False, False])},
]


@pytest.mark.parametrize("laws", LAWS)
def test_a_batch_is_its_problems(laws: dict[str, Any]) -> None:
    G, g = problems()
    held = laws.get("bilateral", np.zeros(4, dtype=bool))
    given = {name: law for name, law in laws.items() if name != "bilateral"}
    low = np.where(held, -np.inf, given.pop("normal_min", 0.0))
    batch = sf.solve_batch(G, g, **given, normal_min=low, tol=1e-12, derivative=True)
    weights = np.random.default_rng(1).normal(size=(40, 8, 3))
    back = batch.derivative.vjp(weights[:, :4], weights[:, 4:])
    assert batch.solved.all()
    assert back.regular.all()
    for k in range(40):
        problem = sf.ContactProblem(G[k], g[k], **laws)
        one = sf.solve(problem, tol=1e-12)
        np.testing.assert_array_equal(batch.forces[k], one.forces)
        assert batch.residual[k] == one.residuals.velocity_error
        wanted = one.derivative().vjp(weights[k, :4], weights[k, 4:])
        for name in ("G", "g", "mu", "normal_min", "normal_max", "compliance"):
            np.testing.assert_allclose(getattr(back, name)[k], getattr(wanted, name), rtol=1e-10, atol=1e-11)


@pytest.mark.parametrize("contacts", [2, 8])
def test_redundant_contacts_in_a_batch(contacts: int) -> None:
    """All on one point mass; of many, what the singular system misses needs all of its row of memory."""
    J = np.vstack([np.eye(3)] * contacts)
    g = np.stack([J @ v for v in ([0.1, 0.0, -1.0], [0.2, 0.1, -1.0], [0.0, 0.0, -2.0])])
    batch = sf.solve_batch(np.tile(J @ J.T, (3, 1, 1)), g, 0.5, derivative=True)
    weights = np.random.default_rng(0).normal(size=(2, 3, contacts, 3))
    back = batch.derivative.vjp(*weights)
    assert not back.regular.any()
    for k in range(3):
        d = sf.solve(sf.ContactProblem(J @ J.T, g[k], 0.5)).derivative()
        np.testing.assert_allclose(back.g[k], d.vjp(weights[0, k], weights[1, k]).g, atol=1e-9)


@pytest.mark.parametrize("contacts", [46, 128, 256])
def test_many_contacts_in_a_batch(contacts: int) -> None:
    """Answers are those of `ContactSolver`, also where other methods come after the compiled call."""
    G, g = problems(3, contacts)
    batch = sf.solve_batch(G, g, 0.6)
    solver = sf.ContactSolver(contacts, 0.6, warm_start=False)
    assert batch.solved.all()
    for k in range(3):
        own = solver.solve(G[k], g[k])
        assert sf.residuals(sf.ContactProblem(G[k], g[k], 0.6), batch.forces[k]).worst <= 1e-8
        np.testing.assert_allclose(batch.forces[k], own.forces, atol=1e-6)


def test_a_batch_names_how_many_contacts_it_takes() -> None:
    with pytest.raises(sf.ProblemError, match="a batch takes up to 256 contacts a problem, got 257"):
        sf.solve_batch(np.zeros((1, 771, 771)), np.zeros((1, 771)), 0.6)


def test_contacts_that_are_off_pad_smaller_problems() -> None:
    G, g = problems(30)
    on = np.random.default_rng(2).random((30, 4)) < 0.6
    on[0] = False
    there = np.repeat(on, 3, axis=1)
    G, g = G * there[:, :, None] * there[:, None, :], g * there
    batch = sf.solve_batch(G, g, 0.6, normal_max=np.where(on, np.inf, 0.0), tol=1e-12, derivative=True)
    weights = np.random.default_rng(3).normal(size=(2, 30, 4, 3))
    back = batch.derivative.vjp(*weights)
    assert batch.solved.all()
    assert (batch.forces[~on] == 0.0).all()
    for k in range(1, 30):
        rows = there[k]
        if rows.any():
            one = sf.solve(sf.ContactProblem(G[k][np.ix_(rows, rows)], g[k][rows], 0.6), tol=1e-12)
            np.testing.assert_allclose(batch.forces[k][on[k]], one.forces, rtol=1e-9, atol=1e-10)
            wanted = one.derivative().vjp(weights[0, k][on[k]], weights[1, k][on[k]])
            np.testing.assert_allclose(back.g[k][rows], wanted.g, rtol=1e-5, atol=1e-6)


def test_what_a_mask_takes_out_is_not_read() -> None:
    """In the CPU fallback of JAX and PyTorch: whatever stands in the rows of a contact that is off."""
    G, g = problems(6)
    on, broken = np.array([True, False, True, True]), G.copy()
    broken[:, 3, 3] = -1.0
    found, rows = solve_on_host(False, 1e-12, broken, g, np.full((6, 4), 0.6), on), np.repeat(on, 3)
    for k in range(6):
        one = sf.solve(sf.ContactProblem(G[k][np.ix_(rows, rows)], g[k][rows], 0.6), tol=1e-12)
        np.testing.assert_allclose(found[k][on], one.forces, atol=1e-12)
        assert (found[k][~on] == 0.0).all()


def test_threads_change_nothing() -> None:
    G, g = problems(400, contacts=2)
    one, two = (sf.solve_batch(G, g, 0.6, threads=t, derivative=True) for t in (1, 3))
    np.testing.assert_array_equal(one.forces, two.forces)
    ends = [b.derivative.vjp(forces=np.ones((400, 2, 3))).g for b in (one, two)]
    np.testing.assert_array_equal(*ends)


def test_every_problem_has_its_own_status() -> None:
    G, g = problems(5, contacts=1)
    g[1, 0] = np.nan
    G[2], g[2] = np.diag([1.0, 1.0, 0.0]), [0.0, 0.0, -1.0]  # nothing stops it
    batch = sf.solve_batch(G, g, 0.5, derivative=True)
    names = [status.value for status in batch.status]
    assert [n for k, n in enumerate(names) if k not in (1, 2)] == ["solved"] * 3
    assert names[1] == "invalid"
    assert names[2] == "infeasible"
    assert np.isfinite(batch.forces).all()
    assert batch.derivative.valid.tolist() == [True, False, False, True, True]
    back = batch.derivative.vjp(forces=np.ones((5, 1, 3)))
    assert np.isfinite(back.G).all()
    assert (back.g[~back.valid] == 0.0).all()


def test_warm_starts_and_single_precision() -> None:
    G, g = problems(20)
    cold = sf.solve_batch(G, g, 0.6)
    warm = sf.solve_batch(G, g, 0.6, warm_start=cold.forces)
    assert warm.iterations.sum() < cold.iterations.sum()
    single = sf.solve_batch(G.astype(np.float32), g.astype(np.float32), 0.6)
    assert single.solved.all()
    np.testing.assert_allclose(single.forces, cold.forces, atol=1e-4)


def test_kinks_in_a_batch_are_seen() -> None:
    forces = np.array([-0.5, 0.0, 1.0])
    G, g = np.tile(np.eye(3), (2, 1, 1)), np.stack([-forces, [-0.1, 0.0, -1.0]])
    batch = sf.solve_batch(G, g, 0.5, derivative=True)
    assert (batch.derivative.distance < 1e-9).tolist() == [True, False]


@pytest.mark.long
def test_the_kernel_runs_in_a_callers_own_code() -> None:
    @numba.njit
    def normal_forces(G, g, laws):  # type: ignore[no-untyped-def]
        out = np.empty(len(G))
        for b in range(len(G)):
            n = laws.shape[1]
            buffer = np.empty((2 * n + 3, 3))
            done = solve_contacts(G[b], g[b], laws, False, 1e-8, 1e-8, -1, False, buffer)
            out[b] = buffer[:n, 2].sum() if done >= 0 else np.nan
        return out

    G, g = problems(6, contacts=1)
    laws = np.array([[0.6], [0.0], [np.inf]])
    np.testing.assert_array_equal(normal_forces(G, g, laws), sf.solve_batch(G, g, 0.6).forces[:, 0, 2])
    ones, out = np.ones((2, 3)), np.empty((2, 3))
    d = sf.solve(sf.ContactProblem(G[0], g[0], 0.6)).derivative()
    buffer = np.vstack([d.forces, d.velocities, np.zeros((3, 3))])
    assert contact_vjp(G[0], laws, False, buffer, ones, out)
    np.testing.assert_allclose(out[0], d.vjp(ones[:1], ones[1:]).g, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"g": np.zeros((3, 5))}, r"g must have shape \(B, 3n\), got \(3, 5\)"),
        ({"G": np.zeros((3, 3, 4))}, r"G must have shape \(3, 3, 3\) for this g"),
        ({"mu": -1.0}, "mu must be finite and >= 0"),
        ({"mu": np.zeros(4)}, r"mu must be a number or have shape \(1,\) or \(3, 1\)"),
        ({"normal_min": 2.0, "normal_max": 1.0}, "normal_min must be <= normal_max"),
        ({"normal_min": -np.inf, "normal_max": 1.0}, "a bilateral contact takes no normal bounds"),
        ({"normal_min": -1.0}, "normal_min must be finite and >= 0"),
        ({"law": "glue"}, "unknown law 'glue'"),
        ({"warm_start": np.zeros((3, 3))}, r"warm_start must have shape \(3, 1, 3\)"),
        ({"G": np.tile(np.diag([1.0, 1.0, -1.0]), (3, 1, 1))}, "problem 0 of the batch: G must be positive"),
        ({"threads": 0}, "threads must be a whole number >= 1"),
    ],
)
def test_wrong_arguments_are_named(changes: dict[str, Any], words: str) -> None:
    arguments = {"G": np.tile(np.eye(3), (3, 1, 1)), "g": np.zeros((3, 3)), "mu": 0.5} | changes
    with pytest.raises(sf.ProblemError, match=words):
        sf.solve_batch(**arguments)


def test_an_option_that_is_none_is_refused() -> None:
    """What comes by keyword is not swallowed: a name that is mistyped would else be ignored."""
    with pytest.raises(TypeError, match="unexpected keyword argument 'warmstart'"):
        sf.solve_batch(*problems(3, contacts=1), 0.5, warmstart=None)  # type: ignore[call-arg]


def test_gradients_name_wrong_shapes() -> None:
    batch = sf.solve_batch(*problems(3, contacts=1), 0.5, derivative=True)
    with pytest.raises(sf.ProblemError, match=r"forces must have shape \(3, 1, 3\)"):
        batch.derivative.vjp(forces=np.zeros((3, 3)))


def test_the_derivative_at_given_forces_is_the_same_object() -> None:
    """`ContactDerivative` needs nothing but forces: a batch's problem can be looked at in full."""
    G, g = problems(1)
    batch = sf.solve_batch(G, g, 0.6)
    d = ContactDerivative(sf.ContactProblem(G[0], g[0], 0.6), batch.forces[0], batch.velocities[0])
    assert d.modes == sf.solve(sf.ContactProblem(G[0], g[0], 0.6)).derivative().modes


def test_dense_blocks_are_those_of_the_derivative() -> None:
    """Both laws, bounds, bilateral contacts, frictionless ones and open ones."""
    rng = np.random.default_rng(11)
    for trial in range(40):
        n, law = 1 + trial % 5, ("coulomb", "convex")[trial % 2]
        J = rng.normal(size=(3 * n, 3 * n + 4))
        G, g = J @ J.T, 3.0 * rng.normal(size=3 * n)
        bilateral = rng.random(n) < 0.2
        mu = np.where(rng.random(n) < 0.2, 0.0, rng.uniform(0.2, 1.0, n))
        high = np.where(bilateral | (rng.random(n) < 0.6), np.inf, rng.uniform(0.01, 0.3, n))
        problem = sf.ContactProblem(G, g, mu, 0.0, high, law, bilateral=bilateral)
        solution = sf.solve(problem, tol=1e-12)
        if not solution.solved or solution.derivative().kinks:
            continue
        d = solution.derivative()
        laws = np.array([problem.mu, problem.normal_min, problem.normal_max])
        out = np.empty((3 * n, 4 * n))
        assert contact_blocks(problem.G, laws, law == "convex", np.concatenate([d.forces, d.velocities]), out)
        assert out[:, : 3 * n] == pytest.approx(d.dforces_dg, abs=1e-9 * np.abs(d.dforces_dg).max())
        assert out[:, 3 * n :] == pytest.approx(
            d.dforces_dmu, abs=1e-9 * max(np.abs(d.dforces_dmu).max(), 1.0)
        )
