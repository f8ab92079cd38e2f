"""The contact laws of a knot in the plane as rows of an NLP: softened complementarity, or equations of modes.

All of them speak of velocities and impulses: the normal impulse stands against the velocity φ = gap / dt +
u_n with which the gap would be closed at the knot's end, so that a product of a pair is an energy [J].

`Facets` is the formulation of Posa, Cantu and Tedrake (IJRR 2014, eqs. 8-12, after Stewart and Trinkle): the
friction impulse is D β with β >= 0, and with γ the sliding speed

    0 <= φ ⟂ λ_n >= 0,    0 <= γ + Dᵀu_t ⟂ β >= 0,    0 <= mu λ_n - Σβ ⟂ γ >= 0

exact in the plane, where D has two directions. `GivenModes` has no softening left: each contact is open,
sticks or slides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.libraries import import_casadi
from surefoot.motion.planning.transcription.smoothed_complementarity import SoftForm, form_named

Expression = Any
OPEN, STICK, SLIDE = 0, 1, 2
"""Modes of a contact during a knot."""
DIRECTIONS = np.array([[1.0, -1.0]])
"""D (1, 2): along the ground in the plane y = 0, and back."""


@dataclass
class ContactRows:
    """Variables of a knot's contacts, what they must obey, and the impulses that they mean.

    Attributes
    ----------
    variables
        (m, 1) SX symbols.
    low, high
        (m,) bounds of the variables.
    rows
        Columns of SX with their bounds.
    impulses
        (3, p) SX in contact axes [N s].
    cost
        To be added to the objective.
    """

    variables: Expression
    low: FloatArray
    high: FloatArray
    impulses: Expression
    rows: list[tuple[Expression, float, float]] = field(default_factory=list)
    cost: Expression = 0.0

    def pair(self, form: SoftForm, a: Expression, b: Expression, eps: Expression) -> None:
        """Ask for a ⟂ b in a softened form."""
        soft = form.soften(a, b, eps)
        self.rows.append((soft.rows, soft.low, 0.0))
        self.cost = self.cost + soft.cost


class ContactLaw(Protocol):
    """A way to write the laws of p contacts."""

    def write(self, closing: Expression, sliding: Expression, mu: FloatArray, eps: Expression) -> ContactRows:
        """Return the rows of a knot.

        Parameters
        ----------
        closing
            (p, 1) SX, φ [m/s].
        sliding
            (1, p) SX, u_t [m/s].
        mu
            (p,) friction.
        eps
            SX scalar, the softening [J].
        """
        ...

    def start(
        self, impulses: FloatArray, closing: FloatArray, sliding: FloatArray, mu: FloatArray
    ) -> FloatArray:
        """Return values (N, m) of the variables for (N, p, 3), (N, p) and (N, p, 1) of N knots."""
        ...


@dataclass(frozen=True)
class Facets:
    """Posa's rows with two directions of friction.

    Attributes
    ----------
    form
        Name of the softened form, see `FORMS` of `transcription.smoothed_complementarity`.
    time
        What φ is multiplied by before it is paired [s]: with a knot's length gaps stand against impulses,
        and eps is no energy but a length times an impulse.
    """

    form: str = "relaxed"
    time: float = 1.0

    def __post_init__(self) -> None:
        form_named(self.form)

    def write(self, closing: Expression, sliding: Expression, mu: FloatArray, eps: Expression) -> ContactRows:
        """See `ContactLaw.write`; variables β, λ_n, φ, σ, γ, s of all contacts, one after the other.

        Without friction a contact has λ_n and φ only: the others are held at zero.
        """
        ca, form = import_casadi(), form_named(self.form)
        D = ca.DM(DIRECTIONS)

        def contact(out: ContactRows, k: int, parts: list[Expression]) -> Expression:
            beta, normal, phi, sigma, gamma, spare = parts
            if mu[k] == 0.0:
                out.rows.append((phi - self.time * closing[k], 0.0, 0.0))
                out.pair(form, normal, phi, eps)
                return ca.vertcat(0.0, 0.0, normal)
            # Both sides of every pair are variables of their own, tied to their expressions by equations: an
            # interior-point method keeps variables inside their bounds, but not expressions.
            equal = ca.vertcat(
                phi - self.time * closing[k],
                sigma - (gamma + D.T * sliding[k]),
                spare - (float(mu[k]) * normal - ca.sum1(beta)),
            )
            out.rows.append((equal, 0.0, 0.0))
            out.pair(form, normal, phi, eps)
            out.pair(form, beta, sigma, eps)
            out.pair(form, gamma, spare, eps)
            return ca.vertcat(ca.mtimes(D, beta), 0.0, normal)

        low = [0.0 if form.signs else -np.inf] * 8
        out = _interleave(int(closing.shape[0]), (2, 1, 1, 2, 1, 1), low, contact)
        held = np.ones(8, dtype=bool)
        held[2:4] = False
        without = np.outer(mu == 0.0, held).ravel()
        out.low[without] = out.high[without] = 0.0
        return out

    def start(
        self, impulses: FloatArray, closing: FloatArray, sliding: FloatArray, mu: FloatArray
    ) -> FloatArray:
        """See `ContactLaw.start`."""
        along = np.maximum(impulses[..., :1] * DIRECTIONS[0], 0.0)
        speed = np.abs(sliding)
        least = 0.0 if form_named(self.form).signs else -np.inf
        normal, phi = impulses[..., 2:3], np.maximum(self.time * closing[..., None], least)
        sigma = np.maximum(speed + sliding * DIRECTIONS[0], 0.0)
        spare = np.maximum(mu[:, None] * normal - along.sum(axis=-1, keepdims=True), least)
        return _flat(along, normal, phi, sigma, speed, spare)


@dataclass(frozen=True)
class GivenModes:
    """The laws where it is known which contacts are open, stick or slide: no softening is left.

    Variables λ_t, λ_n, φ, u_t, with bounds by the mode (`bounds`). The rows: mu² λ_n² - λ_t² >= 0, zero
    where a contact slides; there friction is against the slide, λ_t u_t <= 0.
    """

    def write(self, closing: Expression, sliding: Expression, mu: FloatArray, eps: Expression) -> ContactRows:
        """See `ContactLaw.write`."""
        ca = import_casadi()

        def contact(out: ContactRows, k: int, parts: list[Expression]) -> Expression:
            friction, normal, phi, u = parts
            out.rows.append((ca.vertcat(phi - closing[k], u - sliding[k]), 0.0, 0.0))
            out.rows.append((float(mu[k] * mu[k]) * normal * normal - friction * friction, 0.0, np.inf))
            out.rows.append((friction * u, -np.inf, np.inf))
            return ca.vertcat(friction, 0.0, normal)

        low = [-np.inf, 0.0, 0.0, -np.inf]
        return _interleave(int(closing.shape[0]), (1, 1, 1, 1), low, contact)

    def start(
        self, impulses: FloatArray, closing: FloatArray, sliding: FloatArray, mu: FloatArray
    ) -> FloatArray:
        """See `ContactLaw.start`."""
        return _flat(impulses[..., :1], impulses[..., 2:3], np.maximum(closing[..., None], 0.0), sliding)

    def bounds(self, modes: IntArray, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bounds (N, m) of the variables for modes (N, p) and friction (p,)."""
        inf, slick = np.inf, mu == 0.0
        # Open: no impulse, φ free upwards. Closed: φ = 0; sticking: u_t = 0.
        low = {OPEN: [0.0, 0.0, 0.0, -inf], STICK: [-inf, 0.0, 0.0, 0.0], SLIDE: [-inf, 0.0, 0.0, -inf]}
        high = {OPEN: [0.0, 0.0, inf, inf], STICK: [inf, inf, 0.0, 0.0], SLIDE: [inf, inf, 0.0, inf]}
        least, most = _by_mode(low, modes), _by_mode(high, modes)
        least[:, slick, 0] = most[:, slick, 0] = 0.0  # nothing holds such a contact back
        least[:, slick, 3], most[:, slick, 3] = -inf, inf
        return least.reshape(len(modes), -1), most.reshape(len(modes), -1)

    def row_bounds(self, modes: IntArray, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bounds (N, rows of the laws) for modes (N, p), in the order of `write`."""
        inf, free = np.inf, [0.0, 0.0, 0.0, -np.inf]
        low = {OPEN: free, STICK: free, SLIDE: free}
        high = {OPEN: [0.0, 0.0, inf, inf], STICK: [0.0, 0.0, inf, inf], SLIDE: [0.0, 0.0, 0.0, 0.0]}
        least, most = _by_mode(low, modes), _by_mode(high, modes)
        least[:, mu == 0.0, 2:], most[:, mu == 0.0, 2:] = -inf, inf
        return least.reshape(len(modes), -1), most.reshape(len(modes), -1)


def _by_mode(values: dict[int, list[float]], modes: IntArray) -> FloatArray:
    """Return the m numbers of every contact's mode, (N, p, m) of modes (N, p)."""
    return np.array([values[mode] for mode in modes.ravel().tolist()]).reshape(*modes.shape, -1)


def read_modes(
    impulses: FloatArray, closing: FloatArray, sliding: FloatArray, mu: FloatArray | float
) -> IntArray:
    """Return the modes (N, p) that softened contacts are nearest to.

    Parameters
    ----------
    impulses, closing, sliding
        (N, p, 3) [N s], (N, p) and (N, p, 1) [m/s].
    mu
        Friction, one for all or (p,).
    """
    friction, normal, speed = np.abs(impulses[..., 0]), impulses[..., 2], np.abs(sliding[..., 0])
    # Of each pair the larger side is the one that is not zero in the limit eps -> 0.
    slides = speed > mu * normal - friction
    return np.where(normal > closing, np.where(slides, SLIDE, STICK), OPEN).astype(np.int64)


def _interleave(
    p: int,
    sizes: tuple[int, ...],
    low: list[float],
    contact: Callable[[ContactRows, int, list[Expression]], Expression],
) -> ContactRows:
    """Return the rows of p contacts, one after the other.

    Parameters
    ----------
    p
        Number of contacts.
    sizes, low
        Of the parts of a contact's variables, and the least values of all of them.
    contact
        Adds the rows of a contact, given its number and parts, and returns its impulse (3, 1).
    """
    ca, many = import_casadi(), sum(sizes)
    x = ca.SX.sym("contact", many * p)
    out = ContactRows(x, np.tile(low, p), np.full(many * p, np.inf), None)
    ends = np.cumsum([0, *sizes]).tolist()
    each = [ca.vertsplit(x[k * many : (k + 1) * many], ends) for k in range(p)]
    out.impulses = ca.horzcat(*(contact(out, k, parts) for k, parts in enumerate(each)))
    return out


def _flat(*parts: FloatArray) -> FloatArray:
    """Return parts (N, p, m) of the contacts' variables side by side, as (N, p times their sum)."""
    values = np.concatenate(parts, axis=-1)
    return values.reshape(len(values), -1)
