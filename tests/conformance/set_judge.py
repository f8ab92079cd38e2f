"""The laws of every kind of contact, typed in from the pages: a judge that shares no arithmetic."""

from __future__ import annotations

import math

import numpy as np

import surefoot as sf
from surefoot.contact.sets import ContactKind


def check_laws(contact: ContactKind, f: np.ndarray, u: np.ndarray, theta: float, tol: float) -> None:
    """Admissible, unilateral, and of maximum dissipation; θ Γ(u) less, contacts open by (1 - θ) Γ(u)."""
    name = type(contact).__name__
    if name == "Bilateral":
        assert np.abs(u).max() <= tol
        return
    z, v = f[contact.normal], u[contact.normal]
    mu = getattr(contact, "mu", 0.0)
    power = tipping = tip_power = 0.0  # of friction; what a corner moves down by tipping, and its power
    if name == "Planar":
        gamma, power = mu * abs(u[0]), f[0] * u[0]
        assert abs(f[0]) <= mu * z + tol
    elif name in ("Point", "Rolling", "DecoupledSole", "SoftFinger"):
        reach, size = (math.hypot(*u[:2]), math.hypot(*f[:2]))
        power = float(f[:2] @ u[:2])
        if name == "SoftFinger":
            reach, size = math.hypot(reach, contact.radius * u[3]), math.hypot(size, f[3] / contact.radius)
            power += f[3] * u[3]
        assert size <= mu * z + tol
        gamma = mu * reach
        if name == "Rolling":
            gamma += contact.resistance * math.hypot(*u[3:])
            power += float(f[3:] @ u[3:])
            assert math.hypot(*f[3:]) <= contact.resistance * (z + tol)
        if name == "DecoupledSole":
            gamma += contact.torsion * abs(u[5])
            power += f[5] * u[5]
            tipping = 0.5 * contact.width * abs(u[3]) + 0.5 * contact.length * abs(u[4])
            tip_power = f[3] * u[3] + f[4] * u[4]
            assert abs(f[5]) <= contact.torsion * (z + tol)
            assert abs(f[3]) <= 0.5 * contact.width * (z + tol)
            assert abs(f[4]) <= 0.5 * contact.length * (z + tol)
    elif name == "Pyramid":
        cone = sf.FrictionCone(mu).polyhedral(contact.facets, contact.fit)
        gamma, power = float((-cone.rays[:, :2] @ u[:2]).max()), float(f[:2] @ u[:2])
        assert (cone.halfspaces @ f).max() <= tol
    else:
        gamma = 0.0
    assert z >= -tol
    opening = v - tipping - (1.0 - theta) * gamma  # of the lowest point of the contact
    assert opening >= -tol
    assert abs(power + z * gamma) <= tol * (1.0 + z)  # friction dissipates the most it can
    assert abs(tip_power + z * tipping) <= tol * (1.0 + z)  # pressure only where nothing lifts
    assert z * max(opening, 0.0) <= tol * (1.0 + z)
