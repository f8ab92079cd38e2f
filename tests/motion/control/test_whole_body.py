"""Whole-body control against Pinocchio (dynamics, contacts) and Clarabel (optimality), and its safety."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from surefoot.base.errors import ModelError
from surefoot.base.spatial import rotation_from_normal, skew
from surefoot.contact.solvers.backends import ConeProgram, solve_program
from surefoot.mechanics.robot import Robot
from surefoot.motion.control.whole_body import Tasks, TaskWeights, WholeBodyController
from surefoot.motion.control.whole_body_tasks import WholeBodyCommand
from tests.robots import robot_of

GRAVITY = 9.81
ALIGNED = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
ROBOTS = ("go2", "anymal", "g1")


def stack(matrices: list, rights: list, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Return blocks of rows on top of each other, none included."""
    return np.vstack([np.zeros((0, columns)), *matrices]), np.concatenate([np.zeros(0), *rights])


def random_case(
    name: str, seed: int, feet_down: int | None = None
) -> tuple[Robot, np.ndarray, np.ndarray, Tasks]:
    """Return a robot, a state near nominal and tasks that no ground can quite fulfil."""
    robot, rng = robot_of(name), np.random.default_rng(seed)
    tangent = 0.15 * rng.uniform(-1.0, 1.0, robot.model.nv)
    q = pinocchio.integrate(robot.model, robot.nominal, tangent)
    v = 0.5 * rng.normal(size=robot.model.nv)
    n = len(robot.feet)
    down = rng.integers(1, n + 1) if feet_down is None else feet_down
    stance = np.zeros(n, dtype=bool)
    stance[rng.permutation(n)[:down]] = True
    normals = np.array([[0.2, 0.2, 1.0]]) * rng.uniform(-1.0, 1.0, (n, 3)) + [0.0, 0.0, 2.0]
    frames = np.array([rotation_from_normal(m / np.linalg.norm(m), rng.normal(size=3)) for m in normals])
    points = sum(len(f.centres) for f in robot.feet)
    tasks = Tasks(
        stance, 3.0 * rng.normal(size=3), 3.0 * rng.normal(size=3), 5.0 * rng.normal(size=(n, 6)),
        rng.normal(size=robot.joints), robot.mass * rng.normal(size=(points, 3)), frames, np.zeros(n),
    )  # fmt: skip
    return robot, q, v, tasks


def contact_jacobians(robot: Robot, q: np.ndarray, tasks: Tasks) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the (3p, nv) force Jacobian in contact frames and each foot's (6, nv) at its centre."""
    data = robot.model.createData()
    pinocchio.computeJointJacobians(robot.model, data, q)
    pinocchio.updateFramePlacements(robot.model, data)
    rows, centres = [], []
    for k, foot in enumerate(robot.feet):
        J = pinocchio.getFrameJacobian(robot.model, data, foot.frame, ALIGNED)
        R, normal = data.oMf[foot.frame].rotation, tasks.frames[k][:, 2]
        for centre in foot.centres:
            arm = R @ centre - foot.radius * normal
            rows.append(tasks.frames[k].T @ (J[:3] - skew(arm) @ J[3:]))
        arm = R @ foot.centre
        centres.append(np.vstack([J[:3] - skew(arm) @ J[3:], J[3:]]))
    return np.vstack(rows), centres


def centre_accelerations(robot: Robot, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return classical linear and angular acceleration of every foot's centre: (n, 6)."""
    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, q, v, a)
    pinocchio.updateFramePlacements(robot.model, data)
    out = []
    for foot in robot.feet:
        R = data.oMf[foot.frame].rotation
        linear = pinocchio.getFrameClassicalAcceleration(robot.model, data, foot.frame, ALIGNED)
        omega = pinocchio.getFrameVelocity(robot.model, data, foot.frame, ALIGNED).angular
        arm = R @ foot.centre
        moved = linear.linear + np.cross(linear.angular, arm) + np.cross(omega, np.cross(omega, arm))
        out.append(np.concatenate([moved, linear.angular]))
    return np.array(out)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("seed", range(4))
def test_torques_accelerations_and_forces_obey_the_equations_of_motion(name: str, seed: int) -> None:
    robot, q, v, tasks = random_case(name, seed)
    controller = WholeBodyController(robot, effort_limits=np.full(robot.joints, np.inf))
    command = controller.step(q, v, tasks)
    assert command.feasible
    J, _ = contact_jacobians(robot, q, tasks)
    needed = pinocchio.rnea(robot.model, robot.model.createData(), q, v, command.accelerations)
    residual = needed - J.T @ command.forces.ravel()
    residual[6:] -= command.torques
    assert np.abs(residual).max() < 1e-8 * robot.mass * GRAVITY


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("seed", range(4))
def test_carrying_feet_obey_the_contact_constraint(name: str, seed: int) -> None:
    robot, q, v, tasks = random_case(name, seed)
    damping, sinking, turning = 12.0, 20.0, 35.0
    controller = WholeBodyController(robot, baumgarte=(30.0, damping), sole_damping=(sinking, turning))
    tasks = tasks._replace(gaps=np.linspace(-0.01, 0.01, len(robot.feet)))
    command = controller.step(q, v, tasks)
    found = centre_accelerations(robot, q, v, command.accelerations)
    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, q, v)
    pinocchio.updateFramePlacements(robot.model, data)
    for k in np.flatnonzero(tasks.stance):
        foot, normal = robot.feet[k], tasks.frames[k][:, 2]
        twist = pinocchio.getFrameVelocity(robot.model, data, foot.frame, ALIGNED)
        arm = -foot.radius * normal
        reach = data.oMf[foot.frame].rotation @ foot.centre + arm
        slip = twist.linear + np.cross(twist.angular, reach)
        rolling = found[k, :3] + np.cross(found[k, 3:], arm)
        decay = damping * slip
        if foot.flat:
            decay += (sinking - damping) * float(normal @ slip) * normal
            assert found[k, 3:] == pytest.approx(-turning * twist.angular, abs=2e-6)
        assert rolling == pytest.approx(-decay - 30.0 * tasks.gaps[k] * normal, abs=2e-6)


def oracle(
    robot: Robot, q: np.ndarray, v: np.ndarray, tasks: Tasks, mu: float, bounds: tuple[float, float],
    weights: TaskWeights, damping: float, limits: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Solve the problem of the module's header in (a, f) with Clarabel, matrices from Pinocchio."""
    model, nv = robot.model, robot.model.nv
    data = model.createData()
    M = pinocchio.crba(model, data, q)
    h = pinocchio.rnea(model, data, q, v, np.zeros(nv))
    Jcom = pinocchio.jacobianCenterOfMass(model, data, q).copy()
    pinocchio.centerOfMass(model, data, q, v, np.zeros(nv))
    com_drift = data.acom[0].copy()
    Jf, centres = contact_jacobians(robot, q, tasks)
    drift = centre_accelerations(robot, q, v, np.zeros(nv))
    R = pinocchio.Quaternion(q[3:7]).toRotationMatrix()
    height = robot.nominal[2]
    points = np.array([k for k, f in enumerate(robot.feet) for _ in f.centres])
    p, nx = len(points), nv + 3 * len(points)
    blocks, wanted = [], []

    def ask(rows: np.ndarray, value: np.ndarray, weight: np.ndarray | float) -> None:
        root = np.sqrt(np.broadcast_to(weight, (len(rows),)))[:, None]
        blocks.append(root * rows)
        wanted.append(root[:, 0] * value)

    def pad(rows: np.ndarray) -> np.ndarray:
        return np.hstack([rows, np.zeros((len(rows), 3 * p))])

    ask(pad(Jcom), tasks.com_acceleration - com_drift, weights.linear)
    ask(pad(np.eye(nv)[3:6]), R.T @ tasks.turn_acceleration, weights.angular * height**2)
    legs = np.abs(np.array(centres)[:, :, 6:]).max(axis=(0, 1)) > 1e-12
    ask(pad(np.eye(nv)[6:]), tasks.joints, weights.joints * height**2 * np.where(legs, 1.0, weights.body))
    E, e = [np.hstack([M[:6], -Jf.T[:6]])], [-h[:6]]
    omega = {k: J[3:] @ v for k, J in enumerate(centres)}
    for k, foot in enumerate(robot.feet):
        J, arm = centres[k], -foot.radius * tasks.frames[k][:, 2]
        if tasks.stance[k]:
            rolling = J[:3] - skew(arm) @ J[3:]
            E.append(pad(rolling))
            e.append(-drift[k, :3] - np.cross(drift[k, 3:], arm) - damping * rolling @ v)
            if foot.flat:
                E.append(pad(J[3:]))
                e.append(-drift[k, 3:] - damping * omega[k])
        else:
            ask(pad(J[:3]), tasks.feet[k, :3] - drift[k, :3], weights.swing)
            if foot.flat:
                ask(pad(J[3:]), tasks.feet[k, 3:] - drift[k, 3:], weights.swing * height**2)
    ask(
        np.hstack([np.zeros((3 * p, nv)), np.eye(3 * p)]), tasks.forces.ravel(), weights.force / robot.mass**2
    )
    forces, pushing = np.eye(nx)[nv:].reshape(p, 3, nx), tasks.stance[points]
    E += list(forces[~pushing])
    e += [np.zeros(3)] * int(np.count_nonzero(~pushing))
    torque = (np.hstack([M[6:], -Jf.T[6:]]), h[6:], limits)
    G, K = cone_rows(forces[pushing], mu, bounds, torque)
    program = ConeProgram.of(
        *quadratic(blocks, wanted), zero=(np.vstack(E), np.concatenate(e)), nonneg=G, second_order=K
    )
    x = solve_program(program, tol=1e-10).solution()  # at 1e-11 it gives up short of it
    return x[:nv], x[nv:].reshape(-1, 3)


def quadratic(blocks: list[np.ndarray], wanted: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the Hessian and gradient of the sum of squares."""
    A, b = np.vstack(blocks), np.concatenate(wanted)
    return A.T @ A, -A.T @ b


def cone_rows(
    forces: np.ndarray, mu: float, bounds: tuple[float, float], torque: tuple[np.ndarray, ...]
) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Return G x <= g of bounds and torque limits, and the rows -K x in second-order cones."""
    nx = forces.shape[-1]
    K = [-np.vstack([mu * f[2], f[0], f[1]]) for f in forces]
    G = [np.vstack([f[2], -f[2]]) for f in forces]
    g = [np.array([bounds[1], -bounds[0]])] * len(G)
    T, h, limits = torque
    if np.isfinite(limits).all():
        G.append(np.vstack([T, -T]))
        g.append(np.concatenate([limits - h, limits + h]))
    return stack(G, g, nx), stack(K, [np.zeros(3)] * len(K), nx)


def check_optimal(
    robot: Robot, q: np.ndarray, v: np.ndarray, tasks: Tasks, bounds: tuple[float, float], limits: np.ndarray
) -> WholeBodyCommand:
    """Return the command, whose forces and accelerations have to be the oracle's."""
    mu, alike = 0.5, TaskWeights(swing=1.0, joints=1e-3, body=100.0, force=0.3)
    for weights in (alike, TaskWeights(force=0.3)):
        command = WholeBodyController(robot, mu, *bounds, weights, (0.0, 8.0), limits).step(q, v, tasks)
        a, f = oracle(robot, q, v, tasks, mu, bounds, weights, 8.0, limits)
        assert command.forces == pytest.approx(f, abs=2e-4 * robot.mass * GRAVITY)
        # a cost that is right to a share tells what weighs little by its root less
        assert command.accelerations == pytest.approx(a, abs=1e-2 / np.sqrt(weights.swing))
    return command


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("seed", range(6))
def test_the_command_is_optimal(name: str, seed: int) -> None:
    robot, q, v, tasks = random_case(name, 100 + seed)
    weight = robot.mass * GRAVITY
    check_optimal(robot, q, v, tasks, (0.01 * weight, 0.8 * weight), np.full(robot.joints, np.inf))


@pytest.mark.parametrize("name", ["go2", "anymal"])
@pytest.mark.parametrize("seed", range(6))
def test_the_command_is_optimal_under_torque_limits(name: str, seed: int) -> None:
    robot, q, v, tasks = random_case(name, 200 + seed, feet_down=3)
    tasks = tasks._replace(feet=0.1 * tasks.feet)
    bounds = (0.0, 0.8 * robot.mass * GRAVITY)
    free = check_optimal(robot, q, v, tasks, bounds, np.full(robot.joints, np.inf))
    limits = np.full(robot.joints, 0.8 * np.abs(free.torques).max())
    command = check_optimal(robot, q, v, tasks, bounds, limits)
    assert command.feasible
    assert (np.abs(command.torques) <= limits + 1e-12).all()


@pytest.mark.parametrize("seed", range(6))
def test_a_leg_in_the_air_too_weak_for_its_task_gives_way_optimally(seed: int) -> None:
    robot, q, v, tasks = random_case("go2", 600 + seed, feet_down=3)
    foot = int(np.flatnonzero(~tasks.stance)[0])
    tasks = tasks._replace(feet=20.0 * tasks.feet, forces=np.abs(tasks.forces))
    torques = check_optimal(robot, q, v, tasks, (0.0, 400.0), np.full(robot.joints, np.inf)).torques
    leg = slice(3 * foot, 3 * foot + 3)
    limits = np.full(robot.joints, 1e3)
    worst = 3 * foot + int(np.abs(torques[leg]).argmax())
    limits[worst] = 0.6 * abs(torques[worst])
    command = check_optimal(robot, q, v, tasks, (0.0, 400.0), limits)
    assert command.feasible
    assert abs(command.torques[worst]) == pytest.approx(limits[worst])


def test_the_body_is_not_thrown_up_to_lift_feet_faster_than_their_motors_can() -> None:
    robot = robot_of("go2")
    q, v, stance = robot.nominal, np.zeros(robot.model.nv), np.array([True, False, False, True])
    feet = np.zeros((4, 6))
    feet[~stance, 2] = 150.0
    frames, weight = np.tile(np.eye(3), (4, 1, 1)), robot.mass * GRAVITY
    forces = np.where(stance, 0.5 * weight, 0.0)[:, None] * [0.0, 0.0, 1.0]
    tasks = Tasks(stance, np.zeros(3), np.zeros(3), feet, np.zeros(12), forces, frames, np.zeros(4))
    limits = np.where(np.repeat(stance, 3), 45.0, 2.0)
    command = WholeBodyController(robot, normal_max=1.5 * weight, effort_limits=limits).step(q, v, tasks)
    data = robot.model.createData()
    pinocchio.centerOfMass(robot.model, data, q, v, command.accelerations)
    assert abs(data.acom[0][2]) < 3.0


def test_forces_stay_in_their_cones_whatever_is_asked() -> None:
    for seed in range(30):
        robot, q, v, tasks = random_case("go2", 300 + seed)
        wild = tasks._replace(com_acceleration=100.0 * tasks.com_acceleration)
        command = WholeBodyController(robot, 0.4, 1.0, 120.0).step(q, v, wild)
        f = command.forces
        on = tasks.stance
        assert (np.hypot(f[:, 0], f[:, 1]) <= 0.4 * f[:, 2] + 1e-9).all()
        assert (f[on, 2] >= 1.0 - 1e-9).all()
        assert (f[on, 2] <= 120.0 + 1e-9).all()
        assert (f[~on] == 0.0).all()
        assert np.isfinite(command.torques).all()
        assert (np.abs(command.torques) <= robot.effort_limits).all()


def test_a_robot_too_weak_is_flagged_and_clipped() -> None:
    robot, q, v, tasks = random_case("go2", 2, feet_down=4)
    limits = np.full(robot.joints, 0.05)
    command = WholeBodyController(robot, normal_min=30.0, effort_limits=limits).step(q, v, tasks)
    assert not command.feasible
    assert command.violation > 0.05
    assert (np.abs(command.torques) <= 0.05).all()


def test_no_foot_on_the_ground_leaves_the_body_to_gravity() -> None:
    robot, q, v, tasks = random_case("go2", 3)
    tasks = tasks._replace(stance=np.zeros(4, dtype=bool))
    command = WholeBodyController(robot).step(q, v, tasks)
    data = robot.model.createData()
    pinocchio.centerOfMass(robot.model, data, q, v, command.accelerations)
    assert (command.forces == 0.0).all()
    assert data.acom[0] == pytest.approx([0.0, 0.0, -GRAVITY], abs=1e-8)


def test_the_centre_of_pressure_stays_in_the_soles() -> None:
    for seed in range(10):
        robot, q, v, tasks = random_case("g1", 400 + seed, feet_down=2)
        controller = WholeBodyController(robot, 0.7)
        command = controller.step(q, v, tasks)
        for k, foot in enumerate(robot.feet):
            mine = controller.point_foot == k
            normal = command.forces[mine, 2]
            if normal.sum() < 1.0:
                continue
            pressure = normal @ foot.centres[:, :2] / normal.sum()
            assert (pressure >= foot.centres[:, :2].min(axis=0) - 1e-9).all()
            assert (pressure <= foot.centres[:, :2].max(axis=0) + 1e-9).all()


def test_robots_without_feet_or_with_a_fixed_base_are_refused() -> None:
    with pytest.raises(ModelError, match="needs a floating base and feet"):
        WholeBodyController(robot_of("panda"))
