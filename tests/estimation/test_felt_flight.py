"""Steps from strikes and stands of feet: what is felt is known, what is not is guessed, and they end."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.estimation.felt_flight import ONWARD, FeltFlight
from surefoot.terrain import StairsTerrain

ALONG = np.array([1.0, 0.0])


def felt(rise: float = 0.12, tread: float = 0.3) -> FeltFlight:
    """Return a flight from x = 0 whose rise and tread have been felt."""
    flight = FeltFlight(ALONG, 0.0, 0.0, 0.14, 0.27)
    flight.stand(0.1, rise)
    assert flight.strike(tread)
    return flight


def test_before_a_second_riser_is_felt_the_first_tread_has_no_end() -> None:
    flight = FeltFlight(ALONG, 0.5, 0.2, 0.14, 0.27)
    assert flight.height([0.49, 0.51, 5.0]) == pytest.approx([0.2, 0.34, 0.34])
    flight.stand(0.6, 0.29)
    assert (flight.rise_known, flight.tread_known) == (True, False)
    assert flight.height([0.49, 0.51, 5.0]) == pytest.approx([0.2, 0.29, 0.29])


@pytest.mark.parametrize(("rise", "tread"), [(0.08, 0.3), (0.12, 0.25), (0.15, 0.4)])
def test_what_is_felt_is_the_terrain(rise: float, tread: float) -> None:
    flight, stairs = felt(rise, tread), StairsTerrain(rise, tread)
    x = np.linspace(-0.5, ONWARD * tread, 200)
    assert flight.height(x) == pytest.approx(stairs.height(np.column_stack([x, 0.0 * x])))


@pytest.mark.parametrize("seed", [0, 1])
def test_noisy_strikes_and_stands_are_averaged(seed: int) -> None:
    r, rise, tread = np.random.default_rng(seed), 0.11, 0.28
    flight = FeltFlight(ALONG, float(r.normal(0.0, 0.005)), float(r.normal(0.0, 0.003)), 0.14, 0.3)
    for number in range(8):
        flight.pass_time(0.4)
        assert flight.strike(number * tread + float(r.normal(0.0, 0.005)))
        flight.stand((number + 0.5) * tread, (number + 1) * rise + float(r.normal(0.0, 0.002)))
    assert [flight.edge(k) for k in range(8)] == pytest.approx([k * tread for k in range(8)], abs=0.008)
    assert flight.rise == pytest.approx(rise, abs=0.001)
    assert flight.misses == 0


def test_a_strike_far_from_every_riser_is_none() -> None:
    flight = felt()
    assert not flight.strike(0.45)
    assert flight.strike(0.61)
    before = flight.edge(2)
    assert not flight.strike(-0.1)
    assert flight.edge(2) == before
    unknown = FeltFlight(ALONG, 0.0, 0.0, 0.14, 0.27)
    assert not unknown.strike(0.1)  # no tread is that short
    assert not unknown.tread_known


def test_a_foot_one_step_too_low_has_found_the_end() -> None:
    flight = felt()
    for number in range(1, 4):
        flight.stand(0.3 * number - 0.15, 0.12 * number)
    assert not flight.ended
    flight.stand(1.05, 0.36)  # the fourth tread should be at 0.48
    assert flight.ended
    assert flight.height([0.85, 1.05, 9.0]) == pytest.approx([0.36, 0.36, 0.36], abs=0.005)
    flight.stand(2.0, 0.36)
    assert (flight.last, flight.misses) == (2, 0)


def test_a_foot_one_step_too_high_has_passed_a_riser() -> None:
    flight = FeltFlight(ALONG, 0.0, 0.0, 0.14, 0.27)
    flight.stand(0.1, 0.1)
    flight.stand(0.35, 0.2)
    assert flight.tread_known
    assert flight.tread == pytest.approx(0.35)


def test_stands_that_fit_nothing_are_counted() -> None:
    flight = felt()
    flight.stand(0.45, 0.18)
    flight.stand(0.45, 0.18)
    assert flight.misses == 2
    flight.stand(0.45, 0.24)
    assert flight.misses == 0


def test_a_rise_that_was_told_by_a_false_landing_is_told_anew() -> None:
    flight = FeltFlight(ALONG, 0.0, 0.0, 0.14, 0.27)
    flight.stand(0.1, 0.145)  # a leg that braked in the air
    flight.stand(0.12, 0.05)
    assert flight.rise == pytest.approx(0.05)
    flight.stand(0.15, 0.052)
    assert flight.rise == pytest.approx(0.051, abs=1e-3)
    flight.stand(0.2, 0.01)  # two have told it by now
    assert flight.misses == 1
    assert flight.rise == pytest.approx(0.051, abs=1e-3)
