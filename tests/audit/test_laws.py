from __future__ import annotations

import numpy as np
import pytest

from surefoot.audit import check_laws, contact_use
from surefoot.audit.laws import LEAST_FRICTION

WEIGHT = 100.0


def still(
    force: list[float], gap: float = 0.0, velocity: tuple[float, ...] = (0.0, 0.0, 0.0), mu: float = 0.5
):
    return check_laws([[force]], [[gap]], [[velocity]], [mu], WEIGHT)


def test_a_lawful_contact_breaks_nothing() -> None:
    laws = still([10.0, 0.0, 50.0], gap=-1e-5)
    assert laws.broken(WEIGHT) == []
    assert laws.cone_use_max == pytest.approx(0.4)
    assert laws.penetration_max == pytest.approx(1e-5)
    assert laws.complementarity_max == pytest.approx(5e-4)


@pytest.mark.parametrize(
    ("force", "gap", "said"),
    [
        ([0.0, 0.0, 50.0], -5e-3, "penetration of 5.00 mm"),
        ([0.0, 0.0, -1.0], 0.0, "a pull of 1 N"),
        ([30.0, 0.0, 50.0], 0.0, "1.200 times the friction"),
        ([0.0, 0.0, 50.0], 0.01, "force across a gap: 0.5 N m"),
    ],
)
def test_each_broken_law_is_named(force: list[float], gap: float, said: str) -> None:
    assert any(said in line for line in still(force, gap).broken(WEIGHT))


def test_dissipation_compares_friction_with_the_slip() -> None:
    assert still([-25.0, 0.0, 50.0], velocity=(0.3, 0.0, 0.0)).dissipation_max == pytest.approx(
        0.0, abs=1e-12
    )
    # friction at a right angle to the slip dissipates nothing: all of mu f_n is missing
    assert still([0.0, 25.0, 50.0], velocity=(0.3, 0.0, 0.0)).dissipation_max == pytest.approx(0.25)
    assert still([0.0, 25.0, 50.0], velocity=(1e-3, 0.0, 0.0)).dissipation_max == 0.0  # sticks


def test_cone_use_ignores_unloaded_contacts_and_knows_ice() -> None:
    forces = np.array([[[1.0, 0.0, 0.05], [3.0, 4.0, 20.0]]])
    np.testing.assert_allclose(contact_use(forces, [0.5], 0.1), [[0.0, 0.5]])
    np.testing.assert_allclose(contact_use(forces, [0.0], 0.1)[0, 1], 5.0 / (20.0 * LEAST_FRICTION))


def test_no_contacts_at_all() -> None:
    laws = check_laws(np.zeros((0, 4, 3)), np.zeros((0, 4)), np.zeros((0, 4, 3)), np.zeros(0), WEIGHT)
    assert laws.broken(WEIGHT) == []
