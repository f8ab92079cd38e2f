"""Every world on hard input: it refuses by name, or ends with an error."""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from surefoot.base.errors import SurefootError
from surefoot.mechanics.robot import place
from surefoot.worlds.bullet.bullet_world import BulletWorld
from surefoot.worlds.drake import drake_python
from surefoot.worlds.drake.drake_world import DrakeWorld
from surefoot.worlds.interface.world import World
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.conformance.hard_inputs import NOT_FINITE
from tests.robots import robot_of

WORLDS: dict[str, Callable[..., World]] = {
    "rigid": RigidWorld, "mujoco": MujocoWorld, "drake": DrakeWorld, "bullet": BulletWorld,
}  # fmt: skip
HERE = {"drake": drake_python.present(), "bullet": find_spec("pybullet") is not None}
over_worlds = pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.skipif(not HERE.get(name, True), reason=f"{name} is not here"))
        for name in WORLDS
    ],
)


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes its warnings to a file in the present folder."""
    monkeypatch.chdir(tmp_path)


def world_of(name: str, robot: str = "go2", dt: float = 1e-3) -> World:
    world = WORLDS[name](robot_of(robot), dt=dt)
    world.reset(place(robot_of(robot)))
    return world


def check_state(world: World) -> None:
    reading = world.contacts()
    q, v = world.q_v()
    for array in (q, v, reading.forces, reading.gaps, reading.velocities, reading.positions):
        assert np.isfinite(array).all()
    assert math.isfinite(world.time)


def steps_to_the_end(world: World, steps: int, torques: np.ndarray, push: np.ndarray | None) -> int:
    """Return how many steps a world took before it said that it could not go on."""
    for k in range(steps):
        try:
            world.step(torques, push)
        except SurefootError:
            return k
    return steps


@over_worlds
@pytest.mark.parametrize("bad", NOT_FINITE)
@pytest.mark.parametrize("what", ["torques", "push"])
def test_worlds_refuse_by_name_what_is_not_finite(name: str, what: str, bad: float) -> None:
    world = world_of(name)
    torques, push = np.zeros(12), np.zeros(3)
    (torques if what == "torques" else push)[1] = bad
    before = world.q_v()
    with pytest.raises(SurefootError, match=what):
        world.step(torques, push)
    np.testing.assert_array_equal(world.q_v()[0], before[0])  # nothing has moved
    world.step(np.zeros(12))
    check_state(world)


@over_worlds
@pytest.mark.parametrize("bad", NOT_FINITE)
def test_worlds_refuse_a_start_that_is_not_finite(name: str, bad: float) -> None:
    world = world_of(name)
    q, v = place(robot_of("go2")), np.zeros(18)
    q[8] = bad
    with pytest.raises(SurefootError):
        world.reset(q)
    v[8] = bad
    with pytest.raises(SurefootError):
        world.reset(place(robot_of("go2")), v)
    with pytest.raises(SurefootError, match="mu"):
        world.set_friction(bad if not bad > 0.0 else math.nan)


@over_worlds
@pytest.mark.parametrize("size", [1e3, 1e6, 1e12, 1e100, 1e300])
def test_worlds_end_with_an_error_where_a_state_is_lost(name: str, size: float) -> None:
    """Torques and pushes from strong to absurd: a finite state to the end, or up to a `SurefootError`."""
    for push in (np.zeros(3), np.array([size, 0.0, 0.0])):
        world = world_of(name)
        torques = np.zeros(12) if push.any() else size * np.tile([1.0, -1.0, 1.0], 4)
        ended = steps_to_the_end(world, 50, torques, push)
        assert ended < 50 or size < 1e100
        check_state(world)


@over_worlds
@pytest.mark.parametrize("seed", range(3))
def test_worlds_do_not_lose_fast_limp_robots_in_silence(name: str, seed: int) -> None:
    """G1 with joint speeds of 15 rad/s at 5 ms, which a coarse step cannot follow."""
    robot, rng = robot_of("g1"), np.random.default_rng(seed)
    world = world_of(name, "g1", dt=5e-3)
    v = np.zeros(robot.model.nv)
    v[6:] = 15.0 * rng.normal(size=robot.joints)
    q = robot.nominal.copy()
    q[2] += 0.5
    world.reset(q, v)
    steps_to_the_end(world, 100, np.zeros(robot.joints), None)
    check_state(world)
