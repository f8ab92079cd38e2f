"""Every complementarity form leads to the same pairs, and says what it asks for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.motion.planning.transcription.smoothed_complementarity import (
    FORMS,
    barrier,
    fischer_burmeister,
    form_named,
    schedule,
)

casadi = pytest.importorskip("casadi")


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("symbol", [casadi.SX, casadi.MX], ids=["SX", "MX"])
def test_a_program_with_a_known_answer(name: str, symbol: Any) -> None:
    """The nearest pair to (1, 0.3) and to (0.2, 2) with a b = 0 is (1, 0) and (0, 2)."""
    form, target = FORMS[name], np.array([1.0, 0.2, 0.3, 2.0])
    x, eps = symbol.sym("x", 4), symbol.sym("eps")
    soft = form.soften(x[:2], x[2:], eps)
    program = {"x": x, "p": eps, "f": casadi.sumsqr(x - target) + soft.cost, "g": soft.rows}
    # bounds as they are: a penalty would profit from b = -1e-8, times its weight of 1e6
    ipopt = {"print_level": 0, "sb": "yes", "tol": 1e-10, "bound_relax_factor": 0.0}
    options = {"print_time": False, "ipopt": ipopt}
    solver = casadi.nlpsol("solver", "ipopt", program, options)
    guess = np.full(4, 0.5)
    least = 0.0 if form.signs else -np.inf
    for value in schedule(0.1, 1e-12):
        found = solver(x0=guess, p=value, lbx=least, ubx=np.inf, lbg=soft.low, ubg=0.0)
        guess = np.array(found["x"]).ravel()
    assert guess == pytest.approx([1.0, 0.0, 0.0, 2.0], abs=2e-6)


@pytest.mark.parametrize("name", [name for name, form in FORMS.items() if form.row is not None])
def test_the_row_is_zero_exactly_where_the_product_is_eps(name: str) -> None:
    form, eps = FORMS[name], 0.03
    a = np.geomspace(1e-4, 1e3, 15)
    on, above, below = (casadi.DM(share * eps / a) for share in (1.0, 1.5, 0.5))
    at = lambda b: np.array(form.soften(casadi.DM(a), b, eps).rows).ravel()  # noqa: E731
    assert at(on) == pytest.approx(np.zeros(15), abs=1e-12)
    assert (at(above) > 0.0).all()
    assert (at(below) < 0.0).all()
    assert form.soften(casadi.DM(a), on, eps).low == (0.0 if form.equality else -np.inf)


def test_without_signs_the_function_has_no_other_zeros() -> None:
    """The product is eps for two negative numbers, too; Fischer-Burmeister's function is not zero there."""
    a = -np.geomspace(1e-3, 1e3, 13)
    assert (fischer_burmeister(a, 0.03 / a, 0.03) < 0.0).all()


@pytest.mark.parametrize("power", [0, 1, 2])
def test_the_barrier_in_the_cost_is_least_at_the_root_of_both_weights(power: int) -> None:
    """The chapter's method B leaves sqrt(kappa rho): kappa for rho = kappa, kappa^1.5 for kappa²."""
    kappa = 1e-3
    products = np.geomspace(1e-7, 1.0, 20001)
    cost = barrier(2.0, products / 2.0, kappa, kappa**power)
    assert products[np.argmin(cost)] == pytest.approx(np.sqrt(kappa ** (1 + power)), rel=1e-3)
    assert FORMS["barrier"].row is None


def test_what_is_refused() -> None:
    with pytest.raises(ProblemError, match="valid names: barrier, equal, fischer-burmeister"):
        form_named("smooth")
    with pytest.raises(ProblemError, match="one length"):
        FORMS["equal"].soften(casadi.SX.sym("a", 2), casadi.SX.sym("b", 3), 0.1)
    with pytest.raises(ProblemError, match="first >= last"):
        schedule(1e-9, 1e-8)
