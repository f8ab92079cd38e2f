"""A published policy in its publisher's loop: what it observes, when, and what it drives."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from benchmarks.publisher_loop import HOME, SCALE, PlaygroundLoop, on_a_floor, standing, walked

LEGS = "".join(
    f'<body pos="{0.01 * k} 0 0"><joint name="j{k}" armature="0.1"/><geom size="0.01" mass="0.01"/></body>'
    for k in range(12)
)
ROBOT = f"""<mujoco><option timestep="0.004" gravity="0 0 0"/>
<asset><mesh name="m" file="missing.stl"/></asset>
<worldbody><body name="trunk"><freejoint/><site name="imu"/><geom size="0.1" mass="5"/>
<geom type="mesh" mesh="m" contype="0" conaffinity="0"/>{LEGS}</body></worldbody>
<actuator>{"".join(f'<position joint="j{k}" kp="1"/>' for k in range(12))}</actuator>
<sensor><gyro site="imu" name="gyro"/><velocimeter site="imu" name="local_linvel"/></sensor></mujoco>"""


@pytest.fixture
def model(tmp_path: Path) -> mujoco.MjModel:
    (tmp_path / "robot.xml").write_text(ROBOT)
    return on_a_floor(tmp_path / "robot.xml")


def test_a_model_without_its_meshes_stands_on_a_floor(model: mujoco.MjModel) -> None:
    assert model.nmesh == 0
    floor = model.geom("floor")
    assert (floor.contype, floor.conaffinity, floor.condim) == (1, 0, 3)
    assert model.nq == len(standing()) == 19


def test_observations_are_in_the_axes_of_the_base(model: mujoco.MjModel) -> None:
    data, loop = mujoco.MjData(model), PlaygroundLoop(lambda seen: np.zeros(12))
    data.qpos[:] = standing()
    data.qpos[3:7] = np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)  # turned to the left
    data.qpos[7] += 0.2
    data.qvel[:6], data.qvel[8] = [1.0, 0.0, 0.0, 0.0, 0.3, 0.0], 0.7
    mujoco.mj_forward(model, data)
    seen = loop.observation(data)
    np.testing.assert_allclose(seen[:9], [0.0, -1.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, -1.0], atol=1e-9)
    np.testing.assert_allclose(seen[9:21], 0.2 * np.eye(12)[0], atol=1e-12)
    np.testing.assert_allclose(seen[21:33], 0.7 * np.eye(12)[2])
    np.testing.assert_allclose(seen[33:], [0.0] * 12 + [0.5, 0.0, 0.0])


def test_a_network_is_asked_every_20_ms_and_told_what_it_said(model: mujoco.MjModel) -> None:
    asked: list[np.ndarray] = []

    def infer(seen: np.ndarray) -> np.ndarray:
        asked.append(seen)
        return np.full(12, 0.1 * len(asked))

    data, loop = mujoco.MjData(model), PlaygroundLoop(infer)
    data.qpos[:] = standing()
    for _ in range(11):
        loop(model, data)
        np.testing.assert_allclose(data.ctrl, HOME + SCALE * 0.1 * len(asked))
        mujoco.mj_step(model, data)
    assert len(asked) == 3
    assert [seen[33] for seen in asked] == pytest.approx([0.0, 0.1, 0.2])
    loop.reset()
    data.time = 0.0
    loop(model, data)
    assert asked[3][33] == 0.0


def test_a_walk_succeeds_that_is_upright_and_went_half_the_way(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    for x, z, expected in ((1.2, 0.28, True), (0.8, 0.28, False), (1.2, 0.1, False)):
        data.qpos[0], data.qpos[2] = x, z
        assert walked(4.0)(model, data) is expected
