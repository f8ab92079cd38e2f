"""MuJoCo's ground is the terrain: rays from above meet it at its height, and frames follow its normals."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import (
    FlatTerrain,
    GroundBox,
    HeightfieldTerrain,
    LevelsTerrain,
    PitTerrain,
    Plane,
    Shape,
    SlopeTerrain,
    StairsTerrain,
    Terrain,
    rough_ground,
)
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld, add_ground
from surefoot.worlds.running.walk_terrain import check_ground, start_pose

TERRAINS = [
    FlatTerrain(),
    SlopeTerrain(12.0),
    StairsTerrain(0.08, 0.3, steps=4),
    StairsTerrain(-0.1, 0.25, steps=3),
    PitTerrain(0.5, 0.3, 0.07),
    rough_ground(2, 0.05),
]


def ground_height(model: mujoco.MjModel, data: mujoco.MjData, xy: np.ndarray) -> float:
    hit = np.zeros(1, dtype=np.int32)
    top = np.array([*xy, 5.0])
    return 5.0 - mujoco.mj_ray(model, data, top, np.array([0.0, 0.0, -1.0]), None, 1, -1, hit, None)


@pytest.mark.parametrize("terrain", TERRAINS, ids=repr)
def test_rays_meet_the_ground_at_its_height(terrain: Terrain) -> None:
    spec = mujoco.MjSpec()
    add_ground(spec, terrain, 0.5)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    rng = np.random.default_rng(0)
    places = rng.uniform([-1.0, -2.0], [3.0, 2.0], (150, 2))
    found = [ground_height(model, data, p) for p in places]
    # a height field is flat within its cells: curvature times the cell's square over eight, at most
    tolerance = 2e-4 if isinstance(terrain, HeightfieldTerrain) else 1e-9
    assert found == pytest.approx(terrain.height(places), abs=tolerance)


class Kerb(LevelsTerrain):
    """A plane with a box on it."""

    def height(self, xy: object) -> np.ndarray:
        return np.where(np.asarray(xy, dtype=float)[..., 0] > 0.5, 0.1, 0.0)

    def levels(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array([-50.0, 0.5, 10.5]), np.array([0.0, 0.1])

    def shapes(self) -> tuple[Shape, ...]:
        return Plane(np.zeros(3), np.eye(3)), GroundBox(
            np.array([5.5, 0.0, 0.05]), np.array([10.0, 10.0, 0.1])
        )


def test_shapes_of_several_kinds_are_one_ground() -> None:
    world = MujocoWorld(load_robot("go2"), Kerb(), 0.5)
    world.set_friction(0.2)
    names = [world.model.geom(k).name for k in range(world.model.ngeom)]
    ground = [k for k, name in enumerate(names) if name.startswith("ground")]
    assert [names[k] for k in ground] == ["ground:0", "ground:1"]
    assert (world.model.geom_friction[ground, 0] == 0.2).all()
    places = np.random.default_rng(5).uniform(-1.0, 2.0, (50, 2))
    beside = places + np.array([0.0, 2.5])  # of the robot
    found = [ground_height(world.model, world.data, p) for p in beside]
    assert found == pytest.approx(Kerb().height(places), abs=1e-9)


def test_a_ground_without_a_shape_is_told() -> None:
    class Odd(Terrain):
        def height(self, xy: object) -> np.ndarray:
            return np.zeros(np.asarray(xy).shape[:-1])

        def normal(self, xy: object) -> np.ndarray:
            return np.tile([0.0, 0.0, 1.0], (*np.asarray(xy).shape[:-1], 1))

        def __repr__(self) -> str:
            return "Odd()"

    with pytest.raises(ProblemError, match="has no shape for Odd"):
        add_ground(mujoco.MjSpec(), Odd(), 0.5)
    with pytest.raises(ProblemError, match="height fields of up to"):
        add_ground(mujoco.MjSpec(), HeightfieldTerrain(np.zeros((2, 2)), 100.0), 0.5)


@pytest.mark.parametrize("terrain", TERRAINS[:4] + TERRAINS[5:], ids=repr)
def test_robots_start_on_their_feet(terrain: Terrain) -> None:
    robot = load_robot("go2")
    q = start_pose(robot, terrain)
    check_ground(robot, terrain, q, 0.6)
    gaps = terrain.gap(robot.foot_positions(q)) - [foot.radius for foot in robot.feet]
    assert gaps == pytest.approx(np.zeros(4), abs=1e-6)
