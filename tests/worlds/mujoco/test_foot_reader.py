"""Views see MuJoCo's data; what is read of them is a value that later steps leave alone."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.terrain import Terrain
from surefoot.worlds.mujoco.foot_reader import FootReading
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld


def test_views_are_mujocos_own_arrays() -> None:
    world = MujocoWorld(sf.load_robot("go2"))
    views, data = world._views, world.data
    world.step(np.arange(12.0), np.array([1.0, 2.0, 3.0]))
    assert np.array_equal(data.qfrc_applied, np.r_[np.zeros(6), np.arange(12.0)])
    assert data.xfrc_applied[world.base_body].tolist() == [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]
    for view, own in (
        (views.qpos, data.qpos), (views.qvel, data.qvel), (views.effort, data.qfrc_applied),
        (views.push, data.xfrc_applied), (views.places, data.geom_xpos), (views.twists, data.cvel),
        (views.centres, data.subtree_com),
    ):  # fmt: skip
        assert np.shares_memory(view, own)


def test_geoms_of_feet_and_their_owners() -> None:
    robot = sf.load_robot("go2")
    world = MujocoWorld(robot, collision="full")
    feet, model = world._reader.feet, world.model
    assert [model.geom(int(g)).name for g in feet.geoms] == [f"foot:{n}" for n in robot.contact_points.names]
    assert feet.owner[feet.geoms].tolist() == [0, 1, 2, 3]
    assert (feet.owner[world.ground_geoms] == -1).all()
    assert (feet.owner == -2).sum() == model.ngeom - 4 - len(world.ground_geoms)
    assert feet.sizes[:, 0] == pytest.approx(robot.contact_points.radii)


@pytest.mark.parametrize("terrain", [sf.FlatTerrain(), sf.StairsTerrain(0.1, 0.3)])
def test_a_reading_outlives_the_steps_after_it(terrain: Terrain) -> None:
    robot = sf.load_robot("go2")
    world = MujocoWorld(robot, terrain, collision="full")
    world.reset(sf.place(robot, terrain))
    held = np.zeros(12)
    for _ in range(100):
        world.step(held)
    reading = world._reader.read()
    assert reading.contacts.forces[:, 2].sum() > 1.0
    kept = copy.deepcopy(reading)
    assert _same(reading, world._reader.read())  # looking changes nothing
    for _ in range(50):
        world.step(held)
    assert _same(reading, kept)
    assert not _same(world._reader.read(), kept)


def _same(one: FootReading, other: FootReading) -> bool:
    """Return whether two readings are equal to the last bit."""
    fields = ("forces", "gaps", "velocities", "positions", "others", "normals")
    pairs = [(getattr(one.contacts, name), getattr(other.contacts, name)) for name in fields]
    return one.beside == other.beside and all(np.array_equal(a, b) for a, b in pairs)
