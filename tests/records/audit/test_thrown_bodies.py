"""Bodies without joints that are thrown: what softness did is told, and nothing of gaits and controllers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.worlds.mujoco.stepper.stepper import MujocoStepper

mujoco = pytest.importorskip("mujoco")


def throw(speed: float, mu: float, size: str = ".1 .1 .1", height: float = 0.1, exact: bool = False) -> Any:
    """Return the log of a box that is thrown flat over a plane, from a height of its middle [m/s, m]."""
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><option cone='elliptic'/><worldbody><geom type='plane' size='9 9 1' friction='{mu}'/>"
        f"<body name='crate' pos='0 0 {height}'><freejoint/><geom type='box' size='{size}' friction='{mu}'/>"
        "</body></worldbody></mujoco>"
    )
    stepper = MujocoStepper(model) if exact else None
    data = mujoco.MjData(model)
    data.qvel[0] = speed
    with sf.record(model if stepper is None else stepper.model, data) as log:
        for _ in range(500):
            if stepper is None:
                mujoco.mj_step(model, data)
            else:
                stepper.step(data)
                log.step()
    return log


@pytest.mark.parametrize("speed", [6.0, 8.0, 10.0])
@pytest.mark.parametrize("mu", [0.5, 0.7])
@pytest.mark.sampled(3)
def test_what_soft_contact_lifts_is_told_from_what_rigid_contact_slides(speed: float, mu: float) -> None:
    soft, rigid = (sf.audit_log(throw(speed, mu, exact=exact)) for exact in (False, True))
    assert soft.first_cause is not None
    assert (soft.first_cause.name, soft.first_cause.where) == ("soft contact", "crate")
    assert "by Coulomb's law it slides on upright" in soft.sentence
    assert rigid.first_cause is None
    assert "Nothing went wrong" in str(rigid)
    assert soft.lawful
    assert rigid.lawful


def test_a_tall_box_may_tip_by_the_laws() -> None:
    """Friction times height is more than its base ahead: rigid contact tips it as well."""
    for exact in (False, True):
        report = sf.audit_log(throw(4.0, 0.9, ".05 .05 .2", 0.2, exact))
        assert "slides on upright" not in report.sentence
        assert report.story.failure is not None
        assert report.story.failure.name == "fell"


def test_a_body_without_joints_has_no_gait_and_no_controller() -> None:
    """It was once told to land earlier, and nearer to the capture point."""
    for speed, mu, height in ((4.0, 0.7, 0.11), (3.0, 0.3, 0.2), (6.0, 0.9, 0.3)):
        causes = {cause.name for cause in sf.audit_log(throw(speed, mu, height=height)).causes}
        assert causes <= {"soft contact"}


@pytest.mark.parametrize("tilt", [0.0, 15.0])
def test_what_just_touches_at_the_start_is_there_and_not_where_it_touches_later(tilt: float) -> None:
    """A gap of zero without a contact: its place was that of the material that the box fell on afterwards."""
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody><geom type='plane' size='9 9 1' euler='0 {tilt} 0'/>"
        f"<body euler='0 {tilt} 0'><freejoint/><geom type='box' size='.1 .1 .1'/></body>"
        "</worldbody></mujoco>"
    )
    up = np.array([np.sin(np.radians(tilt)), 0.0, np.cos(np.radians(tilt))])
    data = mujoco.MjData(model)
    data.qpos[:3], data.qvel[:3] = 0.1 * up, 6.0 * np.array([up[2], 0.0, -up[0]])
    with sf.record(model, data) as log:
        for _ in range(600):
            mujoco.mj_step(model, data)
    np.testing.assert_allclose(log["contact_positions"][0] @ up, log["gaps"][0], atol=1e-9)
    np.testing.assert_allclose(log["normals"][0], np.tile(up, (log["normals"].shape[1], 1)), atol=1e-9)
    assert sf.audit_log(log).lawful
