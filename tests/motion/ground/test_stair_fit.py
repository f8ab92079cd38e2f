"""A flight of stairs fitted to scans: edges and heights to millimetres, against those they were cast on."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.base.spatial import rotation_about
from surefoot.mechanics.terrain import StairsTerrain
from surefoot.motion.ground import elevation_kernels as kernels
from surefoot.motion.ground.stair_fit import StairFit, StairSteps

Z = np.array([0.0, 0.0, 1.0])


def _cast(stairs: StairsTerrain, origin: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Return how far rays go to the nearest tread or riser of ten steps that begin at x = 0: (k,) [m]."""
    numbers = np.arange(11)
    levels, edges = stairs.rise * numbers, stairs.tread * (numbers - 1)
    edges[0], ends = -np.inf, np.append(stairs.tread * numbers[:-1], np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        down = (levels - origin[2]) / rays[:, 2:]
        x = origin[0] + down * rays[:, :1]
        down = np.where((down > 0.0) & (x >= edges) & (x < ends), down, np.inf)
        ahead = (ends[:-1] - origin[0]) / rays[:, :1]
        z = origin[2] + ahead * rays[:, 2:]
        between = (z > np.minimum(levels[:-1], levels[1:])) & (z < np.maximum(levels[:-1], levels[1:]))
        ahead = np.where((ahead > 0.0) & between, ahead, np.inf)
    found = np.minimum(down.min(axis=1), ahead.min(axis=1))
    return np.asarray(np.where(found < 2.0, found, np.inf))


def _scan(
    ground: StairsTerrain, origin: np.ndarray, yaw: float, pitch: float, tilt: float, rng: np.random.Generator
) -> np.ndarray:
    """Return what a sensor tells that looks down by a pitch [deg], mounted off by a tilt [rad]."""
    across, along = np.radians(rng.uniform(-50, 50, 1700)), np.radians(rng.uniform(-40, 40, 1700))
    rays = np.column_stack([np.cos(along) * np.cos(across), np.cos(along) * np.sin(across), -np.sin(along)])
    told = rotation_about(Z, yaw) @ rotation_about(np.array([0.0, 1.0, 0.0]), math.radians(pitch))
    true = told @ rotation_about(np.array([0.0, 1.0, 0.0]), tilt)
    distance = _cast(ground, origin, rays @ true.T)
    seen = np.isfinite(distance) & (rng.random(1700) > 0.05)
    length = distance * (1.0 + 0.01 * rng.normal(size=1700))
    length = np.where(rng.random(1700) < 0.003, 2.0 * rng.random(1700), length)
    return np.asarray(origin + length[seen, None] * (rays[seen] @ told.T))


def _walk(
    stairs: StairsTerrain, steps: StairSteps, heading: float, seed: int, tilt: float = 0.0
) -> tuple[StairFit, float]:
    """Return a fit that begins with rough steps after a walk onto the stairs, and where it ended along x."""
    rng = np.random.default_rng(seed)
    along = np.array([math.cos(heading), math.sin(heading)])
    fit = StairFit(along, 0.02, 0.01, steps, np.zeros(2))
    x = 0.0
    for k in range(25):
        x = -0.5 + 0.03 * k
        origin = np.array([x, 0.1, float(stairs.height([x - 0.3, 0.0])) + 0.45])
        fit.pass_time(1.0 / 15.0)
        fit.see(origin, _scan(stairs, origin, heading, 45.0, tilt, rng))
    return fit, x


@pytest.mark.parametrize(
    ("rise", "tread"), [(0.12, 0.3), (-0.12, 0.3), (-0.1, 0.28), (0.16, 0.28), (-0.08, 0.35)]
)
@pytest.mark.parametrize("seed", range(2))
def test_edges_and_levels_are_found_to_millimetres(rise: float, tread: float, seed: int) -> None:
    stairs = StairsTerrain(rise, tread)
    fit, x = _walk(stairs, StairSteps(1.1 * rise, 1.05 * tread), 0.03, seed)
    assert fit.known
    assert fit.first == 0
    assert fit.last >= 2
    assert fit.tread == pytest.approx(tread, abs=0.003)
    assert fit.rise == pytest.approx(rise, abs=0.004)
    flight = fit.parameters()
    level, _ = _height(flight, x + 0.5 * tread)
    assert level == pytest.approx(float(stairs.height([x + 0.5 * tread, 0.0])), abs=0.006)
    for k in range(2):  # the edge that it is at the place of the middle
        edge = _edge(flight, k)
        assert edge == pytest.approx(k * tread, abs=0.006)


def test_an_error_of_the_mounting_moves_edges_by_its_lever_alone() -> None:
    tilt = 0.01
    fit, _ = _walk(StairsTerrain(-0.12, 0.3), StairSteps(-0.12, 0.3), 0.0, 0, tilt)
    nearest = _edge(fit.parameters(), 0)
    assert abs(nearest) < 1.5 * tilt * 0.6  # seen last from 0.45 m above and 0.2 m before it


def _edge(flight: np.ndarray, number: int) -> float:
    """Return where an edge crosses the line y = 0, by bisection on the heights."""
    x = np.linspace(-0.5, 3.0, 35001)
    heights = kernels.stair_heights(
        np.full(len(x), np.nan), x > np.inf, np.column_stack([x, 0.0 * x]), flight
    )[0]
    jumps = np.flatnonzero(np.abs(np.diff(heights)) > 0.5 * abs(flight[7]))
    return float(x[jumps[number]])


def _height(flight: np.ndarray, x: float) -> tuple[float, bool]:
    out, own = kernels.stair_heights(np.zeros(1), np.zeros(1, dtype=bool), np.array([[x, 0.0]]), flight)
    return float(out[0]), bool(own[0])


def test_feet_tell_the_heights() -> None:
    fit, _ = _walk(StairsTerrain(-0.12, 0.3), StairSteps(-0.12, 0.3), 0.0, 1)
    before = fit.parameters()
    for _ in range(4):
        fit.touch(np.array([0.2, 0.1, -0.12 + 0.008]))
    after = fit.parameters()
    assert after[6] + after[7] == pytest.approx(-0.112, abs=0.003)
    for beside in ([0.005, 0.0, -0.2], [5.0, 0.0, 0.0], [0.2, 0.0, 0.3]):  # an edge, elsewhere, far above
        fit.touch(np.array(beside))
    assert fit.parameters() == pytest.approx(after)
    assert before[3:6] == pytest.approx(after[3:6])


@pytest.mark.parametrize("moved", [0.15, 0.0])
def test_stairs_that_are_gone_are_lost(moved: float) -> None:
    stairs = StairsTerrain(0.12, 0.3)
    fit, _ = _walk(stairs, StairSteps(0.12, 0.3), 0.0, 0)
    rng, origin = np.random.default_rng(0), np.array([0.25, 0.0, 0.65])
    for _ in range(20):
        fit.see(origin, _scan(stairs, origin, 0.0, 45.0, 0.0, rng) + np.array([moved, 0.0, 0.0]))
    assert fit.lost == (moved > 0.0)


@pytest.mark.parametrize("seed", range(4))
def test_heights_on_a_flight_are_those_of_its_steps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angle, turn = rng.uniform(-3.0, 3.0), rng.uniform(-0.05, 0.05)
    flight = np.array([math.cos(angle), math.sin(angle), 0.2, 0.7, 0.3, turn, 0.05, -0.12, 1.0, 4.0])
    xy, seen = rng.uniform(-3.0, 3.0, (500, 2)), rng.uniform(-1.0, 0.2, 500)
    known = rng.random(500) < 0.7
    out, own = kernels.stair_heights(seen, known, xy, flight)
    s, w = xy @ flight[:2], xy @ [-flight[1], flight[0]] - 0.2
    share = (s - turn * w - 0.7) / 0.3
    on = (share > 1.0 - kernels.FLIGHT_ENDS) & (share < 4.0 + kernels.FLIGHT_ENDS)
    level = 0.05 - 0.12 * (1.0 + sum((share >= k).astype(float) for k in range(1, 5)))
    near = np.abs(share[:, None] - np.arange(1, 5)).min(axis=1) < kernels.FLIGHT_EDGE
    agrees = np.abs(seen - level) < 0.06
    assert (own == (on & (near | agrees | ~known))).all()
    assert out == pytest.approx(np.where(own, level, seen))
    assert 20 < own.sum() < 300
