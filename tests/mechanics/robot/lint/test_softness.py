"""How deep a robot sinks into MJCF contacts: the formula of the lint against MuJoCo's own rest."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from surefoot.app.cli.lint import lint_of
from surefoot.mechanics.robot.lint.softness import FIRM, find_sinking
from surefoot.worlds.mujoco.spec import CONTACT_TIME, IMPEDANCE
from tests.mechanics.robot.lint import models

FIRM_WORDS = 'solref="0.004 1" solimp="0.99 0.999 0.001"'
SOFT = [
    'solref="0.02 1" solimp="0.9 0.95 0.001"',
    'solref="0.05 1" solimp="0.9 0.95 0.001"',
    'solref="-1000 -50" solimp="0.9 0.95 0.001"',
    'solref="0.02 1" solimp="0.5 0.9 0.01"',
]


def welded(text: str) -> str:
    """Return the robot without joints, motors and keyframe, its feet just above the floor."""
    text = re.sub(r'<joint name="[A-Z]+_[a-z]+"[^/]*/>', "", text)
    text = re.sub(r"<(actuator|keyframe)>.*</\1>", "", text, flags=re.DOTALL)
    return text.replace('pos="0 0 0.4"', 'pos="0 0 0.42"')


def servoed(text: str) -> str:
    """Return the robot with stiff servos in the place of its motors."""
    return re.sub(
        r'<motor name="(\w+)" joint="(\w+)" ctrlrange="-30 30"/>',
        r'<position name="\1" joint="\2" kp="1000" kv="15"/>',
        text,
    )


def rest(text: str) -> tuple[Any, np.ndarray]:
    """Return what the formula says and the depths at which MuJoCo comes to rest [m]."""
    spec = mujoco.MjSpec.from_string(text)
    model = spec.compile()
    found = find_sinking(mujoco, spec, model)
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
        data.ctrl[:] = data.qpos[7:]
    for _ in range(3000):
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-5
    return found, np.array([-contact.dist for contact in data.contact[: data.ncon]])


@pytest.mark.parametrize("soft", SOFT)
def test_a_robot_of_one_piece_sinks_as_deep_as_computed(soft: str) -> None:
    found, depths = rest(welded(models.mjcf().replace(FIRM_WORDS, soft)))
    assert found.contacts == len(depths) == 4
    np.testing.assert_allclose(depths, found.depth, rtol=1e-3)


@pytest.mark.parametrize("soft", SOFT[:3])
def test_a_robot_on_servos_sinks_as_deep_within_a_tenth(soft: str) -> None:
    """Its legs do not share the weight quite alike."""
    found, depths = rest(servoed(models.mjcf().replace(FIRM_WORDS, soft)))
    np.testing.assert_allclose(depths.mean(), found.depth, rtol=0.1)


def test_the_line_says_why_a_urdf_is_lawful_where_an_mjcf_is_not(tmp_path: Path) -> None:
    path = tmp_path / "dog.xml"
    path.write_text(models.mjcf().replace(FIRM_WORDS, 'solref="0.04 1"'))
    (finding,) = [f for f in lint_of(str(path), models.FEET).findings if f.rule == "contact-sinks"]
    assert finding.severity == "warning"
    assert "As a URDF the same robot is lawful" in finding.detail
    assert "solref 0.04 1" in finding.detail
    path.write_text(models.mjcf().replace(FIRM_WORDS, 'solref="0.3 1"'))
    assert not lint_of(str(path), models.FEET).ok


def test_a_file_without_floor_is_told_of_default_floors(tmp_path: Path) -> None:
    path = tmp_path / "dog.xml"
    heavy = models.mjcf().replace('mass="8.0"', 'mass="16.0"').replace(FIRM_WORDS, "")
    path.write_text(re.sub(r'<geom name="floor"[^/]*/>', "", heavy))
    (finding,) = [f for f in lint_of(str(path), models.FEET).findings if f.rule == "contact-sinks"]
    assert finding.severity == "note"
    assert "a floor of MuJoCo's defaults" in finding.detail


def test_firm_ground_is_that_of_our_world() -> None:
    assert FIRM.solref == (CONTACT_TIME, 1.0)
    assert FIRM.solimp == IMPEDANCE
