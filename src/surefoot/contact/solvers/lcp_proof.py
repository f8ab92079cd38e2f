"""Proofs that a linear complementarity problem has no solution because its inequalities have none.

By Farkas' lemma, no z >= 0 has M z + q >= 0 exactly if some v >= 0 has Mᵀ v <= 0 and q . v < 0. Candidates
come from a solver's ray and from a linear program; only `LCP.proves_infeasible`, which computes with exact
integers, decides. A ray in floating point has zeros of Mᵀ v that are not quite zero. Two ways mend it: the
linear program looks for a v whose inequalities are strict wherever they can be; and small ratios of whole
numbers are tried, which is what proofs of hand-made and of symmetric problems consist of.

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, "The Linear Complementarity Problem", 2009, section 2.7.1 and
theorem 4.4.12. Limits: a positive semidefinite M that is singular only up to rounding has no such proof, nor
has a feasible problem without a solution (M not monotone).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact.problem.lcp import LCP, equilibrated

DENOMINATORS = (1, 12, 1000)


def farkas(problem: LCP, guess: FloatArray | None, max_time: float = math.inf) -> FloatArray | None:
    """Return a vector that proves the problem infeasible, or None if none was found.

    Parameters
    ----------
    problem
        The problem.
    guess
        (n,) a vector that may be one, such as the ray's direction of Lemke's method; None for no idea.
    max_time
        Bound on the linear program's time [s].
    """
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        for v in _candidates(problem, guess, max_time):
            if problem.proves_infeasible(v):
                return v
    return None


def _candidates(problem: LCP, guess: FloatArray | None, max_time: float) -> Iterator[FloatArray]:
    """Yield what may be a proof, the cheapest first."""
    M, d = equilibrated(problem.M)
    q = np.ldexp(problem.q, d - int(d.max(initial=0)))
    if guess is not None and np.isfinite(guess).all() and (guess > 0.0).any():
        yield from _round_candidates(np.ldexp(np.maximum(guess, 0.0), -d), d)
    found = _strictest(M, q / (float(np.abs(q).max()) or 1.0), max_time)
    if found is not None:
        yield from _round_candidates(found, d)


def _round_candidates(v: FloatArray, exponents: IntArray) -> Iterator[FloatArray]:
    """Yield v >= 0 of the equilibrated problem, cleaned and rounded, in the problem's own scale."""
    size = float(v.max())
    if not 0.0 < size < np.inf:
        return
    v = v / size
    for least in (0.0, 1e-12, 1e-7):
        yield np.ldexp(np.where(v > least, v, 0.0), exponents)
    kept = np.where(v > 1e-7, v, 0.0)
    unit = float(kept[kept > 0.0].min())
    for scaled in (np.ldexp(kept, exponents), kept / unit, kept):
        top = float(scaled.max())
        for denominator in DENOMINATORS:
            whole = _whole_ratios(scaled / top, denominator)
            if whole is not None:
                yield whole
                yield np.ldexp(whole, exponents)


def _whole_ratios(v: FloatArray, denominator: int) -> FloatArray | None:
    """Return whole numbers in the ratios of v, rounded to fractions of small denominators."""
    ratios = [Fraction(float(x)).limit_denominator(denominator) for x in v]
    common = math.lcm(*(x.denominator for x in ratios))
    whole = [int(x * common) for x in ratios]
    return np.array(whole, dtype=np.float64) if 0 < max(whole) < 2**53 else None


def _strictest(M: FloatArray, q: FloatArray, max_time: float) -> FloatArray | None:
    """Return v >= 0 with Mᵀ v <= -t, q . v <= -1 and the largest sum of t <= 1, by a linear program.

    Sums and multiples of proofs are proofs: the largest sum makes every inequality strict that can be.
    """
    from scipy.optimize import linprog

    n = q.size
    A = np.vstack([np.hstack([M.T, np.eye(n)]), np.append(q, np.zeros(n))])
    b = np.append(np.zeros(n), -1.0)
    bounds = np.column_stack([np.zeros(2 * n), np.repeat([np.inf, 1.0], n)])
    cost = np.repeat([0.0, -1.0], n)
    limit = {"time_limit": max_time} if max_time < math.inf else {}
    found = linprog(cost, A, b, bounds=bounds, method="highs", options=limit)  # type: ignore[call-overload]
    return None if found.x is None else np.maximum(np.asarray(found.x[:n], dtype=np.float64), 0.0)
