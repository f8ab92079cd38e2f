"""Terms of rewards against closed forms, SciPy's hulls and differences; JAX and Torch give NumPy's."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

import surefoot as sf

RNG = np.random.default_rng(61)
N, FEET, WEIGHT = 40, 4, 150.0
FORCES = RNG.normal(size=(N, FEET, 3)) * [20.0, 20.0, 40.0] + [0.0, 0.0, 30.0]
GAPS = RNG.uniform(-0.01, 0.05, size=(N, FEET))
VELOCITIES = RNG.normal(size=(N, FEET, 3))
PLACES, COM = RNG.normal(size=(N, FEET, 3)), 0.3 * RNG.normal(size=(N, 3))
TERMS: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
    "slip_under_load": (sf.rl.terms.slip_under_load, (FORCES, VELOCITIES)),
    "cone_use": (lambda f, v, w: sf.rl.terms.cone_use(f, 0.6, w), (FORCES, VELOCITIES)),
    "foot_impact": (lambda g, v, w: sf.rl.terms.foot_impact(g, v), (GAPS, VELOCITIES)),
    "unlawful_force": (
        lambda f, g, v, w: sf.rl.terms.unlawful_force(f, g, v, 0.6, w), (FORCES, GAPS, VELOCITIES)
    ),
    "step_certificate": (
        lambda g, v, p, c, a, w: sf.rl.terms.step_certificate(p, g, v, c, a, 0.6, 0.02),
        (GAPS, VELOCITIES, PLACES, COM + np.array([0.0, 0.0, 3.0]), 4.0 * COM),
    ),
    "support_margin": (
        lambda f, p, c, w: sf.rl.terms.support_margin(p, f, c, w), (FORCES, PLACES, COM)
    ),
}  # fmt: skip


def _distance_outside(points: Any, c: Any) -> float:
    """Return the distance of a point from a hull by a linear program over many directions, 0 inside."""
    weights = linprog(np.zeros(len(points)), A_eq=np.vstack([points.T, np.ones(len(points))]), b_eq=[*c, 1.0])
    if weights.status == 0:
        return 0.0
    ends = [(p, q) for p in points for q in points]
    best = np.inf
    for p, q in ends:
        along = q - p
        share = np.clip((c - p) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
        best = min(best, float(np.linalg.norm(p + share * along - c)))
    return best


def test_the_margin_is_that_of_scipys_hull() -> None:
    """Inside the least distance to a facet, outside minus the distance to the hull."""
    found = sf.rl.terms.support_margin(PLACES, FORCES, COM, WEIGHT)
    signs = set()
    for k in range(N):
        loaded = FORCES[k, :, 2] > sf.rl.terms.LOADED * WEIGHT
        points, c = PLACES[k, loaded, :2], COM[k, :2]
        if not len(points):
            assert found[k] == -np.inf
            continue
        away = _distance_outside(points, c)
        if len(points) >= 3 and away == 0.0:
            hull = ConvexHull(points).equations
            assert found[k] == pytest.approx(-(hull[:, :2] @ c + hull[:, 2]).max(), abs=1e-12)
        else:
            assert found[k] == pytest.approx(-away, abs=1e-12)
        signs.add(bool(found[k] > 0.0))
    assert signs == {True, False}


@given(st.integers(0, 2**32 - 1))
def test_turning_and_moving_everything_changes_no_margin(seed: int) -> None:
    """The term knows no axes."""
    rng = np.random.default_rng(seed)
    angle, shift = rng.uniform(0.0, 6.28), rng.normal(size=2)
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = sf.rl.terms.support_margin(
        PLACES[..., :2] @ R.T + shift, FORCES, COM[:, :2] @ R.T + shift, WEIGHT
    )
    np.testing.assert_allclose(moved, sf.rl.terms.support_margin(PLACES, FORCES, COM, WEIGHT), atol=1e-9)


def test_corners_lines_and_single_feet_are_borders() -> None:
    """Upon a corner, on the line of two feet, on the only foot: zero; beside them minus the distance."""
    feet = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [5.0, 5.0]]] * 5)
    load = np.zeros((5, 4, 3))
    load[..., 2] = [[50, 50, 50, 0], [50, 50, 0, 0], [50, 0, 0, 0], [50, 0, 0, 0], [50, 50, 0, 0]]
    com = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.0], [0.3, 0.4], [0.5, 0.2]])
    found = sf.rl.terms.support_margin(feet, load, com, WEIGHT)
    np.testing.assert_allclose(found, [0.0, 0.0, 0.0, -0.5, -0.2], atol=1e-15)


def test_a_negative_certificate_is_an_infeasible_program() -> None:
    """Of forces in pyramids around the cones, moments about the centre of mass zero: none; else there are."""
    rng, signs = np.random.default_rng(7), set()
    angles = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
    for _ in range(60):
        feet = np.append(rng.uniform(-0.3, 0.3, (4, 2)), np.zeros((4, 1)), axis=1)
        gaps, com = rng.choice([0.0, 0.1], 4, p=[0.7, 0.3]), np.array([*rng.uniform(-0.1, 0.1, 2), 0.4])
        a, mu = rng.uniform(-4.0, 4.0, 3), rng.uniform(0.3, 1.0)
        found = sf.rl.terms.step_certificate(
            feet[None], gaps[None], np.zeros((1, 4, 3)), com[None], a[None], mu, 0.02
        )[0]
        on = feet[gaps == 0.0]
        if not len(on) or abs(found) < 0.01:
            continue
        outer = mu / np.cos(np.pi / 24.0)
        rays = np.stack([outer * np.cos(angles), outer * np.sin(angles), np.ones(24)], axis=1)
        columns = [np.concatenate([ray, np.cross(foot - com, ray)]) for foot in on for ray in rays]
        # moments about the vertical are the feet's own matter: the certificate leaves them open
        rows = [0, 1, 2, 3, 4]
        wanted = np.concatenate([a / 9.81 + [0.0, 0.0, 1.0], np.zeros(3)])
        program = linprog(np.zeros(len(columns)), A_eq=np.array(columns).T[rows], b_eq=wanted[rows])
        assert (program.status == 0) == (found > 0.0), (found, program.status)
        signs.add(bool(found > 0.0))
    assert signs == {True, False}


def test_half_the_load_is_half_of_the_slip() -> None:
    """No threshold is there to stay below."""
    one = sf.rl.terms.slip_under_load(np.maximum(FORCES, 0.0), VELOCITIES, WEIGHT)
    half = sf.rl.terms.slip_under_load(0.5 * np.maximum(FORCES, 0.0), VELOCITIES, WEIGHT)
    np.testing.assert_allclose(half, 0.5 * one)


@pytest.mark.parametrize("name", TERMS)
@pytest.mark.sampled(1)
def test_jax_gives_numpys_numbers_and_finite_slopes(name: str) -> None:
    """Jitted, to rounding; slopes are those of differences, and finite where everything rests."""
    jax = pytest.importorskip("jax")
    term, arrays = TERMS[name]
    weight = np.full(N, WEIGHT)
    with jax.enable_x64(True):
        expected = term(*arrays, weight)
        found = jax.jit(term)(*map(jax.numpy.asarray, arrays), jax.numpy.asarray(weight))
        np.testing.assert_allclose(np.asarray(found), expected, rtol=1e-12, atol=1e-12)
        finite = np.isfinite(expected)
        slope = np.asarray(jax.grad(lambda x: term(*arrays[:-1], x, weight)[finite].sum())(arrays[-1]))
        turn = RNG.normal(size=arrays[-1].shape)
        ends = [term(*arrays[:-1], arrays[-1] + h * turn, weight)[finite].sum() for h in (1e-7, -1e-7)]
        assert (slope * turn).sum() == pytest.approx((ends[0] - ends[1]) / 2e-7, rel=1e-4, abs=1e-5)
        rest = [jax.numpy.zeros_like(array) for array in arrays]
        still = jax.grad(lambda x: jax.numpy.nan_to_num(term(*rest[:-1], x, weight)).sum())(rest[-1])
        assert bool(jax.numpy.isfinite(still).all())


@pytest.mark.parametrize("wrapper", ["AuditWrapper", "RecordWrapper"])
def test_without_gymnasium_a_wrapper_is_one_line(wrapper: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It names the extra; terms are there all the same."""
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(
        sf.SurefootError, match=r"gymnasium is not installed; run: pip install -e '\.\[gym\]'"
    ):
        getattr(sf.rl, wrapper)(None)
    with pytest.raises(AttributeError, match="Wrapper"):
        sf.rl.Wrapper  # noqa: B018
    assert sf.rl.terms is not None


@pytest.mark.parametrize(("name", "arguments"), [("contact_arrays", 5), ("log_rollouts", 2)])
def test_without_mujoco_what_reads_its_states_is_one_line(
    name: str, arguments: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(sf.SurefootError, match=r"mujoco is not installed; run: pip install -e '\.\[sim\]'"):
        getattr(sf.rl, name)(*[None] * arguments)


@pytest.mark.filterwarnings("ignore:.*torch.jit.*:DeprecationWarning")  # torch's own, of its compiler
@pytest.mark.parametrize("name", TERMS)
def test_torch_gives_numpys_numbers(name: str) -> None:
    """Eager and compiled, to rounding; by inductor where a compiler is."""
    torch = pytest.importorskip("torch")
    term, arrays = TERMS[name]
    given_ = [*map(torch.as_tensor, arrays), torch.full((N,), WEIGHT, dtype=torch.float64)]
    expected = term(*arrays, np.full(N, WEIGHT))
    backend = "inductor" if shutil.which("g++") else "aot_eager"
    for form in (term, torch.compile(term, backend=backend)):
        np.testing.assert_allclose(form(*given_).numpy(), expected, rtol=1e-12, atol=1e-12)
