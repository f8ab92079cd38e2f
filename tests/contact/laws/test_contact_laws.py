"""Laws as values that still read and compare as their names."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.laws import LAWS, law_of


@pytest.mark.parametrize("name", list(LAWS))
def test_a_law_is_its_name_and_more(name: str) -> None:
    problem = sf.ContactProblem(np.eye(3), [1.0, 0.0, -1.0], 0.5, law=name)
    assert problem.law == name
    assert {name: 1}[problem.law] == 1
    assert repr(problem) == f"ContactProblem(contacts=1, law='{name}')"
    assert not problem.general
    for other in (pickle.loads(pickle.dumps(problem.law)), copy.deepcopy(problem.law)):
        assert other == name
        assert other.shift == problem.law.shift
        assert not problem.replace(law=other).general
    again = pickle.loads(pickle.dumps(problem))
    assert not again.replace(g=again.g).general


@pytest.mark.parametrize("share", [0.0, 0.25, 0.75, 1.0])
def test_a_share_of_the_shift_opens_by_what_is_left(share: float) -> None:
    """One mass that slides: u_n = (1 - θ) mu ||u_t||, in closed form between Coulomb's and the convex law."""
    law = sf.laws.Law("of its own", shift=share)
    problem = sf.ContactProblem(np.eye(3), [2.0, 0.0, -1.0], mu=0.5, law=law)
    assert problem.general
    found = sf.solve(problem, tol=1e-11).raise_if_failed()
    # λ = z (-1/2, 0, 1): u = (2 - z/2, 0, z - 1), and z - 1 = (1 - θ) (2 - z/2) / 2
    z = (1.0 + (1.0 - share)) / (1.0 + 0.25 * (1.0 - share))
    assert np.allclose(found.forces, [[-0.5 * z, 0.0, z]], atol=1e-9)
    if share in (0.0, 1.0):
        named = sf.solve(problem.replace(law="coulomb" if share else "convex"), tol=1e-11)
        assert np.allclose(found.forces, named.forces, atol=1e-9)
        assert found.residuals.energy_gap == pytest.approx(named.residuals.energy_gap, abs=1e-11)


def test_what_is_no_law_is_refused() -> None:
    with pytest.raises(sf.ProblemError, match="unknown law 'newton'; valid names: convex, coulomb"):
        law_of("newton")
    with pytest.raises(sf.ProblemError, match="shift must be a number between 0 and 1, got 2"):
        sf.laws.Law("too much", shift=2.0)
    with pytest.raises(sf.ProblemError, match="the name of another law"):
        law_of(sf.laws.Law("coulomb", shift=0.5))
    assert law_of(sf.laws.Law("coulomb", shift=1.0)) is sf.laws.COULOMB


def test_solvers_for_points_refuse_other_laws_by_name() -> None:
    problem = sf.ContactProblem(np.eye(3), [2.0, 0.0, -1.0], 0.5, law=sf.laws.Law("mine", 0.5))
    with pytest.raises(
        sf.ProblemError, match="nsgs does not solve law='mine'; solvers that do: admm, auto, newton"
    ):
        sf.solve(problem, "nsgs")
    answer = sf.ContactSolver(contacts=1, mu=0.5, law=sf.laws.Law("mine", 0.5)).solve(problem.G, problem.g)
    assert answer.solved
    assert np.allclose(answer.forces, sf.solve(problem).forces, atol=1e-7)
