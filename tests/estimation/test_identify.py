"""Identification from made-up tosses whose truth is known, and its parts against exact answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.problems.tosses import POSITION_NOISE, ROTATION_NOISE, random_tosses
from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError
from surefoot.estimation.cube_model import CubeModel
from surefoot.estimation.free_flight import fit_free_flight, flying_frames, gravity_of, gravity_terms
from surefoot.estimation.ground_plane import GroundPlane, GroundPoints, ground_points
from surefoot.estimation.identify import TossFit, identify, surroundings
from surefoot.estimation.response import ResponseSurface
from surefoot.estimation.toss_errors import paired_difference, resample, toss_errors
from surefoot.estimation.toss_model import TossParameter, TossScene
from surefoot.estimation.tosses import Cube, Tosses, read_tosses, write_tosses

RECORDED = Path(__file__).parents[3] / "shared" / "data" / "tosses" / "cube_tosses.npz"
TRUTH, GROUND = (0.2, 0.2, 0.05), (0.003, 0.01, -0.005)


@pytest.fixture(scope="module")
def tosses() -> Tosses:
    return random_tosses(32, TRUTH, ground=GROUND, seed=5, steps=2)


@pytest.fixture(scope="module")
def fit(tosses: Tosses) -> TossFit:
    others = random_tosses(12, TRUTH, ground=GROUND, seed=6, steps=2)
    return identify(tosses, CubeModel(steps=2), test=others, resamples=200)


def test_truth_is_found_within_tight_intervals(fit: TossFit) -> None:
    truth = dict(zip(("mu", "restitution", "rounding"), TRUTH, strict=True))
    truth |= {"ground": GROUND[0], "gravity": 9.81}
    truth |= {"tilt_x": np.degrees(np.arctan(GROUND[1])), "tilt_y": np.degrees(np.arctan(GROUND[2]))}
    widest = {
        "mu": 0.02, "restitution": 0.1, "rounding": 0.1, "ground": 2e-4, "gravity": 0.05, "tilt_x": 0.05,
        "tilt_y": 0.05,
    }  # fmt: skip
    assert set(fit.parameters) == set(truth)
    for name, value in truth.items():
        estimate = fit[name]
        assert estimate.high - estimate.low < widest[name], name
        assert abs(estimate.value - value) < widest[name], name
        assert estimate.low <= estimate.value <= estimate.high


def test_errors_on_other_tosses_are_as_small(fit: TossFit) -> None:
    assert fit.test is not None
    assert fit.train.position.shape == (32,)
    assert fit.test.position.shape == (12,)
    assert np.median(fit.train.position) < 0.02
    assert np.median(fit.test.position) < 0.02
    assert np.median(fit.test.rotation) < 1.0


def test_noise_of_the_recording_is_measured(fit: TossFit) -> None:
    assert fit.position_noise == pytest.approx(POSITION_NOISE, rel=0.2)
    assert fit.rotation_noise == pytest.approx(ROTATION_NOISE, rel=0.2)


def test_the_same_seed_gives_the_same_fit_and_a_file_is_as_good(tosses: Tosses, tmp_path: Path) -> None:
    path = write_tosses(tosses, tmp_path / "tosses.npz")
    model = CubeModel(steps=1)
    first, again = (identify(t, model, most=8, resamples=50, seed=1) for t in (tosses, path))
    assert first.parameters == again.parameters
    assert any("fitted to 8 of 32 tosses" in note for note in first.notes)


def test_a_soft_law_fits_its_own_tosses_and_says_what_it_cannot_tell() -> None:
    recorded = random_tosses(12, (0.2, 2e4, 60.0), law="spring-damper", seed=5, frames=70, steps=3)
    found = identify(recorded, CubeModel("spring-damper", steps=3), resamples=50)
    assert found["mu"].value == pytest.approx(0.2, abs=0.01)
    assert np.median(found.train.position) < 0.03
    assert any("several minima in stiffness" in note for note in found.notes)


class Quadratic:
    """A model that moves every toss aside by a distance that is least at known values."""

    name = "quadratic"
    parameters = (TossParameter("a", 0.0, 1.0), TossParameter("b", 1.0, 100.0, logarithmic=True))

    def __init__(self, tosses: Tosses) -> None:
        self._states, self.calls = tosses.states[:, :7], 0

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        self.calls += 1
        poses = self._states[: int(scene.frames.sum())].copy()
        away = 0.3 * np.hypot(values[0] - 0.3, np.log10(values[1]) - 0.6)
        poses[:, 0] += away + 0.02
        return poses


def test_any_model_can_be_fitted() -> None:
    tosses = random_tosses(10, TRUTH, seed=8)
    found = identify(tosses, Quadratic(tosses), resamples=50)
    assert found["a"].value == pytest.approx(0.3, abs=2e-3)
    assert found["b"].value == pytest.approx(10**0.6, rel=1e-2)


def test_a_response_surface_finds_the_minimum_of_quadratics() -> None:
    random = np.random.default_rng(0)
    points = random.uniform(0.3, 0.7, (40, 3))
    least = np.array([0.45, 0.52, 0.7])  # the last one at the edge of the box
    A = np.array([[2.0, 0.8, 0.0], [0.8, 1.0, 0.2], [0.0, 0.2, 3.0]])
    gap = points - least
    losses = np.einsum("ni,ij,nj->n", gap, A, gap)[:, None] * random.uniform(0.5, 1.5, 30)
    surface = ResponseSurface(points, losses, np.full(3, 0.5), np.full(3, 0.2))
    weights = resample(30, 20, 0)
    np.testing.assert_allclose(surface.minimisers(weights), np.tile(least, (20, 1)), atol=1e-6)
    np.testing.assert_allclose(surface.minimisers(weights, seed=1), np.tile(least, (20, 1)), atol=1e-6)


def test_a_response_surface_with_a_saddle_ends_at_the_edge() -> None:
    x = np.stack(np.meshgrid(*[np.linspace(0.3, 0.7, 7)] * 2), axis=-1).reshape(-1, 2)
    losses = ((x[:, 0] - 0.5) ** 2 - (x[:, 1] - 0.45) ** 2)[:, None]
    found = ResponseSurface(x, losses, np.full(2, 0.5), np.full(2, 0.2)).minimisers(np.ones((1, 1)))[0]
    np.testing.assert_allclose(found, [0.5, 0.7], atol=1e-6)


def test_gravity_and_first_states_are_exact_without_noise() -> None:
    tosses = random_tosses(12, TRUTH, seed=6, noise=0.0)
    frames = flying_frames(tosses, GroundPlane(0.0, np.zeros(2)))
    assert gravity_of(gravity_terms(tosses, frames), np.ones((1, 12)))[0] == pytest.approx(9.81, abs=1e-6)
    flight = fit_free_flight(tosses, frames, 9.81)
    assert flight.position_noise < 1e-9
    scene = TossScene(
        flight.starts, tosses.frames, tosses.dt, GroundPlane(0.0, np.zeros(2)), 9.81, tosses.cube
    )
    errors = toss_errors(tosses, CubeModel().rollout(np.array(TRUTH), scene))
    assert np.median(errors.corners) < 1e-5


def test_the_ground_is_where_the_cube_rests() -> None:
    tosses = random_tosses(30, TRUTH, ground=GROUND, seed=7, noise=0.0, frames=150)
    points = ground_points(tosses)
    assert points.resting
    np.testing.assert_allclose(points.planes(np.ones((1, 30)))[0], GROUND, atol=1e-4)


def test_the_ground_without_rest_is_where_corners_went() -> None:
    tosses = random_tosses(30, TRUTH, ground=GROUND, seed=7, frames=35)
    found = surroundings(tosses, np.ones((20, 30)))
    assert "few tosses come to rest" in found.notes[0]
    assert found.plane.height == pytest.approx(GROUND[0], abs=2e-3)


def test_a_wrong_length_scale_is_noticed() -> None:
    tosses = random_tosses(20, TRUTH, seed=9)
    states = tosses.states.copy()
    states[:, :3] *= 0.98
    found = surroundings(Tosses(states, tosses.starts, tosses.dt), resample(20, 50, 0))
    assert found.gravity == pytest.approx(0.98 * 9.81, abs=0.03)
    assert any("lengths, or times, are" in note for note in found.notes)


def test_errors_of_a_shifted_and_turned_copy() -> None:
    tosses = random_tosses(3, TRUTH, seed=1)
    poses = tosses.states[:, :7].copy()
    poses[:, 0] += 0.1 * tosses.cube.width
    errors = toss_errors(tosses, poses)
    np.testing.assert_allclose(errors.position, 0.1)
    np.testing.assert_allclose(errors.rotation, 0.0, atol=1e-6)
    np.testing.assert_allclose(errors.corners, 0.1)
    poses[tosses.starts[1]] = np.nan
    assert toss_errors(tosses, poses).position[1] == pytest.approx((10.0 + 0.1 * 109) / 110)


def test_paired_differences_have_their_sign_and_their_interval() -> None:
    random = np.random.default_rng(0)
    ours = random.normal(1.0, 1.0, 400)
    gap = paired_difference(ours, ours + 0.1)
    assert (gap.value, gap.low, gap.high) == pytest.approx((-0.1, -0.1, -0.1))
    wide = paired_difference(random.normal(size=400), random.normal(size=400))
    assert wide.high - wide.low == pytest.approx(2 * 1.96 * np.sqrt(2.0 / 400), rel=0.15)
    with pytest.raises(ProblemError, match="cannot be paired"):
        paired_difference(ours, ours[:3])


def test_wrong_questions_are_refused(tosses: Tosses) -> None:
    with pytest.raises(ProblemError, match="needs 8 tosses"):
        identify(tosses.subset([1, 2]))
    with pytest.raises(ProblemError, match="unknown contact law 'hertz'"):
        identify(tosses, "hertz")
    with pytest.raises(ProblemError, match="resamples"):
        identify(tosses, resamples=3)


@pytest.mark.shared
@pytest.mark.skipif(not RECORDED.exists(), reason="no recorded tosses beside the checkout")
def test_recorded_tosses_say_what_others_found() -> None:
    recorded = read_tosses(RECORDED)
    assert (len(recorded), recorded.cube) == (428, Cube())
    errors = []
    found = surroundings(recorded, np.ones((20, 428)))
    assert found.plane.height == pytest.approx(-0.0011, abs=2e-4)
    assert found.gravity == pytest.approx(9.60, abs=0.02)
    part = recorded.subset(np.arange(0, 428, 4))
    scene = found.scene(part)
    for mu in (0.13, 0.18, 0.25):
        poses = CubeModel().rollout(np.array([mu, 0.1, 0.06]), scene)
        errors.append(float(toss_errors(part, poses).position.mean()))
    assert 0.10 < errors[1] < 0.13
    assert min(errors[0], errors[2]) > 1.5 * errors[1]


def test_a_resample_without_a_toss_that_rests_has_the_plane_of_all() -> None:
    points = GroundPoints(
        np.array([[0.0, 0.0, 0.1], [1.0, 0.0, 0.1], [0.0, 1.0, 0.2], [5.0, 5.0, 9.0]]),
        np.array([True, True, True, False]),
        resting=True,
    )
    all_of_them, none_of_them = points.planes(np.array([[1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 3.0]]))
    assert all_of_them == pytest.approx([0.1, 0.0, 0.1], abs=1e-6)
    assert none_of_them == pytest.approx(all_of_them)
