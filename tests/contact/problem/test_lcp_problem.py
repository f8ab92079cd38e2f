from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.problem.lcp import stewart_trinkle


def test_residual_is_zero_only_at_solutions_and_scales() -> None:
    lcp = sf.LCP([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0])
    z = np.array([4.0, 7.0]) / 3.0
    assert lcp.residual(z) < 1e-15
    assert lcp.residual([1.0, 1.0]) > 0.1
    wrong = np.array([1.0, 2.0])
    assert sf.LCP(7.0 * lcp.M, 7.0 * lcp.q).residual(wrong) == pytest.approx(lcp.residual(wrong))
    assert sf.LCP(lcp.M, 7.0 * lcp.q).residual(7.0 * wrong) == pytest.approx(lcp.residual(wrong))


def test_residual_is_not_fooled_by_a_huge_guess() -> None:
    """w_1 = -z_1 - 1 >= 0 has no solution; along the ray z_2 the error must not look smaller."""
    lcp = sf.LCP([[-1.0, 0.0], [0.0, 0.0]], [-1.0, 0.0])
    assert lcp.residual([0.0, 1e12]) >= 1.0


def test_friction_lcp_of_a_sliding_block() -> None:
    """A block of mass 2 pushed along x over a pyramid with edges along the axes: friction -mu N, exactly."""
    problem = sf.ContactProblem(np.eye(3) / 2.0, [3.0, 0.0, -1.0], 0.5).polyhedral(4)
    friction = stewart_trinkle(problem)
    assert not np.allclose(friction.lcp.M, friction.lcp.M.T)
    found = sf.solve_lcp(friction.lcp).raise_if_failed()
    assert friction.forces(found.z)[0] == pytest.approx([-1.0, 0.0, 2.0])
    assert found.z[-1] == pytest.approx(2.5)  # sigma is the sliding speed


def test_friction_lcp_refuses_what_is_not_linear() -> None:
    problem = sf.ContactProblem(np.eye(3), np.ones(3), 0.5)
    with pytest.raises(sf.ProblemError, match="on pyramids"):
        stewart_trinkle(problem)
    with pytest.raises(sf.ProblemError, match="normal bounds"):
        stewart_trinkle(problem.replace(facets=4, normal_max=2.0))


def test_switched_off_contacts_are_left_out() -> None:
    problem = sf.ContactProblem(np.eye(6), -np.ones(6), 0.5, 0.0, [0.0, np.inf]).polyhedral(6)
    friction = stewart_trinkle(problem)
    assert friction.lcp.size == 1 + 6 + 1
    force = friction.forces(sf.solve_lcp(friction.lcp).raise_if_failed().z)
    assert np.array_equal(force[0], np.zeros(3))
    assert force[1, 2] == pytest.approx(1.0)


def test_numbers_cannot_be_changed_under_what_was_measured() -> None:
    M, q = np.eye(2), np.array([-1.0, -1.0])
    lcp = sf.LCP(M, q)
    assert lcp.residual([1.0, 1.0]) == 0.0
    q[0] = -1e12  # the problem has its own copy
    assert lcp.residual([1.0, 1.0]) == 0.0
    with pytest.raises(ValueError, match="read-only"):
        lcp.q[0] = 2.0


def test_parts_are_what_no_entry_couples() -> None:
    M = np.zeros((5, 5))
    M[0, 3] = 1.0
    M[4, 2] = -2.0
    lcp = sf.LCP(M + np.eye(5), -np.ones(5))
    assert [part.tolist() for part in lcp.parts] == [[0, 3], [1], [2, 4]]
    assert lcp.part(lcp.parts[2]).M.tolist() == [[1.0, 0.0], [-2.0, 1.0]]


def test_residual_does_not_depend_on_the_units_of_rows() -> None:
    """A row in millimetres beside one in metres: its whole violation is not a small part of the other's q."""
    lcp = sf.LCP([[1e-10, -1e-6], [-1e-6, 1.0]], [-1e-9, 1.0])
    assert lcp.residual([0.0, 0.0]) > 1e-5
