"""Stories of lawful loops on other models: hands that take things up, robots that move in a plane."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.audit.story.hulls import outside_hulls

mujoco = pytest.importorskip("mujoco")
SCOOP = """<mujoco><option timestep='.002'/><worldbody><geom type='plane' size='5 5 1'/>
<geom type='box' size='.05 .02 .1' pos='0 .12 .1'/><geom type='box' size='.05 .02 .1' pos='0 -.12 .1'/>
<body name='parcel' pos='0 0 .255'><freejoint/><geom type='box' size='.08 .14 .05' mass='3'/></body>
<body name='mast' pos='-.3 0 .15'><geom type='sphere' size='.02' mass='5' contype='0' conaffinity='0'/>
<body name='scoop' pos='.3 0 0'><joint name='lift' type='slide' axis='0 0 1' damping='5'/>
<geom type='box' size='.1 .08 .01' mass='4'/></body></body></worldbody>
<actuator><motor name='winch' joint='lift'/></actuator></mujoco>"""
PLANAR = """<mujoco><option timestep='.002'/><worldbody><geom type='plane' size='50 5 1' friction='.9'/>
<body name='cab' pos='0 0 .3'><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/>
<joint axis='0 1 0'/><geom type='box' size='.3 .1 .05' mass='8'/>
<body pos='.25 0 -.2'><joint name='fore' axis='0 1 0' damping='.1'/><geom size='.1' mass='1'/></body>
<body pos='-.25 0 -.2'><joint name='rear' axis='0 1 0' damping='.1'/><geom size='.1' mass='1'/></body>
</body></worldbody><actuator><motor joint='fore'/><motor joint='rear'/></actuator></mujoco>"""


def lifted() -> sf.Log:
    """Return the log of a scoop that goes up under a parcel of 3 kg and lifts it off its rack."""
    model = mujoco.MjModel.from_xml_string(SCOOP)
    data = mujoco.MjData(model)
    z, v = model.joint("lift").qposadr[0], model.joint("lift").dofadr[0]
    with sf.record(model, data, "mast") as log:
        while data.time < 1.5:
            goal = 0.16 * min(data.time, 1.0)
            data.ctrl[0] = 4e3 * (goal - data.qpos[z]) - 300.0 * data.qvel[v] + 4 * 9.81
            mujoco.mj_step(model, data)
    assert data.qpos[2] > 0.28
    return log


def test_what_a_hand_takes_up_is_no_payload() -> None:
    report = sf.audit_log(lifted())
    assert not report.causes, str(report.story)


def driven(speed: float) -> Any:
    """Return the log of a cab on two wheels in a plane, of which 0.5 m/s is asked for."""
    model = mujoco.MjModel.from_xml_string(PLANAR)
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        while data.time < 3.0:
            data.ctrl[:] = 4.0 * (speed - data.qvel[0])
            mujoco.mj_step(model, data)
    return sf.Log({**log.arrays, "command": np.tile([0.5, 0.0, 0.0], (len(log), 1))}, dict(log.facts))


def test_a_robot_in_a_plane_is_asked_how_far_it_went() -> None:
    followed, stood = sf.audit_log(driven(0.5)), sf.audit_log(driven(0.0))
    assert followed.task == "attained", followed.sentence
    assert not followed.causes
    assert stood.task == "failed", stood.sentence


def test_a_point_between_two_feet_is_within_them() -> None:
    feet = np.array([[[-1.0, 0.0], [1.0, 0.0]]] * 3)
    points = np.array([[0.3, 0.0], [0.0, 0.4], [2.0, 0.0]])
    np.testing.assert_allclose(outside_hulls(feet, points), [0.0, 0.4, 1.0], atol=1e-12)
    in_a_row = np.concatenate([feet, feet[:, :1] * 0.5], axis=1)
    np.testing.assert_allclose(outside_hulls(in_a_row, points), [0.0, 0.4, 1.0], atol=1e-12)


def test_a_limb_that_is_swung_in_the_air_is_no_biased_sensor() -> None:
    """A leg under a cab on slides is asked for a torque in the first row, before anything carries it."""
    model = mujoco.MjModel.from_xml_string("""<mujoco><option timestep='.001'/><worldbody>
<geom type='plane' size='5 5 1'/><body name='cab' pos='0 0 .6'><joint type='slide' axis='1 0 0'/>
<joint type='slide' axis='0 0 1'/><geom type='box' size='.1 .1 .1' mass='10'/>
<body><joint name='hip' axis='0 1 0' damping='.5' armature='.02'/><geom size='.03' mass='1'/>
<body pos='0 0 -.4'><joint name='ram' type='slide' axis='0 0 -1' damping='40'/>
<geom name='toe' size='.03' mass='.5'/></body></body></body></worldbody>
<actuator><motor joint='hip' forcerange='-60 60'/>
<motor joint='ram' forcerange='-800 800'/></actuator></mujoco>""")
    data = mujoco.MjData(model)
    data.qpos[1] = -0.1
    with sf.record(model, data) as log:
        while data.time < 0.6:
            data.ctrl[:] = 200.0 * (-0.1 - data.qpos[2]) - 10.0 * data.qvel[2], -4000.0 * data.qpos[3]
            mujoco.mj_step(model, data)
    told = [cause.name for cause in sf.audit_log(log).causes]
    assert "sensor bias" not in told, told
