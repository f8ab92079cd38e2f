"""The centroidal start: momentum in NumPy, cones, flights, footholds; and legs under it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from surefoot.robot import place
from surefoot.robot.centroidal import momentum
from surefoot.spatial import rotation_from_quaternion
from surefoot.stance.gait import ModeSchedule
from surefoot.terrain import SlopeTerrain

pytest.importorskip("casadi")

from surefoot.planning.schedule.centroidal import CentroidalModel, optimise_centroidal
from surefoot.planning.schedule.limbs import soles, whole_body_guess
from surefoot.planning.schedule.motions import backflip, jump
from surefoot.planning.tasks.scheduled import best_motion
from surefoot.planning.tasks.task import PlanRequest
from tests.pages import run_page

G = np.array([0.0, 0.0, -9.81])


@pytest.fixture(scope="module")
def jumped(go2):
    problem = jump(go2, 0.3, 0.0, 0.6, 0.02)
    return problem, optimise_centroidal(problem)


def marched(problem, motion, pieces):
    """Return com, velocity and momentum by small explicit steps of Newton's and Euler's laws in NumPy."""
    c, v, h = motion.com[0].copy(), motion.velocity[0].copy(), motion.momentum[0].copy()
    out, t = [(c, v, h)], problem.dt / pieces
    for forces, places in zip(motion.forces, np.nan_to_num(motion.footholds), strict=True):
        a = forces.sum(axis=0) / problem.robot.mass + G
        for _ in range(pieces):
            middle = c + 0.5 * t * v + 0.125 * t * t * a  # the centre half-way through a small step
            h = h + t * np.cross(places - middle, forces).sum(axis=0)
            c, v = c + t * v + 0.5 * t * t * a, v + t * a
        out.append((c, v, h))
    return (np.array(part) for part in zip(*out, strict=True))


def test_the_model_is_the_robots(go2, jumped):
    problem, _ = jumped
    known, seen = momentum(go2, problem.q, problem.v), CentroidalModel(problem)
    R = rotation_from_quaternion(problem.q[3:7])
    assert np.allclose(seen.pose[:3], known.com)
    assert np.allclose(R @ seen.inertia @ R.T, known.inertia, atol=1e-9)
    assert np.allclose(seen.pose[:3] + seen.stand @ R.T, seen.feet)
    assert np.abs(seen.feet[:, 2]).max() < 1e-3  # soles on the ground
    shift = seen.reference[:, :3] - problem.reference[:, :3]
    assert np.allclose(shift, known.com - problem.q[:3])  # a jump forward keeps the base level


def test_forces_lead_to_the_motion(jumped):
    problem, motion = jumped
    assert motion.found
    c, v, h = marched(problem, motion, 400)
    assert np.abs(c - motion.com).max() < 1e-6
    assert np.abs(v - motion.velocity).max() < 1e-6
    assert np.abs(h - motion.momentum).max() < 2e-6
    assert np.ptp(motion.momentum[:, 1]) > 0.01  # there is some


def test_a_flight_is_the_parabola(jumped):
    problem, motion = jumped
    first, last = np.flatnonzero(~motion.stance.any(axis=1))[[0, -1]]
    t = problem.dt * np.arange(last - first + 2)
    fall = motion.com[first] + t[:, None] * motion.velocity[first] + 0.5 * t[:, None] ** 2 * G
    assert np.abs(motion.com[first : last + 2] - fall).max() < 1e-7
    assert np.abs(motion.momentum[first : last + 2] - motion.momentum[first]).max() < 1e-7
    assert (motion.forces[first : last + 1] == 0.0).all()


def test_feet_stay_where_they_stand_within_reach(jumped):
    problem, motion = jumped
    first, last = np.flatnonzero(~motion.stance.any(axis=1))[[0, -1]]
    for foot in range(4):
        before, after = motion.footholds[:first, foot], motion.footholds[last + 1 :, foot]
        assert np.ptp(before, axis=0).max() < 1e-7
        assert np.ptp(after, axis=0).max() < 1e-7
        assert after[0, 0] > before[0, 0] + 0.1  # and jump with the body
        assert np.isnan(motion.footholds[first : last + 1, foot]).all()
    reach, stand = CentroidalModel(problem).reach, CentroidalModel(problem).stand
    for k in range(1, problem.knots):
        for at in (k, k + 1):
            R = rotation_from_quaternion(motion.quaternion[at])
            off = (motion.footholds[k] - motion.com[at]) @ R - stand
            assert (np.abs(off[motion.stance[k]]) <= reach + 1e-6).all()


@pytest.mark.parametrize("angle", [0.0, 10.0])
def test_forces_are_inside_exact_cones_of_the_ground(go2, angle):
    terrain = SlopeTerrain(angle)
    q, frame = place(go2, terrain), terrain.frame([0.0, 0.0])
    flat = jump(go2, 0.0, 0.0, 0.6, 0.02)
    problem = replace(
        flat, terrain=terrain, q=q, reference=np.tile(q, (flat.knots + 1, 1)), windows={}, mu=0.4
    )
    motion = optimise_centroidal(problem)
    assert motion.found
    local = motion.forces @ frame
    sideways = np.linalg.norm(local[..., :2], axis=-1)
    assert (sideways <= 0.4 * local[..., 2] + 1e-5).all()
    assert np.nanmax(np.abs(motion.footholds @ frame[:, 2])) < 1e-9
    if angle:
        assert sideways.max() > 1.0


def test_a_flight_that_gravity_forbids_is_not_found(go2):
    """Off the ground for 0.3 s from rest, the centre of mass cannot be where it was: it falls by 0.44 m."""
    made = jump(go2, 0.0, 0.0, 0.6, 0.02)
    (window,) = made.windows.values()
    schedule = ModeSchedule([0.3], [0, 15], feet=4, max_flight=math.inf)
    motion = optimise_centroidal(replace(made, schedule=schedule, windows={15: window}))
    assert not motion.found
    assert motion.iterate.violation > 1e-3


def test_a_flip_takes_its_angular_momentum_along(go2):
    problem = backflip(go2, 0.6, 0.02)
    motion = optimise_centroidal(problem)
    assert motion.found
    first, last = np.flatnonzero(~motion.stance.any(axis=1))[[0, -1]]
    pitch = np.unwrap(2.0 * np.arctan2(motion.quaternion[:, 1], motion.quaternion[:, 3]), period=2.0 * np.pi)
    assert pitch[-1] - pitch[0] == pytest.approx(-2.0 * np.pi, abs=0.2)
    rate = motion.momentum[first, 1] / CentroidalModel(problem).inertia[1, 1]
    turned = pitch[last + 1] - pitch[first]
    assert turned == pytest.approx(rate * problem.dt * (last + 1 - first), rel=2e-2)
    assert turned < -1.0


def test_the_guess_is_the_centroidal_motion_on_the_robots_legs(go2, jumped):
    problem, motion = jumped
    guess = whole_body_guess(problem, motion)
    assert np.allclose(guess.impulses / problem.dt, motion.forces, atol=1e-9)
    standing = [k for k in range(1, problem.knots) if motion.stance[k].all()]
    data = go2.model.createData()
    for k in standing[:: len(standing) // 6]:
        q, v = guess.q[k], guess.v[k]
        known = momentum(go2, q, v)
        assert np.abs(soles(problem, data, q) - motion.footholds[k]).max() < 2e-3
        # legs are moved, the lever is that of the start
        assert np.abs(known.com - motion.com[k]).max() < 0.03
        assert np.abs(known.linear / go2.mass - motion.velocity[k]).max() < 0.3
    assert (np.abs(guess.torques) <= problem.torque_limits).all()


def test_a_search_that_starts_light_tells_of_both_models(go2):
    problem, heard = jump(go2, 0.3, 0.0, 0.6, 0.02), []
    motion = best_motion(problem, PlanRequest(go2), heard.append, light=True)
    assert motion.found
    notes = [iteration.note for iteration in heard]
    assert list(dict.fromkeys(notes)) == ["centre of mass over the schedule", "whole body over the schedule"]
    numbers = [iteration.number for iteration in heard]
    assert numbers[0] == 1
    assert (np.diff(numbers) >= 0).all()


def test_the_page_runs():
    names = run_page("schedules.md")
    assert names["motion"].found
