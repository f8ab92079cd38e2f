"""How far first states are off, by what noise of the frames before the first touch does to their fit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.problems.tosses import ELBOW, random_tosses
from surefoot.records.identification.thrown_body import ThrownBody, thrown_body
from surefoot.records.identification.toss_start import TossFlight
from surefoot.records.identification.tosses import Tosses

NOISE = (2e-4, 3e-3)
FRAMES = 6


@pytest.fixture(scope="module")
def elbow(tmp_path_factory: pytest.TempPathFactory) -> ThrownBody:
    path: Path = tmp_path_factory.mktemp("elbow") / "elbow.urdf"
    path.write_text(ELBOW)
    return thrown_body(path)


@pytest.mark.parametrize("friction", [0.0, 0.02])
def test_shaken_states_are_as_far_off_as_is_said_even_where_frames_tell_nothing(
    elbow: ThrownBody, friction: float
) -> None:
    """A hinge that its friction holds ends every rate at once: no frame tells the rate it began with."""
    body = elbow.at({"friction_hinge": friction})
    tosses = random_tosses(5, (0.25, 0.15, 0.002), seed=1, frames=20, steps=2, body=body)
    flight = TossFlight(tosses, np.full(5, FRAMES), body.tree, 9.81)
    said = flight.deviations(NOISE)
    assert np.isfinite(said).all()
    random = np.random.default_rng(0)
    exact = flight.starts
    shaken = np.stack([flight.shaken(exact, NOISE, random) for _ in range(2000)])
    assert np.isfinite(shaken).all()
    # places and rates move in proportion; turns do so about the axes of the world
    moved = np.concatenate([shaken[..., :3], shaken[..., 8:]], axis=-1)
    places = [0, 1, 2, *range(7, 14)]
    np.testing.assert_allclose(moved.std(axis=0), said[:, places], rtol=0.1, atol=1e-9)


def test_hinges_that_friction_holds_are_shaken_too(elbow: ThrownBody) -> None:
    """Of one that is held half the flight, rounding makes a covariance without a root: that ended a fit."""
    body = elbow.at({"friction_hinge": 0.01})
    all_of_them = random_tosses(200, (0.25, 0.15, 0.002), seed=1, frames=20, steps=2, body=body)
    tosses = all_of_them.subset(np.arange(60, 70))  # that of the 65th has none
    flight = TossFlight(tosses, np.full(10, 18), body.tree, 9.81)
    shaken = flight.shaken(flight.starts, NOISE, np.random.default_rng(0))
    assert np.isfinite(shaken).all()
    off = np.abs(shaken - flight.starts)[:, [0, 1, 2, *range(8, 15)]]
    assert (off < 6.0 * flight.deviations(NOISE)[:, [0, 1, 2, *range(7, 14)]] + 1e-9).all()


def test_it_is_what_refitted_noise_scatters_by(elbow: ThrownBody) -> None:
    """An oracle without covariances: the same flight recorded anew with noise, and fitted again."""
    true = random_tosses(1, (0.25, 0.15, 0.002), seed=2, frames=20, noise=0.0, steps=2, body=elbow)
    said = TossFlight(true, np.array([FRAMES]), elbow.tree, 9.81).deviations(NOISE)[0]
    random, found = np.random.default_rng(0), []
    for _ in range(100):
        states = true.states.copy()
        states[:, :3] += NOISE[0] * random.normal(size=(len(states), 3))
        turned = Rotation.from_rotvec(NOISE[1] * random.normal(size=(len(states), 3)))
        states[:, 3:7] = (turned * Rotation.from_quat(states[:, 3:7])).as_quat()
        states[:, 7] += NOISE[1] * random.normal(size=len(states))
        again = Tosses(states, true.starts, true.dt)
        found.append(TossFlight(again, np.array([FRAMES]), elbow.tree, 9.81).starts[0])
    rates = np.std(found, axis=0)[8:]
    np.testing.assert_allclose(rates, said[7:], rtol=0.25)
