"""A stranger's robot is drawn from its recording alone, where MuJoCo has its geoms."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.app.lab.drawing import Mesh
from surefoot.app.lab.recorded_body import RecordedBody, can_draw
from surefoot.app.lab.recording import RecordedMotion, RecordingPage

pytest.importorskip("trimesh")
ROOTS = {
    "free": "<freejoint/>",
    "planar": (
        "<joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/>"
        "<joint axis='0 1 0' pos='0 0 .1'/>"
    ),
    "bolted": "",
}


def model_of(root: str) -> mujoco.MjModel:
    """Return a robot with a box, a capsule, a cylinder and an ellipsoid, turned and moved in their links."""
    return mujoco.MjModel.from_xml_string(f"""<mujoco model='odd one'><worldbody>
<geom type='plane' size='5 5 1'/><body name='trunk' pos='.1 .2 .6' euler='10 20 0'>{ROOTS[root]}
<geom type='box' size='.2 .1 .05' pos='.02 0 .03' euler='0 30 0' mass='3'/>
<body name='upper' pos='.1 .05 0' euler='0 0 40'><joint name='a' axis='0 1 0' pos='0 0 .02'/>
<joint name='b' axis='1 0 0'/><geom type='capsule' size='.03' fromto='0 0 0 .05 0 -.2' mass='1'/>
<body name='lower' pos='.05 0 -.2'><joint name='c' type='slide' axis='0 0 1'/>
<geom type='cylinder' size='.02 .1' euler='20 0 0' mass='.5'/>
<geom type='ellipsoid' size='.05 .03 .02' pos='0 0 -.1' mass='.1'/>
</body></body></body></worldbody><actuator>
<motor joint='a'/><motor joint='b'/><motor joint='c'/></actuator></mujoco>""")


@pytest.mark.parametrize("root", ROOTS)
def test_links_are_where_mujoco_has_them(root: str) -> None:
    model = model_of(root)
    data = mujoco.MjData(model)
    data.qvel[:] = np.random.default_rng(3).normal(size=model.nv)
    places, turns = [], []
    with sf.record(model, data) as log:
        for _ in range(60):
            mujoco.mj_kinematics(model, data)
            places.append(data.xpos[1:].copy())
            turns.append(data.xmat[1:].reshape(-1, 3, 3).copy())
            mujoco.mj_step(model, data)
    assert can_draw(log)
    body = RecordedBody(log)
    for row in (0, 30, 59):
        found = body.poses(np.asarray(log["q"][row]))
        own = slice(-len(found), None)  # what is bolted to the world is none of its links
        np.testing.assert_allclose([place for _, place in found], places[row][own], atol=1e-9)
        np.testing.assert_allclose([turn for turn, _ in found], turns[row][own], atol=1e-9)


def test_a_page_draws_the_robot_of_a_recording_and_no_ball() -> None:
    model = model_of("free")
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        for _ in range(20):
            mujoco.mj_step(model, data)
    motion = RecordedMotion(log)
    assert not [note for note in motion.notes if "not drawn" in note]
    shapes = RecordingPage(motion, "Audit").drawing().shapes
    links = {name: shape for name, shape in shapes.items() if name.startswith("/robot/")}
    assert [name.split("-")[1] for name in links] == ["trunk", "upper", "lower"]
    assert all(isinstance(shape, Mesh) for shape in links.values())
    at = np.array([shape.position for shape in links.values() if isinstance(shape, Mesh)])
    np.testing.assert_allclose(at[:, :2].mean(axis=0), 0.0, atol=0.3)  # the camera goes with it


def test_a_mesh_is_drawn_as_its_hull() -> None:
    tent = "-1 -1 0 1 -1 0 -1 1 0 1 1 0 0 0 1"
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><asset><mesh name='tent' vertex='{tent}'/></asset>
<worldbody><geom type='plane' size='5 5 1'/><body name='camp' pos='0 0 2'><freejoint/>
<geom type='mesh' mesh='tent' mass='1'/><body pos='0 0 1.5'><joint name='turret' axis='0 0 1'/>
<geom size='.05' mass='.1'/></body></body></worldbody>
<actuator><motor joint='turret'/></actuator></mujoco>""")
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        for _ in range(5):
            mujoco.mj_step(model, data)
    links = RecordedBody(log).shapes(np.asarray(log["q"][0]), np.zeros(2))
    drawn = links["/robot/0-camp"]
    assert isinstance(drawn, Mesh)
    vertices = np.asarray(drawn.vertices)
    assert len(vertices) == 5
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [2.0, 2.0, 1.0], atol=1e-6)


def test_what_keeps_no_model_is_drawn_as_before() -> None:
    assert not can_draw(sf.Log({"time": np.arange(3.0), "forces": np.zeros((3, 1, 3))}))
