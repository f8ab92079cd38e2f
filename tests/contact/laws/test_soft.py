"""Soft laws against integrated motion, closed forms and their own derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from surefoot.base.errors import ProblemError
from surefoot.contact.laws.soft import (
    ExactFriction,
    Hertz,
    HuntCrossley,
    MujocoLaw,
    RegularisedFriction,
    SoftLaw,
    SpringDamper,
    behaviour,
    rebound,
)

LAWS: dict[str, SoftLaw] = {
    "spring": SpringDamper(2e4),
    "spring-damper": SpringDamper(1e4, 20.0),
    "overdamped": SpringDamper(1e4, 300.0, friction=RegularisedFriction(0.5, 1e-2)),
    "hunt-crossley": HuntCrossley(2e5, 0.5),
    "hunt-crossley-sphere": HuntCrossley(2e6, 0.5, 1.5, friction=RegularisedFriction(0.8, 1e-3)),
    "hertz": Hertz.sphere(0.02, 1e7),
    "hertz-damped": Hertz.sphere(0.02, 1e7, dissipation=0.7),
    "mujoco": MujocoLaw(mass=4.0),
    "mujoco-direct": MujocoLaw((-1000.0, -30.0), (0.3, 0.95, 0.002, 0.3, 3.0)),
    "mujoco-constant": MujocoLaw((0.01, 0.2), (0.3, 0.3)),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
def test_law_is_lawful(law: SoftLaw) -> None:
    """No pull, no force across a gap, friction within its cone, no energy made, true derivatives."""
    rng = np.random.default_rng(0)
    gaps, velocities = -1e-3 * rng.uniform(0.02, 2.0, 200), rng.normal(size=(200, 3))
    forces = law.force(gaps, velocities)
    assert (forces[:, 2] >= 0.0).all()
    assert not law.force(-gaps, velocities).any()
    assert (np.hypot(forces[:, 0], forces[:, 1]) <= law.friction.mu * forces[:, 2] * (1.0 + 1e-12)).all()
    assert ((forces[:, :2] * velocities[:, :2]).sum(axis=1) <= 1e-12 * forces[:, 2]).all()
    damping = forces[:, 2] - law.normal(gaps, 0.0)
    assert (damping * velocities[:, 2] <= 1e-12 * forces[:, 2]).all()
    far = (law.normal(gaps + 1e-8, velocities[:, 2] + 1e-5) > 0.0) | (
        forces[:, 2] == 0.0
    )  # from a pull's onset
    gaps, velocities, forces = gaps[far], velocities[far], forces[far]
    slopes = law.jacobian(gaps, velocities)
    by_gap = (law.force(gaps + 1e-9, velocities) - law.force(gaps - 1e-9, velocities)) / 2e-9
    np.testing.assert_allclose(slopes.gap, by_gap, rtol=1e-5, atol=1e-4 * np.abs(forces).max() / 1e-3)
    for axis, step in enumerate(1e-6 * np.eye(3)):
        by_axis = (law.force(gaps, velocities + step) - law.force(gaps, velocities - step)) / 2e-6
        np.testing.assert_allclose(
            slopes.velocity[..., axis], by_axis, rtol=1e-5, atol=1e-4 * np.abs(forces).max()
        )


@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.9, 1.0, 1.1, 4.0])
def test_restitution_of_spring_and_damper(ratio: float) -> None:
    """The mass is followed by the matrix exponential's own solution, through SciPy's Radau."""
    law = SpringDamper(1e4, 2.0 * ratio * 1e2)

    def gone(_: float, y: np.ndarray) -> float:
        return 1e4 * y[0] + law.damping * y[1] if _ > 1e-7 else 1.0

    gone.terminal, gone.direction = True, -1.0  # type: ignore[attr-defined]
    run = solve_ivp(
        lambda t, y: [y[1], -1e4 * y[0] - law.damping * y[1]],
        (0.0, 10.0), [0.0, 1.0], events=gone, rtol=1e-11, atol=1e-15, max_step=1e-3,
    )  # fmt: skip
    assert law.restitution(1.0) == pytest.approx(-run.y[1, -1], rel=1e-6)


@pytest.mark.parametrize("wanted", [1e-3, 0.2, 0.8, 1.0])
def test_bouncing_laws_bounce_as_asked(wanted: float) -> None:
    assert SpringDamper.bouncing(1e5, wanted, 3.0).restitution(3.0) == pytest.approx(wanted, rel=1e-9)
    law = HuntCrossley.bouncing(1e5, wanted, 2.0, exponent=1.5)
    assert law.restitution(2.0) == pytest.approx(wanted, rel=1e-9)
    if wanted > 0.1:  # the closed form leaves out the weight
        assert rebound(law, 1.0, 2.0, gravity=1e-6) == pytest.approx(wanted, rel=1e-4)


def test_hertz_is_hertz() -> None:
    """Depth (9 F² / (16 R E*²))^(1/3)."""
    radius, modulus, load = 0.03, 5e6, 60.0
    effective = modulus / (1.0 - 0.3**2)
    expected = (9.0 * load**2 / (16.0 * radius * effective**2)) ** (1.0 / 3.0)
    assert Hertz.sphere(radius, modulus, 0.3).rest_depth(load) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
def test_energy_is_the_integral_of_the_force(law: SoftLaw) -> None:
    for depth in (1e-5, 4e-4, 3e-3):
        marks = [m for m in (3e-4, 5e-4, 6e-4, 1e-3, 2e-3) if m < depth]
        work = quad(
            lambda x: float(law.normal(-x, 0.0)), 0.0, depth, points=marks or None, epsrel=1e-12, epsabs=1e-18
        )[0]
        assert float(law.energy(-depth)) == pytest.approx(work, rel=1e-9)


def test_friction_at_rest() -> None:
    law = SpringDamper(1e4, friction=0.7)
    assert np.array_equal(law.force(-1e-3, [0.0, 0.0, 0.0]), [0.0, 0.0, 10.0])
    with pytest.raises(ProblemError, match="no derivative at zero sliding"):
        law.jacobian(-1e-3, [0.0, 0.0, 0.0])
    assert np.isfinite(law.jacobian(1e-3, [0.0, 0.0, 0.0]).velocity).all()  # in the air it has one
    smooth = SpringDamper(1e4, friction=RegularisedFriction(0.7, 1e-3))
    assert smooth.jacobian(-1e-3, [0.0, 0.0, 0.0]).velocity[0, 0] == pytest.approx(-0.7 * 10.0 / 1e-3)
    creep = RegularisedFriction(0.7, 1e-3).creep(0.6)
    assert -smooth.force(-1e-3, [creep, 0.0, 0.0])[0] == pytest.approx(0.6 * 0.7 * 10.0)


def test_settling_and_frequency() -> None:
    law = SpringDamper(1e4, 20.0)
    found = behaviour(law, 1.0)
    assert (found.frequency, found.ratio) == (pytest.approx(100.0), pytest.approx(0.1))
    assert found.settling_time == pytest.approx(-math.log(0.02) / 10.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: SpringDamper(0.0), "stiffness"),
        (lambda: SpringDamper(1e4, -1.0), "damping"),
        (lambda: HuntCrossley(1e4, math.nan), "dissipation"),
        (lambda: HuntCrossley(1e4, 0.1, 0.5), "exponent"),
        (lambda: Hertz(1e4, 0.1, 2.0), "1.5"),
        (lambda: MujocoLaw((0.02, -1.0)), "solref"),
        (lambda: MujocoLaw(solimp=()), "solimp"),
        (lambda: ExactFriction(-0.1), "mu"),
        (lambda: RegularisedFriction(0.5, 0.0), "slip_speed"),
        (lambda: SpringDamper.bouncing(1e4, 0.0, 1.0), "restitution"),
        (lambda: SpringDamper(1e4).force(0.0, [1.0, 2.0]), "velocity"),
        (lambda: SpringDamper(1e4).force(math.nan, [0.0, 0.0, 0.0]), "gap"),
        (lambda: SpringDamper(1e4).rest_depth(0.0), "load"),
    ],
)
def test_wrong_input_is_named(make, words: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ProblemError, match=words):
        make()
