"""Complementarity made soft, one form a line: 0 <= a ⟂ b >= 0 for an NLP solver, with one smoothing for all.

Every form takes the same smoothing `eps`, the product a b that it allows or asks for, so that forms are
compared on the same path: for eps -> 0 all of them lead to a b = 0. The regularised function of Fischer and
Burmeister

    psi(a, b) = a + b - sqrt(a² + b² + 2 eps)

vanishes exactly where a b = eps with a, b > 0 (Kanzow 1996), and is negative or zero, for a, b >= 0, exactly
where a b <= eps: it describes the same sets as the product. Books write it with their own
eps_book² = 2 eps, see `fischer_burmeister_eps`.

References: Scholtes, SIAM J. Optim. 11 (2001), for a b <= eps; Fischer, Optimization 24 (1992), and Kanzow,
SIAM J. Matrix Anal. 17 (1996); Anitescu, SIAM J. Optim. 15 (2005), and Leyffer, López-Calva and Nocedal,
SIAM J. Optim. 17 (2006), for the penalty. Three forms go by "log barrier" in books: the equality a b = eps
(`equal`), the same in logarithms (`log-equal`), and a barrier with a penalty in the cost (`barrier`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.errors import ProblemError, check_name
from surefoot.base.libraries import import_casadi

Pairwise = Callable[[Any, Any, Any], Any]
"""(a, b, eps) to a CasADi column, entry by entry."""


class Softened(NamedTuple):
    """What pairs add to an NLP.

    Attributes
    ----------
    rows
        (m, 1) CasADi expression, m = 0 or the number of pairs, of `low` to zero.
    low
        0 or minus infinity; it does not depend on eps, which stands in the rows.
    cost
        Scalar CasADi expression to be added to the objective, or 0.0.
    """

    rows: Any
    low: float
    cost: Any


@dataclass(frozen=True)
class SoftForm:
    """A way to write 0 <= a ⟂ b >= 0.

    Attributes
    ----------
    name, meaning
        For tables: a word, and the formula.
    signs
        Whether a >= 0 and b >= 0 are asked for as well. They must be bounds of *variables*: give a and b
        variables of their own, with rows a = its expression, so that an interior-point method keeps them
        inside (`barrier` and `log-equal` cannot be evaluated otherwise).
    row
        The function whose sign or zero is asked for; None for a form that lives in the cost.
    equality
        Whether the row is to be zero; else at most zero.
    price
        What is added to the cost for each pair; None for nothing.
    """

    name: str
    meaning: str
    signs: bool
    row: Pairwise | None = None
    equality: bool = True
    price: Pairwise | None = None

    def soften(self, a: Any, b: Any, eps: Any) -> Softened:
        """Return the rows and the cost of n pairs.

        Parameters
        ----------
        a, b
            (n, 1) CasADi SX or MX, best variables (see `signs`), both in units that make them of one
            size: the form sees no units.
        eps
            Scalar CasADi parameter or number: the product a b that is allowed or asked for, above 0.

        Raises
        ------
        ProblemError
            If a and b are not columns of one length.
        MissingExtra
            If CasADi is not installed.
        """
        casadi = import_casadi()
        if a.shape != b.shape or a.shape[1] != 1:
            raise ProblemError(f"a and b must be columns of one length, got {a.shape} and {b.shape}")
        rows = type(a)(0, 1) if self.row is None else self.row(a, b, eps)
        cost = 0.0 if self.price is None else casadi.sum1(self.price(a, b, eps))
        return Softened(rows, 0.0 if self.equality else -np.inf, cost)


def _product(a: Any, b: Any, eps: Any) -> Any:
    return a * b - eps


def _logarithms(a: Any, b: Any, eps: Any) -> Any:
    """Return log a + log b - log eps: the equality in logarithms, b = eps / a."""
    casadi = import_casadi()
    return casadi.log(a) + casadi.log(b) - casadi.log(eps)


def fischer_burmeister(a: Any, b: Any, eps: Any) -> Any:
    """Return a + b - sqrt(a² + b² + 2 eps), of CasADi expressions, arrays or numbers.

    >>> float(fischer_burmeister(3.0, 4.0, 12.0))
    0.0
    """
    root = np.sqrt if isinstance(a, np.ndarray | float) else import_casadi().sqrt
    return a + b - root(a * a + b * b + 2.0 * eps)


def barrier(a: Any, b: Any, kappa: Any, rho: Any) -> Any:
    """Return -kappa (log a + log b) + (a b)² / (2 rho), of CasADi expressions, arrays or numbers.

    Alone it is least where a b = sqrt(kappa rho): kappa for rho = kappa, kappa^1.5 for rho = kappa². Beside
    another cost the product goes where both weigh the same, as with any penalty.

    >>> products = np.array([0.9e-2, 1e-2, 1.1e-2])
    >>> int(np.argmin(barrier(1.0, products, 1e-2, 1e-2)))
    1
    """
    log = np.log if isinstance(b, np.ndarray | float) else import_casadi().log
    return -kappa * (log(a) + log(b)) + (a * b) ** 2 / (2.0 * rho)


def _price(a: Any, b: Any, eps: Any) -> Any:
    return a * b / import_casadi().sqrt(eps)


_FB = "a + b - sqrt(a² + b² + 2 eps)"
_LISTED = (
    SoftForm("relaxed", "a b <= eps, a >= 0, b >= 0", True, _product, equality=False),
    SoftForm("equal", "a b = eps, a >= 0, b >= 0", True, _product),
    SoftForm("log-equal", "log a + log b = log eps, a >= 0, b >= 0", True, _logarithms),
    SoftForm(
        "barrier",
        "cost - eps (log a + log b) + (a b)² / (2 eps), a >= 0, b >= 0",
        True,
        price=lambda a, b, eps: barrier(a, b, eps, eps),
    ),
    SoftForm("fischer-burmeister", f"{_FB} = 0, signs implied", False, fischer_burmeister),
    SoftForm("fischer-burmeister-signs", f"{_FB} = 0, a >= 0, b >= 0", True, fischer_burmeister),
    SoftForm("fischer-burmeister-relaxed", f"{_FB} <= 0, a >= 0, b >= 0", True, fischer_burmeister, False),
    SoftForm("penalty", "cost + a b / sqrt(eps), a >= 0, b >= 0", True, price=_price),
)
FORMS = {form.name: form for form in _LISTED}
"""The forms by name."""


def form_named(name: str) -> SoftForm:
    """Return a form by name.

    Raises
    ------
    ProblemError
        If there is none; the message lists them.
    """
    check_name("complementarity form", name, FORMS)
    return FORMS[name]


def fischer_burmeister_eps(book: float) -> float:
    """Return the smoothing of this package for a book's eps in sqrt(a² + b² + eps²).

    >>> fischer_burmeister_eps(0.1)
    0.005000000000000001
    """
    return 0.5 * book * book


def schedule(first: float = 0.1, last: float = 1e-13, factor: float = 0.1) -> tuple[float, ...]:
    """Return the smoothings of a continuation, first, first * factor, ..., last.

    A pair whose both sides end at zero is off by sqrt(eps): min(a, b) < 1e-6 needs last < 1e-12.

    Raises
    ------
    ProblemError
        Unless first >= last > 0 and 0 < factor < 1.

    Examples
    --------
    >>> schedule(0.1, 1e-3)
    (0.1, 0.01, 0.001)
    """
    if not (0.0 < last <= first < math.inf and 0.0 < factor < 1.0):
        raise ProblemError(
            f"a continuation needs first >= last > 0 and 0 < factor < 1, got {first:g}, {last:g}, {factor:g}"
        )
    count = max(0, math.ceil(math.log(last / first) / math.log(factor) - 1e-9))
    return (*(float(f"{first * factor**k:.6g}") for k in range(count)), last)
