"""One law, written three times: plain NumPy, compiled, and in a framework's arrays. They say the same.

The plain form (`ContactDerivative`) is the reference; its own judge is the arithmetic of
`tests/adversary/test_derivatives.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray


class Said(NamedTuple):
    """Forces and velocities (B, n, 3), gradients in G, g and mu, who is solved and who at a kink (B, n)."""

    forces: FloatArray
    velocities: FloatArray
    G: FloatArray
    g: FloatArray
    mu: FloatArray
    solved: FloatArray
    kinks: FloatArray


def plain(G: Any, g: Any, mu: Any, law: str, weights: Any) -> Said:
    rows = []
    for k in range(len(g)):
        solution = sf.solve(sf.ContactProblem(G[k], g[k], mu[k], law=law), tol=1e-12)
        d = solution.derivative(kink_tol=1e-6)
        back = d.vjp(*weights[:, k])
        near = np.isin(np.arange(len(mu[k])), [kink.contact for kink in d.kinks])
        rows.append((d.forces, d.velocities, back.G, back.g, back.mu, solution.solved, near))
    return Said(*(np.array(v) for v in zip(*rows, strict=True)))


def compiled(G: Any, g: Any, mu: Any, law: str, weights: Any) -> Said:
    found = sf.solve_batch(G, g, mu, law=law, tol=1e-12, derivative=True)
    back = found.derivative.vjp(*weights)
    near = np.broadcast_to((found.derivative.distance < 1e-6)[:, None], mu.shape)
    return Said(found.forces, found.velocities, back.G, back.g, back.mu, found.solved, near)


def in_jax(G: Any, g: Any, mu: Any, law: str, weights: Any, method: str = "solve") -> Said:
    import jax

    from surefoot.contact.batch import jax as sfj

    def number(*given: Any) -> Any:
        found = getattr(sfj, method)(*given, law=law)
        return (weights[0] * found.forces).sum() + (weights[1] * found.velocities).sum(), found

    with jax.enable_x64(True):
        slopes, found = jax.jit(jax.grad(number, argnums=(0, 1, 2), has_aux=True))(
            *map(jax.numpy.asarray, (G, g, mu))
        )
        out = [
            np.asarray(v) for v in (found.forces, found.velocities, *slopes, found.status == 0, found.kinks)
        ]
    return Said(*out)


def in_torch(G: Any, g: Any, mu: Any, law: str, weights: Any, on_host: bool) -> Said:
    import torch

    from surefoot.contact.batch import torch as sft

    given = [torch.tensor(v, requires_grad=True) for v in (G, g, mu)]
    found = sft.solve(*given, law=law, on_host=on_host)
    wanted = torch.tensor(weights)
    slopes = torch.autograd.grad(
        (wanted[0] * found.forces).sum() + (wanted[1] * found.velocities).sum(), given
    )
    out = (found.forces, found.velocities, *slopes, found.status == 0, found.kinks)
    return Said(*(v.detach().numpy() for v in out))


NEEDS = {"jax": "jax", "jax on the host": "jax", "torch on the host": "torch", "torch in its arrays": "torch"}
FORMS: dict[str, Callable[..., Said]] = {
    "compiled": compiled,
    "jax": in_jax,
    "jax on the host": lambda *a: in_jax(*a, method="solve_on_host"),
    "torch on the host": lambda *a: in_torch(*a, True),
    "torch in its arrays": lambda *a: in_torch(*a, False),
}


HOST = pytest.param("jax on the host", marks=pytest.mark.long)
LAWS = ["coulomb", pytest.param("convex", marks=pytest.mark.long)]


@pytest.fixture(params=[HOST if name == "jax on the host" else name for name in FORMS])
def form(request: pytest.FixtureRequest) -> Callable[..., Said]:
    needed = NEEDS.get(request.param)
    if needed is not None and find_spec(needed) is None:
        pytest.skip(f"{needed} is not installed (make test-extras)")
    return FORMS[request.param]


def weights_for(g: FloatArray) -> FloatArray:
    return np.random.default_rng(1).normal(size=(2, len(g), g.shape[1] // 3, 3))


@pytest.mark.parametrize("law", LAWS)
def test_the_forms_agree(form: Callable[..., Said], law: str, problems: Any) -> None:
    """Stick, slide and open contacts, some without friction: forces, velocities and gradients."""
    G, g, mu = (v[:16] for v in problems)
    mu = np.where(np.arange(64).reshape(16, 4) % 9 == 0, 0.0, mu)
    weights = weights_for(g)
    wanted, found = plain(G, g, mu, law, weights), form(G, g, mu, law, weights)
    assert wanted.solved.all()
    assert found.solved.all()
    assert not wanted.kinks.any()
    assert not found.kinks.any()
    for name in ("forces", "velocities", "G", "g", "mu"):
        own, other = getattr(found, name), getattr(wanted, name)
        np.testing.assert_allclose(own, other, atol=2e-7 * np.abs(other).max(), err_msg=name)


def test_redundant_contacts_have_the_same_least_gradient(form: Callable[..., Said], redundant: Any) -> None:
    """A rigid body that stands: forces are not unique, velocities are.

    So are the gradients by g where all forces are clear of their cones' boundaries, in both forms.
    """
    G, g, mu = redundant
    weights = weights_for(g)
    weights[0] = 0.0
    wanted, found = plain(G, g, mu + 1.0, "convex", weights), form(G, g, mu + 1.0, "convex", weights)
    assert (wanted.solved & found.solved).all()
    np.testing.assert_allclose(found.velocities, wanted.velocities, atol=1e-7)
    good = _clear(wanted.forces, mu + 1.0) & _clear(found.forces, mu + 1.0)
    assert good.any()
    np.testing.assert_allclose(found.g[good], wanted.g[good], atol=1e-5)


def _clear(forces: FloatArray, mu: FloatArray) -> FloatArray:
    """Return which problems (B,) have all forces (B, n, 3) well inside their cones."""
    inside = mu * forces[..., 2] - np.hypot(forces[..., 0], forces[..., 1])
    return np.asarray((inside > 1e-3 * np.abs(forces).max()).all(axis=1))


EDGES = {
    "on the edge of its cone": ([-0.5, 0.0, 1.0], [0.0, 0.0, 0.0]),
    "just touching": ([0.0, 0.0, 0.0], [0.2, 0.0, 0.0]),
    "neither force nor velocity": ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("edge", EDGES)
def test_a_kink_has_the_gradient_of_a_mode(form: Callable[..., Said], edge: str, law: str) -> None:
    """Beside it a contact that sticks; the gradient at the kink is one of those found a little off it."""
    force, velocity = (np.array([*v, 0.0, 0.0, s]) for v, s in zip(EDGES[edge], (1.0, 0.0), strict=True))
    if law == "convex":
        velocity[2] += 0.5 * np.hypot(*velocity[:2])
    G, mu = np.diag([1.0, 1.0, 1.0, 2.0, 2.0, 1.0])[None], np.array([[0.5, 0.5]])
    g = (velocity - G[0] @ force)[None]
    weights = weights_for(g)
    found = form(G, g, mu, law, weights)
    assert found.solved.all()
    assert found.kinks[0, 0]
    assert np.isfinite(found.g).all()
    around = np.random.default_rng(3).normal(size=(40, 6)) * 1e-5
    many = [np.repeat(v, 40, axis=0) for v in (G, g, mu)]
    near = plain(many[0], many[1] + around, many[2], law, np.repeat(weights, 40, axis=1))
    gaps = np.abs(near.g - found.g).max(axis=1)
    assert gaps.min() < 0.05 * max(np.abs(found.g).max(), 1.0)


def test_what_is_off_and_what_is_at_rest(form: Callable[..., Said]) -> None:
    """No free velocity, no load, no friction: zero forces and finite gradients in every form."""
    G, mu = np.tile(np.eye(6), (3, 1, 1)), np.array([[0.5, 0.5], [0.0, 0.0], [0.5, 0.0]])
    g = np.array([[0.0] * 6, [0.1, 0.0, 1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 0.3, 0.0, -1.0]])
    for law in ("coulomb", "convex"):
        found = form(G, g, mu, law, weights_for(g))
        assert found.solved.all()
        np.testing.assert_allclose(found.forces[:2], 0.0, atol=1e-9)
        np.testing.assert_allclose(found.forces[2, 1], [0.0, 0.0, 1.0], atol=1e-7)
        assert all(np.isfinite(v).all() for v in found[2:5])
