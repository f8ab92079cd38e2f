"""How long a step an explicit integrator can take on a soft contact."""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray, finite_array, per_contact, real_number
from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.errors import ProblemError


def stable_step(law: SoftLaw, mass: float, depth: float) -> float:
    """Return the longest stable step [s] of an explicit integrator for a mass on a contact.

    2 (sqrt(1 + ζ²) - ζ) / ω, which is 2 / ω without damping: for v⁺ = v + dt f(x, v) / m, x⁺ = x + dt v⁺
    linearised at an overlap, the point where an eigenvalue reaches -1.

    Parameters
    ----------
    law
        The contact.
    mass
        Effective mass, 1 / G_nn [kg].
    depth
        Overlap [m]; the linear law does not ask, others grow stiffer.

    Examples
    --------
    >>> from surefoot.contact.laws.soft.spring_damper import SpringDamper
    >>> stable_step(SpringDamper(1e4), mass=1.0, depth=0.0)
    0.02
    """
    heavy = real_number("mass", mass, low=1e-300)
    deep = real_number("depth", depth, low=0.0, high=1e6)
    _, by_depth, by_rate = law.pressed(np.array(deep), np.array(0.0))
    return stable_step_together(np.array([[1.0 / heavy]]), by_depth[None], by_rate[None])


def stable_step_together(G: FloatArray, stiffness: FloatArray, damping: FloatArray) -> float:
    """Return the longest step [s] that is stable for contacts on one robot, infinity without any.

    Parameters
    ----------
    G
        (n, n) what unit impulses along the normals do to the normal velocities [1/kg].
    stiffness, damping
        (n,) slopes of the forces [N/m], [N s/m].

    Notes
    -----
    4 / (c + sqrt(c² + 4 ω²)) with ω² and c the largest eigenvalues of G K and G D: exact for one contact and
    where D is proportional to K, else on the safe side.
    """
    response = finite_array("G", G)
    n = response.shape[0] if response.ndim == 2 else -1
    if response.shape != (n, n):
        raise ProblemError(f"G must be square, got shape {response.shape}")
    if not n:
        return math.inf
    largest = []
    for name, slopes in (("stiffness", stiffness), ("damping", damping)):
        root = np.sqrt(per_contact(name, slopes, n))
        scaled = root[:, None] * response * root
        if not np.isfinite(scaled).all():
            return 0.0
        largest.append(max(float(np.linalg.eigvalsh(scaled)[-1]), 0.0))
    square, rate = largest
    total = rate + math.sqrt(rate * rate + 4.0 * square)
    return 4.0 / total if total > 0.0 else math.inf
