"""Translations run in the engines that are here: what was promised is what the engine does."""

from __future__ import annotations

import pytest

from surefoot.base.errors import ProblemError
from surefoot.contact.laws.soft import Hertz, HuntCrossley, MujocoLaw, SoftLaw, SpringDamper, behaviour
from surefoot.contact.translation import EngineContact, translate
from surefoot.worlds.drake import drake_python
from surefoot.worlds.experiments.drops import measure
from tests.mechanics.dynamics.test_soft_world import ImplicitStep

LAWS = {
    "bouncy": (SpringDamper(2e4, 40.0), 4.0),
    "damped": (SpringDamper(5e3, 300.0), 2.0),
    "hertz": (Hertz.sphere(0.02, 1e6, dissipation=0.3), 1.0),
    "stiff": (SpringDamper(3e5, 500.0), 10.0),
}


@pytest.mark.parametrize(("law", "mass"), LAWS.values(), ids=LAWS)
@pytest.mark.long
def test_mujoco_does_what_the_translation_says(law: SoftLaw, mass: float) -> None:
    pytest.importorskip("mujoco")
    dt = 2e-5
    found = translate(law, "mujoco", mass, dt=dt)
    got = measure("mujoco", found.parameters, found.translated, mass, dt=dt)
    assert got.rest_depth == pytest.approx(found.translated.rest_depth, rel=1e-6)
    assert got.restitution == pytest.approx(found.translated.restitution, rel=0.01, abs=1e-3)
    assert got.frequency == pytest.approx(found.translated.frequency, rel=0.01)
    assert got.settling_time == pytest.approx(found.translated.settling_time, rel=0.01)


@pytest.mark.parametrize(
    "words",
    [
        {},
        {"solref": (0.02, 0.4)},
        {"solref": (-3000.0, -20.0), "solimp": (0.3, 0.95, 0.003, 0.3, 3.0)},
        {"solref": (0.004, 1.0), "solimp": (0.97, 0.99)},
    ],
    ids=["default", "bouncy", "direct", "stiff"],
)
@pytest.mark.sampled(1)
def test_the_law_is_mujocos_own(words: dict[str, tuple[float, ...]]) -> None:
    pytest.importorskip("mujoco")
    found = translate(EngineContact("mujoco", words), "mujoco", 3.0, dt=2e-5)
    assert isinstance(found.law, MujocoLaw)
    got = measure("mujoco", found.parameters, found.translated, 3.0, dt=2e-5)
    assert got.rest_depth == pytest.approx(found.translated.rest_depth, rel=1e-6)
    assert got.restitution == pytest.approx(found.translated.restitution, rel=0.01, abs=1e-3)
    if found.law.solimp[0] == found.law.solimp[1]:  # elsewhere 2 % of the depth is no small motion
        assert got.frequency == pytest.approx(found.translated.frequency, rel=0.01)


@pytest.mark.long
@pytest.mark.skipif(
    not drake_python.present(), reason="Drake is not here; SUREFOOT_DRAKE_PYTHON names a Python with it"
)
@pytest.mark.parametrize("engine", ["drake", "drake-hunt-crossley"])
@pytest.mark.parametrize(
    "law", [SpringDamper(2e4, 40.0), HuntCrossley(2e4, 0.4)], ids=["linear", "hunt-crossley"]
)
def test_drake_does_what_the_translation_says(engine: str, law: SoftLaw) -> None:
    dt, mass = 5e-5, 4.0
    found = translate(law, engine, mass, dt=dt)
    got = measure(engine, found.parameters, found.translated, mass, dt=dt)
    # the words of a linear contact take the implicit step's damping off, those of Hunt and Crossley cannot
    expected = found.translated if engine == "drake" else behaviour(ImplicitStep(found.law, dt), mass)
    assert got.rest_depth == pytest.approx(found.translated.rest_depth, rel=1e-6)
    assert got.restitution == pytest.approx(expected.restitution, rel=2e-3)
    assert got.restitution == pytest.approx(found.translated.restitution, rel=0.01)
    assert got.frequency == pytest.approx(found.translated.frequency, rel=0.01)
    assert got.settling_time == pytest.approx(expected.settling_time, rel=0.01)


def test_engines_that_cannot_be_run_are_named() -> None:
    found = translate(SpringDamper(1e4, 20.0), "bullet", 1.0)
    with pytest.raises(ProblemError, match="valid names: drake, drake-hunt-crossley, mujoco"):
        measure("bullet", found.parameters, found.translated, 1.0)
