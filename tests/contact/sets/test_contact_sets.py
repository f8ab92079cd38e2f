"""The axioms of an admissible set, for every kind of contact, and what a contact set says of itself."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import surefoot as sf
from surefoot.contact.sets import ContactKind
from surefoot.contact.sets.contact_set import ContactSet

C = sf.contact_sets
KINDS: dict[str, ContactKind] = {
    "frictionless": C.Frictionless(),
    "frictionless, bounded": C.Frictionless(normal_min=0.5, normal_max=2.0),
    "planar": C.Planar(0.6),
    "planar, no friction": C.Planar(0.0),
    "point": C.Point(0.6),
    "point, bounded": C.Point(0.6, normal_min=0.5, normal_max=2.0),
    "point, off": C.Point(0.6, normal_max=0.0),
    "soft finger": C.SoftFinger(0.5, 0.03),
    "soft finger, free to turn": C.SoftFinger(0.5, 0.0),
    "rolling": C.Rolling(0.5, 0.02, normal_max=3.0),
    "rolling, free": C.Rolling(0.5, 0.0),
    "patch": C.DecoupledSole(0.6, 0.2, 0.1, 0.03),
    "patch, free to turn": C.DecoupledSole(0.6, 0.2, 0.1, 0.0, normal_min=0.3),
    "pyramid": C.Pyramid(0.6, 5),
    "pyramid, outer, bounded": C.Pyramid(0.6, 8, "outer", normal_min=0.5, normal_max=2.0),
    "bilateral": C.Bilateral(),
    "bilateral, six": C.Bilateral(6),
}
kinds = pytest.mark.parametrize("contact", KINDS.values(), ids=KINDS.keys())
seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=40, deadline=None)


def draw(contact: ContactKind, seed: int) -> np.ndarray:
    """A random wrench, its moments of the size that the contact can carry."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=contact.rows) * 10.0 ** rng.uniform(-1, 1.5) * contact.lengths


def admissible(contact: ContactKind, f: np.ndarray, slack: float = 1e-9) -> bool:
    """Membership, written out kind by kind from the words of the docs, not from `factors`."""
    if contact.bilateral:
        return True
    z = f[contact.normal]
    size = slack * (1.0 + float(np.abs(f / contact.lengths).max()))
    name = type(contact).__name__
    rules = {
        "Frictionless": lambda: [0.0],
        "Planar": lambda: [abs(f[0]) - contact.mu * z],
        "Point": lambda: [math.hypot(f[0], f[1]) - contact.mu * z],
        "SoftFinger": lambda: [
            math.hypot(f[0], f[1], f[3] / contact.radius) - contact.mu * z
            if contact.radius
            else max(math.hypot(f[0], f[1]) - contact.mu * z, abs(f[3]))
        ],
        "Rolling": lambda: [
            math.hypot(f[0], f[1]) - contact.mu * z,
            (math.hypot(f[3], f[4]) - contact.resistance * z) / (contact.resistance or 1.0),
        ],
        "DecoupledSole": lambda: [
            math.hypot(f[0], f[1]) - contact.mu * z,
            abs(f[3]) / (0.5 * contact.width) - z,
            abs(f[4]) / (0.5 * contact.length) - z,
            (abs(f[5]) - contact.torsion * z) / (contact.torsion or 1.0),
        ],
        "Pyramid": lambda: [
            float((sf.FrictionCone(contact.mu).polyhedral(contact.facets, contact.fit).halfspaces @ f).max())
        ],
    }
    return bool(
        max(rules[name]()) <= size
        and contact.normal_min - size <= z <= contact.normal_max + size
        and z >= -size
    )


@kinds
@few
@given(seed=seeds)
def test_projection_is_admissible_idempotent_and_nearest(contact: ContactKind, seed: int) -> None:
    """Nearest: (x - P(x))·(y - P(x)) <= 0 for all y of the set, in the contact's metric."""
    x = draw(contact, seed)
    p = contact.project(x)
    assert admissible(contact, p)
    assert np.allclose(contact.project(p) / contact.lengths, p / contact.lengths, rtol=1e-12, atol=1e-12)
    if admissible(contact, x, -1e-9):
        assert np.allclose(p, x, rtol=1e-14)
    metric = contact.lengths**-2
    for k in range(8):
        y = contact.project(draw(contact, seed + 1 + k))
        size = (1.0 + np.abs(x / contact.lengths).max()) * (1.0 + np.abs(y / contact.lengths).max())
        assert ((x - p) * metric) @ (y - p) <= 1e-10 * size


@kinds
@few
@given(seed=seeds)
def test_moreau(contact: ContactKind, seed: int) -> None:
    """For a cone, x - P(x) is orthogonal to P(x) and in the polar: its support over the set is zero."""
    if contact.normal_min > 0.0 or contact.normal_max < np.inf:
        return
    x = draw(contact, seed)
    p = contact.project(x)
    rest = (x - p) / contact.lengths**2
    size = 1.0 + float(((x / contact.lengths) ** 2).sum())
    assert abs(rest @ p) <= 1e-12 * size
    inward = rest.copy()
    inward[contact.normal] -= 1e-9 * size  # the support of a direction on the polar's boundary is 0 or inf
    if not contact.bilateral:
        assert contact.support(inward) == 0.0


@kinds
@few
@given(seed=seeds)
def test_support_is_reached_and_not_exceeded(contact: ContactKind, seed: int) -> None:
    """Over the set cut to a finite height, whose maximum a far projection finds."""
    if contact.bilateral:
        assert contact.support(np.zeros(contact.rows)) == 0.0
        assert contact.support(draw(contact, seed)) == math.inf
        return
    rng = np.random.default_rng(seed)
    d = rng.normal(size=contact.rows) / contact.lengths
    value = contact.support(d)
    for k in range(8):
        assert contact.project(draw(contact, seed + k)) @ d <= value + 1e-9 * (1.0 + abs(value))
    far = contact.project(1e7 * d * contact.lengths**2)  # the maximiser, in the limit
    if math.isinf(value):
        assert far @ d > 0.0  # a cone: one force that gains, gains without end
    else:
        assert far @ d == pytest.approx(value, abs=1e-5)


@kinds
@few
@given(seed=seeds)
def test_the_shift_is_the_most_power_friction_can_take(contact: ContactKind, seed: int) -> None:
    """Γ(u) = max of -λ_t·u_t over the friction rows of forces of unit normal force, and is reached."""
    if contact.bilateral:
        return
    rng = np.random.default_rng(seed)
    u = rng.normal(size=contact.rows) / contact.lengths
    gamma = contact.shift(u)
    free = dataclasses.replace(contact, normal_min=1.0, normal_max=1.0)
    tipping = [row for b in contact.factors if not b.friction for row in b.rows]
    u_t = u.copy()
    u_t[[contact.normal, *tipping]] = 0.0
    powers = [-free.project(draw(contact, seed + k)) @ u_t for k in range(20)]
    assert max(powers) <= gamma + 1e-9
    assert -free.project(-1e7 * u_t * contact.lengths**2) @ u_t == pytest.approx(gamma, abs=1e-6)


@kinds
def test_residual_vanishes_where_it_must(contact: ContactKind) -> None:
    """At a force inside with no velocity, and at none with a velocity that opens."""
    if contact.bilateral or contact.normal_max == 0.0:
        return
    f = np.zeros(contact.rows)
    f[contact.normal] = max(contact.normal_min, 1.0)
    assert contact.residual(f, np.zeros(contact.rows), 2.0) == pytest.approx(0.0, abs=1e-15)
    u = np.zeros(contact.rows)
    u[contact.normal] = 3.0
    f[contact.normal] = contact.normal_min
    assert contact.residual(f, u, 2.0) == pytest.approx(0.0, abs=1e-15)
    f[contact.normal] = min(contact.normal_min + 1.0, contact.normal_max)
    assert contact.residual(f, u, 2.0) > 0.1


def test_a_soft_finger_without_radius_is_a_point_and_a_plane_a_section_of_one() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        f = rng.normal(size=4) * 3.0
        assert np.allclose(C.SoftFinger(0.4, 0.0).project(f), [*C.Point(0.4).project(f[:3]), 0.0])
        assert np.allclose(C.Planar(0.4).project(f[[0, 2]]), C.Point(0.4).project([f[0], 0.0, f[2]])[[0, 2]])
        assert np.allclose(C.Rolling(0.4, 0.1).project([*f[:3], 0.0, 0.0])[:3], C.Point(0.4).project(f[:3]))


def test_a_set_splits_packs_and_copies() -> None:
    contacts = ContactSet([C.Planar(0.5), C.DecoupledSole(0.5, 0.2, 0.1, 0.0), C.Frictionless()])
    assert (len(contacts), contacts.rows, contacts.shape) == (3, 9, (9,))
    assert [part.size for part in contacts.split(np.arange(9.0))] == [2, 6, 1]
    assert contacts.normal_rows.tolist() == [1, 4, 8]
    assert ContactSet([C.SoftFinger(0.5, 0.1)] * 3).shape == (3, 4)
    problem = sf.ContactProblem(np.eye(9), -np.ones(9), contacts=contacts)
    for other in (
        pickle.loads(pickle.dumps(problem)),
        copy.deepcopy(problem),
        problem.replace(law="coulomb"),
    ):
        other.g[:] = 0.0
        assert not sf.solve(other).forces.any()
        assert list(other.contact_set) == list(contacts)
    assert sf.solve(problem).forces.any()


def test_three_row_contacts_become_the_short_form() -> None:
    """The compiled path takes them; bounds, pyramids and joints are kept."""
    given = [C.Point(0.5, normal_min=0.1), C.Bilateral(), C.Point(0.3, normal_max=2.0)]
    problem = sf.ContactProblem(np.eye(9), np.zeros(9), contacts=given)
    assert not problem.general
    assert list(problem.contact_set) == given
    assert problem.mu.tolist() == [0.5, 0.0, 0.3]
    pyramids = [C.Pyramid(0.5, 6, "outer"), C.Pyramid(0.2, 6, "outer")]
    problem = sf.ContactProblem(np.eye(6), np.zeros(6), contacts=pyramids)
    assert (problem.facets, problem.fit, problem.general) == (6, "outer", False)
    assert sf.ContactProblem(np.eye(6), np.zeros(6), contacts=[C.Pyramid(0.5, 6), C.Point(0.5)]).general


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: C.Point(-1.0), "mu must be a number between 0"),
        (lambda: C.Point("a"), "mu must be a number, got 'a'"),
        (lambda: C.DecoupledSole(0.5, 0.0, 1.0, 0.0), "length and width must be > 0"),
        (lambda: C.DecoupledSole(0.5, 1.0, 1.0, -1.0), "torsion must be a number"),
        (lambda: C.SoftFinger(0.5, math.nan), "radius must be a number"),
        (lambda: C.Rolling(0.5, math.inf), "resistance must be a number"),
        (lambda: C.Bilateral(9), "rows must be at most 6"),
        (lambda: C.Bilateral(3, normal_max=1.0), "a bilateral contact takes no normal bounds"),
        (lambda: C.Pyramid(0.5, 2), "facets must be a whole number >= 3"),
        (lambda: C.Pyramid(-0.5), "mu must be a number between 0"),
        (lambda: C.Point(0.5, normal_min=2.0, normal_max=1.0), "normal_min must be finite and <= normal_max"),
        (
            lambda: sf.ContactProblem(np.eye(3), np.ones(3), 0.5, contacts=[C.Point(0.5)]),
            "give those or them",
        ),
        (
            lambda: sf.ContactProblem(np.eye(3), np.ones(3), normal_max=1.0, contacts=[C.Point(0.5)]),
            "give those or them",
        ),
        (lambda: sf.ContactProblem(np.eye(3), np.ones(3)), "needs mu, or contacts"),
        (lambda: sf.ContactProblem(np.eye(3), np.ones(3), contacts=[0.5]), r"contacts\[0\] must be one of"),
        (lambda: sf.ContactProblem(np.eye(3), np.ones(3), contacts=[C.Planar(0.5)]), "shape"),
        (lambda: sf.ContactProblem(-np.eye(2), np.ones(2), contacts=[C.Planar(0.5)]), "semidefinite"),
        (
            lambda: sf.solve(sf.ContactProblem(np.eye(2), np.ones(2), contacts=[C.Planar(0.5)]), "nsgs"),
            "solvers that do: admm, auto, newton",
        ),
        (
            lambda: sf.write_problem(
                sf.ContactProblem(np.eye(2), np.ones(2), contacts=[C.Planar(0.5)]), "nowhere.npz"
            ),
            "no file format holds",
        ),
        (
            lambda: sf.redundancy(sf.ContactProblem(np.eye(2), np.ones(2), contacts=[C.Planar(0.5)])),
            "three rows",
        ),
    ],
)
def test_what_is_no_contact_is_refused_with_words(make, words: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(sf.ProblemError, match=words):
        make()
