"""The filter of a flight of stairs by hand: corrections, drift, edges that are there, feet on treads."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from surefoot.motion.ground.stair_fit import StairFit, StairSteps, correct, parting

RIGHT = np.array([1.0, 0.0])


def flight(along: Any = RIGHT, rise: float = 0.2, place: Any = (0.0, 0.0)) -> StairFit:
    """Return a fit whose edge 0 is at 0.5 m and whose treads are 0.4 m deep, from a level of 0.1 m."""
    return StairFit(np.array(along), 0.5, 0.1, StairSteps(rise, 0.4), np.array(place))


def test_a_state_is_corrected_by_the_gain_of_kalman() -> None:
    """Of variances 4 and 1 a sum of 3 is measured as 5 with a variance of 5: gains 0.4 and 0.1."""
    x, P = np.array([1.0, 2.0]), np.diag([4.0, 1.0])
    assert correct(x, P, np.ones(2), 5.0, 5.0)
    np.testing.assert_allclose(x, [1.8, 2.2])
    np.testing.assert_allclose(P, [[2.4, -0.4], [-0.4, 0.9]])


def test_a_covariance_stays_symmetric() -> None:
    P = np.array([[4.0, 1e-9], [0.0, 1.0]])
    assert correct(np.zeros(2), P, np.ones(2), 0.0, 5.0)
    assert P[0, 1] == P[1, 0]


@pytest.mark.parametrize(("miss", "taken"), [(9.4, True), (-9.4, True), (9.5, False), (-9.5, False)])
def test_what_is_off_by_three_standard_deviations_is_left_out(miss: float, taken: bool) -> None:
    """Of a variance of 4 + 1 + 5: 9.49."""
    x, P = np.array([1.0, 2.0]), np.diag([4.0, 1.0])
    assert correct(x, P, np.ones(2), 3.0 + miss, 5.0) is taken
    assert (x.tolist() == [1.0, 2.0]) is not taken
    assert (P.tolist() == [[4.0, 0.0], [0.0, 1.0]]) is not taken


@pytest.mark.parametrize(
    ("before", "after", "number"),
    [
        ([0.0, 0.1], [0.3, 0.4], 0.2), ([0.0, 0.1, 0.2, 0.7], [0.3, 0.4, 0.5], 0.25),
        ([0.4, 0.5], [0.0, 0.1], 0.25), ([0.0, 0.2], [0.1, 0.3], 0.15), ([0.0], [1.0, 0.6, -0.4], -0.05),
    ],
)  # fmt: skip
def test_numbers_are_parted_with_the_fewest_wrong(
    before: list[float], after: list[float], number: float
) -> None:
    """Of several such partings the mean; before all numbers, the first of them."""
    assert parting(np.array(before), np.array(after)) == pytest.approx(number)


def test_a_fit_begins_as_unsure_as_its_words() -> None:
    """A tenth of a tread for the first edge, 0.06 of one for each tread."""
    fit = flight()
    assert (fit.tread, fit.rise) == (0.4, 0.2)
    assert [fit.edge(k) for k in (-1, 0, 2)] == pytest.approx([0.1, 0.5, 1.3])
    for number in (-1, 0, 3):
        expected = math.hypot(0.04, 0.024 * number)
        assert fit.deviation(number) == pytest.approx(expected, rel=1e-12)
    assert (fit.first, fit.last, fit.known, fit.lost) == (0, 0, False, False)
    along = [0.6, 0.8]
    parameters = flight(along, place=(1.0, 2.0)).parameters()
    aside = -0.8 * 1.0 + 0.6 * 2.0
    np.testing.assert_allclose(parameters, [0.6, 0.8, aside, 0.5, 0.4, 0.0, 0.1, 0.2, 0.0, 0.0])


def test_time_lets_the_flight_wander() -> None:
    """By 4 mm and treads by 0.3 mm in a second, growing with its root; heights by 6 mm and 0.3 mm."""
    fit = flight()
    fit.pass_time(4.0)
    for number in (0, 2):
        variance = 0.04**2 + 4.0 * 4e-3**2 + number**2 * (0.024**2 + 4.0 * 3e-4**2)
        assert fit.deviation(number) ** 2 == pytest.approx(variance, rel=1e-9)
    before = fit.rise
    fit.touch(np.array([0.7, 0.0, 0.31]))
    level, rise = 0.02**2 + 4.0 * 6e-3**2, 0.02**2 + 4.0 * 3e-4**2
    assert fit.rise - before == pytest.approx(rise / (level + rise + 0.003**2) * 0.01, rel=1e-9)


@pytest.mark.parametrize(
    ("s", "number"),
    [
        (0.3, 0), (0.53, None), (0.55, 1), (0.7, 1), (0.85, 1), (0.87, None), (-0.25, 0), (-0.65, 0),
        (-1.05, None), (1.1, 1), (1.5, 1), (1.9, None), (0.45, 0), (0.47, None),
    ],
)  # fmt: skip
@pytest.mark.parametrize("along", [(1.0, 0.0), (0.6, 0.8)])
def test_a_foot_tells_the_height_of_its_tread(
    s: float, number: int | None, along: tuple[float, float]
) -> None:
    """Nearer to an edge than a tenth of a tread it tells nothing; two treads beyond the edges are level.

    Of variances of 2 cm each and one of 3 mm: the ground before the edge, or the tread after it.
    """
    fit = flight(along)
    expected = 0.1 if number == 0 else 0.3
    fit.touch(np.array([s * along[0], s * along[1], expected + 0.01]))
    level, rise = fit.parameters()[6:8]
    if number is None:
        assert (level, rise) == (0.1, 0.2)
        return
    gain = 0.02**2 / ((1.0 + number) * 0.02**2 + 0.003**2)
    assert level - 0.1 == pytest.approx(gain * 0.01, rel=1e-9)
    assert rise - 0.2 == pytest.approx(number * gain * 0.01, abs=1e-12)


def points_of(fit_edges: list[float], rise: float, level: float, count: int = 8) -> np.ndarray:
    """Return points in the middle of each tread, and of the ground before and after, on both sides."""
    middles = [fit_edges[0] - 0.2, *(edge + 0.2 for edge in fit_edges)]
    out = [
        [x + 0.01 * k, 0.05 * (k - 0.5 * count), level + rise * number]
        for number, x in enumerate(middles)
        for k in range(count)
    ]
    return np.array(out)


def test_scans_that_contradict_the_treads_are_counted_until_it_is_lost() -> None:
    """Ten in turn are borne; one that agrees begins anew."""
    fit, origin = flight(), np.array([0.0, 0.0, 0.6])
    wrong, right = points_of([0.5], 0.2, 0.6), points_of([0.5], 0.2, 0.1)
    for _ in range(10):
        fit.see(origin, wrong)
    assert not fit.lost
    fit.see(origin, right)
    for _ in range(10):
        fit.see(origin, wrong)
    assert not fit.lost
    fit.see(origin, wrong)
    assert fit.lost


@pytest.mark.parametrize(("agreeing", "told"), [(10, True), (9, False)])
def test_six_in_ten_points_must_lie_on_treads(agreeing: int, told: bool) -> None:
    """Of sixteen points 9.6."""
    fit, points = flight(), points_of([0.5], 0.2, 0.102)
    points[agreeing:, 2] += 0.5
    fit.see(np.array([0.0, 0.0, 2.0]), points)
    assert bool(fit.parameters()[6] != 0.1) is told


def riser(x: float, count: int, side: float, spread: float = 0.0) -> np.ndarray:
    """Return points on a riser from 0.1 to 0.3 m, on one side of the sensor."""
    k = np.arange(count)
    return np.column_stack([x + spread * (k - 0.5 * (count - 1)), side * (0.1 + 0.01 * k), 0.2 + 0.0 * k])


@pytest.mark.parametrize(("count", "found"), [(5, True), (4, False)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_five_points_on_a_riser_are_an_edge(count: int, found: bool, side: float) -> None:
    """The median of their places, with a standard deviation of 4 mm of which eight are one."""
    fit = flight()
    fit.see(np.array([0.0, 0.0, 0.6]), riser(0.52, count, side, 1e-3))
    if not found:
        assert fit.parameters()[3] == 0.5
        return
    aside = side * (0.1 + 0.01 * 2.0)
    spread = 0.04**2 + 0.06**2 * aside**2 + 8.0 * 0.004**2
    assert fit.parameters()[3] - 0.5 == pytest.approx(0.02 * 0.04**2 / spread, rel=1e-6)
    assert fit.parameters()[5] == pytest.approx(0.02 * 0.06**2 * aside / spread, rel=1e-6)


@pytest.mark.parametrize(
    ("x", "z", "found"),
    [(0.61, 0.2, True), (0.63, 0.2, False), (0.52, 0.235, True), (0.52, 0.245, False), (0.52, 0.155, False)],
)
def test_points_far_from_an_edge_s_place_or_from_half_its_height_are_not_on_its_riser(
    x: float, z: float, found: bool
) -> None:
    """0.3 of a tread is 12 cm, 0.2 of a rise 4 cm."""
    fit = flight()
    points = riser(x, 8, 1.0)
    points[:, 2] = z
    fit.see(np.array([0.0, 0.0, 0.6]), points)
    assert bool(fit.parameters()[3] != 0.5) is found


def test_an_edge_is_there_from_four_measurements_on_and_known_within_a_centimetre() -> None:
    fit, origin = flight(), np.array([0.0, 0.0, 0.6])
    points = np.vstack([riser(0.5, 8, 1.0), riser(0.9, 8, 1.0) + np.array([0.0, 0.0, 0.2])])
    origin[2] = 0.8
    for times in range(1, 12):
        fit.see(origin, points)
        assert fit.first == 0
        if times < 4:
            assert fit.last == 0
            assert not fit.known
    assert fit.last == 1
    assert fit.known
    assert max(fit.deviation(0), fit.deviation(1)) < 0.01
    assert fit.distance_outside(np.array([0.1, 3.0])) == pytest.approx(0.4, abs=1e-3)
    assert fit.distance_outside(np.array([1.3, 3.0])) == pytest.approx(0.4, abs=1e-3)
    assert fit.distance_outside(np.array([0.7, 3.0])) == pytest.approx(-0.2, abs=1e-3)
    fit.pass_time(30.0)
    assert not fit.known
