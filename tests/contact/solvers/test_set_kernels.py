"""Compiled code for contacts of any kind against the NumPy operations of the contacts themselves."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.sets.contact_set import ContactSet
from surefoot.contact.solvers import set_kernels
from surefoot.contact.solvers.scaled import ScaledContacts, measure_of, scaling

C = sf.contact_sets
CONTACTS = [
    C.Frictionless(normal_min=0.2, normal_max=2.0),
    C.Planar(0.6),
    C.Planar(0.0),
    C.Point(0.6, normal_min=0.5, normal_max=2.0),
    C.Point(0.6, normal_max=0.0),
    C.SoftFinger(0.5, 0.03),
    C.SoftFinger(0.5, 0.0),
    C.Rolling(0.5, 0.02),
    C.DecoupledSole(0.6, 0.2, 0.1, 0.03),
    C.DecoupledSole(0.6, 0.2, 0.1, 0.0, normal_min=0.3),
    C.Pyramid(0.6, 5),
    C.Pyramid(0.6, 8, "outer", normal_min=0.5, normal_max=2.0),
    C.Bilateral(2),
]
SET = ContactSet(CONTACTS)


def draws(count: int) -> list[np.ndarray]:
    """Points of all sizes, some of them on the axes."""
    rng = np.random.default_rng(0)
    out = [rng.normal(size=SET.rows) * 10.0 ** rng.uniform(-1.0, 1.0) for _ in range(count)]
    for x in out[: count // 4]:
        x[rng.random(SET.rows) < 0.4] = 0.0
    return out


@pytest.mark.parametrize("unit", [1.0, 0.2])
def test_projection_and_shift_are_those_of_the_contacts(unit: float) -> None:
    """Scaled variables: forces over lengths and over the contact's unit, bounds over the unit."""
    packed = set_kernels.pack(SET, sf.laws.Law("most of it", 0.7), np.full(len(SET), unit))
    out, gamma = np.empty(SET.rows), np.empty(SET.rows)
    scale = unit * SET.lengths
    for x in draws(200):
        set_kernels.project_sets(*packed, x, out)
        gamma[:] = x
        set_kernels.add_shift(*packed, x, 1.0, gamma)
        back = -x
        set_kernels.add_shift(*packed, -x, -1.0, back)
        assert np.array_equal(back, -gamma)
        parts = zip(CONTACTS, *(SET.split(v) for v in (scale * x, scale * out, x, gamma)), strict=True)
        for contact, own, nearest, velocity, shifted in parts:
            assert np.allclose(contact.project(own) / contact.lengths, nearest / contact.lengths, atol=1e-12)
            expected = velocity.copy()
            expected[contact.normal] += 0.7 * contact.shift(velocity / contact.lengths)
            assert np.allclose(shifted, expected, atol=1e-12)


@pytest.mark.parametrize("facets", [None, 5])
def test_cones_are_packed_as_the_contacts_that_they_are(facets: int | None) -> None:
    held = np.array([False, True, False])
    problem = sf.ContactProblem(
        np.eye(9),
        np.ones(9),
        [0.5, 0.0, 0.7],
        [0.2, 0.0, 0.0],
        [2.0, np.inf, np.inf],
        facets=facets,
        bilateral=held,
    )
    own = ScaledContacts(problem)
    offset, group, table = own.packed
    expected = set_kernels.pack(problem.contact_set, problem.law, own.D[2::3])
    assert np.array_equal(own.D, scaling(problem))
    assert np.array_equal([own.step, own.weight], measure_of(problem, own.D[2::3]))
    assert np.array_equal(offset, expected[0])
    free = table[:, set_kernels.CODE] == set_kernels.FREE
    assert free.tolist() == held.tolist()
    assert np.array_equal(group.reshape(3, 3)[~free], expected[1].reshape(3, 3)[~free])
    x = np.random.default_rng(0).normal(size=9)
    for kernel in (set_kernels.project_sets, lambda *a: set_kernels.add_shift(*a[:4], 1.0, a[4])):
        out, other = np.zeros(9), np.zeros(9)
        kernel(offset, group, table, x, out)
        kernel(*expected, x, other)
        assert np.array_equal(out, other)


def test_jacobian_is_that_of_finite_differences() -> None:
    """Contact by contact, away from kinks; a projection's is symmetric, with eigenvalues between 0 and 1."""
    packed = set_kernels.pack(SET, sf.laws.COULOMB, np.ones(len(SET)))
    J, ends, compared = np.empty((len(SET), 6, 6)), np.empty((3, SET.rows)), 0
    for x in draws(80):
        set_kernels.jacobian_sets(*packed, x, J)
        h = 1e-6 * (1.0 + float(np.abs(x).max()))
        for k, (start, end) in enumerate(itertools.pairwise(SET.offsets)):
            own = J[k, : end - start, : end - start]
            assert np.allclose(own, own.T, atol=1e-10)
            values = np.linalg.eigvalsh(0.5 * (own + own.T))
            assert values.min() >= -1e-9
            assert values.max() <= 1.0 + 1e-9
            for i in range(start, end):
                for out, step in zip(ends, (-h, 0.0, h), strict=True):
                    point = x.copy()
                    point[i] += step
                    set_kernels.project_sets(*packed, point, out)
                behind, ahead = np.diff(ends[:, start:end], axis=0)
                if np.abs(ahead - behind).max() <= 1e-4 * h:  # else a kink lies between
                    slope = (ahead + behind) / (2.0 * h)
                    assert np.allclose(slope, own[:, i - start], atol=1e-4), CONTACTS[k]
                    compared += 1
    assert compared > 60 * SET.rows


@pytest.mark.parametrize("law", [sf.laws.COULOMB, sf.laws.CONVEX])
def test_newton_matrix_is_the_derivative_of_the_natural_map(law: sf.laws.Law) -> None:
    rng = np.random.default_rng(1)
    A = rng.normal(size=(SET.rows, 2 * SET.rows)) / SET.lengths[:, None]
    problem = sf.ContactProblem(A @ A.T / SET.rows, A[:, 0], contacts=CONTACTS, law=law)
    s = ScaledContacts(problem)
    J, matrix = np.empty((len(SET), 6, 6)), np.empty((SET.rows, SET.rows))
    for x in draws(10)[3:]:
        u, _ = s.measure(x)
        base = s.gap.copy()
        set_kernels.jacobian_sets(*s.packed, s.point, J)
        set_kernels.newton_matrix(s.G, *s.packed, s.step, u, J, matrix)
        h = 1e-6
        for _ in range(10):
            d = rng.normal(size=SET.rows)
            s.measure(x + h * d)
            ahead = (s.gap - base) / h
            s.measure(x - h * d)
            behind = (base - s.gap) / h
            smooth = np.abs(ahead - behind) < 1e-3 * (1.0 + np.abs(ahead))  # no kink in between
            assert smooth.mean() > 0.8
            expected = 0.5 * (ahead + behind)
            assert np.allclose((matrix @ d)[smooth], expected[smooth], rtol=1e-4, atol=1e-4)


def test_a_disc_without_radius_holds_its_rows_wherever_the_point_is() -> None:
    """Frictionless: the tangential force is zero and stays so, also on the normal itself."""
    contacts = ContactSet([sf.contact_sets.Point(mu=0.0)])
    packed = set_kernels.pack(contacts, sf.laws.Law("coulomb", 1.0), np.ones(1))
    for tangent in (0.0, 0.3):
        J = np.empty((1, set_kernels.WIDEST, set_kernels.WIDEST))
        set_kernels.jacobian_sets(*packed, np.array([tangent, 0.0, 1.0]), J)
        assert J[0, :3, :3].tolist() == np.diag([0.0, 0.0, 1.0]).tolist()
