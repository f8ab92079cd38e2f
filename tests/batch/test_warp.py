"""The problem in Warp, on its CPU device: the source that runs on CUDA."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.batch.answers import STATUSES
from surefoot.contact import Status
from surefoot.errors import ProblemError

wp = pytest.importorskip("warp", reason="Warp is not installed (extra warp; make test-extras)")
wp.config.quiet = True
sfw = pytest.importorskip("surefoot.batch.warp")


def _arrays(problems: Any, count: int | None = None, real: Any = wp.float64, grad: bool = False) -> list[Any]:
    return [wp.array(v[:count], dtype=real, device="cpu", requires_grad=grad) for v in problems]


def test_agrees_with_solve(problems: Any, solved: Any) -> None:
    law, reference = solved
    found = sfw.solve(*_arrays(problems), law=law)
    assert (found.status.numpy() == 0).all()
    for name in ("forces", "velocities"):
        wanted = np.array([getattr(s, name) for s in reference])
        assert np.abs(getattr(found, name).numpy() - wanted).max() <= 1e-7 * np.abs(wanted).max()
    assert (np.bincount(found.modes.numpy().ravel(), minlength=4)[1:] > 5).all()
    for k, (G, g, mu) in enumerate(zip(*problems, strict=True)):
        numbers = sf.residuals(sf.ContactProblem(G, g, mu, law=law), found.forces.numpy()[k])
        assert found.residual.numpy()[k] == pytest.approx(numbers.velocity_error, abs=1e-12)


def test_gradients_are_those_of_differences(problems: Any, solved: Any) -> None:
    law, _ = solved
    few = [v[:10] for v in problems]
    rng = np.random.default_rng(2)
    wf, wu = rng.normal(size=(2, 10, 4, 3))
    given = _arrays(few)
    slopes = sfw.vjp(
        *given, sfw.solve(*given, law=law), law=law,
        forces=wp.array(wf, dtype=wp.float64, device="cpu"),
        velocities=wp.array(wu, dtype=wp.float64, device="cpu"),
    )  # fmt: skip

    def number(*problem: Any) -> Any:
        found = sfw.solve(*_arrays(problem), law=law)
        return (wf * found.forces.numpy()).sum((1, 2)) + (wu * found.velocities.numpy()).sum((1, 2))

    for place in range(3):
        step = rng.normal(size=few[place].shape) * np.abs(few[place]).max()
        if place == 0:
            step = step + step.swapaxes(1, 2)
        up, down = list(few), list(few)
        up[place], down[place] = few[place] + 1e-7 * step, few[place] - 1e-7 * step
        difference = (number(*up) - number(*down)) / 2e-7
        slope = (slopes[place].numpy() * step).reshape(10, -1).sum(1)
        np.testing.assert_allclose(slope, difference, rtol=1e-5, atol=1e-5 * np.abs(slope).max())


def test_tape(problems: Any) -> None:
    given = _arrays(problems, 5, grad=True)
    with wp.Tape() as tape:
        found = sfw.solve(*given, tape=tape)
    weights = wp.array(np.ones((5, 4, 3)), dtype=wp.float64, device="cpu")
    tape.backward(grads={found.forces: weights})
    direct = sfw.vjp(*given, found, forces=weights)
    for array, slope in zip(given, direct, strict=True):
        assert np.abs(slope.numpy()).max() > 0.0
        np.testing.assert_allclose(array.grad.numpy(), slope.numpy(), atol=1e-14)


def test_redundant_contacts_agree_with_the_batched_pseudo_inverse(redundant: Any) -> None:
    from surefoot.batch.host import answer_gradients

    rng = np.random.default_rng(5)
    weights = rng.normal(size=(2, 10, 4, 3))
    given = _arrays(redundant)
    found = sfw.solve(*given)
    assert (found.status.numpy() == 0).all()
    own = sfw.vjp(*given, found, forces=wp.array(weights[0], dtype=wp.float64, device="cpu"),
                  velocities=wp.array(weights[1], dtype=wp.float64, device="cpu"))  # fmt: skip
    point = found.forces.numpy(), found.velocities.numpy()
    on = np.ones((10, 4), dtype=bool)
    other = answer_gradients(*redundant, on, False, point, (weights[0], weights[1]))
    for a, b in zip(own, other, strict=True):
        np.testing.assert_allclose(a.numpy(), b, rtol=1e-6, atol=1e-7 * np.abs(b).max())


def test_never_nan(hard: Any) -> None:
    ones = wp.array(np.ones((1, 4, 3)), dtype=wp.float64, device="cpu")
    for name, problem in hard:
        given = _arrays(problem)
        for law in ("coulomb", "convex"):
            found = sfw.solve(*given, law=law)
            slopes = sfw.vjp(*given, found, forces=ones, velocities=ones, law=law)
            numbers = (found.forces, found.velocities, *slopes)
            assert all(np.isfinite(v.numpy()).all() for v in numbers), name
            bad = name in ("nan in g", "infinite G", "negative mu")
            assert (STATUSES[int(found.status.numpy()[0])] is Status.INVALID) == bad, name
            if name == "G is zero":
                assert STATUSES[int(found.status.numpy()[0])] is not Status.SOLVED


def test_masks_and_single_precision(problems: Any) -> None:
    mask = wp.array(np.tile([True, True, False, True], (40, 1)), dtype=wp.bool, device="cpu")
    found = sfw.solve(*_arrays(problems, real=wp.float32), mask=mask, tol=1e-6)
    assert found.forces.dtype is wp.float32
    assert (found.status.numpy() == 0).all()
    assert (found.forces.numpy()[:, 2] == 0.0).all()
    assert (found.modes.numpy()[:, 2] == 0).all()
    keep = np.repeat([True, True, False, True], 3)
    for k in range(40):
        problem = sf.ContactProblem(
            problems.G[k][np.ix_(keep, keep)], problems.g[k][keep], problems.mu[k][[0, 1, 3]]
        )
        wanted = sf.solve(problem).velocities
        assert (
            np.abs(found.velocities.numpy()[k][[0, 1, 3]] - wanted).max()
            <= 1e-5 * np.abs(problems.g[k]).max()
        )


def test_wrong_input_is_named(problems: Any) -> None:
    G, g, mu = _arrays(problems, 2)
    with pytest.raises(ProblemError, match="G must be a Warp array, got ndarray"):
        sfw.solve(problems.G, g, mu)
    with pytest.raises(ProblemError, match="g must be float32 or float64, as G, got float32"):
        sfw.solve(G, _arrays(problems, 2, wp.float32)[1], mu)
    with pytest.raises(ProblemError, match="G must have shape"):
        sfw.solve(_arrays(problems, 1)[0], g, mu)
    many = [wp.zeros(s, wp.float64, device="cpu") for s in ((1, 27, 27), (1, 27), (1, 9))]
    with pytest.raises(ProblemError, match="at most 8 contacts, got 9"):
        sfw.solve(*many)
