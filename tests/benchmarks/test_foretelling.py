"""What a reference foretells of its execution: pieces of made pairs, and correlations of a known order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from benchmarks.certify.foretelling import Piece, accelerations, foretell, lowered, main, pieces_of
from benchmarks.certify.repair_cases import rising_motion
from surefoot.records.motions.motion import Motion


@pytest.fixture(scope="module")
def rising() -> Motion:
    return rising_motion(sf.load_robot("g1"))


def test_a_reference_that_hangs_is_lowered_to_where_it_was(rising: Motion) -> None:
    high = rising.q.copy()
    high[:, 2] += 0.07
    np.testing.assert_allclose(lowered(replace(rising, q=high)).q, lowered(rising).q, atol=1e-9)
    assert abs(lowered(rising).q[:, 2] - rising.q[:, 2]).max() < 0.01


def test_accelerations_of_a_fall_are_gravity_and_of_a_shift_nothing(rising: Motion) -> None:
    q = np.repeat(rising.q[:1], 60, axis=0)
    times = np.arange(60) / 50.0
    falling = q.copy()
    falling[:, 2] -= 0.5 * 9.81 * times**2
    found = accelerations(replace(rising, q=falling, rate=50.0, torques=None))
    np.testing.assert_allclose(found, np.tile([0.0, 0.0, -9.81], (50, 1)), atol=1e-9)
    gliding = q.copy()
    gliding[:, 0] += 0.3 * times
    assert abs(accelerations(replace(rising, q=gliding, rate=50.0, torques=None))).max() < 1e-9


def test_pieces_tell_where_an_execution_left_its_reference(rising: Motion) -> None:
    same = pieces_of(rising, rising, 0.5)
    assert len(same) >= 2
    assert max(piece.deviation for piece in same) < 1e-9
    shaken = rising.q.copy()
    half = len(shaken) // 2
    times = np.arange(len(shaken) - half) / rising.rate
    shaken[half:, 0] += 0.02 * np.sin(2.0 * np.pi * times)
    off = [piece.deviation for piece in pieces_of(rising, replace(rising, q=shaken), 0.5)]
    assert off[0] < 1e-9
    assert off[-1] > 0.1


@pytest.mark.long
def test_correlations_are_those_of_ranks() -> None:
    rng = np.random.default_rng(3)
    off = rng.permutation(12).astype(float)
    pieces = [Piece("made", 0.0, np.exp(x), -x, x) for x in off]
    impossible, residual, acceleration = foretell(pieces)
    assert np.isnan(impossible.correlation)
    assert residual[1:] == pytest.approx((1.0, 1.0, 1.0))
    assert acceleration[1:] == pytest.approx((-1.0, -1.0, -1.0))
    noise = [Piece("made", *rng.normal(size=4)) for _ in range(40)]
    for one in foretell(noise):
        assert one.low < one.correlation < one.high
        assert one.low < 0.35
        assert one.high > -0.35


def test_the_command_wants_pairs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["foretelling", "only.csv"])
    with pytest.raises(SystemExit, match="2"):
        main()
    assert "each reference needs its execution" in capsys.readouterr().err
