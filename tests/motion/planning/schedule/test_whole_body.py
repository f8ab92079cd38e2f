"""Motions over a schedule: checked by Pinocchio, led through exact steps, honest where there is none."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from surefoot.base.errors import ModelError, ProblemError
from surefoot.contact.solution import Status
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.robot.motor_limits import motor_limits
from surefoot.mechanics.robot.quadruped import mirrored_joints, quadruped_order
from surefoot.mechanics.terrain import StairsTerrain, rough_ground
from surefoot.motion.planning.planner import plan
from surefoot.motion.planning.schedule import ScheduledMotion, ScheduleProblem, optimise
from surefoot.motion.planning.schedule.mirror import found_in_half, robot_reflections
from surefoot.motion.planning.schedule.motions import backflip, jump
from surefoot.motion.planning.schedule.schedule_transcription import transcribe, variable_bounds
from surefoot.motion.planning.schedule.search import OPTIONS, guess_from, pack_guess
from surefoot.motion.planning.tasks.backflip import pitch_of_motion

pytest.importorskip("casadi")


@pytest.fixture(scope="module")
def found(go2) -> tuple[ScheduleProblem, ScheduledMotion]:
    """A jump of 0.25 m in knots of 20 ms: one of 0.2 m takes four times as many iterations."""
    problem = jump(go2, 0.25, 0.0, 0.6, 0.02)
    return problem, optimise(problem)


def test_the_motion_keeps_to_the_equations_of_motion(go2, found) -> None:
    problem, motion = found
    assert motion.found, motion.iterate.ending
    model, points, dt = go2.model, go2.contact_points, problem.dt
    data = model.createData()

    def momentum(q, v):
        return pin.computeCentroidalMomentum(model, data, q, v).vector.copy()

    for q, v, ahead, after, impulses, torques in zip(
        motion.q[:-1], motion.v[:-1], motion.q[1:], motion.v[1:], motion.impulses, motion.torques, strict=True
    ):
        effort = pin.rnea(model, data, q, v, (after - v) / dt)
        pin.computeJointJacobians(model, data, q)
        com = pin.centerOfMass(model, data, q).copy()
        gained = np.array([0.0, 0.0, -problem.weight * dt, 0.0, 0.0, 0.0])
        for impulse, joint, centre, radius in zip(
            impulses, points.joints, points.places, points.radii, strict=True
        ):  # flat ground: contact axes are the world's
            J = pin.getJointJacobian(model, data, int(joint), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            arm = data.oMi[int(joint)].rotation @ centre - [0.0, 0.0, radius]
            effort -= (J[:3].T @ impulse + J[3:].T @ np.cross(arm, impulse)) / dt
            place = data.oMi[int(joint)].translation + arm
            gained += np.concatenate([impulse, np.cross(place - com, impulse)])
        assert np.abs(effort[6:] - torques).max() < 1e-4
        before = momentum(pin.integrate(model, q, -dt * v), v)
        assert np.abs(momentum(q, after) - before - gained).max() < 1e-4 * dt
        assert np.abs(pin.integrate(model, q, dt * after) - ahead)[3:].max() < 1e-7
        way = dt / go2.mass * momentum(q, after)[:3]
        assert np.abs(pin.centerOfMass(model, data, ahead) - com - way).max() < 1e-7


def test_forces_modes_and_limits(go2, found) -> None:
    problem, motion = found
    stance = problem.stance
    assert np.abs(motion.impulses[~stance]).max() == 0.0
    forces = motion.impulses / problem.dt
    normal, tangential = forces[..., 2][stance], np.hypot(forces[..., 0], forces[..., 1])[stance]
    assert (normal >= problem.force_min - 1e-6).all()
    assert (tangential <= problem.mu * normal + 2e-3 * problem.weight).all()
    assert (np.abs(motion.torques) <= problem.torque_limits * (1.0 + 1e-6)).all()
    assert (np.abs(motion.v[1:, 6:]) <= problem.speed_share * go2.speed_limits * (1.0 + 1e-6)).all()
    assert (~stance.any(axis=1)).sum() * problem.dt == pytest.approx(0.3, abs=0.03)


@pytest.mark.parametrize(
    "asked",
    [{"task": "jump", "amount": 0.2, "dt": 0.02}, pytest.param({"task": "backflip"}, marks=pytest.mark.long)],
    ids=str,
)
def test_a_search_that_is_stopped_is_not_solved(go2, asked) -> None:
    def stop(iteration) -> None:
        if iteration.number == 5:
            raise KeyboardInterrupt

    found = plan(go2, **asked, tell=stop)
    assert found.status is not Status.SOLVED
    assert found.facts["interrupted"] is True
    assert plan(go2, **asked, max_iterations=3).status is not Status.SOLVED


@pytest.mark.long
def test_what_motors_cannot_do_is_not_found(go2) -> None:
    problem = replace(jump(go2, 0.4, 0.0, 0.6, 0.02), torque_share=0.15)
    assert not optimise(problem, max_iterations=60).found


@pytest.mark.parametrize("name", ["go2", "a1", "anymal_c", "solo12"])
def test_mirrored_joints_move_mirrored_feet(name: str) -> None:
    robot = load_robot(name)
    other, sign = mirrored_joints(robot)
    order = quadruped_order(robot)
    rng = np.random.default_rng(0)
    q = robot.nominal.copy()
    q[:7] = [0, 0, 0, 0, 0, 0, 1]
    q[7:] = rng.uniform(-0.5, 0.5, robot.joints)
    twin = q.copy()
    twin[7:] = sign * q[7:][other]
    data = robot.model.createData()
    places = []
    for pose in (q, twin):
        pin.framesForwardKinematics(robot.model, data, pose)
        places.append(np.array([data.oMf[k].translation.copy() for k in robot.contact_points.frames])[order])
    swapped = places[1][[1, 0, 3, 2]] * [1.0, -1.0, 1.0]
    assert np.abs(places[0] - swapped).max() < 5e-3


def test_a_robot_without_symmetry_is_refused() -> None:
    lame = copy(load_robot("go2"))
    lame.model = lame.model.copy()
    placement = lame.model.jointPlacements[2]
    placement.translation = placement.translation + np.array([0.05, 0.0, 0.0])
    lame.model.jointPlacements[2] = placement
    with pytest.raises(ModelError, match="not symmetric"):
        mirrored_joints(lame)


@pytest.mark.long
def test_motors_soft_landings_and_reach_are_kept_to(go2) -> None:
    curve = motor_limits(go2, "curve")
    problem = replace(
        jump(go2, 0.2, 0.0, 0.6, 0.02), motors=curve, motor_share=0.9, touchdown_speed=0.3, stance_reach=0.2,
        torque_share=curve.driving,
    )  # fmt: skip
    motion = optimise(problem)
    assert motion.found, motion.iterate.ending
    # the motor gives each torque at both ends of its knot
    for speeds in (motion.v[:-1, 6:], motion.v[1:, 6:]):
        for torques, speed in zip(motion.torques, speeds, strict=True):
            np.testing.assert_allclose(curve.clip(torques, speed), torques, atol=1e-4)
    stance = problem.stance
    (k,) = np.flatnonzero(stance[1:].all(axis=1) & ~stance[:-1].any(axis=1)) + 1
    before, after = (go2.foot_positions(pin.integrate(go2.model, motion.q[k], s * 1e-6 * motion.v[k]))
                     for s in (-1.0, 1.0))  # fmt: skip
    assert np.abs((after - before) / 2e-6).max() <= 0.3 + 1e-2  # spheres roll a little about their middles
    for q in motion.q[1:][stance.all(axis=1)]:
        up = pin.Quaternion(q[3:7]).toRotationMatrix()[:, 2]
        reach = (q[:3] - go2.foot_positions(q)) @ up
        assert reach.min() >= 0.2 - 1e-5


def test_a_backflip_turns_its_reference_once(go2) -> None:
    problem = backflip(go2, 0.6, 0.02)
    assert pitch_of_motion(problem.reference) == pytest.approx(-2.0 * math.pi, abs=1e-6)
    assert problem.reference[-1, 6] == pytest.approx(-problem.q[6], abs=1e-9)
    variables = pack_guess(problem, guess_from(problem))
    assert variables.shape == (problem.knots * (37 + 24) + 37,)
    shares = variables[:-37].reshape(problem.knots, -1)[:, 37 + 12 :].reshape(problem.knots, 4, 3)
    assert np.abs(shares.sum(axis=1)[:, 2] - problem.stance.any(axis=1)).max() < 1e-12  # the whole weight


def test_front_feet_keep_ahead_of_rear_hips_that_push(go2) -> None:
    problem = backflip(go2, 0.6, 0.02)
    bound = (transcribe(problem)[1][0] == problem.leg_gap).sum(axis=1)
    reared = problem.stance[:, 2:].all(axis=1) & ~problem.stance[:, :2].any(axis=1)
    assert bound.tolist() == (8 + 2 * reared).tolist()


@pytest.mark.long
def test_a_search_begins_from_a_motion_that_is_its_own_image(found) -> None:
    problem, asked = found[0], (*transcribe(found[0]), variable_bounds(found[0]))
    half = found_in_half(problem, *asked, pack_guess(problem, guess_from(problem)), None, **OPTIONS)
    q = half.variables[:-37].reshape(problem.knots, -1)[:, :19]
    assert np.abs(q @ robot_reflections(problem.robot)[0].T - q).max() < 1e-12
    assert optimise(problem, max_iterations=half.iterations + 8).found


@pytest.mark.parametrize("rise", [0.0, 0.1])
def test_only_a_jump_onto_something_must_land_softly(go2, rise: float) -> None:
    """However low the box is: its feet stop above the old ground, which no fall from there prepares."""
    ground = StairsTerrain(rise, 2.0, 1) if rise else None
    problem = jump(go2, 0.75, 0.0, 0.6, 0.02, terrain=ground)
    assert math.isfinite(problem.touchdown_speed) == (rise > 0.0)
    assert (problem.reference[-1, 2] - problem.reference[0, 2]) == pytest.approx(rise, abs=0.01)


BAD = {
    "dt": 0.0, "knots": 1, "mu": -1.0, "torque_share": 0.0, "motor_share": 0.0, "touchdown_speed": -1.0,
    "stance_reach": -1.0, "force_min": 1e4, "clearance": -0.1, "reference": np.zeros((3, 19)),
    "v": np.full(18, np.nan), "terrain": rough_ground(1, 0.05), "windows": {999: None},
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_problems_are_named(go2, name: str) -> None:
    with pytest.raises(ProblemError, match="a plane or steps" if name == "terrain" else name):
        replace(jump(go2, 0.2, 0.0, 0.6, 0.02), **{name: BAD[name]})
