"""What `auto` tries, in which order: data, so that a plan can be read at a glance."""

from __future__ import annotations

from dataclasses import dataclass

PARTS, PROOF, EARLY_PROOF = "connected parts apart", "infeasibility proof", "early infeasibility proof"
ON_BLOCKS, MORE_NEWTON = "sweeps and newton on blocks", "more newton on blocks"
ADMM_AND_NEWTON = "admm and newton"
"""What is tried besides solvers; see `auto`. The early proof is looked for in little time."""


@dataclass(frozen=True)
class Stage:
    """One step of a plan.

    Attributes
    ----------
    name
        Of a solver, or of a part of `auto`.
    most
        Its iterations at most; None for its own limit.
    warm
        Whether it starts from the best forces so far: a bad guess can hold a method back, so some start
        afresh.
    """

    name: str
    most: int | None = None
    warm: bool = False

    @property
    def label(self) -> str:
        """What it is called in tables."""
        return self.name + (f", {self.most}" if self.most else "") + (", warm" if self.warm else "")


Plan = tuple[Stage, ...]
CONES: dict[str, Plan] = {
    "coulomb": (
        Stage(PARTS),
        Stage(PROOF),
        Stage("newton"),
        Stage("admm", 1500),
        Stage(ON_BLOCKS, 20_000),
        Stage("interior_point"),
        Stage("admm", 10_000, warm=True),
        Stage("nsgs", 20_000, warm=True),
    ),
    "convex": (
        Stage(PARTS),
        Stage(PROOF),
        Stage("distribution"),
        Stage("interior_point"),
        Stage("admm", 4000, warm=True),
        Stage("clarabel"),
    ),
}
"""After the compiled call on few contacts."""
CONES_LARGE: dict[str, Plan] = {
    "coulomb": (
        Stage(PARTS),
        Stage(EARLY_PROOF),
        Stage("interior_point", 40),
        Stage(ADMM_AND_NEWTON, 6000, warm=True),
        Stage(PROOF),
        Stage(MORE_NEWTON, 30_000, warm=True),
        Stage(ADMM_AND_NEWTON, 20_000, warm=True),
        Stage(MORE_NEWTON, 100_000, warm=True),
        Stage(PROOF),
    ),
    "convex": (
        Stage(PARTS),
        Stage(PROOF),
        Stage("interior_point"),
        Stage(ADMM_AND_NEWTON, 4000, warm=True),
        Stage("clarabel"),
        Stage(PROOF),
    ),
}
"""After sweeps and Newton steps on blocks."""
PYRAMIDS: dict[str, Plan] = {
    "coulomb": (
        Stage("admm", 2000, warm=True),
        Stage(PARTS),
        Stage(PROOF),
        Stage("lemke"),
        Stage("admm", warm=True),
    ),
    "convex": (
        Stage("admm", 2000, warm=True),
        Stage(PARTS),
        Stage(PROOF),
        Stage("daqp"),
        Stage("admm", warm=True),
    ),
}
ANY_LAW = "any law"
GENERAL: dict[str, Plan] = {
    ANY_LAW: (
        Stage("newton", 30),
        Stage(PARTS),
        Stage(ADMM_AND_NEWTON, 300),
        Stage(PROOF),
        Stage(ADMM_AND_NEWTON, 10_000, warm=True),
        Stage("admm", 20_000),
    )
}
"""For contacts of any kind, under any law."""
