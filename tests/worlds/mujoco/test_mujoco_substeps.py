"""A step of MuJoCo in parts: impulses and means, feet in corners, strikes that stay outside the ground."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain, StairsTerrain, Terrain
from surefoot.mechanics.terrain.frames import surface_frames
from surefoot.worlds.interface.world import ContactReading
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.mujoco.readings import SAME_FACE, face_principal
from surefoot.worlds.mujoco.substeps import mean_reading, substeps_of
from surefoot.worlds.running.walk_terrain import start_pose

ROBOT = load_robot("go2")
STAIRS = StairsTerrain(0.12, 0.3)


def divided(substeps: int, terrain: Terrain | None = None, **options: Any) -> MujocoWorld:
    """A world whose steps are made in parts."""
    world = MujocoWorld(ROBOT, terrain, **options)
    world.divide(substeps)
    return world


def in_world(reading: ContactReading) -> np.ndarray:
    """The forces of a reading in world axes."""
    assert reading.normals is not None
    frames = np.empty((len(reading.normals), 3, 3))
    surface_frames(np.ascontiguousarray(reading.normals), frames)
    return np.asarray(np.einsum("kij,kj->ki", frames, reading.forces))


@pytest.mark.parametrize("terrain", [FlatTerrain(), SlopeTerrain(8.0), STAIRS], ids=repr)
def test_forces_are_what_moved_the_robot(terrain: FlatTerrain) -> None:
    """Momentum, which shares nothing with how forces are read: m dv = (mean force + weight) dt."""
    world = divided(8, terrain, mu=0.7, collision="full")
    q = start_pose(ROBOT, terrain)
    world.reset(q, 0.1 * np.random.default_rng(3).normal(size=18))
    mass = float(sum(world.model.body_mass))
    for _ in range(30):
        mujoco.mj_subtreeVel(world.model, world.data)
        before = world.data.subtree_linvel[0].copy()
        world.step(np.zeros(12))
        mujoco.mj_fwdPosition(world.model, world.data)
        mujoco.mj_fwdVelocity(world.model, world.data)
        mujoco.mj_subtreeVel(world.model, world.data)
        change = mass * (world.data.subtree_linvel[0] - before) / world.dt
        reading = world.contacts()
        assert reading.others is not None
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, world.data.qpos[3:7])
        ground = in_world(reading).sum(axis=0) + rotation.reshape(3, 3) @ reading.others[:3]
        weight = mass * np.array([0.0, 0.0, -9.81])
        assert ground + weight == pytest.approx(change, abs=0.02 * mass * 9.81)


def test_the_parts_are_steps_of_their_length() -> None:
    coarse, fine = (divided(n, collision="full") for n in (1, 4))
    assert fine.model.opt.timestep == pytest.approx(0.25 * coarse.model.opt.timestep)
    assert fine.model.geom_solref[fine.ground_geoms[0], 0] == pytest.approx(0.75e-3)
    assert fine.model.pair_solref[:, 0] == pytest.approx(0.75e-3)
    fine.step(np.zeros(12))
    assert fine.time == pytest.approx(1e-3)
    told = divided(4, solref=(0.02, 1.0))
    assert told.model.geom_solref[told.ground_geoms[0], 0] == pytest.approx(0.02)


def strike(substeps: int) -> tuple[float, float]:
    """Deepest penetration [m] and largest f_n |gap| [N m] of a foot that meets a riser at 1.5 m/s."""
    world = divided(substeps, STAIRS, mu=0.6, collision="full")
    q = start_pose(ROBOT, STAIRS)
    q[2] += 0.03
    world.reset(q)
    q[0] -= max(world.data.geom_xpos[world._reader.feet.geoms, 0]) + 0.04  # the first riser is at x = 0
    v = np.zeros(18)
    v[0], v[2] = 1.5, 0.15
    world.reset(q, v)
    deepest = most = 0.0
    for _ in range(30):
        world.step(np.zeros(12))
        reading = world.contacts()
        assert reading.normals is not None
        on_riser = (np.abs(reading.normals[:, 0]) > 0.9) & (reading.forces[:, 2] > 0.0)
        deepest = max(deepest, float(-reading.gaps[on_riser].min(initial=0.0)))
        most = max(most, float((reading.forces[:, 2] * np.abs(reading.gaps))[on_riser].max(initial=0.0)))
    return deepest, most


def test_a_strike_stays_outside_a_riser_as_parts_get_shorter() -> None:
    coarse, fine, finest = (strike(n) for n in (1, 4, 16))
    assert coarse[0] > 2.0 * fine[0] > 4.0 * finest[0] > 0.0
    assert coarse[1] > 3.0 * finest[1] > 0.0


def reading(force: list[float], gap: float, normal: list[float], velocity: list[float]) -> ContactReading:
    row = [np.array([some], dtype=np.float64) for some in (force, velocity, [0.0, 0.0, 0.0], normal)]
    return ContactReading(row[0], np.array([gap]), row[1], row[2], None, row[3])


def test_means_weigh_parts_by_their_force() -> None:
    parts = [
        reading([0.0, 0.0, 0.0], 2e-3, [0, 0, 1], [1.0, 0.0, -2.0]),
        reading([3.0, 0.0, 30.0], -2e-4, [0, 0, 1], [0.9, 0.0, -1.0]),
        reading([1.0, 0.0, 10.0], -3e-4, [0, 0, 1], [0.1, 0.0, 0.0]),
    ]
    found, rest = mean_reading(parts)
    assert found.forces[0] == pytest.approx([4.0 / 3.0, 0.0, 40.0 / 3.0])
    assert found.gaps[0] == -3e-4
    assert found.velocities[0] == pytest.approx([0.7, 0.0, -0.75])
    assert not rest.any()


def test_forces_of_another_surface_are_told_apart() -> None:
    floor = reading([0.0, 0.0, 60.0], -1e-4, [0, 0, 1], [0, 0, 0])
    riser = reading([0.0, 0.0, 20.0], -1e-4, [-1, 0, 0], [0, 0, 0])
    found, rest = mean_reading([floor, floor, riser, floor])
    assert found.forces[0] == pytest.approx([0.0, 0.0, 45.0])
    assert rest[0] == pytest.approx([-5.0, 0.0, 0.0])


def test_what_a_frame_that_turns_leaves_of_the_sum_is_told() -> None:
    """Two forces of 60 N, 20 degrees apart, are 59.1 N each along their mean, and 60 N along either."""
    lean = np.radians(10.0)
    parts = [
        reading([0.0, 0.0, 60.0], -1e-4, [side * np.sin(lean), 0, np.cos(lean)], [0, 0, 0])
        for side in (1.0, -1.0)
    ]
    found, rest = mean_reading(parts)
    assert found.forces[0] == pytest.approx([0.0, 0.0, 60.0])
    sum_of_both = np.array([0.0, 0.0, 60.0 * np.cos(lean)])
    assert rest[0] == pytest.approx(sum_of_both - 60.0 * found.normals[0])


def test_a_foot_in_a_corner_tells_of_what_bears_more() -> None:
    """Frames (n; t; t) point from the ground, the first geom, to the foot, the second."""
    owner = np.array([-1, 0])
    pairs, at = np.array([[0, 1], [0, 1]], dtype=np.int32), np.array([0, 3], dtype=np.int32)
    frames = np.array([[-1.0, 0, 0, 0, 0, 1, 0, 1, 0], [0, 0, 1.0, 1, 0, 0, 0, 1, 0]])
    for forces, wanted in (((20.0, 60.0), ([0, 0, 1], -2e-4)), ((60.0, 20.0), ([-1, 0, 0], -3e-4))):
        efc = np.array([forces[0], 1.0, 1.0, forces[1], 1.0, 1.0])
        gaps, normals = np.array([-3e-4]), np.array([[-1.0, 0.0, 0.0]])
        face_principal(gaps, normals, pairs, at, frames, np.array([-3e-4, -2e-4]), efc, owner, False)
        assert normals[0].tolist() == wanted[0]
        assert gaps[0] == wanted[1]
        gaps[0] = 1.0
        face_principal(gaps, normals, pairs, at, frames, np.array([-3e-4, -2e-4]), efc, owner, False)
        assert gaps[0] == 1.0  # it faces that surface already
        face_principal(gaps, normals, pairs, at, frames, np.array([-3e-4, -2e-4]), efc, owner, True)
        assert gaps[0] == wanted[1]
    assert 0.0 < SAME_FACE < 1.0


def test_blind_walks_over_edges_take_shorter_steps() -> None:
    assert substeps_of(STAIRS, "exact") == 1
    assert substeps_of(STAIRS, "blind") > 1
    assert substeps_of(SlopeTerrain(10.0), "blind") == 1


@pytest.mark.parametrize("wrong", [0, 65, 2.5, float("nan"), "many"])
def test_wrong_numbers_of_parts(wrong: object) -> None:
    with pytest.raises(ProblemError, match="substeps"):
        MujocoWorld(ROBOT).divide(wrong)  # type: ignore[arg-type]
