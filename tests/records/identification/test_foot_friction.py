"""Friction under each foot: bounds of made-up forces, and of a walk on ground that it slips on."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from benchmarks.friction_walks import slippery_walk, slipping_walk
from surefoot.base.errors import ProblemError
from surefoot.records.identification.foot_friction import (
    FootFriction,
    friction_of_feet,
    friction_of_walk,
)
from surefoot.records.identification.walk_forces import WalkForces
from surefoot.records.identification.walk_motion import WalkRows

DT, ROWS, MU = 0.001, 2000, 0.4


def made_rows(robot: sf.Robot, sliding: np.ndarray) -> WalkRows:
    """Rows in which every foot stands, or slides along x at 0.2 m/s where `sliding` (T,) says so."""
    points, nv = robot.contact_points, int(robot.model.nv)
    levers = np.zeros((ROWS, len(points), 3, nv))
    levers[:, :, :, :3] = np.eye(3)
    v = np.zeros((ROWS, nv))
    v[sliding, 0] = 0.2
    empty = np.zeros((ROWS, nv))
    return WalkRows(
        v, empty, np.zeros((ROWS, robot.joints)), empty, np.zeros((ROWS, 6, 10)), levers,
        np.tile(np.eye(3), (ROWS, len(points), 1, 1)), np.zeros((ROWS, len(points)), dtype=bool),
    )  # fmt: skip


def bounds(use: np.ndarray, sliding: np.ndarray, off: float = 0.5, against: float = -1.0) -> FootFriction:
    """The interval of feet that bear 40 N, use (T,) friction, by forces that are `off` [N]."""
    robot = sf.load_robot("go2")
    rows = made_rows(robot, sliding)
    forces = np.zeros((ROWS, len(robot.feet), 3))
    forces[:, :, 0], forces[:, :, 2] = against * 40.0 * use[:, None], 40.0
    open_left, scales = (np.broadcast_to(size**2 * np.eye(3), (*forces.shape, 3)) for size in (off, 0.6))
    pushed = WalkForces(forces, open_left, scales)
    steady = np.ones(ROWS, dtype=bool)
    feet, ground = friction_of_feet(robot, rows, pushed, steady, DT)
    assert ground.slips == sum(foot.slips for foot in feet)
    assert ground.low >= feet[0].low - 1e-12
    return feet[0]


def slides(count: int) -> np.ndarray:
    """(T,) so many slides of 60 ms, 100 ms apart."""
    return np.asarray((np.arange(ROWS) % 160 < 60) & (np.arange(ROWS) < 160 * count))


def test_a_foot_that_stands_bounds_friction_below_only() -> None:
    found = bounds(np.full(ROWS, 0.3), np.zeros(ROWS, dtype=bool))
    assert math.isinf(found.high)
    assert found.slips == 0
    assert 0.2 < found.low < 0.3
    assert str(found).startswith("FL_foot: mu above 0.2")


def test_slides_tell_friction_and_few_of_them_do_not() -> None:
    random = np.random.default_rng(0)
    use = np.where(slides(12), MU, 0.2) + 0.02 * random.normal(size=ROWS)
    found = bounds(use, slides(12))
    assert found.slips == 12
    assert found.low < MU < found.high
    assert found.high - found.low < 0.2
    assert math.isinf(bounds(use, slides(3)).high)


def test_forces_that_are_badly_known_bound_nothing() -> None:
    """A landing whose forces look like more than there is, and leave much of the motion unexplained."""
    assert bounds(np.full(ROWS, 0.9), np.zeros(ROWS, dtype=bool), off=40.0).low == 0.0


def test_a_foot_whose_friction_does_not_oppose_its_motion_does_not_slide() -> None:
    """An estimated base that drifts moves standing feet: they use less than there is."""
    use = np.where(slides(12), 0.1, 0.2)
    for against in (1.0, 0.0):
        found = bounds(use, slides(12), against=against)
        assert found.slips == 0
        assert math.isinf(found.high)


def test_a_few_slides_of_other_use_are_outvoted() -> None:
    use = np.where(slides(12), np.where(np.arange(ROWS) < 400, 0.15, MU), 0.1)
    found = bounds(use, slides(12))
    assert found.low < MU < found.high
    assert found.high - found.low < 0.2


@pytest.mark.long
@pytest.mark.parametrize("seed", [3, 6])
def test_feet_that_slip_ten_times_tell_friction(seed: int) -> None:
    """Pushed every second; with forces of all equations alike, a quarter of such feet missed the truth."""
    log, mu = slippery_walk(seed)
    found = friction_of_walk(sf.load_robot("go2"), log)
    assert all(foot.low <= mu <= foot.high for foot in found)
    assert all(foot.high - foot.low < 0.2 for foot in found if foot.slips >= 10)
    assert sum(foot.slips for foot in found) > 10


@pytest.mark.long
def test_a_walk_that_slips_on_a_slippery_floor() -> None:
    log, mu = slipping_walk(29)
    robot = sf.load_robot("go2")
    found = friction_of_walk(robot, log)
    assert all(foot.low <= mu <= foot.high for foot in found)
    assert any(math.isfinite(foot.high) for foot in found)
    nothing = friction_of_walk(robot, log, np.zeros(len(log), dtype=bool))
    assert all(foot.low == 0.0 and math.isinf(foot.high) for foot in nothing)


def test_what_tells_nothing_is_refused() -> None:
    robot = sf.load_robot("go2")
    arrays = {"time": DT * np.arange(100), "q": np.tile(robot.nominal, (100, 1)), "v": np.zeros((100, 18))}
    with pytest.raises(ProblemError, match="no torques"):
        friction_of_walk(robot, sf.Log(arrays, {"dt": DT}))
    arrays["torques"] = np.zeros((100, 12))
    with pytest.raises(ProblemError, match=r"0\.6 s, the log has 0\.1 s"):
        friction_of_walk(robot, sf.Log(arrays, {"dt": DT}))
