"""Compare derivatives with 50-digit references: `python tests/adversary/hunt_derivatives.py --count 500`.

Every problem whose error exceeds max(1e-8, 100 eps · condition) is printed with the seed that brings it back.
Problems with a contact within 1e-5 of a change of mode are drawn again: there is no derivative at a kink. So
are those whose derivative is flagged: `velocities_determined` is False, or something was `removed`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

import numpy as np
from derivative_reference import Moving, redundant, reference, regular

import surefoot as sf

EPS = 2.0**-52
NEAR = 1e-5
CONTACTS = (1, 2, 3, 4, 5, 6, 8, 10, 12)


@dataclass(frozen=True)
class Comparison:
    """One problem's relative errors and what they may be; None of forces where contacts are redundant."""

    seed: int
    contacts: int
    modes: tuple[str, ...]
    condition: float
    forces: float | None
    velocities: float
    adjoint: float

    @property
    def bound(self) -> float:
        return max(1e-8, 100.0 * EPS * self.condition)

    @property
    def wrong(self) -> bool:
        return not (max(self.forces or 0.0, self.velocities) <= self.bound and self.adjoint <= 1e-12)


def drawn(seed: int, contacts: int | None = None) -> Moving:
    """The problem of a seed."""
    rng = np.random.default_rng([20, seed])
    n = int(rng.choice(CONTACTS)) if contacts is None else contacts
    return redundant(rng, n) if seed % 4 == 3 else regular(rng, n)


def relative(found: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.abs(found - wanted).max() / max(np.abs(wanted).max(), 1e-300))


def compare(seed: int, contacts: int | None = None) -> Comparison | None:
    """Compare one problem, or return None where it is not solved, near a kink, or without a derivative.

    Coulomb's law leaves the velocities open where redundant contacts slide (how they share the load turns
    the friction), and directions that a coincidence of contacts cannot follow have no derivative; both are
    flagged, and no reference converges.
    """
    moving = drawn(seed, contacts)
    solution = sf.solve(sf.ContactProblem(**moving.arguments))
    if not solution.solved:
        return None
    d = solution.derivative(kink_tol=NEAR)
    if d.kinks:
        return None
    found = d.jvp(**moving.rates)
    if not d.velocities_determined or found.removed > 1e-9:
        return None
    forces, velocities, _ = reference(moving, d.forces)
    rng = np.random.default_rng(seed)
    f, u = rng.normal(size=(2, *found.forces.shape))
    back = d.vjp(forces=f, velocities=u)
    terms = np.concatenate([np.ravel(getattr(back, name) * rate) for name, rate in moving.rates.items()])
    ahead = np.concatenate([(f * found.forces).ravel(), (u * found.velocities).ravel()])
    size = np.abs(terms).sum() + np.abs(ahead).sum()
    adjoint = abs(terms.sum() - ahead.sum()) / max(size, 1e-300)
    # all rates of forces may vanish (contacts are open), or of velocities (they stick): then the other's
    weight = float(np.abs(d.problem.G).max())
    scale = max(np.abs(velocities).max(), weight * np.abs(forces).max())
    off = float(np.abs(found.velocities - velocities).max() / scale)
    own = None
    if moving.regular:
        own = float(weight * np.abs(found.forces - forces).max() / scale)
    return Comparison(seed, len(f), d.modes, d.condition, own, off, adjoint)


def main() -> int:
    """Compare so many problems; exit code 1 if one is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    done: list[Comparison] = []
    skipped, seed = 0, options.seed
    while len(done) < options.count:
        found = compare(seed)
        if found is None:
            skipped += 1
        else:
            done.append(found)
            if found.wrong:
                print(f"WRONG {found}")
        seed += 1
    errors = np.array([max(c.forces or 0.0, c.velocities) for c in done])
    wrong = sum(c.wrong for c in done)
    redundant_ones = sum(c.forces is None for c in done)
    print(
        f"{len(done)} problems ({redundant_ones} redundant; {skipped} unsolved, near kinks or flagged): "
        f"relative error median {np.median(errors):.1e}, largest {errors.max():.1e}; adjoint gap at most "
        f"{max(c.adjoint for c in done):.1e}; {wrong} beyond max(1e-8, 100 eps condition)"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
