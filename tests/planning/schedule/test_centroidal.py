"""Centroidal motions over schedules: momentum in NumPy, cones, flights, footholds, bounds, refusals."""

import numpy as np
import pytest

from surefoot.control.gait import ModeSchedule
from surefoot.errors import ProblemError
from surefoot.interop.gait_files import read_gaits
from surefoot.spatial import rotation_from_quaternion
from surefoot.terrain import SlopeTerrain

pytest.importorskip("casadi")

from surefoot.planning.direct.problem import Window
from surefoot.planning.schedule.centroidal import (
    CentroidalProblem,
    CentroidalWeights,
    optimise_centroidal,
)

MASS, INERTIA = 15.0, np.array([[0.1, 0.005, -0.01], [0.005, 0.25, 0.0], [-0.01, 0.0, 0.3]])
HEIGHT = 0.3
STAND = np.array([[x, y, -HEIGHT] for x in (0.19, -0.19) for y in (0.14, -0.14)])
G = np.array([0.0, 0.0, -9.81])
JUMP = ModeSchedule([0.3, 0.55], [15, 0, 15], feet=4)
FILE = """list
{
  [0] hop
}
hop
{
  modeSequence
  {
    [0] STANCE
    [1] LF_RH
    [2] STANCE
    [3] FLY
    [4] STANCE
  }
  eventTimes
  {
    [0] 0.15
    [1] 0.3
    [2] 0.45
    [3] 0.65
  }
}
"""


def ask(schedule=JUMP, knots=40, forward=0.25, **changes):
    """Return a jump forward, from rest to rest, on flat ground."""
    pose = np.array([0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0, 1.0])
    reference = np.tile(pose, (knots + 1, 1))
    reference[:, 0] = forward * np.linspace(0.0, 1.0, knots + 1)
    end = Window(reference[-1] - 1e-3, reference[-1] + 1e-3, np.full(6, -1e-3), np.full(6, 1e-3))
    given = {
        "mass": MASS, "inertia": INERTIA, "stand": STAND, "schedule": schedule, "dt": 0.025, "knots": knots,
        "pose": pose, "velocity": np.zeros(6), "feet": pose[:3] + STAND, "reference": reference,
        "windows": {knots: end},
    }  # fmt: skip
    return CentroidalProblem(**{**given, **changes})


def marched(problem, motion, pieces):
    """Return com, velocity and momentum by small explicit steps of Newton's and Euler's laws in NumPy."""
    c, v, h = motion.com[0].copy(), motion.velocity[0].copy(), motion.momentum[0].copy()
    out, t = [(c, v, h)], problem.dt / pieces
    for forces, places in zip(motion.forces, np.nan_to_num(motion.footholds), strict=True):
        a = forces.sum(axis=0) / problem.mass + G
        for _ in range(pieces):
            middle = c + 0.5 * t * v + 0.125 * t * t * a  # the centre half-way through a small step
            h = h + t * np.cross(places - middle, forces).sum(axis=0)
            c, v = c + t * v + 0.5 * t * t * a, v + t * a
        out.append((c, v, h))
    return (np.array(part) for part in zip(*out, strict=True))


@pytest.fixture(scope="module")
def jumped():
    problem = ask()
    return problem, optimise_centroidal(problem)


def test_forces_lead_to_the_motion(jumped):
    problem, motion = jumped
    assert motion.found
    c, v, h = marched(problem, motion, 400)
    assert np.abs(c - motion.com).max() < 1e-6
    assert np.abs(v - motion.velocity).max() < 1e-6
    assert np.abs(h - motion.momentum).max() < 1e-6
    assert np.ptp(motion.momentum[:, 1]) > 0.01  # there is some


def test_a_flight_is_the_parabola(jumped):
    _, motion = jumped
    first, last = np.flatnonzero(~motion.stance.any(axis=1))[[0, -1]]
    t = motion.times[first : last + 2] - motion.times[first]
    fall = motion.com[first] + t[:, None] * motion.velocity[first] + 0.5 * t[:, None] ** 2 * G
    assert len(t) == 11
    assert np.abs(motion.com[first : last + 2] - fall).max() < 1e-7
    assert np.abs(motion.momentum[first : last + 2] - motion.momentum[first]).max() < 1e-7
    assert (motion.forces[first : last + 1] == 0.0).all()


def test_feet_stay_where_they_stand_within_reach(jumped):
    problem, motion = jumped
    for foot in range(4):
        before, after = motion.footholds[:12, foot], motion.footholds[-18:, foot]
        assert np.ptp(before, axis=0).max() < 1e-7
        assert np.ptp(after, axis=0).max() < 1e-7
        assert np.allclose(before, STAND[foot] + [0.0, 0.0, HEIGHT], atol=1e-7)
        assert after[0, 0] > before[0, 0] + 0.1  # and jump with the body
        assert np.isnan(motion.footholds[12:22, foot]).all()
    for k in range(1, problem.knots):
        for at in (k, k + 1):
            R = rotation_from_quaternion(motion.quaternion[at])
            off = (motion.footholds[k] - motion.com[at]) @ R - STAND
            assert (np.abs(off[motion.stance[k]]) <= problem.reach + 1e-6).all()


@pytest.mark.parametrize("angle", [0.0, 10.0])
def test_forces_are_inside_exact_cones_of_the_ground(angle):
    terrain = SlopeTerrain(angle)
    frame = terrain.frame([0.0, 0.0])
    half = 0.5 * np.arctan2(frame[0, 2], frame[2, 2])
    pose = np.concatenate([HEIGHT * frame[:, 2], [0.0, np.sin(half), 0.0, np.cos(half)]])
    problem = ask(
        ModeSchedule([0.2, 0.45], [15, 9, 15], feet=4), 30, terrain=terrain, mu=0.4, pose=pose, windows={},
        feet=pose[:3] + STAND @ frame.T, reference=np.tile(pose, (31, 1)),
    )  # fmt: skip
    motion = optimise_centroidal(problem)
    assert motion.found
    local = motion.forces @ frame
    sideways = np.linalg.norm(local[..., :2], axis=-1)
    assert (sideways <= 0.4 * local[..., 2] + 1e-6).all()
    assert (local[..., 2] >= -1e-6).all()
    assert np.nanmax(np.abs(motion.footholds @ frame[:, 2])) < 1e-9
    if angle:
        assert sideways.max() > 1.0


def test_a_file_of_modes_is_carried_out(tmp_path):
    path = tmp_path / "modes.info"
    path.write_text(FILE)
    schedule = read_gaits(path)["hop"]
    motion = optimise_centroidal(ask(schedule, 44, forward=0.15))
    assert motion.found
    assert motion.stance[:6].all()
    assert motion.stance[6:12].tolist() == [[True, False, False, True]] * 6
    assert not motion.stance[18:26].any()
    assert motion.stance[26:].all()
    assert (motion.forces[~motion.stance] == 0.0).all()


def test_a_flight_that_gravity_forbids_is_not_found():
    """Off the ground for 0.3 s from rest, the centre of mass cannot be where it was: it falls by 0.44 m."""
    schedule = ModeSchedule([0.3], [0, 15], feet=4, max_flight=np.inf)
    pose = np.array([0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0, 1.0])
    level = Window(pose - 0.01, pose + 0.01)
    motion = optimise_centroidal(ask(schedule, 20, forward=0.0, windows={12: level}), max_iterations=200)
    assert not motion.found
    assert motion.violation > 1e-3
    assert motion.said != "Solve_Succeeded"


def test_a_turn_takes_angular_momentum_and_keeps_it_in_the_air():
    """A full turn about the vertical axis in the air: the turned angle is that of h / I."""
    knots, inertia = 40, np.diag([0.1, 0.25, 0.3])
    angle = 1.0 * np.clip((np.arange(knots + 1) - 8) / 20, 0.0, 1.0)
    pose = np.array([0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0, 1.0])
    reference = np.tile(pose, (knots + 1, 1))
    reference[:, 5], reference[:, 6] = np.sin(0.5 * angle), np.cos(0.5 * angle)
    end = Window(reference[-1] - 1e-3, reference[-1] + 1e-3)
    motion = optimise_centroidal(ask(inertia=inertia, reference=reference, windows={knots: end}))
    assert motion.found
    yaw = 2.0 * np.arctan2(motion.quaternion[:, 2], motion.quaternion[:, 3])
    assert yaw[-1] == pytest.approx(1.0, abs=5e-3)
    first, last = np.flatnonzero(~motion.stance.any(axis=1))[[0, -1]]
    wanted = motion.momentum[first, 2] / 0.3 * (last + 1 - first) * 0.025
    assert wanted > 0.1
    assert yaw[last + 1] - yaw[first] == pytest.approx(wanted, rel=2e-2)


@pytest.mark.parametrize("bound", [0.05, 0.02])
def test_momentum_is_a_cost_or_bounded_and_not_zero(jumped, bound):
    free = np.abs(jumped[1].momentum[:, 1])
    motion = optimise_centroidal(ask(momentum_bound=np.full(3, bound)))
    assert motion.found
    size = np.abs(motion.momentum).max()
    assert free.max() > 0.05
    assert 0.1 * bound < size <= bound + 1e-6
    dear = optimise_centroidal(ask(weights=CentroidalWeights(momentum=1e4)))
    assert dear.found
    assert 0.0 < np.sum(dear.momentum**2) < 0.5 * np.sum(jumped[1].momentum ** 2)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"momentum_bound": np.zeros(3)}, "cannot turn"),
        ({"mass": -1.0}, "mass"),
        ({"inertia": np.zeros((3, 3))}, "inertia"),
        ({"stand": np.zeros((2, 3))}, "stand"),
        ({"windows": {99: Window()}}, "windows"),
        ({"mu": 0.0}, "mu"),
        ({"reach": np.array([0.1, -0.1, 0.1])}, "reach"),
    ],
)
def test_what_is_no_problem_is_refused(changes, word):
    with pytest.raises(ProblemError, match=word):
        ask(**changes)
