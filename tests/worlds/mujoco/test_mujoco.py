"""MuJoCo against Pinocchio: one robot in two engines."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError, ProblemError
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld, pinocchio_state, robot_spec
from surefoot.worlds.mujoco.spec import compile_spec

ROBOTS = ["go2", "anymal_c", "solo12", "hyq", "g1", "panda"]


def random_state(robot: sf.Robot, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    low = np.clip(robot.model.lowerPositionLimit, -1.0, 1.0)
    high = np.clip(robot.model.upperPositionLimit, -1.0, 1.0)
    pin.seed(int(rng.integers(1 << 30)))
    return pin.randomConfiguration(robot.model, low, high), rng.normal(size=robot.model.nv)


def base_to_mujoco(robot: sf.Robot, q: np.ndarray) -> np.ndarray:
    """The matrix that takes Pinocchio's velocities to MuJoCo's."""
    T = np.eye(robot.model.nv)
    if robot.floating:
        T[:3, :3] = rotation_from_quaternion(q[3:7])
    return T


@pytest.mark.parametrize("name", ROBOTS)
def test_parity_with_pinocchio(name: str) -> None:
    """Mass matrix, bias, centre of mass, foot places and foot Jacobians at random states."""
    robot = sf.load_robot(name)
    world = MujocoWorld(robot)
    model, data, m, d = robot.model, robot.data, world.model, world.data
    assert float(m.body_mass.sum()) == pytest.approx(robot.mass, rel=1e-12)
    rng = np.random.default_rng(11)
    for _ in range(5):
        q, v = random_state(robot, rng)
        world.reset(q, v)
        T = base_to_mujoco(robot, q)
        M = np.zeros((m.nv, m.nv))
        mujoco.mj_fullM(m, d, M)
        want = pin.crba(model, data, q)
        want = np.triu(want) + np.triu(want, 1).T
        np.testing.assert_allclose(T.T @ M @ T, want, atol=1e-12 * np.abs(want).max())
        # MuJoCo's linear base acceleration is in world axes: dv_mj = T dv_pin + (R (w x v), 0)
        drift = np.zeros(m.nv)
        if robot.floating:
            drift[:3] = T[:3, :3] @ np.cross(v[3:6], v[:3])
        bias = T.T @ (np.array(d.qfrc_bias) + M @ drift)
        nle = pin.nonLinearEffects(model, data, q, v)
        np.testing.assert_allclose(bias, nle, atol=1e-11 * max(1.0, np.abs(nle).max()))
        np.testing.assert_allclose(d.subtree_com[0], pin.centerOfMass(model, data, q), atol=1e-13)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        for k, foot in enumerate(robot.feet):
            geom = m.geom(f"foot:{foot.name}:0").id
            place = data.oMf[foot.frame].act(foot.centres[0])
            np.testing.assert_allclose(d.geom_xpos[geom], place, atol=1e-13)
            J = np.zeros((3, m.nv))
            mujoco.mj_jac(m, d, J, None, place, m.geom_bodyid[geom])
            F = pin.getFrameJacobian(model, data, foot.frame, pin.LOCAL_WORLD_ALIGNED)
            arm = place - data.oMf[foot.frame].translation
            np.testing.assert_allclose(J @ T, F[:3] - pin.skew(arm) @ F[3:], atol=1e-12)
            if not foot.flat:
                assert k == world.contact_foot[list(world._reader.feet.geoms).index(geom)]


@pytest.mark.parametrize("name", ROBOTS)
def test_state_survives_the_round_trip(name: str) -> None:
    robot = sf.load_robot(name)
    world = MujocoWorld(robot)
    rng = np.random.default_rng(12)
    for _ in range(5):
        q, v = random_state(robot, rng)
        world.reset(q, v)
        got_q, got_v = world.q_v()
        np.testing.assert_allclose(got_q, q, atol=1e-14)
        np.testing.assert_allclose(got_v, v, atol=1e-13)
        if robot.floating:
            other_q, other_v = pinocchio_state(np.array(world.data.qpos), np.array(world.data.qvel))
            np.testing.assert_allclose(other_q, q, atol=1e-14)
            np.testing.assert_allclose(other_v, v, atol=1e-13)


@pytest.mark.parametrize("degrees", [0.0, 12.0])
def test_contact_forces_are_mujocos_own(degrees: float) -> None:
    """Forces, gaps and velocities against mj_contactForce and finite differences of the foot's place."""
    robot, terrain = sf.load_robot("go2"), sf.SlopeTerrain(degrees)
    world = MujocoWorld(robot, terrain, mu=0.5)
    q = sf.place(robot, terrain)
    rng = np.random.default_rng(13)
    q[2] -= 2e-4
    world.reset(q, 0.05 * rng.normal(size=18))
    world.step(np.zeros(12))
    reading = world.contacts()
    frame = terrain.frame([0.0, 0.0])
    want = np.zeros((4, 3))
    wrench = np.zeros(6)
    for c in range(world.data.ncon):
        contact = world.data.contact[c]
        point = list(world._reader.feet.geoms).index(int(contact.geom2))
        mujoco.mj_contactForce(world.model, world.data, c, wrench)
        want[point] += frame.T @ (contact.frame.reshape(3, 3).T @ wrench[:3])
        assert reading.gaps[point] == pytest.approx(contact.dist, abs=1e-12)
    assert np.abs(want).max() > 1.0
    np.testing.assert_allclose(reading.forces, want, atol=1e-9)
    np.testing.assert_allclose(terrain.gap(reading.positions), reading.gaps, atol=1e-12)
    assert np.all(sf.FrictionCone(0.5).margin(reading.forces) > -1e-6)


def test_contact_velocity_is_that_of_the_material() -> None:
    """Against Pinocchio's velocity of the point fixed to the foot."""
    robot = sf.load_robot("go2")
    world = MujocoWorld(robot)
    rng = np.random.default_rng(14)
    q = sf.place(robot)
    v = rng.normal(size=18)
    world.reset(q, v)  # reset computes velocities at this state
    reading = world.contacts()
    pin.forwardKinematics(robot.model, robot.data, q, v)
    pin.updateFramePlacements(robot.model, robot.data)
    for k, foot in enumerate(robot.feet):
        twist = pin.getFrameVelocity(robot.model, robot.data, foot.frame, pin.LOCAL_WORLD_ALIGNED)
        arm = reading.positions[k] - robot.data.oMf[foot.frame].translation
        np.testing.assert_allclose(
            reading.velocities[k], twist.linear + np.cross(twist.angular, arm), atol=1e-12
        )


def test_free_fall_and_push_follow_newton() -> None:
    robot = sf.load_robot("go2")
    world = MujocoWorld(robot)
    high = robot.nominal.copy()
    high[2] += 5.0
    world.reset(high)
    push = np.array([30.0, -20.0, 10.0])
    before = momentum(robot, *world.q_v())
    for _ in range(100):
        world.step(np.zeros(12), push)
    after = momentum(robot, *world.q_v())
    gained = 0.1 * (push - [0.0, 0.0, robot.mass * GRAVITY])
    np.testing.assert_allclose(after - before, gained, atol=1e-3 * np.abs(gained).max())
    assert world.time == pytest.approx(0.1)


def momentum(robot: sf.Robot, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.array(pin.computeCentroidalMomentum(robot.model, robot.data, q, v).linear)


@pytest.mark.parametrize("whole", [False, True])
def test_feet_at_rest_stay_so_however_fast_joints_are(whole: bool) -> None:
    """Pinocchio's point velocity a step later: the base rises at 2 m/s over feet that stood still."""
    robot, dt = sf.load_robot("go2"), 1e-5
    world = MujocoWorld(robot, mu=2.0, dt=dt, solref=(5e-4, 1.0))
    if whole:
        world.count_centripetal()
    q, down = robot.nominal.copy(), np.array([0.0, 0.0, -robot.feet[0].radius])
    q[2] -= 1e-4  # pressed in, so that friction holds
    v = np.concatenate([[0.5, 0.3, 2.0], np.zeros(15)])

    def slopes(q: np.ndarray) -> np.ndarray:
        pin.computeJointJacobians(robot.model, robot.data, q)
        pin.updateFramePlacements(robot.model, robot.data)
        frames = (robot.contact_points.frames[k] for k in range(4))
        full = [pin.getFrameJacobian(robot.model, robot.data, f, pin.LOCAL_WORLD_ALIGNED) for f in frames]
        return np.vstack([J[:3] - pin.skew(down) @ J[3:] for J in full])

    v[6:] = -np.linalg.solve(slopes(q)[:, 6:], slopes(q)[:, :6] @ v[:6])
    world.reset(q, v)
    world.step(np.zeros(12))
    q, v = world.q_v()
    assert (np.abs((slopes(q) @ v)[1::3]).max() < 0.5 * dt) == whole  # sideways: 0.2 m/s², or 6


def test_payload_adds_mass_and_friction_can_change() -> None:
    robot = sf.load_robot("go2")
    world = MujocoWorld(robot, payload=5.0)
    assert float(world.model.body_mass.sum()) == pytest.approx(robot.mass + 5.0)
    world.set_friction(0.05)
    assert world.model.geom_friction[world.model.geom("ground").id, 0] == 0.05
    with pytest.raises(ProblemError, match="mu must be a number"):
        world.set_friction(-0.1)


def test_unknown_joint_kinds_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    model = pin.buildSampleModelManipulator()
    model.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    robot = sf.load_robot("panda")
    monkeypatch.setattr(robot, "model", model)
    with pytest.raises(ModelError, match="joint ball is a Spherical"):
        robot_spec(robot)


def test_a_model_that_does_not_compile_is_refused_by_its_name() -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_body(name="light").add_joint(name="hinge")  # it moves and has no mass
    with pytest.raises(ModelError, match="MuJoCo cannot simulate thing: "):
        compile_spec(spec, "thing")
