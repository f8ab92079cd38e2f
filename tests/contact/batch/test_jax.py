"""The problem in JAX: the same forces as `surefoot.solve`, certified alike, with finite gradients."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.contact.batch.answers import STATUSES
from surefoot.contact.batch.certificate import scales
from surefoot.contact.batch.modes import certified
from surefoot.contact.solution import Status

jax = pytest.importorskip("jax", reason="JAX is not installed (extra jax)")
jnp = jax.numpy
sfj = pytest.importorskip("surefoot.contact.batch.jax")
METHODS = (sfj.solve, sfj.solve_on_host)


@pytest.fixture(autouse=True)
def _double_precision() -> Any:
    with jax.enable_x64(True):
        yield


def _weights(count: int, seed: int = 1) -> tuple[Any, Any]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, 4, 3)), rng.normal(size=(count, 4, 3))


def test_certificate_is_the_packages_own(problems: Any, solved: Any) -> None:
    law, _ = solved
    found = sfj.solve(*problems, law=law)
    rough = found.forces * (1.0 + 1e-5)  # and that of forces which are a little off
    for forces in (found.forces, rough):
        on = jnp.ones(problems.mu.shape, bool)
        size = scales(sfj.JAX, *problems[:2], on)
        own = certified(sfj.JAX, *problems, on, size, forces, True, law == "convex", 1e-8)
        own = jax.tree.map(np.asarray, own)
        for k, (G, g, mu) in enumerate(zip(*problems, strict=True)):
            numbers = sf.residuals(sf.ContactProblem(G, g, mu, law=law), np.asarray(forces[k]))
            assert own.residual[k] == pytest.approx(numbers.velocity_error, rel=1e-6, abs=1e-14)
            assert (STATUSES[int(own.status[k])] is Status.SOLVED) == (numbers.worst <= 1e-8)


@pytest.mark.parametrize("smoothing", [0.0, pytest.param(1e-3, marks=pytest.mark.long)])
def test_gradients_are_those_of_differences(problems: Any, solved: Any, smoothing: float) -> None:
    law, _ = solved
    few = [jnp.asarray(v[:12]) for v in problems]
    wf, wu = _weights(12)

    def number(G: Any, g: Any, mu: Any) -> Any:
        found = sfj.solve(G, g, mu, law=law, smoothing=smoothing)
        return (wf * found.forces).sum((1, 2)) + (wu * found.velocities).sum((1, 2))

    number = jax.jit(number)
    slopes = jax.jit(jax.grad(lambda *a: number(*a).sum(), argnums=(0, 1, 2)))(*few)
    rng = np.random.default_rng(2)
    for place in range(3):
        step = rng.normal(size=few[place].shape) * np.abs(few[place]).max()
        if place == 0:
            step = step + step.swapaxes(1, 2)
        up, down = list(few), list(few)
        up[place], down[place] = few[place] + 1e-7 * step, few[place] - 1e-7 * step
        difference = (number(*up) - number(*down)) / 2e-7
        slope = (slopes[place] * step).reshape(12, -1).sum(1)
        assert np.abs(slope).max() > 1e-2
        np.testing.assert_allclose(slope, difference, rtol=1e-5, atol=1e-5 * np.abs(slope).max())


@pytest.mark.long
def test_check_grads_and_vmap(problems: Any) -> None:
    from jax.test_util import check_grads

    G, g, mu = (jnp.asarray(v[3]) for v in problems)
    check_grads(lambda *a: sfj.solve(*a)[:2], (G, g, mu), order=1, modes=["rev"], eps=1e-6, rtol=1e-4)
    several = [jnp.asarray(v[:6]) for v in problems]
    mapped = jax.vmap(jax.grad(lambda *a: sfj.solve(*a).forces[:, 2].sum(), argnums=1))(*several)
    whole = jax.grad(lambda *a: sfj.solve(*a).forces[..., 2].sum(), argnums=1)(*several)
    np.testing.assert_allclose(mapped, whole, rtol=1e-9, atol=1e-12)
    host = jax.vmap(jax.grad(lambda *a: sfj.solve_on_host(*a, tol=1e-12).forces[:, 2].sum(), argnums=1))(
        *several
    )
    np.testing.assert_allclose(host, whole, rtol=1e-6, atol=1e-9)


@pytest.mark.long
def test_absent_contacts_are_no_contacts(problems: Any) -> None:
    mask = np.array([True, False, True, True])
    keep = np.repeat(mask, 3)
    for smoothing in (0.0, 1e-3):
        found = sfj.solve(*problems, mask=mask, smoothing=smoothing)
        fewer = sfj.solve(
            problems.G[:, keep][:, :, keep], problems.g[:, keep], problems.mu[:, mask], smoothing=smoothing
        )
        np.testing.assert_allclose(found.forces[:, mask], fewer.forces, rtol=1e-7, atol=1e-9)
        assert (found.forces[:, 1] == 0.0).all()
        assert (found.modes[:, 1] == 0).all()
        slope = jax.grad(
            lambda mu, smoothing=smoothing: sfj.solve(
                *problems[:2], mu, mask=mask, smoothing=smoothing
            ).forces.sum()
        )(jnp.asarray(problems.mu))
        assert (slope[:, 1] == 0.0).all()


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_open_contacts_have_true_zeros_and_smoothing_fills_them(method: Any) -> None:
    G, g, mu = jnp.eye(3), jnp.array([0.1, 0.0, 2.0]), jnp.array([0.5])
    found = method(G, g, mu)
    assert found.modes.tolist() == [1]
    assert (jax.grad(lambda g: method(G, g, mu).forces.sum())(g) == 0.0).all()
    slope = jax.grad(lambda g: sfj.solve(G, g, mu, smoothing=1e-2).forces[0, 2])(g)
    assert -1.0 < slope[2] < -1e-4


@pytest.mark.long
def test_on_the_path_force_times_velocity_is_the_smoothing(problems: Any, solved: Any) -> None:
    law, _ = solved
    found = sfj.solve(*problems, law=law, smoothing=1e-3)
    assert (found.status == 0).all()
    u = np.asarray(found.velocities)
    if law == "convex":
        power = (np.asarray(found.forces) * u).sum(-1)
        np.testing.assert_allclose(power, 1e-3, rtol=1e-6)
    gap = problems.mu * found.forces[..., 2] - jnp.hypot(found.forces[..., 0], found.forces[..., 1])
    assert (gap > 0.0).all()


@pytest.mark.long
@pytest.mark.parametrize("law", ["coulomb", "convex"])
@pytest.mark.parametrize("smoothing", [0.0, 1e-4])
def test_never_nan(hard: Any, smoothing: float, law: str) -> None:
    names = [name for name, _ in hard]
    given = [jnp.asarray(np.concatenate(v)) for v in zip(*(problem for _, problem in hard), strict=True)]

    def number(*arrays: Any) -> Any:
        found = sfj.solve(*arrays, law=law, smoothing=smoothing)
        return found.forces.sum() + found.velocities.sum(), found

    slopes, found = jax.jit(jax.grad(number, argnums=(0, 1, 2), has_aux=True))(*given)
    for k, name in enumerate(names):
        assert all(np.isfinite(s[k]).all() for s in (*slopes, found.forces, found.velocities)), name
        bad = name in ("nan in g", "infinite G", "negative mu")
        assert (STATUSES[int(found.status[k])] is Status.INVALID) == bad, name
        assert not (bad and found.forces[k].any()), name
        if name == "G is zero":
            assert STATUSES[int(found.status[k])] is not Status.SOLVED


@pytest.mark.long
def test_single_precision(problems: Any) -> None:
    found = sfj.solve(*(v.astype(np.float32) for v in problems))
    exact = sfj.solve(*problems)
    assert found.forces.dtype == jnp.float32
    assert (found.status == 0).all()
    assert np.abs(found.velocities - exact.velocities).max() <= 1e-5 * np.abs(problems.g).max()


def test_wrong_input_is_named(problems: Any) -> None:
    G, g, mu = problems
    with pytest.raises(ProblemError, match="g must have shape"):
        sfj.solve(G, g[:, :11], mu)
    with pytest.raises(ProblemError, match="G must have shape"):
        sfj.solve(G[0], g, mu)
    with pytest.raises(ProblemError, match="mu must have shape"):
        sfj.solve(G, g, mu[:, :3])
    with pytest.raises(ProblemError, match="G must be float32 or float64, got int"):
        sfj.solve(G.astype(int), g, mu)
    with pytest.raises(ProblemError, match="unknown law 'rigid'"):
        sfj.solve(G, g, mu, law="rigid")
    with pytest.raises(ProblemError, match="smoothing"):
        sfj.solve(G, g, mu, smoothing=-1.0)
