"""The MuJoCo world with exact contacts: lawful, followed in its changes, and a world of its own by name."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError, SimulationError
from surefoot.base.memory import alike
from surefoot.mechanics.robot import place
from surefoot.mechanics.terrain import rough_ground
from surefoot.motion.walking.walkers import walking_controller
from surefoot.records import summarise_walk
from surefoot.records.audit.log_context import setting_of
from surefoot.records.audit.rows import Rows
from surefoot.records.audit.summary.run_summary import world_name
from surefoot.worlds.interface.world_names import make_world
from surefoot.worlds.mujoco.exact_world import MujocoExactWorld
from surefoot.worlds.mujoco.mjcf_world import MjcfWorld
from surefoot.worlds.rigid.bodies import ball, box
from tests.robots import robot_of


def exact(robot: str = "go2", **options: Any) -> sf.MujocoWorld:
    """Return an exact world of a robot that stands on the ground."""
    world = sf.MujocoWorld(robot_of(robot), exact=True, **options)
    world.reset(place(robot_of(robot)))
    return world


@pytest.mark.parametrize("robot", ["go2", pytest.param("g1", marks=pytest.mark.long)])
def test_a_walk_is_lawful_without_any_softness(robot: str) -> None:
    """No depth, no creep: a sticking foot's speed is rounding, and what is declared is no softness."""
    own = robot_of(robot)
    walker = walking_controller(own, sf.VelocityCommand.constant(0.4))
    log = sf.run(make_world("mujoco-exact", own), walker, sf.Scenario(1.5, 0.6))
    summary = summarise_walk(log)
    assert (summary.world, summary.laws_broken) == ("mujoco-exact", [])
    assert not {"sinking", "creep", "stopping", "settling", "step_depth"} & set(log.facts)
    soft = int(log.fact("unsolved_steps"))
    assert summary.unsolved_steps == soft <= 2
    forces, speed = np.asarray(log["forces"]), np.asarray(log["contact_velocities"])
    across, along = (np.linalg.norm(a[..., :2], axis=-1) for a in (forces, speed))
    held = (forces[..., 2] > 1.0) & (across < 0.5 * 0.6 * forces[..., 2])
    assert np.sort(along[held])[: len(along[held]) - 4 * soft].max(initial=0.0) < 1e-5
    if not soft:
        assert np.asarray(log["gaps"]).min() > -1e-5
        assert np.abs(np.where(forces[..., 2] > 0.0, log["gaps"], 0.0)).max() < 1e-5


def test_at_rest_the_ground_bears_the_weight() -> None:
    """A box: forces sum up to m g, gaps and velocities are zero."""
    world = sf.MujocoWorld(box(3.0, (0.2, 0.2, 0.1), 0.01), exact=True)
    for _ in range(50):
        world.step(np.zeros(0))
    reading = world.contacts()
    assert reading.forces[:, 2].sum() == pytest.approx(3.0 * 9.81, rel=1e-9)
    down = reading.forces[:, 2] > 0.0
    assert down.sum() == 4
    assert np.abs(reading.gaps[down]).max() < 1e-8
    assert np.abs(reading.velocities).max() < 1e-9


def test_changes_of_friction_are_followed() -> None:
    """Ice everywhere, then under one foot alone, whose priority rises."""
    body = box(3.0, (0.2, 0.2, 0.1), 0.01)
    world = sf.MujocoWorld(body, mu=0.5, exact=True)
    push = np.array([10.0, 0.0, 0.0])
    for mu, slides in ((0.5, False), (0.1, True)):
        world.reset(body.nominal)
        world.set_friction(mu)
        for _ in range(100):
            world.step(np.zeros(0), push)
        moved = world.q_v()[0][0] - body.nominal[0]
        expected = 0.5 * (10.0 / 3.0 - 0.1 * 9.81) * 0.1**2 if slides else 0.0
        assert moved == pytest.approx(expected, rel=0.02, abs=1e-9)
    world.reset(body.nominal)
    world.set_friction(0.5)
    places = world.contacts().positions
    world.set_point_friction(np.where(places[:, 0] > 0.0, 0.0, 0.5))
    for _ in range(100):
        world.step(np.zeros(0), push)
    forces = world.contacts().forces
    across = np.hypot(forces[:, 0], forces[:, 1])
    icy = (places[:, 0] > 0.0) & (forces[:, 2] > 0.0)
    assert icy.sum() == 2
    assert (across[icy] < 2e-5 * forces[icy, 2]).all()
    assert across[~icy].max() > 1.0


def test_a_copy_and_a_resumed_world_go_on_to_the_last_bit() -> None:
    """The last impulses are part of the state: forgotten ones would change the last bits."""
    first = exact(collision="full")
    rng = np.random.default_rng(3)
    for _ in range(30):
        first.step(rng.normal(0.0, 4.0, 12))
    second, third = copy.deepcopy(first), exact(collision="full")
    third.resume(first.state)
    assert len(first.state.own["values"]) > 0
    for _ in range(40):
        torques = rng.normal(0.0, 4.0, 12)
        for world in (first, second, third):
            world.step(torques)
        assert alike(first.state, second.state)
        assert alike(first.state, third.state)
    soft = sf.MujocoWorld(robot_of("go2"), collision="full")
    with pytest.raises(ProblemError, match="a MujocoExactWorld, this world is a MujocoWorld"):
        soft.resume(first.state)
    for name, wrong in (
        ("keys", np.zeros((2, 2), np.int64)),
        ("values", None),
        ("places", np.full((1, 2), 9)),
    ):
        state = copy.deepcopy(first.state)
        state.own[name] = wrong
        before = third.state
        with pytest.raises(ProblemError):
            third.resume(state)
        assert alike(third.state, before)


def test_a_step_that_is_lost_is_undone() -> None:
    world = exact()
    world.step(np.zeros(12))
    before = world.q_v()
    with pytest.raises(SimulationError):
        world.step(np.full(12, 1e18))
    for one, two in zip(world.q_v(), before, strict=True):
        np.testing.assert_allclose(one, two, rtol=1e-12, atol=1e-12)
    world.reset(place(world.robot))
    world.step(np.zeros(12))
    assert world.unsolved == 0


def test_restitution_and_softness_are_asked_of_whom_they_are() -> None:
    body = ball(2.0, 0.1)
    world = sf.MujocoWorld(body, exact=True, restitution=0.5, dt=1e-4)
    q = body.nominal.copy()
    q[2] += 0.05
    world.reset(q)
    heights = []
    for _ in range(2500):
        world.step(np.zeros(0))
        heights.append(float(world.q_v()[0][2]))
    low = int(np.argmax(np.diff(heights) > 0.0))
    assert max(heights[low:]) - 0.1 == pytest.approx(0.25 * 0.05, rel=0.01)
    for options, told in (
        ({"exact": True, "solref": (0.01, 1.0)}, "exact ones have none"),
        ({"exact": True, "solimp": (0.9,)}, "exact ones have none"),
        ({"restitution": 0.5}, "exact=True"),
        ({"exact": True, "restitution": 2.0}, "restitution"),
    ):
        with pytest.raises(ProblemError, match=told):
            sf.MujocoWorld(body, **options)  # type: ignore[arg-type]


def test_names_of_the_world() -> None:
    """One kind however it is made; its model has elliptic cones, and a plain world none of this."""
    robot = robot_of("go2")
    for world in (
        MujocoExactWorld(robot),
        sf.MujocoWorld(robot, exact=True),
        make_world("mujoco-exact", robot),
    ):
        assert isinstance(world, sf.MujocoWorld)
        assert world.kind == "MujocoExactWorld"
        assert world.stepper is not None
    plain = sf.MujocoWorld(robot)
    assert (plain.kind, plain.stepper, plain.unsolved) == ("MujocoWorld", None, 0)
    log = sf.Log({"time": np.zeros(1)}, {"world": "MujocoWorld"})
    assert world_name(log) == "mujoco"


def test_the_feet_s_reading_is_what_mujoco_says_of_the_end() -> None:
    """Velocities against finite differences of MuJoCo's own kinematics, before and after a step."""
    world = exact()
    rng, hold = np.random.default_rng(0), place(robot_of("go2"))[7:]

    def step() -> None:
        q, v = world.q_v()
        world.step(60.0 * (hold - q[7:]) - 2.0 * v[6:] + rng.normal(0.0, 5.0, 12))

    for _ in range(20):
        step()
    data = mujoco.MjData(world.model)
    feet = world._reader.feet
    data.qpos[:] = world.data.qpos
    mujoco.mj_kinematics(world.model, data)
    before = data.geom_xpos[feet.geoms].copy()
    step()
    data.qpos[:] = world.data.qpos
    mujoco.mj_kinematics(world.model, data)
    rise = (data.geom_xpos[feet.geoms] - before)[:, 2] / world.dt
    reading = world.contacts()
    np.testing.assert_allclose(reading.velocities[:, 2], rise, atol=2e-2)
    pressed = reading.forces[:, 2] > 0.0
    assert pressed.any()
    ends = np.where(pressed, data.geom_xpos[feet.geoms][:, 2], before[:, 2]) - feet.sizes[:, 0]
    np.testing.assert_allclose(reading.gaps, ends, atol=2e-5)


def test_a_file_that_is_a_world_has_exact_contacts_too() -> None:
    """Feet that its softness lets sink rest on the ground."""
    path = Path(__file__).parents[3] / "examples" / "models" / "quadruped.xml"
    robot = sf.load_robot(path, feet=["FL", "FR", "RL", "RR"])
    deepest = {}
    for chosen in (False, True):
        world = MjcfWorld(robot, path, collision="feet", exact=chosen)
        world.reset(place(robot))
        hold = world.q_v()[0][7:]
        for _ in range(400):
            q, v = world.q_v()
            world.step(60.0 * (hold - q[7:]) - 2.0 * v[6:])
        deepest[chosen] = -float(world.contacts().gaps.min())
    assert (world.kind, world.unsolved) == ("MjcfExactWorld", 0)
    assert deepest[True] < 1e-8 < 1e-6 < deepest[False]


@pytest.mark.parametrize(("seed", "height"), [(3, 0.05), pytest.param(5, 0.08, marks=pytest.mark.long)])
@pytest.mark.long
def test_forces_on_facets_of_rough_ground_explain_the_motion(seed: int, height: float) -> None:
    """A foot that bears has its facets' normal: by the terrain's, forces were newtons beside."""
    own, ground = robot_of("go2"), rough_ground(seed, height)
    walker = walking_controller(own, sf.VelocityCommand.constant(0.4), terrain=ground)
    log = sf.run(make_world("mujoco-exact", own, terrain=ground), walker, sf.Scenario(2.0, 0.6))
    rest = Rows(log, setting_of(log, None), 0, len(log)).unexplained
    assert rest is not None
    left = np.linalg.norm(rest.force[:-1], axis=1)
    assert np.percentile(left, 99.0) < 1e-4
    assert left.max() < 0.1
