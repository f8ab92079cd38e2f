"""Identification from made-up tosses whose truth is known, and its parts against exact answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.identify_minimum import robust_mean
from benchmarks.problems.tosses import ELBOW, POSITION_NOISE, ROTATION_NOISE, random_tosses, write_tosses
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.records.identification.ground_plane import GroundPlane, GroundPoints, ground_points
from surefoot.records.identification.identify import identify
from surefoot.records.identification.relevel_tosses import find_levelled
from surefoot.records.identification.thrown_body import TossParameter, cube_body, thrown_body
from surefoot.records.identification.thrown_body_tree import sphere_places
from surefoot.records.identification.toss_errors import (
    LOST,
    deviations,
    paired_difference,
    resample,
    toss_errors,
)
from surefoot.records.identification.toss_fit import TossFit
from surefoot.records.identification.toss_impacts import first_impacts
from surefoot.records.identification.toss_model import ThrownModel, TossScene
from surefoot.records.identification.toss_refit import list_parameters, simulate_around
from surefoot.records.identification.toss_search import search
from surefoot.records.identification.toss_start import TossFlight, flying_frames
from surefoot.records.identification.tosses import Cube, Tosses
from surefoot.worlds.drake import drake_python
from surefoot.worlds.experiments.drake_tosses import DrakeBody

TRUTH, GROUND = (0.2, 0.2, 0.003), (0.003, 0.01, -0.005)
COM = 0.005
WIDTH = Cube().width


@pytest.fixture(scope="module")
def tosses() -> Tosses:
    """A cube whose centre of mass is 5 mm off its middle."""
    body = cube_body(Cube()).at({"com_z": COM})
    return random_tosses(16, TRUTH, ground=GROUND, seed=5, steps=2, frames=70, body=body)


@pytest.fixture(scope="module")
def fit(tosses: Tosses) -> TossFit:
    body = cube_body(Cube()).at({"com_z": COM})
    others = random_tosses(8, TRUTH, ground=GROUND, seed=6, steps=2, frames=70, body=body)
    simulated: list[float] = []
    found = identify(tosses, ThrownModel(steps=2), test=others, resamples=200, progress=simulated.append)
    assert simulated, "a long fit says how far it is"
    assert (np.diff([0.0, *simulated]) > 0.0).all(), "each time more tosses have been simulated"
    return found


@pytest.mark.long
def test_truth_is_found_with_the_centre_of_mass_that_the_model_has_not(fit: TossFit) -> None:
    truth = dict(zip(("mu", "restitution", "rounding"), TRUTH, strict=True))
    truth |= {"gravity": 9.81, "com_x": 0.0, "com_z": COM, "scale": 1.0, "ground": GROUND[0]}
    truth |= {"tilt_x": np.degrees(np.arctan(GROUND[1])), "spread_x": np.sqrt(0.5 * 0.00081 / 0.37)}
    near = {
        "mu": 1e-3, "restitution": 0.01, "rounding": 3e-4, "gravity": 0.05, "com_x": 2e-4, "com_z": 2e-4,
        "scale": 4e-3, "tilt_x": 0.3, "spread_x": 5e-4, "ground": 3e-4,
    }  # fmt: skip
    for name, value in truth.items():
        estimate = fit[name]
        assert abs(estimate.value - value) < near[name], name
        assert estimate.low <= estimate.value <= estimate.high


@pytest.mark.long
def test_errors_on_other_tosses_are_as_small_and_noise_is_measured(fit: TossFit) -> None:
    assert fit.test is not None
    assert fit.train.position.shape == (16,)
    assert np.median(fit.test.position) < 0.03
    assert np.median(fit.test.rotation) < 3.0
    assert np.median(fit.test.early) < 0.01
    assert fit.position_noise == pytest.approx(POSITION_NOISE, rel=0.3)
    assert fit.rotation_noise == pytest.approx(ROTATION_NOISE, rel=0.3)


def test_impacts_tell_the_true_body_from_one_whose_mass_is_in_its_middle(tosses: Tosses) -> None:
    plane = GroundPlane(GROUND[0], np.array(GROUND[1:]))
    speeds, likelihoods = [], []
    for com in (COM, 0.0):
        body = cube_body(Cube()).at({"com_z": com})
        places = sphere_places(body.tree, tosses.poses)
        flight = TossFlight(tosses, flying_frames(tosses, places, plane, WIDTH), body.tree, 9.81)
        scene = TossScene(flight.starts, tosses.frames, tosses.dt, plane, 9.81, body)
        noise = (POSITION_NOISE, ROTATION_NOISE)
        found = first_impacts(tosses, scene, ThrownModel(steps=2), np.array(TRUTH), noise, (body, plane))
        assert found is not None
        speeds.append(found.median(slice(0, 3))[0])
        likelihoods.append(found.likelihood(found.spreads()).mean())
        floor = found.median(slice(0, 3))[1]
    assert max(speeds[0], 3.0 * floor) < speeds[1]
    assert likelihoods[0] > likelihoods[1] + 1.0
    # laws that find another ground are judged by the same impacts
    lower = scene._replace(plane=GroundPlane(plane.height - 0.1 * WIDTH, plane.slope))
    again = first_impacts(tosses, lower, ThrownModel(steps=2), np.array(TRUTH), noise, (body, plane))
    assert again is not None
    np.testing.assert_array_equal(again.which, found.which)
    lost = first_impacts(tosses, scene, LostToss(steps=2), np.array(TRUTH), noise, (body, plane))
    assert lost is not None
    np.testing.assert_array_equal(lost.which, found.which)
    np.testing.assert_array_equal(lost.errors[0], LOST)
    np.testing.assert_array_equal(lost.errors[1:], found.errors[1:])


class LostToss(ThrownModel):
    """The same law, but that the first toss of a scene blows up."""

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        poses = super().rollout(values, scene)
        poses[1 : scene.frames[0]] = np.nan
        return poses


def test_a_bodys_inertia_stays_physical_wherever_a_search_goes(tmp_path: Path) -> None:
    path = tmp_path / "elbow.urdf"
    path.write_text(ELBOW)
    body, random = thrown_body(path), np.random.default_rng(0)
    assert (body.joints, body.width, len(body.tree.points)) == (("hinge",), 0.1, 16)
    for _ in range(20):
        values = {p.name: float(random.uniform(p.low, p.high)) for p in body.parameters}
        tree = body.at(values).tree
        for inertia in tree.inertias:
            assert np.linalg.eigvalsh(0.5 * np.trace(inertia) * np.eye(3) - inertia)[0] > 0.0
        assert tree.masses[1] == values["mass_hinge"]


@pytest.mark.long
def test_what_a_jointed_body_can_tell_is_found(tmp_path: Path) -> None:
    """Not its masses one by one: what lies on the hinge's axis moves alike with either link."""
    path = tmp_path / "elbow.urdf"
    path.write_text(ELBOW)
    body = thrown_body(path)
    true = body.at({"friction_hinge": 0.01, "mass_hinge": 0.45, "com_x": 0.004})
    recorded = random_tosses(16, (0.25, 0.15, 0.002), seed=3, frames=60, steps=2, body=true)
    corners, wrong = sphere_places(body.tree, recorded.poses), body.at({"friction_hinge": 0.03})
    before = flying_frames(recorded, corners, GroundPlane(0.0, np.zeros(2)), 0.1)
    first = TossFlight(recorded, before, wrong.tree, 9.81)  # whole steps throw one away, at 27 m/s
    assert np.abs(first.starts[:, 8:]).max() < 10.0
    found = identify(recorded, ThrownModel(steps=2), model=path, resamples=100)
    assert found.train.position.mean() < 0.02
    for name, value, near in (
        ("mu", 0.25, 0.03), ("restitution", 0.15, 0.02), ("friction_hinge", 0.01, 3e-3),
    ):  # fmt: skip
        assert found[name].value == pytest.approx(value, abs=near), name


def test_the_search_follows_a_bent_valley_stays_in_its_range_and_doubts_what_is_held() -> None:
    A = np.array([[1.0, 1.0, 0.0], [0.03, 0.0, 0.0], [0.0, 0.2, 3.0]])
    own = [TossParameter(name, 0.5, 0.01, 0.0, 0.7) for name in "abc"]
    held = np.random.default_rng(0).normal(0.0, 0.01, (50, 1))
    for least in ([0.35, 0.52, 0.3], [0.35, 0.52, 0.9]):

        def rows(x: FloatArray, least: list[float] = least) -> FloatArray:
            a, b, c = x[:3] - least
            return np.tile(A @ [a, b + 2.0 * a**2, c - x[3]], (5, 1))

        begin = np.array([0.5, 0.5, 0.5, 0.0])
        found = search(rows, own, begin, np.full(5, 1), resample(5, 50, 0), held)
        if least[2] < 0.7:
            np.testing.assert_allclose(found.values, least, atol=1e-3)
            np.testing.assert_allclose(found.draws - found.values, held * [0.0, 0.0, 1.0], atol=1e-4)
        assert found.values[2] <= 0.7


@pytest.mark.parametrize("width", [0.03, 0.05, 0.08])
def test_the_search_gets_out_of_small_valleys(width: float) -> None:
    """Ripples of 3 to 8 steps: from its start alone, a descent of two parameters ends beside the least."""
    own = [TossParameter(name, 0.0, 0.01, -1.0, 1.0) for name in "ab"]
    for seed in range(6):
        least = np.random.default_rng(seed).uniform(-0.08, 0.08, 2)

        def rows(x: FloatArray, least: FloatArray = least) -> FloatArray:
            away = x[:2] - least
            ripple = 0.02 * (1.0 - np.cos(2.0 * np.pi * away / width)).sum()
            return np.tile([*away, ripple], (12, 1))

        found = search(rows, own, np.zeros(2), np.full(6, 2), resample(6, 50, 0))
        np.testing.assert_allclose(found.values, least, atol=1e-4)


AT = 0.1


def rough(x: FloatArray) -> FloatArray:
    """A bent valley of three parameters with ripples across it, as thirty tosses of four frames have it."""
    a, b, c = x[:3] - [0.3, -0.1, 0.2]
    shift = np.linspace(0.0, 6.0, 30)[:, None]
    ripple = 0.03 * np.sin(120.0 * (a + b) + shift) + 0.02 * np.sin(310.0 * c + 2.0 * shift)
    floor = 0.15 * np.sin(7.0 * shift)  # what no parameter explains
    off = np.concatenate([a + 2.0 * b**2 + ripple, b - a + floor, c + a * b + ripple], axis=1)
    return np.repeat(off, 4, axis=0)


def robust_loss(x: FloatArray) -> float:
    """The loss of three columns, all places, by its definition in `toss_loss`, robust from `AT` on."""
    errors = [np.sqrt((toss**2).sum(axis=1).mean()) for toss in np.split(rough(x), 30)]
    return float(np.mean([np.hypot(AT, e) - AT for e in errors]))


def test_no_parameter_is_left_along_which_the_loss_falls() -> None:
    own = [TossParameter(name, 0.0, 0.01, -1.0, 1.0) for name in "abc"]
    found = search(rough, own, np.zeros(3), np.full(30, 4), resample(30, 100, 0), scale=np.array([AT]))
    loss = robust_loss(found.values)
    assert found.settled
    assert loss == pytest.approx(found.loss, rel=1e-12)
    for k in range(3):
        for move in np.linspace(-0.1, 0.1, 201):
            assert robust_loss(found.values + move * np.eye(3)[k]) > 0.995 * loss, (k, move)


def test_a_search_is_never_worse_than_any_of_its_starts() -> None:
    own = [TossParameter(name, 0.0, 0.01, -1.0, 1.0) for name in "abc"]
    far = np.array([0.31, -0.12, 0.21])
    found = search(
        rough, own, np.full(3, -0.9), np.full(30, 4), resample(30, 20, 0), others=[far], scale=np.array([AT]),
        descents=0,
    )  # fmt: skip
    assert found.scale == AT
    assert found.loss <= robust_loss(far)


@pytest.mark.long
def test_a_law_that_contains_another_never_trains_worse(fit: TossFit, tosses: Tosses) -> None:
    for law in ("tangential", "growing-friction"):
        wider = identify(tosses, ThrownModel(law, steps=2), found=fit.found, resamples=20)
        scale = fit.found.scale
        assert scale is not None
        np.testing.assert_array_equal(wider.found.scale, scale)
        assert wider.loss <= fit.loss * (1.0 + 1e-9), law
        start = [*(fit[p.name].value for p in ThrownModel("rigid").parameters), 0.0]  # rigid, in its words
        here = simulate_around(fit.found.upright(tosses), ThrownModel(law, steps=2), fit.found)
        values = fit.found.values
        point = np.append(start, [values[p.name] for p in list_parameters(ThrownModel(law), fit.found)[4:]])
        assert robust_mean(here(point), tosses.frames, scale) == pytest.approx(fit.loss), law


@pytest.mark.skipif(not drake_python.present(), reason="Drake is not installed")
def test_drake_throws_the_same_body_onto_the_same_ground(tosses: Tosses) -> None:
    plane, body = GroundPlane(GROUND[0], np.array(GROUND[1:])), cube_body(Cube()).at({"com_z": COM})
    flight = TossFlight(tosses, np.full(16, 12), body.tree, 9.81)
    scene = TossScene(flight.starts, tosses.frames, tosses.dt, plane, 9.81, body)
    poses = DrakeBody().rollout(np.array([0.2, 5.0, 0.5, 0.003]), scene)
    assert toss_errors(tosses, poses, WIDTH, np.full(16, 15)).position.mean() < 0.2


def test_a_range_that_is_a_point_stops_no_search() -> None:
    own = [TossParameter("a", 0.5, 0.01, 0.0, 1.0), TossParameter("b", 0.5, 0.01, 0.5, 0.5)]
    draws, begin = resample(5, 20, 0), np.array([0.5, 0.5])
    found = search(lambda x: np.tile(x - 0.3, (5, 1)), own, begin, np.full(5, 1), draws)
    np.testing.assert_allclose(found.values, [0.3, 0.5], atol=1e-3)


CAMERA = Rotation.from_rotvec([0.03, -0.02, 0.0])


def level_each(true: Tosses) -> Tosses:
    """Return tosses of a cube as a camera that leans records them, each lifted to end at height 0."""
    states = true.states.copy()
    states[:, :3] = CAMERA.apply(states[:, :3])
    states[:, 3:7] = (CAMERA * Rotation.from_quat(states[:, 3:7])).as_quat()
    states[:, 7:10] = CAMERA.apply(states[:, 7:10])
    ends = sphere_places(cube_body(Cube()).tree, states[true.starts[1:] - 1, :7])[:, :, 2].min(axis=1)
    states[:, 2] -= np.repeat(ends, true.frames)
    return Tosses(states, true.starts, true.dt)


def test_tosses_that_were_levelled_one_by_one_stand_upright_again() -> None:
    true = random_tosses(24, (0.2, 0.2, 0.0), ground=(0.0, 0.01, -0.02), seed=2, steps=2)
    body, recorded = cube_body(Cube()), level_each(true)
    found = find_levelled(recorded, body)
    assert found is not None
    assert (found.turn * CAMERA).magnitude() < 0.003
    slope = found.touches.planes(np.ones((1, len(recorded))))[0, 1:]
    np.testing.assert_allclose(slope, [0.01, -0.02], atol=0.003)
    boards = GroundPlane(0.0, slope), GroundPlane(0.0, np.array([0.01, -0.02]))
    here, there = found.upright(recorded).poses[:, None, :3], true.poses[:, None, :3]
    off = boards[0].above(here) - boards[1].above(there)
    assert np.abs(off - np.median(off)).max() < 0.0015
    assert find_levelled(true, body) is None


@pytest.mark.long
def test_slopes_that_no_rest_tells_are_fitted() -> None:
    """Touches on the way tell them to a twentieth of a degree, whole throws to a hundredth."""
    true = random_tosses(24, (0.2, 0.2, 0.003), ground=(0.0, 0.01, -0.02), seed=2, steps=2)
    fit = identify(level_each(true), ThrownModel(steps=2), resamples=50)
    levelled = fit.found.levelled
    assert levelled is not None
    normal = (levelled.turn * CAMERA).apply([-0.01, 0.02, 1.0])  # of the board, in the axes of the fit
    for name, slope in zip(("tilt_x", "tilt_y"), -normal[:2] / normal[2], strict=True):
        assert fit[name].value == pytest.approx(np.degrees(np.arctan(slope)), abs=0.02), name
    assert fit["mu"].value == pytest.approx(0.2, abs=0.01)
    assert fit["restitution"].value == pytest.approx(0.2, abs=0.02)


def test_the_ground_is_where_the_cube_rests() -> None:
    tosses = random_tosses(16, TRUTH, ground=GROUND, seed=7, noise=0.0, frames=150, steps=2)
    corners = sphere_places(cube_body(Cube()).rounded(TRUTH[2]), tosses.poses)
    points = ground_points(tosses, corners, WIDTH)
    assert points.resting
    np.testing.assert_allclose(points.planes(np.ones((1, 16)))[0], GROUND, atol=2e-4)
    # and where corners went, if it never does
    cut = tosses.until(np.full(16, 35))
    points = ground_points(cut, sphere_places(cube_body(Cube()).tree, cut.poses), WIDTH)
    assert not points.resting
    assert points.planes(np.ones((1, 16)))[0][0] == pytest.approx(GROUND[0], abs=2e-3)


def test_errors_of_a_shifted_copy() -> None:
    tosses = random_tosses(3, TRUTH, seed=1, steps=1)
    poses = tosses.poses.copy()
    poses[:, 0] += 0.1 * WIDTH
    errors = toss_errors(tosses, poses, WIDTH, np.full(3, 20))
    np.testing.assert_allclose(errors.position, 0.1)
    np.testing.assert_allclose(errors.early, 0.1)
    np.testing.assert_allclose(errors.rotation, 0.0, atol=1e-6)
    poses[tosses.starts[1]] = np.nan
    assert toss_errors(tosses, poses, WIDTH, np.full(3, 20)).position[1] == pytest.approx(
        (10.0 + 0.1 * 109) / 110
    )


def test_a_row_of_a_toss_that_blew_up_has_no_deviation() -> None:
    """SciPy refuses a turn of NaN, and so half an hour's fit of MuJoCo's contact had ended."""
    tosses = random_tosses(3, TRUTH, seed=1, steps=1)
    poses = tosses.poses.copy()
    poses[:, 0] += 0.1
    poses[tosses.starts[1] + 5 : tosses.starts[2]] = np.nan
    poses[tosses.starts[2], 2] = np.inf
    rows = deviations(tosses, poses, WIDTH, 0.5 * WIDTH)
    lost = np.flatnonzero(np.isnan(rows).any(axis=1))
    assert lost.tolist() == list(range(tosses.starts[1] + 5, tosses.starts[2] + 1))
    assert np.isnan(rows[lost]).all()
    np.testing.assert_allclose(np.delete(rows, lost, axis=0)[:, 0], 0.1 / WIDTH)


def test_paired_differences_have_their_sign_and_their_interval() -> None:
    random = np.random.default_rng(0)
    ours = random.normal(1.0, 1.0, 400)
    gap = paired_difference(ours, ours + 0.1)
    assert (gap.value, gap.low, gap.high) == pytest.approx((-0.1, -0.1, -0.1))
    wide = paired_difference(random.normal(size=400), random.normal(size=400))
    assert wide.high - wide.low == pytest.approx(2 * 1.96 * np.sqrt(2.0 / 400), rel=0.15)
    with pytest.raises(ProblemError, match="cannot be paired"):
        paired_difference(ours, ours[:3])


def test_wrong_questions_are_refused(tosses: Tosses, tmp_path: Path) -> None:
    path = tmp_path / "elbow.urdf"
    path.write_text(ELBOW)
    with pytest.raises(ProblemError, match="resamples"):
        identify(tosses, resamples=3)
    with pytest.raises(ProblemError, match="the model has 1 joints, the tosses have 0"):
        identify(write_tosses(tosses, tmp_path / "t.npz"), model=path)


def test_a_resample_without_a_toss_that_rests_has_the_plane_of_all() -> None:
    points = GroundPoints(
        np.array([[0.0, 0.0, 0.1], [1.0, 0.0, 0.1], [0.0, 1.0, 0.2], [5.0, 5.0, 9.0]]),
        np.array([True, True, True, False]),
        resting=True,
    )
    all_of_them, none_of_them = points.planes(np.array([[1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 3.0]]))
    assert all_of_them == pytest.approx([0.1, 0.0, 0.1], abs=1e-6)
    assert none_of_them == pytest.approx(all_of_them)
