"""The derivative of an exchange of impulses, by everything that goes into it.

With w = v⁺ - v, at fixed impulses λ and by inverse dynamics ID at (q, 0, w / h), of a first-order step at
(q, v, w / h) (Pinocchio's derivatives)::

    M δv⁺ = M δv + (∂(Jᵀλ)/∂q - h ∂ID/∂q) δq - h ∂ID/∂v δv + h δτ
    b = δ(J v⁺ + shift) at fixed λ,     δλ = ∂λ/∂g b + ∂λ/∂mu δmu,     δv⁺ += M⁻¹ Jᵀ δλ

with ∂λ/∂g of the contact problem, see `derivative.solution_derivative`. The shift of the normal velocity is
that of `arithmetic.assemble`, and the guess of `arithmetic.swerves`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact import SoftLaw
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics.derivative.contact_problem import Response
from surefoot.mechanics.dynamics.derivative.flow import Dynamics
from surefoot.mechanics.dynamics.derivative.points import GroundRates
from surefoot.mechanics.dynamics.detection import Contacts
from surefoot.mechanics.dynamics.options import StepOptions
from surefoot.mechanics.dynamics.state import Impact

TOUCHING = 1e-9
"""Gaps up to this are none: whether they open or close makes two derivatives [m]."""
RESTING = 1e-6
"""Gaps up to this stay as they are where one slope is asked for both ways: on the ground [m]."""


def law_fields(law: SoftLaw) -> tuple[str, ...]:
    """Return the names of a soft law's numbers, in their order."""
    return tuple(f.name for f in fields(law) if isinstance(getattr(law, f.name), float | int))


class InputRates(NamedTuple):
    """Rates of what goes into a step, or into one of its stages, as c columns.

    Attributes
    ----------
    q, v
        (nv, c) of the configuration and of the velocity, on arrival at the stage.
    torques, push
        (joints, c) and (3, c) of the torques and of the push.
    mu
        (p, c) of every contact's friction.
    leaving
        (3p, c) of the contact velocities after the last impulses.
    inertia
        (10 bodies, c) of the inertial parameters; None for none.
    one_sided
        Whether contacts that touch open or press as each column says; None: they stay on the ground.
    seconds
        (c,) of the length of the step, the time to the next impulses; None for none.
    restitution, law
        (p, c) of restitution, and (fields, c) of a soft law's numbers, see `law_fields`; None for none.
    """

    q: FloatArray
    v: FloatArray
    torques: FloatArray
    mu: FloatArray
    push: FloatArray
    leaving: FloatArray
    inertia: FloatArray | None = None
    one_sided: bool | None = False
    seconds: FloatArray | None = None
    restitution: FloatArray | None = None
    law: FloatArray | None = None


@dataclass(frozen=True)
class Exchange:
    """An exchange of impulses: what happened, what it depends on, and the answer of its contact problem.

    Attributes
    ----------
    dynamics
        Of the bodies, with the gravity that acts during the exchange.
    impact
        What happened.
    contacts, ground
        At its configuration, and how they turn with it.
    foot, restitution
        (p,) what each contact belongs to, and its restitution.
    light
        (nv, nv) inverse of the lower factor of the mass matrix.
    span
        Length of the exchange [s].
    base_rotation
        (3, 3) rotation_world_base.
    speed
        (nv,) velocity at which the bodies' own motion makes forces during the exchange; zero for none.
    last, leaving
        (p, 3) impulses before [N s] and contact velocities right after them [m/s].
    horizon
        Time to the next impulses [s].
    options, pull
        Of the step, and the share of a penetration that is asked back.
    response
        The answer of the contact problem; None without contacts.
    """

    dynamics: Dynamics
    impact: Impact
    contacts: Contacts
    ground: GroundRates
    foot: IntArray
    restitution: FloatArray
    light: FloatArray
    span: float
    base_rotation: FloatArray
    speed: FloatArray
    last: FloatArray
    leaving: FloatArray
    horizon: float
    options: StepOptions
    pull: float
    response: Response | None

    @property
    def _change(self) -> FloatArray:
        """Acceleration (nv,) of the whole exchange over its span."""
        return np.asarray((self.impact.after - self.impact.before) / self.span)

    @property
    def force(self) -> FloatArray:
        """All forces but the ground's (nv,) [N, N m]."""
        change = self.impact.free - self.impact.before
        return np.asarray(np.linalg.solve(self.light.T @ self.light, change) / self.horizon)

    def _takes(self, inertia: FloatArray | None) -> FloatArray | float:
        """Return the effort (nv, c) [N s, N m s] that rates (10 bodies, c) of inertial parameters mean."""
        if inertia is None:
            return 0.0
        Y = self.dynamics.regressor(self.impact.q, self.speed, self._change)
        return np.asarray(-(self.span * Y) @ inertia)

    def through(
        self, rates: InputRates, effort: FloatArray | float = 0.0
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the rates of v⁺ (nv, c), of the contact velocities after it (3p, c), and of λ (3p, c).

        `effort` (nv, c) are those of the impulse of all forces but the ground's [N s, N m s].
        """
        impact, J, near = self.impact, self.contacts.J, self.impact.near
        rows = (3 * near[:, None] + np.arange(3)).ravel()
        by_q, by_v = self.dynamics.rates(impact.q, self.speed, self._change)
        turned = self.ground.force(impact.impulses)
        effort = (turned - self.span * by_q) @ rates.q + (effort + self._takes(rates.inertia))
        if self.speed.any():
            effort -= self.span * by_v @ rates.v
        spin = self.ground.velocity(impact.after)
        light = self.light
        v = rates.v + light.T @ (light @ effort)
        impulses = np.zeros((J.shape[0], v.shape[1]))
        if near.size:
            assert impact.rows is not None
            assert self.response is not None
            # What the contact velocities would do if the impulses stayed, and the shift with them: to this
            # the problem answers by ∂λ/∂g.
            b = (spin @ rates.q + J @ v)[rows]
            b[2::3] += self._shift(rates)
            guess = self._swerve(rates)
            if guess is not None:
                b += guess[rows]
            respond = self.response.one_sided if rates.one_sided else self.response.linear
            impulses[rows] = respond(b, rates.mu[near])
            v = v + light.T @ (impact.rows.T @ impulses[rows])
        return v, spin @ rates.q + J @ v, impulses

    def _arriving(self, rates: InputRates) -> FloatArray:
        """Return the rates (3p, c) of the contact velocities before the impulses."""
        return self.ground.velocity(self.impact.before) @ rates.q + self.contacts.J @ rates.v

    def _shift(self, rates: InputRates) -> FloatArray:
        """Return the rates (k, c) of the normal velocity that the law adds; see `arithmetic.assemble`."""
        impact, options, horizon, pull = self.impact, self.options, self.horizon, self.pull
        near, gaps = impact.near, self.contacts.gaps[impact.near]
        if options.soft is not None:
            return self._soft_shift(rates, options.soft)
        share = np.where(gaps > 0.0, 1.0, pull) / horizon
        opening = self.ground.gaps()[near] @ rates.q
        if rates.one_sided is None:
            share = np.where(np.abs(gaps) <= RESTING, 1.0, share * horizon) / horizon
        out = share[:, None] * opening
        if rates.one_sided and (touching := np.abs(gaps) <= TOUCHING).any():
            # A gap of zero is the kink of gap -> shift: a motion that opens it has the slope of open gaps,
            # one that closes it that of penetration.
            out[touching] = np.where(opening > 0.0, 1.0, pull)[touching] / horizon * opening[touching]
        if rates.seconds is not None:
            # The shift is gap over the time to the next impulses.
            out -= np.outer(share * gaps / horizon, rates.seconds)
        e = self.restitution[near]
        if e.any():
            normal = self.contacts.J[3 * near + 2]
            before, free = normal @ impact.before, normal @ impact.free
            slow = options.rest_speed
            hit = arithmetic.normal_shifts(gaps, before, free, horizon, e, slow, pull)[1]
            out[hit] = e[hit, None] * self._arriving(rates)[3 * near[hit] + 2]
            if rates.restitution is not None:
                out[hit] += before[hit, None] * rates.restitution[near[hit]]
        return np.asarray(out)

    def _soft_shift(self, rates: InputRates, law: SoftLaw) -> FloatArray:
        """Return the same under a law λ = Λ(gap, u, u⁻, θ): -(∂Λ/∂gap δgap + ...) / |∂Λ/∂u|.

        A contact that ends the step at the surface has u = -gap / horizon instead.
        """
        impact, horizon = self.impact, self.horizon
        assert impact.solution is not None
        near, speeds = impact.near, impact.velocities[impact.near, 2]
        gaps, opening = self.contacts.gaps[near], self.ground.gaps()[near] @ rates.q
        before = self.contacts.J[3 * near + 2] @ impact.before
        steep = np.asarray(impact.solution.problem.compliance).reshape(-1, 3)[:, 2:]

        def slope(width: float, gap: float = 0.0, speed: float = 0.0, **fields: float) -> FloatArray:
            ends = []
            for w in (-width, width):
                other = replace(law, **{n: getattr(law, n) + w * share for n, share in fields.items()})
                ends.append(other.over_step(gaps + w * gap, speeds, before + w * speed, horizon)[0])
            return np.asarray(horizon * (ends[1] - ends[0]) / (2.0 * width))[:, None]

        push = slope(1e-8, gap=1.0) * opening
        push += slope(1e-6, speed=1.0) * self._arriving(rates)[3 * near + 2]
        for rate, name in zip(() if rates.law is None else rates.law, law_fields(law), strict=False):
            if rate.any():
                push += slope(1e-5 * max(abs(getattr(law, name)), 1e-3), **{name: 1.0}) * rate
        return np.where(steep > 0.0, -steep * push, opening / horizon)

    def _swerve(self, rates: InputRates) -> FloatArray | None:
        """Return the rates (3p, c) of the guess that the laws' velocities contain; None without one."""
        impact, last, leaving, feet = self.impact, self.last, self.leaving, self.foot
        taken = impact.velocities - impact.leaving
        if impact.velocities is impact.leaving:
            return None
        frames = self.contacts.frames
        guess = self.contacts.swerves(impact.before, leaving, last, feet, 0.0)
        axes = 2 if self.options.soft is not None else 3  # soft laws take no guess along the normal
        # `Meeting.collide` takes half the change, or the mean over the impulses where that would make energy:
        # which of both it was shows in the step's velocities.
        half = guess is not None and bool(
            (np.abs(guess[1] - taken)[:, :axes] <= 1e-12 + 1e-6 * np.abs(taken[:, :axes])).all()
        )
        change = self._arriving(rates)
        arriving = self.contacts.velocities(impact.before)
        value = 0.5 * (arriving - leaving) if half else arriving
        if half:
            change = 0.5 * (change - rates.leaving)
        change = change.reshape(*leaving.shape, -1)
        loaded, out = last[:, 2] > 0.0, np.zeros_like(change)
        if len(loaded) == len(np.unique(feet)):  # point feet have no mean to share
            out[loaded, :axes] = change[loaded, :axes]
            return out.reshape(leaving.size, -1)
        turn = self.ground.frames(rates.q)  # (p, 3, 3, c)
        world = np.einsum("cia,cax->cix", frames, change) + np.einsum("ciax,ca->cix", turn, value)
        for foot in np.unique(feet[loaded]):
            mine = np.flatnonzero(feet == foot)
            mean = world[mine[loaded[mine]]].mean(axis=0)
            rest = mean - np.einsum("ciax,ca->cix", turn[mine], taken[mine])
            out[mine, :axes] = np.einsum("cia,cix->cax", frames[mine], rest)[:, :axes]
        return out.reshape(leaving.size, -1)
