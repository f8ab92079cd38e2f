"""The centre of pressure of flat feet, against the moments of the forces themselves."""

import numpy as np
import pytest

from surefoot.records.audit import sole_pressures
from surefoot.records.log import Log

CORNERS = np.array([[0.12, 0.03, -0.03], [0.12, -0.03, -0.03], [-0.05, 0.025, -0.03], [-0.05, -0.025, -0.03]])


def log_of(normal: np.ndarray) -> Log:
    forces = np.zeros((len(normal), 4, 3))
    forces[..., 2] = normal
    facts = {"contact_foot": [0] * 4, "contact_centres": CORNERS, "feet": ["sole"], "mass": 10.0}
    return Log({"time": np.arange(len(normal)), "forces": forces}, facts)


def test_it_is_where_the_forces_have_no_tilting_moment() -> None:
    normal = np.random.default_rng(0).uniform(0.0, 50.0, (20, 4))
    (sole,) = sole_pressures(log_of(normal))
    for f, centre in zip(normal, sole.centres, strict=True):
        arms = CORNERS[:, :2] - centre
        assert f @ arms == pytest.approx([0.0, 0.0], abs=1e-10)
    assert sole.margin > 0.0


def test_a_force_on_one_corner_leaves_no_margin() -> None:
    (sole,) = sole_pressures(log_of(np.array([[40.0, 0.0, 0.0, 0.0]])))
    assert sole.margin == pytest.approx(0.0, abs=1e-12)
    assert sole.centres[0] == pytest.approx(CORNERS[0, :2])


def test_a_foot_in_the_air_has_none() -> None:
    (sole,) = sole_pressures(log_of(np.zeros((3, 4))))
    assert np.isnan(sole.centres).all()
    assert np.isnan(sole.margin)


def test_point_feet_and_old_logs_have_none() -> None:
    log = log_of(np.ones((2, 4)))
    log.facts["contact_foot"] = [0, 1, 2, 3]
    log.facts["feet"] = list("abcd")
    assert sole_pressures(log) == []
    del log.facts["contact_centres"]
    assert sole_pressures(log) == []
