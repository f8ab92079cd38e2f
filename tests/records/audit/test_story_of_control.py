"""Stories of what no channel of a log names: gaits' own steps, torques that nothing asks for, planes."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import surefoot as sf
from benchmarks.foreign.loops import LOOPS, OTHERS
from surefoot.records import Log
from surefoot.records.audit.resets import join_episodes

ABLE = {loop.name: loop for loop in (*LOOPS, *OTHERS)}


@pytest.mark.parametrize(
    ("loop", "cause", "seed"),
    [
        ("hopper", "foot placement", 1),  # a foot set down beside where it was so far
        ("pd quadruped", "foot placement", 0),  # and one that comes late
        ("hopper", "foot placement", 35),  # beside, and not to where the body has become faster
        ("pd quadruped", "foot placement", 22),  # of all that come late the first
        ("pd quadruped", "foot placement", 26),  # lifted late, swung as long as ever
        ("pd humanoid", "sensor bias", 7),  # a joint's angle jumps, of which the torque tells
        ("hopper", "slow gait", 1),
        ("hopper", "slow gait", 33),  # a first stance in which it tips, before all that comes of it
        ("hopper", "delayed control", 34),  # of whose torques most is what its legs do as they land
        ("hopper", "wrong mass", 21),  # which falls short of its way, and not over
        ("arm pushing a box", "self-collision", 1),  # a bolted arm runs into its own stand
        ("arm pushing a box", "self-collision", 22),  # just after its controller has switched
        ("arm pushing a box", "payload", 26),  # whose softness gives back energy afterwards
        ("arm pushing a box", "wrong contact frame", 22),  # axes that leave nothing along the normal
        ("pd quadruped", "self-collision", 21),  # a foot had slid a little long before
        ("pd humanoid", "impossible command", 35),  # which makes a step as it falls
        ("pd humanoid", "chattering gains", 27),  # from the first row on
        ("servo hexapod", "slippery ground", 2),  # dated when it came there, seconds before it lost its grip
        ("servo hexapod", "sensor bias", 0),  # which walks on, crooked
        ("wheeled balancer", "wrong mass", 0),  # started with its centre of mass beside its wheels
        ("wheeled balancer", "impossible command", 0),  # on its way to which it tips at once
        ("wheeled balancer", "sensor bias", 1),
    ],
)
@pytest.mark.sampled(2)
def test_the_cause_comes_first(loop: str, cause: str, seed: int) -> None:
    run = ABLE[loop].failed(cause, seed)
    assert run.fault is not None
    first = sf.audit_log(run.log).first_cause
    assert first is not None
    assert first.name == cause
    assert not run.fault.places or first.where.split(", ")[0] in run.fault.places
    assert run.onset is None or abs(first.time - run.onset) <= 0.15


FLAT = """<mujoco model='flat'><option timestep='.002'/><worldbody>
<geom name='floor' type='plane' size='9 9 1'/>
<body name='trunk' pos='0 0 .85'><joint name='x' type='slide' axis='1 0 0'/>
<joint name='z' type='slide' axis='0 0 1'/>
<joint name='turn' axis='0 1 0'/><geom type='capsule' size='.06' fromto='0 0 0 0 0 .4' mass='5'/>
<body name='thigh'><joint name='hip' axis='0 1 0' damping='1' armature='.05'/>
<geom type='capsule' size='.04' fromto='0 0 -.05 0 0 -.75' mass='2'/>
<body name='foot' pos='0 0 -.8'><joint name='ankle' axis='0 1 0' range='-.6 .6' damping='1' armature='.05'/>
<geom type='capsule' size='.04' fromto='-.1 0 0 .15 0 0' mass='.7'/></body></body></body></worldbody>
<actuator><motor joint='hip'/><motor joint='ankle'/></actuator></mujoco>"""


def flat_robot(hold: int, seconds: float, push: float = 0.0) -> Log:
    """Return the log of a robot in an upright plane that stands by torques held for some rows."""
    model = mujoco.MjModel.from_xml_string(FLAT)
    data = mujoco.MjData(model)
    data.qpos[1] = -0.01
    with sf.record(model, data) as log:
        for step in range(round(seconds / model.opt.timestep)):
            if step % hold == 0:
                lean, rate = data.qpos[2], data.qvel[2]
                data.ctrl[:] = -200.0 * data.qpos[3:] - 8.0 * data.qvel[3:]
                data.ctrl[1] += 150.0 * lean + 10.0 * rate + 0.2 * np.sin(9.0 * data.time)
            data.xfrc_applied[1, 0] = push if 0.5 <= data.time < 0.6 else 0.0
            mujoco.mj_step(model, data)
    return log


def test_a_robot_in_a_plane_falls_too() -> None:
    report = sf.audit_log(flat_robot(1, 1.5, push=300.0))
    assert report.story.failure is not None
    assert report.story.failure.name == "fell"
    assert report.first_cause is not None
    assert (report.first_cause.name, report.first_cause.where) == ("push", "trunk")
    assert report.story.failure.because == "push"
    assert [event.because for event in report.story.events if event.name == "push"] == [""]
    assert any("because of push" in str(event) for event in report.story.events)


@pytest.mark.parametrize("hold", [1, 5, 10])
def test_torques_that_are_held_are_neither_late_nor_chattering(hold: int) -> None:
    report = sf.audit_log(flat_robot(hold, 1.5))
    assert report.story.failure is None
    assert report.first_cause is None


def test_of_several_episodes_the_one_that_failed_is_told() -> None:
    stood, fell = sf.audit_log(flat_robot(1, 0.5)), sf.audit_log(flat_robot(1, 1.5, push=300.0))
    assert fell.log is not None
    joined = join_episodes(fell.log, [stood, fell])
    assert joined.first_cause is not None
    assert joined.first_cause.name == "push"
