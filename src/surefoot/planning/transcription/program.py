"""A small problem as an NLP: semi-implicit Euler with the ground's answer at the end of every knot.

With impulses λ (normal) and β = β⁺ - β⁻ (friction), knot k says, as `surefoot.stepping.Knot` does::

    M(q) (v⁺ - v) = dt (S u - h(q, v)) + Jₙᵀ λ + Jₜᵀ β,      q⁺ = q + dt v⁺
    0 <= gap(q) + dt Jₙ v⁺ ⟂ λ >= 0                           no penetration, no pulling
    0 <= γ + Jₜ v⁺ ⟂ β⁺ >= 0,   0 <= γ - Jₜ v⁺ ⟂ β⁻ >= 0      friction against sliding: γ = |Jₜ v⁺|
    0 <= mu λ - β⁺ - β⁻ ⟂ γ >= 0                              on the cone where it slides

(Stewart and Trinkle 1996; Posa, Cantu and Tedrake 2014): exact Coulomb friction in the plane. The left sides
of the pairs are variables of their own, so that an interior-point method can keep them positive.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.planning.transcription.forms import Form, import_casadi
from surefoot.planning.transcription.problem import Motion, SmallProblem


@dataclass(frozen=True)
class Units:
    """In which units the pairs are softened.

    A form sees gap / `length`, impulse / `impulse`, speed / `speed`. The answer does not
    depend on them, the path to it does.
    """

    length: float = 1.0
    impulse: float = 1.0
    speed: float = 1.0


@dataclass(frozen=True)
class Layout:
    """Where the parts of a knot stand among its variables: q⁺, v⁺, u, then a and b of all pairs.

    Pairs are in the order normal (p), β⁺ (f), β⁻ (f), cone (f), with p contacts, f of them with friction.
    """

    n: int
    m: int
    p: int
    f: int

    @property
    def pairs(self) -> int:
        """Pairs of a knot."""
        return self.p + 3 * self.f

    @property
    def width(self) -> int:
        """Variables of a knot."""
        return 2 * self.n + self.m + 2 * self.pairs

    def ends(self) -> IntArray:
        """(6,) where q⁺, v⁺, u, a, b begin, and the end."""
        parts = np.array([0, self.n, self.n, self.m, self.pairs, self.pairs])
        return np.cumsum(parts)


@dataclass(frozen=True)
class Program:
    """An NLP for CasADi whose parameter is the smoothing.

    Attributes
    ----------
    problem, form, layout, units
        What it was made of.
    nlp
        For `casadi.nlpsol`.
    low, high, row_low, row_high
        Bounds of variables and rows.
    """

    problem: SmallProblem
    form: Form
    layout: Layout
    units: Units
    nlp: dict[str, Any]
    low: FloatArray
    high: FloatArray
    row_low: FloatArray
    row_high: FloatArray

    def pack(self, motion: Motion) -> FloatArray:
        """Return the variables (n,) of a motion; a of each pair is the size of what it stands for."""
        problem, layout, z = self.problem, self.layout, []
        for k in range(problem.knots):
            a, b = pairs_at(problem, motion, k)
            slack = np.abs(a) if self.form.signs else a
            z += [motion.q[k + 1], motion.v[k + 1], motion.u[k], slack / self._of(True), b / self._of(False)]
        packed = np.concatenate(z)
        assert packed.size == layout.width * problem.knots
        return packed

    def unpack(self, z: FloatArray) -> Motion:
        """Return the motion of variables (n,)."""
        problem, system = self.problem, self.problem.system
        rows = z.reshape(problem.knots, self.layout.width)
        q, v, u, _, b = np.split(rows, self.layout.ends()[1:-1], axis=1)
        b = b * self._of(False)
        p, f = self.layout.p, self.layout.f
        friction = np.zeros((problem.knots, p))
        friction[:, list(system.rubbing)] = b[:, p : p + f] - b[:, p + f : p + 2 * f]
        return Motion(np.vstack([problem.q, q]), np.vstack([problem.v, v]), u, b[:, :p].copy(), friction)

    def sides(self) -> tuple[IntArray, IntArray]:
        """Return the numbers of the variables a and b of all pairs: (knots pairs,) each."""
        starts = np.arange(self.problem.knots)[:, None] * self.layout.width
        begins = self.layout.ends()
        own = np.arange(self.layout.pairs)
        return (starts + begins[3] + own).ravel(), (starts + begins[4] + own).ravel()

    def _of(self, left: bool) -> FloatArray:
        """Return the units of a (left) or b."""
        return unit_columns(self.layout, self.units)[0 if left else 1]


def unit_columns(layout: Layout, units: Units) -> tuple[FloatArray, FloatArray]:
    """Return (pairs,) units of a and of b."""
    p, f = layout.p, layout.f
    a = np.repeat([units.length, units.speed, units.speed, units.impulse], [p, f, f, f])
    b = np.repeat([units.impulse, units.impulse, units.impulse, units.speed], [p, f, f, f])
    return a, b


def pairs_at(problem: SmallProblem, motion: Motion, k: int) -> tuple[FloatArray, FloatArray]:
    """Return a and b of the pairs of knot k, as the laws read them from a motion: (pairs,) each, SI units.

    γ is the sliding speed itself.
    """
    system = problem.system
    q, after = motion.q[k], motion.v[k + 1]
    rubs = list(system.rubbing)
    gap = np.array(system.gap(q)).ravel() + problem.dt * np.array(system.normal(q)) @ after
    slide = (np.array(system.tangent(q)) @ after)[rubs]
    beta = motion.friction[k][rubs]
    left, right = np.maximum(beta, 0.0), np.maximum(-beta, 0.0)
    speed = np.abs(slide)
    spare = system.mu[rubs] * motion.normal[k][rubs] - left - right
    a = np.concatenate([gap, speed + slide, speed - slide, spare])
    return a, np.concatenate([motion.normal[k], left, right, speed])


def transcribe(problem: SmallProblem, form: Form, units: Units | None = None) -> Program:
    """Return a problem as an NLP in one of the forms.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """
    casadi = import_casadi()
    system, units = problem.system, units or Units()
    layout = Layout(system.size, len(system.actuated), len(system.touches), len(system.rubbing))
    z, eps = casadi.SX.sym("z", layout.width * problem.knots), casadi.SX.sym("eps")
    q, v = casadi.SX(casadi.DM(problem.q)), casadi.SX(casadi.DM(problem.v))
    rows: list[Any] = []
    row_low: list[FloatArray] = []
    row_high: list[FloatArray] = []
    cost = casadi.SX(0.0)
    for k in range(problem.knots):
        mine = z[k * layout.width : (k + 1) * layout.width]
        q, v, u, laws, a, b = _knot(problem, layout, units, mine, (q, v))
        soft = form.soften(a, b, eps)
        rows += [laws, soft.rows]
        row_low += [np.zeros(laws.shape[0]), soft.lower]
        row_high += [np.zeros(laws.shape[0]), soft.upper]
        cost += soft.cost + problem.effort * problem.dt * casadi.sumsqr(u)
    if problem.goal is not None:
        end = problem.goal(q, v)
        rows.append(end)
        row_low.append(np.zeros(end.shape[0]))
        row_high.append(np.zeros(end.shape[0]))
    low, high = _bounds(problem, layout, form)
    nlp = {"x": z, "p": eps, "f": cost, "g": casadi.vertcat(*rows)}
    return Program(
        problem, form, layout, units, nlp, low, high, np.concatenate(row_low), np.concatenate(row_high)
    )


def _knot(
    problem: SmallProblem, layout: Layout, units: Units, z: Any, before: tuple[Any, Any]
) -> tuple[Any, ...]:
    """Return q⁺, v⁺, u, the rows of the knot that are zero, and its a and b in the units of the form."""
    casadi = import_casadi()
    system, dt, (q, v) = problem.system, problem.dt, before
    after, speed, u, a, b = casadi.vertsplit(z, layout.ends().tolist())
    p, f = layout.p, layout.f
    of_a, of_b = (casadi.DM(x) for x in unit_columns(layout, units))
    told, given = a * of_a, b * of_b
    normal, left, right, slides = casadi.vertsplit(given, np.cumsum([0, p, f, f, f]).tolist())
    rubs = list(system.rubbing)
    pick = casadi.DM(np.eye(p)[rubs])
    Jn, Jt = system.normal(q), pick @ system.tangent(q)
    force = dt * (casadi.DM(system.selection) @ u - system.bias(q, v)) + Jn.T @ normal + Jt.T @ (left - right)
    slide = Jt @ speed
    spare = casadi.DM(system.mu[rubs]) * (pick @ normal) - left - right
    meant = casadi.vertcat(system.gap(q) + dt * (Jn @ speed), slides + slide, slides - slide, spare)
    laws = casadi.vertcat(system.mass(q) @ (speed - v) - force, after - q - dt * speed, told - meant)
    return after, speed, u, laws, a, b


def _bounds(problem: SmallProblem, layout: Layout, form: Form) -> tuple[FloatArray, FloatArray]:
    """Return the bounds of all variables."""
    n, pairs = layout.n, layout.pairs
    least = 0.0 if form.signs else -np.inf
    low = [np.broadcast_to(problem.low, n), np.full(n, -np.inf), -problem.limit, np.full(2 * pairs, least)]
    high = [np.broadcast_to(problem.high, n), np.full(n, np.inf), problem.limit, np.full(2 * pairs, np.inf)]
    return np.tile(np.concatenate(low), problem.knots), np.tile(np.concatenate(high), problem.knots)
