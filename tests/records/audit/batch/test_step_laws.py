"""Costs of single steps against closed forms, and verdicts of a loop against those of its arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from benchmarks.batch_audit import CHANNELS
from surefoot.records.audit.batch.step_cost import step_cost

from .environments import ROWS, soft_facts, spoil_one, windows

DT = 0.002


def test_costs_are_shares_of_the_weight() -> None:
    """One foot each: a pull, friction of 0.9 at mu 0.6, a force in the air, friction along the slip."""
    forces = np.array(
        [[[0, 0, -20.0]], [[90, 0, 100.0]], [[0, 30, 40.0]], [[30, 40, 100.0]], [[0, 0, 100.0]]]
    )
    gaps = np.array([[0.0], [0.0], [0.01], [0.0], [0.0]])
    velocities = np.zeros((5, 1, 3))
    velocities[3, 0] = [0.3, 0.4, 0.0]
    cost = step_cost(forces, gaps, velocities, np.full((5, 1), 0.6), np.full(5, 100.0))
    np.testing.assert_allclose(cost.pull, [0.2, 0, 0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(cost.friction, [0, 0.3, 0.06, 0, 0], atol=1e-15)
    np.testing.assert_allclose(cost.distance, [0, 0, 0.5, 0, 0], atol=1e-15)
    np.testing.assert_allclose(cost.work, [0, 0, 0, 0.5, 0], atol=1e-15)
    np.testing.assert_allclose(cost.total, [0.2, 0.3, 0.56, 0.5, 0], atol=1e-15)


def test_jax_gives_numpys_costs_and_jits() -> None:
    """The same lines, to rounding; gradients are finite where a foot does not move."""
    jax = pytest.importorskip("jax")
    arrays, masses, mu = windows(16, 21)
    rng = np.random.default_rng(22)
    for k in range(16):
        spoil_one(arrays, k, rng)
    f, gaps, v = (np.nan_to_num(np.clip(arrays[name][120], -1e6, 1e6)) for name in CHANNELS)
    weight = 9.81 * masses
    with jax.enable_x64(True):
        expected = step_cost(f, gaps, v, mu[:, None], weight)
        found = jax.jit(step_cost)(*map(jax.numpy.asarray, (f, gaps, v)), mu[:, None], weight)
        for one, two in zip(found, expected, strict=True):
            np.testing.assert_allclose(np.asarray(one), two, rtol=1e-12, atol=1e-12)
        slope = jax.grad(lambda u: step_cost(f, gaps, u, 0.5, weight).total.sum())(jax.numpy.zeros_like(v))
        assert bool(jax.numpy.isfinite(slope).all())


@pytest.mark.filterwarnings("ignore:.*torch.jit.*:DeprecationWarning")  # torch's own, of its compiler
@pytest.mark.parametrize("backend", ["", "aot_eager"])
def test_torch_gives_numpys_costs(backend: str) -> None:
    """The same lines, to rounding, in a reward's own precision, compiled or not."""
    torch = pytest.importorskip("torch")
    arrays, masses, mu = windows(8, 23)
    given = [*(arrays[name][100] for name in CHANNELS), mu[:, None], 9.81 * masses]
    f, gaps, v, friction, weight = given
    expected = step_cost(f, gaps, v, friction, weight)
    f, gaps, v, friction, weight = map(torch.as_tensor, given)
    form = torch.compile(step_cost, backend=backend) if backend else step_cost
    found = form(f, gaps, v, friction, weight)
    for one, two in zip(found, expected, strict=True):
        np.testing.assert_allclose(one.numpy(), two, rtol=1e-12, atol=1e-12)


def _loop(laws: sf.StepLaws, arrays: dict[str, Any], done: Any = None) -> None:
    for t in range(len(arrays["forces"])):
        laws(arrays["forces"][t], arrays["gaps"][t], arrays["contact_velocities"][t])
        if done is not None:
            laws.reset(done[t])


def test_a_loop_is_judged_as_its_arrays() -> None:
    """Kept as one stretch: the figures of `audit_batch`; episodes end where `reset` says so."""
    arrays, masses, mu = windows(10, 24)
    rng = np.random.default_rng(25)
    for k in range(10):
        spoil_one(arrays, k, rng)
    done = np.zeros((ROWS, 10), dtype=bool)
    done[90, 3] = done[150] = True
    laws = sf.StepLaws(4, mu, masses, DT, facts=soft_facts(), rows=ROWS)
    _loop(laws, arrays, done)
    found = laws.report()
    expected = sf.audit_batch(arrays, DT, mu, mass=masses, done=done, facts=soft_facts())
    assert found.verdicts == expected.verdicts
    for name, law in expected.laws.items():
        np.testing.assert_array_equal(found[name].share, law.share)
    worst = int(found.worst()[0])
    assert len(found.log(worst)) == ROWS
    assert found.audit(worst).verdict == "broken"


def test_stretches_find_what_the_whole_shows() -> None:
    """In stretches of 60 steps: no alarm that the whole does not give, and the single rows' laws in full."""
    arrays, masses, mu = windows(30, 26)
    rng = np.random.default_rng(27)
    kinds = [spoil_one(arrays, k, rng) for k in range(30)]
    laws = sf.StepLaws(["FL", "FR", "RL", "RR"], mu, masses, DT, facts=soft_facts(), rows=60)
    _loop(laws, arrays)
    found = laws.report()
    expected = sf.audit_batch(arrays, DT, mu, mass=masses, facts=soft_facts())
    assert found.rows == ROWS
    for name in ("pull", "friction", "penetration"):
        np.testing.assert_allclose(found[name].share, expected[name].share, atol=1e-12)
        seen = expected[name].share > 0.0
        np.testing.assert_allclose(found[name].instant[seen], expected[name].instant[seen], atol=1e-9)
    for k, kind in enumerate(kinds):
        if expected.verdicts[k] == "lawful":
            assert found.verdicts[k] == "lawful", kind
    assert laws.report().verdicts == found.verdicts


def test_rows_of_zero_keep_nothing() -> None:
    """Costs alone."""
    laws = sf.StepLaws(4, 0.6, 12.0, 0.02, rows=0)
    assert laws(np.zeros((2, 4, 3))).total.tolist() == [0.0, 0.0]
    laws.reset(np.ones(2, dtype=bool))
    with pytest.raises(sf.SurefootError, match="no step was kept"):
        laws.report()


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: sf.StepLaws(0, 0.6, 12.0, 0.02), "feet"),
        (lambda: sf.StepLaws(4, -0.1, 12.0, 0.02), "mu must be >= 0"),
        (lambda: sf.StepLaws(4, 0.6, 0.0, 0.02), "mass must be positive"),
        (lambda: sf.StepLaws(4, 0.6, 12.0, 0.0), "dt"),
        (lambda: sf.StepLaws(4, 0.6, 12.0, 0.02)(np.zeros((2, 3, 3))), r"forces must have shape \(N, 4, 3\)"),
        (lambda: sf.StepLaws(4, 0.6, 12.0, 0.02)(np.zeros((2, 4, 3)), np.zeros((2, 3))), "gaps must have"),
        (lambda: sf.StepLaws(4, 0.6, [1.0] * 3, 0.02)(np.zeros((2, 4, 3))), "that of 3 environments"),
        (lambda: sf.StepLaws(4, 0.6, 12.0, 0.02)([1, 2]), "forces must have shape"),
    ],
)
def test_what_does_not_fit_is_one_line(call: Any, told: str) -> None:
    """Each names the value, and what was expected."""
    with pytest.raises(sf.SurefootError, match=told):
        call()


def test_steps_must_have_the_same_arrays() -> None:
    """A step with gaps after one without is one line."""
    laws = sf.StepLaws(4, 0.6, 12.0, 0.02)
    laws(np.zeros((2, 4, 3)))
    with pytest.raises(sf.SurefootError, match="steps so far had forces"):
        laws(np.zeros((2, 4, 3)), np.zeros((2, 4)))
    with pytest.raises(sf.SurefootError, match="done must have shape"):
        laws.reset(np.ones(3))
