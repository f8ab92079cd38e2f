"""From the whole body's problem to its centroidal one and back, and the benchmark's quick table."""

import numpy as np
import pytest

from surefoot.robot import load_robot
from surefoot.robot.centroidal import momentum

pytest.importorskip("casadi")

from benchmarks.scheduled_motions import main
from surefoot.planning.schedule.centroidal import optimise_centroidal
from surefoot.planning.schedule.centroidal_start import centroidal_problem, whole_body_start
from surefoot.planning.schedule.motions import jump
from surefoot.spatial import rotation_from_quaternion
from tests.pages import run_page


@pytest.fixture(scope="module")
def jumped():
    problem = jump(load_robot("go2"), 0.3, 0.0, 0.6, 0.02)
    return problem, optimise_centroidal(centroidal_problem(problem))


def test_the_centroidal_problem_is_that_of_the_robot(jumped):
    problem, _ = jumped
    robot, asked = problem.robot, centroidal_problem(problem)
    known = momentum(robot, problem.q, problem.v)
    R = rotation_from_quaternion(problem.q[3:7])
    assert np.allclose(asked.pose[:3], known.com)
    assert np.allclose(R @ asked.inertia @ R.T, known.inertia, atol=1e-9)
    assert np.allclose(asked.pose[:3] + asked.stand @ R.T, asked.feet)
    assert np.abs(asked.feet[:, 2]).max() < 1e-3  # soles on the ground
    shift = asked.reference[:, :3] - problem.reference[:, :3]
    assert np.allclose(shift, known.com - problem.q[:3])  # a jump forward keeps the base level


def test_the_start_is_the_centroidal_motion_on_the_robots_legs(jumped):
    problem, motion = jumped
    assert motion.found
    robot, model = problem.robot, problem.robot.model
    variables = whole_body_start(problem, motion)
    nx = model.nq + model.nv
    table = variables[:-nx].reshape(problem.knots, -1)
    forces = table[:, nx + robot.joints :].reshape(problem.knots, -1, 3) * problem.weight
    assert np.allclose(forces, motion.forces, atol=1e-9)
    standing = [k for k in range(1, problem.knots) if motion.stance[k].all()]
    for k in standing[:: len(standing) // 6]:
        q, v = table[k, : model.nq], table[k, model.nq : nx]
        known = momentum(robot, q, v)
        soles = np.array([_sole(robot, q, i) for i in range(4)])
        assert np.abs(soles - motion.footholds[k]).max() < 2e-3
        assert (
            np.abs(known.com - motion.com[k]).max() < 0.03
        )  # legs are moved, the lever is that of the start
        assert np.abs(known.linear / robot.mass - motion.velocity[k]).max() < 0.3
    assert (np.abs(table[:, nx : nx + robot.joints]) <= 1.0).all()


def _sole(robot, q, foot):
    import pinocchio

    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, q)
    points = robot.contact_points
    place = data.oMf[points.frames[foot]].act(points.middles[foot])
    return place - points.foot_radii[foot] * np.array([0.0, 0.0, 1.0])


def test_the_benchmark_finds_every_motion(capsys):
    table = main(["--quick"])
    assert [row.motion for row in table] == ["jump", "jump-up", "backflip"]
    assert all(row.found for row in table)
    assert len(capsys.readouterr().out.splitlines()) == 5


def test_the_page_runs():
    names = run_page("schedules.md")
    assert names["motion"].found
