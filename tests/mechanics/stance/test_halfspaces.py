"""Stacked rows of a stance, and a standing QP that needs nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag

import surefoot as sf
from surefoot.contact.solvers.backends import ConeProgram, solve_program
from surefoot.mechanics.stance.halfspaces import HalfSpaces

FEET = np.array([[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]])
NAMES = ("FL", "FR", "RL", "RR")


def quadruped(mu: float = 0.6, normal: tuple[float, ...] = (0.0, 0.0, 1.0)) -> sf.Stance:
    """Return four feet whose normal forces are between 10 and 500 N."""
    feet = zip(FEET, NAMES, strict=True)
    return sf.Stance([sf.PointContact(p, normal, mu, name, 10.0, 500.0) for p, name in feet])


def standing_forces(stance: sf.Stance, rows: HalfSpaces, mass: float, world: bool = False) -> np.ndarray:
    """Return the smallest forces that hold the weight, by an outside QP solver."""
    G = stance.grasp_map([0.0, 0.0, 0.3])
    if world:
        G = G @ block_diag(*stance.rotations).T
    load = np.array([0.0, 0.0, mass * 9.81, 0.0, 0.0, 0.0])
    P = G.T @ G + 1e-6 * np.eye(12)
    zero = None if len(rows.E) == 0 else (rows.E, rows.e)
    program = ConeProgram.of(P, -G.T @ load, zero=zero, nonneg=(rows.A, rows.b))
    return solve_program(program, "daqp", tol=1e-9).solution()


def test_swing_feet_carry_nothing_and_stance_feet_their_least() -> None:
    pytest.importorskip("daqp")
    stance = quadruped()
    rows = stance.halfspaces(8, swing=["FR", "RL"])
    f = standing_forces(stance, rows, 15.0).reshape(4, 3)
    assert np.abs(f[1:3]).max() < 1e-9
    assert f[[0, 3], 2] == pytest.approx(np.full(2, 15.0 * 9.81 / 2.0), rel=1e-4)
    light = standing_forces(stance, stance.halfspaces(8), 2.0).reshape(
        4, 3
    )  # 4.9 N for each foot: not enough
    assert light[:, 2] == pytest.approx(np.full(4, 10.0), abs=1e-6)


@pytest.mark.parametrize("fit", ["inner", "outer"])
@pytest.mark.parametrize("facets", [3, 4, 8, 16])
def test_rows_are_the_pyramids_and_the_bounds(facets: int, fit: str) -> None:
    stance, rng = quadruped(normal=(0.0, 0.6, 0.8)), np.random.default_rng(0)
    rows = stance.halfspaces(facets, fit)
    world = stance.halfspaces(facets, fit, "world")
    assert (len(rows.A), len(rows.E)) == (4 * (facets + 2), 0)
    pyramid = sf.FrictionCone(0.6).polyhedral(facets, fit)
    seen = set()
    for _ in range(300):
        f = rng.normal(size=(4, 3)) * [30.0, 30.0, 100.0] + [0.0, 0.0, 200.0]
        inside = bool(pyramid.contains(f, 0.0).all() and (f[:, 2] >= 10.0).all() and (f[:, 2] <= 500.0).all())
        assert (rows.violation(f.ravel()) <= 0.0) == inside
        turned = np.einsum("nij,nj->ni", stance.rotations, f)
        assert world.violation(turned.ravel()) == pytest.approx(rows.violation(f.ravel()), abs=1e-9)
        seen.add(inside)
    assert seen == {True, False}


def test_rows_of_each_contact_are_where_it_says() -> None:
    sole = sf.Sole(0.2, 0.1)
    stance = sf.Stance([sf.SoleContact([0.0, 0.1, 0.0], sole, name="left"), *quadruped().contacts[:2]])
    rows = stance.halfspaces(4, swing=[False, True, False])
    assert rows.rows == (slice(0, 33), slice(0, 3), slice(33, 39))
    assert rows.swing == (False, True, False)
    assert np.array_equal(rows.A[:32, :6], sole.polyhedral(4).halfspaces)
    assert not rows.A[:33, 6:].any()
    assert not rows.A[:, 6:9].any()
    assert np.array_equal(rows.E[:, 6:9], np.eye(3))
    assert np.isfinite(rows.b).all()
    assert rows.b[-2:].tolist() == [-10.0, 500.0]


def test_the_number_of_rows_depends_on_friction_no_more_than_on_the_bounds_values() -> None:
    """A QP is set up once: other friction, other bounds, the same rows; no upper bound is no row."""
    for mu, low, high in ((0.0, 0.0, np.inf), (0.6, 0.0, np.inf), (1.5, 5.0, 90.0), (0.0, 1.0, 1.0)):
        stance = sf.Stance([sf.PointContact(p, mu=mu, normal_min=low, normal_max=high) for p in FEET])
        rows = stance.halfspaces(4)
        assert rows.A.shape == (20 if high == np.inf else 24, 12)
        assert np.isfinite(rows.b).all()
        assert rows.violation(np.zeros(12)) == low  # what is lacking, or nothing
        assert stance.two_sided(4).A.shape == (20, 12)
    assert quadruped(mu=0.0).halfspaces(4).violation(np.tile([0.1, 0.0, 100.0], 4)) > 0.0


def test_no_contacts_no_rows() -> None:
    rows = sf.Stance([]).halfspaces()
    assert rows.A.shape == (0, 0)
    assert rows.violation([]) == -np.inf


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"fit": "middle"}, "fit"),
        ({"axes": "body"}, "valid names: contact, world"),
        ({"swing": ["XX"]}, "XX"),
        ({"swing": [True, False]}, "swing must have 4 flags"),
    ],
)
def test_wrong_input_is_named(arguments: dict, message: str) -> None:
    with pytest.raises(sf.ProblemError, match=message):
        quadruped().halfspaces(**arguments)
