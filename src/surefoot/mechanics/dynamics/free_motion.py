"""The motion of a robot between impulses: its equations of motion under constant joint torques.

::

    q̇ = v,      v̇ = M(q)⁻¹ (τ - h(q, v))

in tangent coordinates ξ of q = q₀ ⊕ ξ (Munthe-Kaas [2]_), so that orientations stay orientations:
ξ̇ = dexp⁻¹(ξ) v. The least work that keeps one tolerance: a constant acceleration (one evaluation), one that
changes evenly (two), Dormand and Prince's embedded pair of fifth order [1]_ (seven) in as many pieces as that
takes. Momentum and kinetic energy are kept as well as the tolerance says; nothing is projected.

References
----------
.. [1] J. R. Dormand, P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6, 1980.
.. [2] H. Munthe-Kaas, "High order Runge-Kutta methods on manifolds", Applied Numerical Mathematics 29, 1999.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.vectors import largest
from surefoot.mechanics.dynamics.impacts import LostMotion

STAGES = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
        [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
"""Share of each slope in each stage; the last row is the step itself."""
ERROR = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
"""Step of fifth order minus the embedded one of fourth, in slopes."""
TOLERANCE = 1e-8
"""Largest error of a step, in velocities, as a share of the largest velocity."""
HOPE = 1e3
"""Error of constant acceleration, in tolerances, up to which one that changes evenly may do."""
PIECES = 500
"""Most pieces tried for one step."""
SHRINK, GROW, SAFETY = 0.2, 5.0, 0.9
"""Bounds of the change of a piece's length after one, and its safety factor."""


class Ahead(NamedTuple):
    """Where a motion leads: q (nq,), v (nv,), and the acceleration there (nv,) where it came for nothing."""

    q: FloatArray
    v: FloatArray
    rate: FloatArray | None


class FreeMotion:
    """Moves a robot that nothing touches; one per thread, since it keeps its work arrays.

    Parameters
    ----------
    model
        Pinocchio's, with the gravity that is meant.
    floating
        Whether the first joint is a free flyer, or how many of them there are before all others.
    data
        Pinocchio's; None where `acceleration` needs none.
    """

    def __init__(self, model: Any, floating: int, data: Any = ...) -> None:
        import pinocchio

        self.model, self.data = model, model.createData() if data is ... else data
        self._floating = int(floating)
        self._curved = [
            slice(joint.idx_v, joint.idx_v + joint.nv)
            for k, joint in enumerate(model.joints)
            if k > self._floating and joint.nq != joint.nv > 1
        ]
        """Velocities of other joints whose positions are rotations, as of ball joints."""
        self._aba, self._integrate = pinocchio.aba, pinocchio.integrate
        n = model.nv
        self._rest = np.zeros(n)
        self._moves, self._slopes = np.zeros((7, n)), np.zeros((7, n))
        self._xi, self._speed = np.zeros(n), np.zeros(n)

    def acceleration(self, q: FloatArray, v: FloatArray, effort: FloatArray | None = None) -> FloatArray:
        """Return v̇ (nv,) under (nv,) generalised forces [N m, N]."""
        return np.asarray(self._aba(self.model, self.data, q, v, self._rest if effort is None else effort))

    def advance(
        self,
        q: FloatArray,
        v: FloatArray,
        seconds: float,
        effort: FloatArray | None = None,
        rate: FloatArray | None = None,
    ) -> Ahead | None:
        """Return where q (nq,), v (nv,) lead in `seconds` [s]; None where `PIECES` do not do.

        `rate` is the acceleration at the start as the last call left it (`Ahead.rate`), for a motion that
        goes on from there; None where it is not known.
        """
        # From the cheapest up: each formula comes with an estimate of its own error, and the next one is paid
        # for only where that is above the tolerance. Joints with curved positions of their own need the
        # stages' `_bend`.
        known = rate is not None
        first = self.acceleration(q, v, effort) if rate is None else rate
        xi, speed = self._xi, self._speed
        last = first
        error = straight(seconds, first, v, xi, speed)
        if not error <= TOLERANCE:
            if self._curved or not error <= HOPE * TOLERANCE:
                return self._pieces(q, v, seconds, first, effort)
            halfway(seconds, first, v, xi, speed)
            last = self.acceleration(self._integrate(self.model, q, xi), speed, effort).copy()
            if not bent(seconds, first, last, v, self._floating, xi, speed) <= TOLERANCE:
                return self._pieces(q, v, seconds, first, effort)
        # an acceleration is carried on once: cheap steps in a row would let it drift
        return Ahead(self._integrate(self.model, q, xi), speed.copy(), None if known else last)

    def _pieces(
        self, q: FloatArray, v: FloatArray, seconds: float, first: FloatArray, effort: FloatArray | None
    ) -> Ahead | None:
        """Go on in pieces, each as long as the embedded pair allows."""
        left = length = seconds
        for _ in range(PIECES):
            error, ahead, speed = self._piece(q, v, length, first, effort)
            if error <= TOLERANCE:
                q, v, first, left = ahead, speed, self._slopes[6].copy(), left - length
                if left <= 0.0:
                    return Ahead(q, v, first)
            elif not error < np.inf:
                error = np.inf  # not a number: as short as it goes
            # The error of the embedded pair is of fifth order in the length of a piece.
            change = SAFETY * (TOLERANCE / max(error, 1e-30)) ** 0.2
            length *= min(GROW, max(SHRINK, change))
            if length >= left * (1.0 - 1e-9):
                length = left
        return None

    def _piece(
        self, q: FloatArray, v: FloatArray, h: float, first: FloatArray, effort: FloatArray | None
    ) -> tuple[float, FloatArray, FloatArray]:
        """Return the error of one piece of `h` seconds, and where it ends."""
        moves, slopes, xi, speed = self._moves, self._slopes, self._xi, self._speed
        # First same as last: the seventh stage is the acceleration at the end, with which the next piece
        # begins.
        slopes[0] = first
        moves[0] = v
        at = q
        for i in range(1, 7):
            stage(i, h, v, moves, slopes, self._floating, xi, speed)
            at = self._integrate(self.model, q, xi)
            if self._curved:
                self._bend(q, i)
            slopes[i] = self.acceleration(at, speed, effort)
        return pair_error(h, slopes, speed), at, speed.copy()

    def _bend(self, q: FloatArray, i: int) -> None:
        """Set ξ̇ of stage `i` for the curved joints: their blocks of D ξ̇ = v, with D of q ⊕ ξ by ξ."""
        import pinocchio

        D = pinocchio.dIntegrate(self.model, q, self._xi, pinocchio.ArgumentPosition.ARG1)
        for part in self._curved:
            self._moves[i, part] = np.linalg.solve(D[part, part], self._speed[part])


def moved(
    motion: FreeMotion,
    q: FloatArray,
    v: FloatArray,
    seconds: float,
    effort: FloatArray | None = None,
    rate: FloatArray | None = None,
) -> Ahead:
    """Return where a motion without contacts leads, see `FreeMotion.advance`; `LostMotion` where nowhere."""
    ahead = motion.advance(q, v, seconds, effort, rate)
    if ahead is None or not largest(ahead.q) < np.inf:
        raise LostMotion("motion")
    return ahead


@inline_kernel
def bracket(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Write the Lie bracket [a, b] of two base twists [linear; angular], in any unit, into out (6,)."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = a[3 + j] * b[k] - a[3 + k] * b[j] + a[j] * b[3 + k] - a[k] * b[3 + j]
        out[3 + i] = a[3 + j] * b[3 + k] - a[3 + k] * b[3 + j]


@kernel
def stage(
    i: int, h: float, v: FloatArray, moves: FloatArray, slopes: FloatArray, flyers: int,
    xi: FloatArray, speed: FloatArray,
) -> None:  # fmt: skip
    """Write ξ, v and ξ̇ of stage `i` of a piece of h [s] that starts with v (nv,).

    `moves` and `slopes` (7, nv) hold ξ̇ and v̇ of the stages; the first `flyers` joints are free flyers.
    ξ̇ = v + [ξ, v]/2 + [ξ, [ξ, v]]/12 - ad⁴/720, exact to the order of the method, in body axes.
    """
    for k in range(v.size):
        # An explicit Runge-Kutta stage of (ξ, v).
        a = b = 0.0
        for j in range(i):
            a += STAGES[i, j] * moves[j, k]
            b += STAGES[i, j] * slopes[j, k]
        xi[k] = h * a
        speed[k] = v[k] + h * b
        moves[i, k] = speed[k]
    # Joints of one axis have ξ̇ = v. A free flyer's velocity is along axes that turn with it: dexp⁻¹ in
    # brackets, with the Bernoulli numbers over factorials; the odd ones beyond the first are zero.
    one, two, three, four = np.empty(6), np.empty(6), np.empty(6), np.empty(6)
    for b in range(flyers):
        turn = xi[6 * b : 6 * b + 6]
        bracket(turn, speed[6 * b : 6 * b + 6], one)
        bracket(turn, one, two)
        bracket(turn, two, three)
        bracket(turn, three, four)
        for k in range(6):
            moves[i, 6 * b + k] += 0.5 * one[k] + two[k] / 12.0 - four[k] / 720.0


@kernel
def straight(h: float, rate: FloatArray, v: FloatArray, xi: FloatArray, speed: FloatArray) -> float:
    """Write ξ and v after h [s] of constant v̇ = `rate` (nv,); return the error of v over the largest.

    Over h an acceleration changes by about itself times the angle turned, h times the largest velocity, as
    Coriolis terms are quadratic in v. NaN where the rate is not finite.
    """
    pace = 0.0
    for k in range(v.size):
        if not abs(rate[k]) < np.inf:
            return np.nan
        pace = max(pace, abs(rate[k]))
        speed[k] = v[k] + h * rate[k]
        xi[k] = h * (v[k] + 0.5 * h * rate[k])
    return h * h * pace


@kernel
def halfway(h: float, rate: FloatArray, v: FloatArray, xi: FloatArray, speed: FloatArray) -> None:
    """Write ξ and v after h / 2 [s] of constant v̇ = `rate` (nv,)."""
    for k in range(v.size):
        speed[k] = v[k] + 0.5 * h * rate[k]
        xi[k] = 0.5 * h * (v[k] + 0.25 * h * rate[k])


@kernel
def bent(
    h: float, rate: FloatArray, middle: FloatArray, v: FloatArray, flyers: int,
    xi: FloatArray, speed: FloatArray,
) -> float:  # fmt: skip
    """Write ξ and v after h [s] of a v̇ that changes evenly; return the error of v over the largest one.

    v̇ goes from `rate` (nv,) over `middle` at h / 2 to what replaces `middle`. The error is the change of v̇
    over h, times the angle turned. NaN where a rate is not finite.
    """
    change = 0.0
    for k in range(v.size):
        a, b = rate[k], middle[k]
        if not abs(b - a) < np.inf:
            return np.nan
        # v̇ = a + 2 (b - a) t / h, integrated once and twice; at the end it is 2 b - a.
        change = max(change, abs(b - a))
        speed[k] = v[k] + h * b
        xi[k] = h * v[k] + h * h * (a + 2.0 * b) / 6.0
        middle[k] = 2.0 * b - a
    swerve = np.empty(6)
    for b in range(flyers):
        # First commutator of Magnus' series: while v turns to v + h v̇, twists before and after do not
        # commute.
        bracket(v[6 * b : 6 * b + 6], rate[6 * b : 6 * b + 6], swerve)
        for k in range(6):
            xi[6 * b + k] += h * h * h / 12.0 * swerve[k]
    return h * h * change


@kernel
def pair_error(h: float, slopes: FloatArray, v: FloatArray) -> float:
    """Return how far the pair's velocities differ, over the largest velocity; NaN where one is.

    For a step h [s] from v (nv,) with the seven accelerations `slopes` (7, nv).
    """
    worst = largest = 0.0
    for k in range(v.size):
        total = 0.0
        for j in range(7):
            # h Σ (b_j - b̂_j) k_j: the difference of the two steps, the error of the one of fourth order.
            total += ERROR[j] * slopes[j, k]
        if not abs(total) < np.inf:
            return np.nan
        worst = max(worst, abs(h * total))
        largest = max(largest, abs(v[k]))
    return worst / largest if worst > 0.0 else 0.0
