"""Translations against the engines' published formulas, against themselves there and back, and bad input."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.contact.laws.soft import Hertz, HuntCrossley, MujocoLaw, SpringDamper
from surefoot.contact.translation import (
    ENGINES,
    EngineContact,
    combination_rules,
    combine_friction,
    translate,
)
from surefoot.contact.translation.translation import read_contact

LINEAR = ("physical", "drake", "physx", "isaaclab", "bullet")


@pytest.mark.parametrize(("first", "second"), list(itertools.product(LINEAR, LINEAR)))
def test_linear_engines_there_and_back(first: str, second: str) -> None:
    law = SpringDamper(2e4, 40.0)
    there = translate(law, first, 4.0)
    back = translate(translate(there.contact, second, 4.0).contact, "physical", 4.0)
    assert back.parameters["stiffness"] == pytest.approx(2e4, rel=1e-12)
    assert back.parameters["damping"] == pytest.approx(40.0, rel=1e-12)
    assert all(q.agrees for q in there.agreement.values())


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "law", [SpringDamper(2e4, 40.0), Hertz.sphere(0.02, 1e7, dissipation=0.3), MujocoLaw(mass=4.0)],
    ids=["linear", "hertz", "mujoco"],
)  # fmt: skip
def test_what_disagrees_is_said(engine: str, law: SpringDamper) -> None:
    found = translate(law, engine, 4.0)
    for name, quantity in found.agreement.items():
        said = any(line.startswith(name.replace("_", " ") + ":") for line in found.lost)
        assert said or quantity.agrees
        if quantity.agrees and quantity.given:
            assert quantity.translated == pytest.approx(quantity.given, rel=0.011)


def test_drakes_relaxation_time() -> None:
    drake = translate(SpringDamper(5e3, 15.0), "drake", 2.0).contact.words
    assert drake == {"point_stiffness": pytest.approx(5e3), "relaxation_time": pytest.approx(2e-3)}


@pytest.mark.parametrize("keep", ["motion", "rest"])
def test_mujocos_two_stiffnesses(keep: str) -> None:
    """Default parameters rest as if ten times stiffer than they move: d of the weight is free."""
    found = translate(EngineContact("mujoco", {}), "physical", 4.0, keep=keep)
    agreed = {name for name, q in found.agreement.items() if q.agrees}
    assert ("rest_depth" in agreed) == (keep == "rest")
    assert ("frequency" in agreed) == (keep == "motion")
    assert found.given.rest_depth == pytest.approx(0.367182e-3, rel=1e-5)


def test_mujoco_large_impedance_keeps_motion() -> None:
    found = translate(SpringDamper(2e4, 40.0), "mujoco", 4.0, impedance=0.9)
    assert found.agreement["frequency"].agrees
    assert found.agreement["settling_time"].agrees
    assert found.translated.rest_depth == pytest.approx(0.1 * found.given.rest_depth)
    assert any("rest depth" in line for line in found.lost)


def test_refsafe_is_counted() -> None:
    stiff, safe = (MujocoLaw((0.002, 1.0), mass=1.0, dt=dt) for dt in (0.0, 0.005))
    assert safe.stiffness_and_damping == MujocoLaw((0.01, 1.0), mass=1.0).stiffness_and_damping
    assert stiff.stiffness_and_damping != safe.stiffness_and_damping


def test_sap_softens_what_its_step_cannot_resolve() -> None:
    found = translate(SpringDamper(1e9, 0.0), "drake", 1.0, dt=1e-3)
    assert found.translated.rest_depth > 10.0 * found.given.rest_depth
    assert any(line.startswith("rest depth") for line in found.lost)


@pytest.mark.parametrize("engine", ["drake", "physx", "bullet"])
def test_implicit_steps_bounce_as_the_law_does(engine: str) -> None:
    """Against the step itself, v' = v - dt/m (k (x + dt v') + d v'): it adds k dt of damping."""
    mass, dt, law = 4.0, 1e-4, SpringDamper(2e4, 40.0)
    found = translate(law, engine, mass, dt=dt)
    words = found.parameters
    a, b = (float(v) for v in list(words.values())[:2])
    k, d = (a, a * b) if engine == "drake" else (a, b)
    x, v = 0.0, 1.0
    while True:
        push = v - dt / mass * (k * x - mass * 9.81)
        after = push / (1.0 + dt / mass * (d + k * dt))
        if k * (x + dt * after) + d * after <= 0.0:
            break
        x, v = x + dt * after, after
    # it has left when the overlap is gone, a little after the force
    assert np.sqrt(v * v - 2.0 * 9.81 * x) == pytest.approx(found.given.restitution, abs=2e-3)
    assert d == pytest.approx(38.0)


def test_a_proof_that_fails_is_no_agreement() -> None:
    quantity = translate(SpringDamper(2e4, 40.0), "drake", 4.0).agreement["restitution"]
    assert quantity.proven(None)
    assert quantity.proven(1.005 * quantity.given)
    assert not quantity.proven(0.604)  # what Drake did at 1 ms with the damping as given


def test_bullet_puts_two_bodies_in_series() -> None:
    words = translate(SpringDamper(2e4, 40.0), "bullet", 4.0).parameters
    each = words["each_body"]
    assert 1.0 / (2.0 / each["contactStiffness"]) == pytest.approx(words["contactStiffness"])
    assert 2.0 * each["contactDamping"] == pytest.approx(words["contactDamping"])


def test_friction_rules() -> None:
    assert set(combination_rules()) >= {"mujoco", "drake", "physx", "bullet", "ode"}
    assert combine_friction("drake", 0.5, 1.0) == pytest.approx(2.0 / 3.0)
    assert combine_friction("drake", 0.0, 0.0) == 0.0
    assert combine_friction("mujoco", 0.2, 0.9) == 0.9
    assert combine_friction("physx-min", 0.2, 0.9) == 0.2
    assert combine_friction("bullet", 5.0, 9.0) == 10.0
    with pytest.raises(ProblemError, match="valid names: bullet, drake"):
        combine_friction("havok", 0.5, 0.5)


@pytest.mark.parametrize(
    ("source", "values", "words"),
    [
        ("nobody", {}, "valid names: bullet"),
        ("physical", {"stiffness": 1.0}, "needs damping"),
        ("physical", {"stiffness": 1.0, "dumping": 2.0}, "valid names: damping, stiffness"),
        ("mujoco", {"solref": 1.0}, "solref"),
        ("hertz", {"radius": 0.02}, "needs modulus"),
        ("physical", {"stiffness": -1.0, "damping": 0.0}, "stiffness"),
        ("physical", {"stiffness": np.nan, "damping": 0.0}, "stiffness"),
    ],
)
def test_unreadable_contacts(source: str, values: dict[str, float], words: str) -> None:
    with pytest.raises(ProblemError, match=words):
        read_contact(source, values, mass=1.0, speed=1.0)


@pytest.mark.parametrize(
    "options",
    [
        {"to": "havok"},
        {"mass": 0.0},
        {"mass": np.nan},
        {"keep": "all"},
        {"impedance": 1.0},
        {"dt": -1.0},
        {"speed": 0.0},
    ],
)
def test_wrong_questions(options: dict[str, object]) -> None:
    asked = {"to": "mujoco", "mass": 1.0} | options
    with pytest.raises(ProblemError):
        translate(SpringDamper(1e4, 1.0), **asked)  # type: ignore[arg-type]


def test_restitution_instead_of_damping() -> None:
    law = read_contact("physical", {"stiffness": 1e4, "restitution": 0.5}, mass=2.0, speed=1.0)
    assert isinstance(law, SpringDamper)
    assert law.restitution(2.0) == pytest.approx(0.5)
    law = read_contact("hunt-crossley", {"stiffness": 1e4, "restitution": 0.5}, mass=2.0, speed=3.0)
    assert isinstance(law, HuntCrossley)
    assert law.restitution(3.0) == pytest.approx(0.5)
