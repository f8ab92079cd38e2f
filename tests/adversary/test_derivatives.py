"""Derivatives hold against 50-digit references, and at kinks against one-sided differences.

A sample; `python tests/adversary/hunt_derivatives.py --count 500` is the whole.
"""

from __future__ import annotations

from itertools import count, islice

import numpy as np
import pytest
from hunt_derivatives import Comparison, compare
from kink_problems import kinky, moved

import surefoot as sf
from surefoot.contact.derivative.solution_derivative import ContactDerivative

SAMPLE = 60


@pytest.fixture(scope="module")
def sample() -> list[Comparison]:
    """The first comparisons of the hunt."""
    return list(islice((one for one in map(compare, count()) if one is not None), SAMPLE))


def test_derivatives_are_those_of_fifty_digits(sample: list[Comparison]) -> None:
    assert [one for one in sample if one.wrong] == []


def test_the_sample_has_every_kind(sample: list[Comparison]) -> None:
    modes = {mode for one in sample for mode in one.modes}
    assert {"open", "stick", "slide", "bilateral"} <= modes
    assert {"slide at normal_min", "stick at normal_max"} <= modes
    assert max(one.contacts for one in sample) == 12
    assert sum(one.forces is None for one in sample) >= 5  # redundant ones


@pytest.mark.parametrize("seed", range(60))
def test_one_sided_derivatives_at_kinks(seed: int) -> None:
    rng = np.random.default_rng([5, seed])
    arguments, forces, rates = kinky(rng, int(rng.integers(1, 5)))
    problem = sf.ContactProblem(**arguments)
    solution = sf.solve(problem, warm_start=forces)
    d = ContactDerivative(problem, solution.forces, solution.velocities)
    found = d.jvp(**rates)
    assert found.settled
    gaps = []
    for step in (1e-5, 1e-6):
        after = sf.solve(
            sf.ContactProblem(**moved(arguments, rates, step)),
            tol=1e-13,
            warm_start=d.forces + step * found.forces,
        )
        scale = max(1.0, float(np.abs(found.forces).max()))
        gaps.append(float(np.abs((after.forces - d.forces) / step - found.forces).max()) / scale)
    assert gaps[1] < 2e-4
    assert gaps[1] < 0.3 * gaps[0] + 1e-7  # and the gap shrinks with the step


def test_jumps_are_flagged() -> None:
    """A sliding contact that would have to stick and a sticking one that would have to slide: neither can."""
    mu, c = 2.0, 1.0
    # one contact, normal and tangent so coupled that pushing it harder lifts its slip (Painlevé's matrix)
    G = np.array([[4.0, 0.0, 3.0], [0.0, 1.0, 0.0], [3.0, 0.0, 2.5]])
    forces = np.array([[-mu * c, 0.0, c]])
    problem = sf.ContactProblem(G, -(G @ forces[0]), mu)
    assert sf.residuals(problem, forces).worst < 1e-12
    d = ContactDerivative(problem, forces, np.zeros((1, 3)))
    assert d.kinks[0].modes == ("stick", "slide")
    ways = [d.jvp(g=sign * e) for e in np.eye(3) for sign in (1.0, -1.0)]
    assert not all(way.settled for way in ways)
    assert all(np.isfinite(way.forces).all() for way in ways)
