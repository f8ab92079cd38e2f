"""The rigid world against MuJoCo: same robot, same controller, same ground."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.terrain import Terrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.worlds.interface.world import World
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.rigid.rigid_world import RigidWorld


def standing(world_type, robot: sf.Robot, ground: Terrain, steps: int, push=None) -> Iterator[World]:
    """Yield the world after every step of standing; it is pushed from 0.3 to 0.5 s."""
    q = sf.place(robot, ground)
    controller = StandingController(robot, StandingPlan(robot, ground, q), ground, q)
    world = world_type(robot, ground)
    world.reset(q)
    for k in range(steps):
        torques = controller.step(RobotState(*world.q_v(), k * world.dt)).torques
        world.step(torques, push if 300 <= k < 500 else None)
        yield world


@pytest.mark.parametrize("degrees", [0.0, 10.0])
def test_standing_forces_agree_within_two_percent(degrees):
    """Their means over the last 0.2 s of 1.5 s."""
    robot, ground = sf.load_robot("go2"), sf.SlopeTerrain(degrees)
    rigid, soft = (
        np.mean([w.contacts().forces for w in standing(kind, robot, ground, 1500)][-200:], axis=0)
        for kind in (RigidWorld, MujocoWorld)
    )
    apart = np.linalg.norm(rigid - soft, axis=1) / np.linalg.norm(rigid, axis=1)
    assert apart.max() < 5e-3  # measured 0.1 %
    assert rigid[:, 2].min() > 30.0


def test_soles_carry_the_same_wrench():
    """G1's eight corners share their load as they like; each sole's force and centre of pressure agree."""
    robot, found = sf.load_robot("g1"), []
    for world_type in (RigidWorld, MujocoWorld):
        *_, world = standing(world_type, robot, sf.FlatTerrain(), 1000)
        reading = world.contacts()
        normal = reading.forces[:, 2].reshape(2, 4)
        places = reading.positions.reshape(2, 4, 3)
        pressure = (normal[..., None] * places).sum(axis=1) / normal.sum(axis=1)[:, None]
        found.append((normal.sum(axis=1), pressure[:, :2]))
    assert np.allclose(found[0][0], found[1][0], rtol=5e-3)
    assert np.abs(found[0][1] - found[1][1]).max() < 1e-3


@pytest.mark.parametrize(("name", "push"), [("go2", [48.0, 24.0, 0.0]), ("g1", [40.0, 20.0, 0.0])])
@pytest.mark.long
def test_a_push_moves_the_base_alike(name, push):
    robot = sf.load_robot(name)
    paths = [
        np.array([w.q_v()[0][:3] for w in standing(kind, robot, sf.FlatTerrain(), 1000, np.array(push))])
        for kind in (RigidWorld, MujocoWorld)
    ]
    moved = np.abs(paths[0] - sf.place(robot)[:3]).max()
    assert moved > 5e-3
    assert np.abs(paths[0] - paths[1]).max() < 0.01 * moved  # measured: 0.1 %


def test_a_stack_carries_the_same_forces_and_sinks_only_in_mujoco():
    """Five cubes: the forces between them agree; MuJoCo's contacts give, the rigid ones do not."""
    import mujoco

    from surefoot.mechanics.collision import Box
    from surefoot.worlds.rigid.scene import Body, Scene, SceneWorld

    bodies = "".join(
        f'<body name="b{k}" pos="0 0 {0.1 + 0.2 * k}"><freejoint/>'
        '<geom type="box" size=".1 .1 .1" mass="1"/></body>'
        for k in range(5)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="0.001" gravity="0 0 -{GRAVITY}" tolerance="1e-12"/>'
        f'<worldbody><geom type="plane" size="2 2 .1"/>{bodies}</worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    for _ in range(2000):
        mujoco.mj_step(model, data)
    soft, force = np.zeros(5), np.zeros(6)
    for k in range(data.ncon):
        mujoco.mj_contactForce(model, data, k, force)
        upper = max(model.geom_bodyid[data.contact[k].geom1], model.geom_bodyid[data.contact[k].geom2])
        soft[upper - 1] += force[0]

    cube = Box((0.2, 0.2, 0.2))
    world = SceneWorld(Scene([Body(f"b{k}", cube, 1.0, (0, 0, 0.1 + 0.2 * k)) for k in range(5)]))
    for _ in range(200):
        world.step()
    rigid = np.zeros(5)
    for touch in world.touches():
        rigid[int(touch.body[1])] += touch.force[2]
    np.testing.assert_allclose(rigid, GRAVITY * np.arange(5, 0, -1), atol=1e-5)
    np.testing.assert_allclose(soft, rigid, rtol=2e-3)
    sunk = 0.9 - data.xpos[5, 2]
    assert sunk > 1e-4 > 1e3 * abs(0.9 - world.pose("b4").position[2])
