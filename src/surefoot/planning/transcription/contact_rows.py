"""The contact laws of a knot as rows of an NLP: softened complementarity, or the equations of given modes.

All of them speak of velocities and impulses: the normal impulse stands against the velocity φ = gap / dt +
u_n with which the gap would be closed at the knot's end, so that a product of a pair is an energy [J].

`Facets` is the formulation of Posa, Cantu and Tedrake (IJRR 2014, eqs. 8-12, after Stewart and Trinkle): the
friction impulse is D β with β >= 0, and with γ the sliding speed

    0 <= φ ⟂ λ_n >= 0,    0 <= γ + Dᵀu_t ⟂ β >= 0,    0 <= mu λ_n - Σβ ⟂ γ >= 0

exact in the plane (two facets), an inner pyramid in space. `RoundCone` has the exact cone of space instead:
||λ_t|| <= mu λ_n, γ >= ||u_t||, and maximum dissipation as one product, mu γ λ_n + λ_t·u_t <= eps, which the
two inequalities keep above zero. `GivenModes` has no softening left: each contact is open, sticks or slides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.errors import ProblemError
from surefoot.planning.transcription.forms import SoftForm, form_named
from surefoot.robot.libraries import import_casadi

Expression = Any
OPEN, STICK, SLIDE = 0, 1, 2
"""Modes of a contact during a knot."""
AXES = {2: (0,), 3: (0, 1)}
"""Tangential contact axes in the plane y = 0 and in space."""
ROUND = 1e-3
"""Below this, norms of `RoundCone` are rounded off, in m/s and N s; less as eps falls, see `_rounding`."""


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
            (d, p) SX, u_t [m/s].
        mu
            (p,) friction.
        eps
            SX scalar, the softening [J].
        """
        ...

    def start(
        self, impulses: FloatArray, closing: FloatArray, sliding: FloatArray, mu: FloatArray
    ) -> FloatArray:
        """Return values (N, m) of the variables for (N, p, 3), (N, p) and (N, p, d) of N knots."""
        ...


@dataclass(frozen=True)
class Facets:
    """Posa's rows with a pyramid of friction.

    Attributes
    ----------
    count
        Directions of friction: 2 in the plane, 4 or more in space.
    form
        Name of the softened form, see `surefoot.planning.transcription.forms.FORMS`.
    time
        What φ is multiplied by before it is paired [s]: with a knot's length gaps stand against impulses,
        and eps is no energy but a length times an impulse.
    """

    count: int = 2
    form: str = "relaxed"
    time: float = 1.0

    def __post_init__(self) -> None:
        form_named(self.form)
        if self.count != 2 and self.count < 4:
            raise ProblemError(f"facets must be 2 in the plane, at least 4 in space, got {self.count}")

    @property
    def directions(self) -> FloatArray:
        """(d, count) unit vectors in the ground."""
        if self.count == 2:
            return np.array([[1.0, -1.0]])
        angles = 2.0 * np.pi * np.arange(self.count) / self.count
        return np.array([np.cos(angles), np.sin(angles)])

    def write(self, closing: Expression, sliding: Expression, mu: FloatArray, eps: Expression) -> ContactRows:
        """See `ContactLaw.write`; variables β, λ_n, φ, σ, γ, s of all contacts, one after the other.

        Without friction a contact has λ_n and φ only: the others are held at zero.
        """
        ca, form, m = import_casadi(), form_named(self.form), self.count
        D = ca.DM(self.directions)

        def contact(out: ContactRows, k: int, parts: list[Expression]) -> Expression:
            beta, normal, phi, sigma, gamma, spare = parts
            if mu[k] == 0.0:
                out.rows.append((phi - self.time * closing[k], 0.0, 0.0))
                out.pair(form, normal, phi, eps)
                return _with_normal(ca, ca.SX(len(self.directions), 1), normal)
            u = sliding[:, k]
            equal = ca.vertcat(
                phi - self.time * closing[k],
                sigma - (gamma + ca.mtimes(D.T, u)),
                spare - (float(mu[k]) * normal - ca.sum1(beta)),
            )
            out.rows.append((equal, 0.0, 0.0))
            out.pair(form, normal, phi, eps)
            out.pair(form, beta, sigma, eps)
            out.pair(form, gamma, spare, eps)
            return _with_normal(ca, ca.mtimes(D, beta), normal)

        low = [0.0 if form.signs else -np.inf] * (2 * m + 4)
        out = _written(int(closing.shape[0]), (m, 1, 1, m, 1, 1), low, contact)
        held = np.ones(2 * m + 4, dtype=bool)
        held[m : m + 2] = False
        without = np.outer(mu == 0.0, held).ravel()
        out.low[without] = out.high[without] = 0.0
        return out

    def start(
        self, impulses: FloatArray, closing: FloatArray, sliding: FloatArray, mu: FloatArray
    ) -> FloatArray:
        """See `ContactLaw.start`."""
        D = self.directions
        d = len(D)
        # a tangential impulse as the two directions beside it, or in the plane the one along it
        along = np.maximum(impulses[..., :d] @ D, 0.0) * (2.0 * d / self.count if d > 1 else 1.0)
        speed = np.linalg.norm(sliding, axis=-1, keepdims=True)
        least = 0.0 if form_named(self.form).signs else -np.inf
        normal, phi = impulses[..., 2:3], np.maximum(self.time * closing[..., None], least)
        sigma = np.maximum(speed + sliding @ D, 0.0)
        spare = np.maximum(mu[:, None] * normal - along.sum(axis=-1, keepdims=True), least)
        return _flat(along, normal, phi, sigma, speed, spare)


@dataclass(frozen=True)
class RoundCone:
    """Rows with the exact round cone of space, and maximum dissipation as one product.

    Attributes
    ----------
    form
        Of the normal pair; dissipation is always relaxed.
    """

    form: str = "relaxed"

    def __post_init__(self) -> None:
        form_named(self.form)

    def write(self, closing: Expression, sliding: Expression, mu: FloatArray, eps: Expression) -> ContactRows:
        """See `ContactLaw.write`; variables λ_t, λ_n, φ, u_t, γ of all contacts, one after the other."""
        ca, form = import_casadi(), form_named(self.form)
        d, p = (int(n) for n in sliding.shape)
        small = _rounding(ca, eps)

        def contact(out: ContactRows, k: int, parts: list[Expression]) -> Expression:
            friction, normal, phi, u, gamma = parts
            out.rows.append((ca.vertcat(phi - closing[k], u - sliding[:, k]), 0.0, 0.0))
            out.pair(form, normal, phi, eps)
            out.rows.append((float(mu[k]) * normal - _length(ca, friction, small), 0.0, np.inf))
            out.rows.append((gamma - _length(ca, u, small), 0.0, np.inf))
            out.rows.append((float(mu[k]) * gamma * normal + ca.dot(friction, u) - eps, -np.inf, 0.0))
            return _with_normal(ca, friction, normal)

        return _written(p, (d, 1, 1, d, 1), [-np.inf] * d + [0.0, 0.0] + [-np.inf] * d + [0.0], contact)

    def start(
        self, impulses: FloatArray, closing: FloatArray, sliding: FloatArray, mu: FloatArray
    ) -> FloatArray:
        """See `ContactLaw.start`."""
        return _flat(*_seen(impulses, closing, sliding), np.linalg.norm(sliding, axis=-1, keepdims=True))


@dataclass(frozen=True)
class GivenModes:
    """The laws where it is known which contacts are open, stick or slide: no softening is left.

    Variables λ_t, λ_n, φ, u_t, with bounds by the mode (`bounds`). The rows: mu² λ_n² - ||λ_t||² >= 0, zero
    where a contact slides; there friction lies along the slide, λ_t x u_t = 0 (nothing to ask in the plane),
    and against it, λ_t·u_t <= 0.
    """

    def write(self, closing: Expression, sliding: Expression, mu: FloatArray, eps: Expression) -> ContactRows:
        """See `ContactLaw.write`."""
        ca = import_casadi()
        d, p = (int(n) for n in sliding.shape)

        def contact(out: ContactRows, k: int, parts: list[Expression]) -> Expression:
            friction, normal, phi, u = parts
            out.rows.append((ca.vertcat(phi - closing[k], u - sliding[:, k]), 0.0, 0.0))
            if d == 2:
                out.rows.append((friction[0] * u[1] - friction[1] * u[0], -np.inf, np.inf))
            out.rows.append(
                (float(mu[k] * mu[k]) * normal * normal - ca.dot(friction, friction), 0.0, np.inf)
            )
            out.rows.append((ca.dot(friction, u), -np.inf, np.inf))
            return _with_normal(ca, friction, normal)

        return _written(p, (d, 1, 1, d), [-np.inf] * d + [0.0, 0.0] + [-np.inf] * d, contact)

    def start(
        self, impulses: FloatArray, closing: FloatArray, sliding: FloatArray, mu: FloatArray
    ) -> FloatArray:
        """See `ContactLaw.start`."""
        return _flat(*_seen(impulses, closing, sliding))

    def bounds(self, modes: IntArray, d: int, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bounds (N, m) of the variables for modes (N, p) and friction (p,)."""
        inf, slick = np.inf, mu == 0.0
        low = {
            OPEN: [0.0] * (d + 2) + [-inf] * d,
            STICK: [-inf] * d + [0.0] * (d + 2),
            SLIDE: [-inf] * d + [0.0, 0.0] + [-inf] * d,
        }
        high = {
            OPEN: [0.0] * (d + 1) + [inf] * (d + 1),
            STICK: [inf] * (d + 1) + [0.0] * (d + 1),
            SLIDE: [inf] * (d + 1) + [0.0] + [inf] * d,
        }
        least, most = _by_mode(low, modes), _by_mode(high, modes)
        least[:, slick, :d] = most[:, slick, :d] = 0.0  # nothing holds such a contact back
        least[:, slick, d + 2 :], most[:, slick, d + 2 :] = -inf, inf
        return least.reshape(len(modes), -1), most.reshape(len(modes), -1)

    def row_bounds(self, modes: IntArray, d: int, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bounds (N, rows of the laws) for modes (N, p), in the order of `write`."""
        inf, equal, cross = np.inf, [0.0] * (d + 1), d - 1
        free = [*equal, *[-inf] * cross, 0.0, -inf]
        low = {OPEN: free, STICK: free, SLIDE: [*equal, *[0.0] * cross, 0.0, -inf]}
        free = [*equal, *[inf] * cross, inf, inf]
        high = {OPEN: free, STICK: free, SLIDE: [*equal, *[0.0] * cross, 0.0, 0.0]}
        least, most = _by_mode(low, modes), _by_mode(high, modes)
        least[:, mu == 0.0, d + 1 :], most[:, mu == 0.0, d + 1 :] = -inf, inf
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
        (N, p, 3) [N s], (N, p) and (N, p, d) [m/s].
    mu
        Friction, one for all or (p,).
    """
    friction = np.linalg.norm(impulses[..., :2], axis=-1)
    normal, speed = impulses[..., 2], np.linalg.norm(sliding, axis=-1)
    closed = normal > closing
    slides = speed > mu * normal - friction
    return np.where(closed, np.where(slides, SLIDE, STICK), OPEN).astype(np.int64)


def _written(
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


def _with_normal(ca: Any, friction: Expression, normal: Expression) -> Expression:
    """Return an impulse (3, 1); in the plane its lateral part is zero."""
    across = ca.SX(1, 1) if friction.shape[0] == 1 else friction[1]
    return ca.vertcat(friction[0], across, normal)


def _rounding(ca: Any, eps: Expression) -> Expression:
    """Return what norms are rounded by: it falls with the softening."""
    return ca.fmin(ROUND, ca.sqrt(eps))


def _length(ca: Any, x: Expression, small: Expression) -> Expression:
    """Return ||x||, rounded off near zero and never larger."""
    return ca.sqrt(ca.dot(x, x) + small * small) - small


def _seen(
    impulses: FloatArray, closing: FloatArray, sliding: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return λ_t, λ_n, φ (not below zero) and u_t of motions, (N, p, ...) each."""
    friction, normal = impulses[..., : sliding.shape[-1]], impulses[..., 2:3]
    return friction, normal, np.maximum(closing[..., None], 0.0), sliding


def _flat(*parts: FloatArray) -> FloatArray:
    """Return parts (N, p, m) of the contacts' variables side by side, as (N, p times their sum)."""
    values = np.concatenate(parts, axis=-1)
    return values.reshape(len(values), -1)
