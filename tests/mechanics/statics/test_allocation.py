"""The wrench of a standing robot shared among its feet: carried, within cones, parallel where it can be."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.contact import Status
from surefoot.mechanics.stance import PointContact, Stance
from surefoot.mechanics.statics.allocation import ExactAllocation

FEET = [(x, y, 0.0) for x in (0.2, -0.2) for y in (0.15, -0.15)]
MU, WEIGHT = 0.6, 120.0
MAP = Stance([PointContact(p, mu=MU) for p in FEET]).grasp_map([0.0, 0.0, 0.3])
LOW, HIGH = np.zeros(4), np.full(4, 200.0)


def allocation() -> ExactAllocation:
    return ExactAllocation(np.full(4, MU), np.ones(6), 1e-6)


def use(forces: np.ndarray) -> np.ndarray:
    """Return the share of its friction that each loaded foot uses."""
    return np.asarray(np.linalg.norm(forces[:, :2], axis=1) / (MU * forces[:, 2]))


def test_feet_share_their_friction_alike() -> None:
    """A pull forwards on a body that leans: feet with little weight pull little, each by the same share."""
    wrench, shared = np.array([20.0, 5.0, WEIGHT, 3.0, -8.0, 0.0]), allocation()
    for _ in range(30):
        forces = shared.share(MAP, wrench, LOW, HIGH)
    assert shared.status is Status.SOLVED
    np.testing.assert_allclose(MAP @ forces.ravel(), wrench, atol=1e-2)
    assert np.ptp(forces[:, 2]) > 9.0
    np.testing.assert_allclose(use(forces), np.hypot(20.0, 5.0) / (MU * WEIGHT), rtol=0.05)


@pytest.mark.parametrize("resumed", [False, True])
def test_a_foot_that_is_lifted_leaves_its_load_to_the_others(resumed: bool) -> None:
    """Three feet carry the weight in one way only: a body over the middle hangs on one diagonal."""
    shared, wrench = allocation(), np.array([0.0, 0.0, WEIGHT, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(shared.share(MAP, wrench, LOW, HIGH)[:, 2], 0.25 * WEIGHT, atol=0.01)
    if resumed:
        later = allocation()
        later.resume(shared.remembered())
        shared = later
    lifted = HIGH.copy()
    lifted[0] = 0.0
    forces = shared.share(MAP, wrench, LOW, lifted)
    np.testing.assert_allclose(forces[:, 2], [0.0, 0.5 * WEIGHT, 0.5 * WEIGHT, 0.0], atol=0.05)
    back = shared.share(MAP, wrench, LOW, HIGH)
    np.testing.assert_allclose(back[:, 2], 0.25 * WEIGHT, atol=0.01)


def test_the_last_tenth_of_friction_is_for_what_needs_it() -> None:
    shared = allocation()
    for pull, most in ((0.85, 0.9), (0.97, 1.0), (1.5, 1.0)):
        wrench = np.array([pull * MU * WEIGHT, 0.0, WEIGHT, 0.0, 0.0, 0.0])
        wrench[4] = -0.3 * wrench[0]  # the pull is at the ground's height: no moment lifts the front
        forces = shared.share(MAP, wrench, LOW, HIGH)
        assert use(forces).max() <= most + 1e-9
        if pull < 1.0:
            assert forces[:, 0].sum() == pytest.approx(wrench[0], rel=0.02)
        else:
            assert use(forces) == pytest.approx(1.0)  # all that there is


def test_after_numbers_that_are_none_the_last_command_holds() -> None:
    shared, wrench = allocation(), np.array([10.0, 0.0, WEIGHT, 0.0, -3.0, 0.0])
    last = shared.share(MAP, wrench, LOW, HIGH)
    held = shared.share(MAP, np.full(6, np.nan), LOW, HIGH)
    assert shared.status is Status.INVALID
    np.testing.assert_allclose(held, last, atol=1e-9)
    shared.reset()
    assert shared.status is Status.SOLVED
    np.testing.assert_allclose(
        shared.share(MAP, wrench, LOW, HIGH), allocation().share(MAP, wrench, LOW, HIGH)
    )
