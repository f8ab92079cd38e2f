"""Random contact sequences."""

from __future__ import annotations

import math

import numpy as np

from surefoot.app.export import ContactSequence, SequencePhase
from surefoot.contact.cones import Sole
from surefoot.mechanics.stance import PointContact, SoleContact, Stance

FRAMES = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")


def random_sequence(
    seed: int,
    patches: bool = True,
    facets: int | None = None,
    fit: str | None = None,
    lean: float = 0.3,
) -> ContactSequence:
    """Return a sequence of four feet on tilted ground, with flights, bounds, patches and forces.

    `lean` is the standard deviation of the normals' slopes.
    """
    rng = np.random.default_rng(seed)
    facets = int(rng.choice([4, 6, 8, 12])) if facets is None else facets
    fit = str(rng.choice(["inner", "outer"])) if fit is None else fit
    phases = []
    for _ in range(int(rng.integers(1, 7))):
        touching = [name for name in FRAMES if rng.random() < 0.6]
        stance = Stance([_contact(rng, name, patches, lean) for name in touching])
        forces = rng.normal(size=stance.dim) * 30.0 if rng.random() < 0.5 else None
        phases.append(SequencePhase(float(rng.uniform(0.01, 1.0)), stance, forces))
    return ContactSequence(phases, FRAMES, "anymal", float(rng.uniform(1.0, 60.0)), facets, fit)


def _contact(rng: np.random.Generator, name: str, patches: bool, lean: float) -> PointContact | SoleContact:
    normal = rng.normal(size=3) * lean + [0.0, 0.0, 1.0]
    low = float(rng.uniform(0.0, 5.0)) if rng.random() < 0.5 else 0.0
    high = float(rng.uniform(50.0, 500.0)) if rng.random() < 0.5 else math.inf
    common = {
        "position": rng.normal(size=3), "normal": normal / np.linalg.norm(normal),
        "name": name, "normal_min": low, "normal_max": high,
        "heading": rng.normal(size=3),
    }  # fmt: skip
    mu = float(rng.uniform(0.1, 1.2))
    if patches and rng.random() < 0.3:
        return SoleContact(sole=Sole(rng.uniform(0.05, 0.3), rng.uniform(0.05, 0.2), mu), **common)
    return PointContact(mu=mu, **common)


def sampled_forces(sequence: ContactSequence, phase: int, count: int, seed: int) -> np.ndarray:
    """Return (count, dim) forces about the surfaces of the cones, some inside, some outside."""
    rng, stance = np.random.default_rng(seed), sequence.phases[phase].stance
    parts = []
    for contact in stance:
        load = rng.uniform(-5.0, 120.0, size=(count, 1))
        if contact.dim == 3:
            angle = rng.uniform(0.0, 2.0 * np.pi, size=(count, 1))
            size = contact.mu * load * rng.uniform(0.0, 1.0, size=(count, 1)) ** 0.2 * 1.05
            parts.append(np.hstack([size * np.cos(angle), size * np.sin(angle), load]))
        else:
            spread = np.array(
                [
                    contact.mu,
                    contact.mu,
                    0.0,
                    contact.sole.width,
                    contact.sole.length,
                    contact.mu * contact.sole.width,
                ]
            )
            wrench = 0.35 * spread * load * rng.uniform(-1.0, 1.0, size=(count, 6))
            wrench[:, 2:3] = load
            parts.append(wrench)
    return np.hstack(parts) if parts else np.zeros((count, 0))
