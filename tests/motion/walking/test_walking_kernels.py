"""The compiled pieces of the walking controller against plain NumPy and SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from surefoot.motion.walking import walking_kernels as kernels
from surefoot.motion.walking.foot_phases import FOOT, FootPhase, swing_accelerations, swing_paths
from surefoot.motion.walking.foothold import step_place
from surefoot.motion.walking.swing import swing_motion

SEEDS = range(4)


def turned(vectors: np.ndarray, yaw: float) -> np.ndarray:
    """Return (..., 2) vectors turned by a heading."""
    c, s = np.cos(yaw), np.sin(yaw)
    return vectors @ np.array([[c, s], [-s, c]])


@pytest.mark.parametrize("fastest", [math.inf, 0.06])
@pytest.mark.parametrize("seed", SEEDS)
def test_feet_in_the_air_follow_their_paths(seed: int, fastest: float) -> None:
    rng = np.random.default_rng(seed)
    ends, centres, twists = rng.normal(size=(2, 3, 3)), rng.normal(size=(3, 3)), rng.normal(size=(3, 6))
    timing = np.array(
        [[2.0, 0.3, 0.2, 0.1, -1.0, 0.95], [2.0, 1.2, 0.2, 0.1, 0.04, 0.85], [2.0, 0.5, 0.2, 0.1, -1.0, 0.9]]
    )
    flying, now = np.array([True, True, False]), 1.0
    feet = np.zeros(3, dtype=FOOT)
    feet["phase"] = FootPhase.SWING, FootPhase.SEARCHING, FootPhase.STANCE
    feet["start"], feet["target"] = ends
    feet["apex"], feet["share"], feet["duration"], feet["lift_first"], _, feet["sink_from"] = timing.T
    feet["search_from"] = now - 0.04
    out = swing_accelerations(feet, now, 0.1, 3.0, fastest, centres, twists, 400.0, 40.0)
    for k in range(3):
        apex, share, duration, lift, late, down = timing[k]
        path = swing_motion(ends[0, k], ends[1, k], apex, share, duration, 0.1, lift, down)
        if late >= 0.0:
            ramp = min(late, fastest / 3.0)  # then on at the largest speed
            path[:, 2] -= [1.5 * ramp**2 + 3.0 * ramp * (late - ramp), 3.0 * ramp, 3.0 * (ramp == late)]
        assert swing_paths(feet, now, 0.1, 3.0, fastest)[k] == pytest.approx(path * flying[k])
        wanted = path[2] + 400.0 * (path[0] - centres[k]) + 40.0 * (path[1] - twists[k, :3])
        assert out[k, :3] == pytest.approx(wanted * flying[k])
    assert (out[:, 3:] == 0.0).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_feet_stand_where_they_are_until_they_have_flown(seed: int) -> None:
    rng = np.random.default_rng(seed)
    contacts = np.array([[1, 1, 0], [0, 1, 1], [1, 1, 0], [1, 1, 1]], dtype=bool)
    stance = contacts[0]
    stands, target, com = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), rng.normal(size=(5, 3))
    frames, radii = Rotation.random(3, rng=rng).as_matrix(), np.array([0.02, 0.03, 0.04])
    yaw, offsets = rng.normal(size=5), rng.normal(size=(3, 3))
    arms = kernels.turned_arms(offsets, yaw)
    assert arms == pytest.approx(np.array([turned(offsets[:, :2], a) for a in yaw]))
    ground, middle, slope = 0.3, rng.normal(size=3), rng.normal(size=2)
    out = kernels.stance_places(
        contacts, stance, stands, target, frames, radii, com, arms, 1, ground, middle, slope
    )

    def coming(i: int, k: int) -> np.ndarray:
        xy = com[i + 1, :2] + arms[i + 1, k]
        return np.array([*xy, ground + (xy - middle[:2]) @ slope])

    landing = target[2] - radii[2] * frames[2, :, 2]
    wanted = np.array(
        [
            [stands[0], stands[1], landing],
            [stands[0], stands[1], landing],
            [coming(2, 0), stands[1], landing],
            [coming(2, 0), stands[1], coming(3, 2)],
        ]
    )
    assert out == pytest.approx(wanted)


@pytest.mark.parametrize("turn", [0.0, 0.8])
def test_a_step_goes_where_raibert_puts_it_about_the_coming_hip(turn: float) -> None:
    com, v, arm = np.array([0.1, 0.2, 0.3]), np.array([0.5, -0.1, 0.0]), np.array([0.2, 0.15, -0.3])
    wanted, left, yaw = np.array([0.6, 0.1, turn]), 0.12, 0.4
    flow, hip = turned(wanted[:2], yaw + turn * left), turned(arm[:2], yaw + turn * left)
    place = com[:2] + left * flow + hip + 0.1 * flow + math.sqrt(0.3 / 9.81) * (v[:2] - flow)
    place += 0.5 * 0.3 / 9.81 * turn * np.array([flow[1], -flow[0]])
    place += 0.1 * turn * np.array([-hip[1], hip[0]])
    assert step_place(com, v, arm, yaw, wanted, left, 0.3, 0.2) == pytest.approx(place)
