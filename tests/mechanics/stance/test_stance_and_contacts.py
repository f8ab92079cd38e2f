"""Contacts, grasp maps and corner maps against mechanics written out by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefoot import PointContact, ProblemError, Sole, SoleContact, Stance

seeds = st.integers(0, 2**32 - 1)


def random_stance(rng, count=4):
    contacts = []
    for k in range(count):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        place, heading = rng.normal(size=(2, 3))
        if rng.random() < 0.5:
            contacts.append(PointContact(place, normal, rng.uniform(0, 1), f"c{k}", heading=heading))
        else:
            length, width = rng.uniform(0.05, 0.3, 2)
            contacts.append(
                SoleContact(place, Sole(length, width, rng.uniform(0, 1)), normal, f"c{k}", heading=heading)
            )
    return Stance(contacts)


@settings(max_examples=40)
@given(seed=seeds)
def test_grasp_map_sums_forces_and_moments(seed):
    rng = np.random.default_rng(seed)
    stance, about = random_stance(rng), rng.normal(size=3)
    forces = rng.normal(size=stance.dim)
    total, moment = np.zeros(3), np.zeros(3)
    for contact, part in zip(stance, stance.slices, strict=True):
        f = contact.rotation_world_contact @ forces[part][:3]
        total += f
        moment += np.cross(contact.position - about, f)
        if contact.dim == 6:
            moment += contact.rotation_world_contact @ forces[part][3:]
    np.testing.assert_allclose(stance.grasp_map(about) @ forces, [*total, *moment], atol=1e-12)


@settings(max_examples=40)
@given(seed=seeds)
def test_corner_forces_give_the_same_wrench_as_the_patch(seed):
    rng = np.random.default_rng(seed)
    stance, about = random_stance(rng), rng.normal(size=3)
    corners = rng.normal(size=stance.points().dim)
    whole = stance.points().grasp_map(about) @ corners
    np.testing.assert_allclose(stance.grasp_map(about) @ (stance.corner_map @ corners), whole, atol=1e-12)


def test_stance_keeps_order_and_drops_named_contacts():
    stance = Stance([PointContact([k, 0, 0], name=n) for k, n in enumerate("abc")])
    assert stance.names == ("a", "b", "c")
    assert stance.without("b").names == ("a", "c")
    with pytest.raises(ProblemError, match="valid names: a, b, c"):
        stance.without("d")
    assert stance.points() is stance
    assert len(Stance([])) == 0
    assert Stance([]).grasp_map().shape == (6, 0)
    assert stance.cone().dim == 9


def test_with_friction_changes_nothing_else():
    stance = Stance(
        [PointContact([0, 0, 0], mu=0.3, normal_max=5.0), SoleContact([1, 0, 0], Sole(0.1, 0.1, mu=0.9))]
    )
    twin = stance.with_friction(0.5)
    assert twin.mu.tolist() == [0.5, 0.5]
    assert stance.mu.tolist() == [0.3, 0.9]
    assert twin.bounded
    assert twin.contacts[0].normal_max == 5.0
    assert not Stance([PointContact([0, 0, 0])]).bounded


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"normal": [0, 0, 0]}, "normal must have length 1"),
        ({"normal": [0, 0, 1.01]}, "normal must have length 1"),
        ({"normal": [0, math.nan, 1]}, "normal"),
        ({"position": [0, 0, math.nan]}, "position.* is NaN"),
        ({"position": [0, 0]}, "position must have shape"),
        ({"mu": -0.1}, "mu must be"),
        ({"mu": math.inf}, "mu must be finite"),
        ({"mu": math.nan}, "mu must be"),
        ({"normal_min": 5.0, "normal_max": 1.0, "name": "FL"}, "normal_min must be <= normal_max.*FL"),
        ({"normal_min": -1.0}, "normal_min"),
        ({"heading": [0, 0, math.inf]}, "heading"),
    ],
)
def test_bad_contacts_are_named(change, message):
    with pytest.raises(ProblemError, match=message):
        PointContact(**({"position": [0, 0, 0]} | change))


def test_bad_soles_and_stances_are_named():
    with pytest.raises(ProblemError, match="sole must be"):
        SoleContact([0, 0, 0], (0.2, 0.1))
    with pytest.raises(ProblemError, match="without a torsional radius"):
        SoleContact([0, 0, 0], Sole(0.2, 0.1, 0.6, torsional_radius=0.01))
    with pytest.raises(ProblemError, match=r"contacts\[1\].*str"):
        Stance([PointContact([0, 0, 0]), "foot"])
