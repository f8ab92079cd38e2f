"""What `auto` tries, in which order: data, so that a plan can be read at a glance."""

from __future__ import annotations

from dataclasses import dataclass

PROOF, EARLY_PROOF = "infeasibility proof", "infeasibility proof, in small parts only"
ON_BLOCKS, ADMM_AND_NEWTON = "sweeps and newton on blocks", "admm and newton"
MORE_NEWTON, SETS = "more newton on blocks", "admm and newton on sets"
"""What is tried besides solvers; see `auto`."""


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


Plan = tuple[Stage, ...]
CONES: dict[str, Plan] = {
    "coulomb": (
        Stage(PROOF),
        Stage("newton"),
        Stage("admm", 1500),
        Stage(ON_BLOCKS, 20_000),
        Stage("interior_point"),
        Stage("admm", 10_000, warm=True),
        Stage("staggered", 20, warm=True),
        Stage("nsgs", 20_000, warm=True),
    ),
    "convex": (
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
        Stage(EARLY_PROOF),
        Stage("interior_point", 40),
        Stage(ADMM_AND_NEWTON, 6000, warm=True),
        Stage(PROOF),
        Stage(MORE_NEWTON, 30_000, warm=True),
        Stage(ADMM_AND_NEWTON, 20_000, warm=True),
        Stage(MORE_NEWTON, 100_000, warm=True),
    ),
    "convex": (
        Stage(PROOF),
        Stage("interior_point"),
        Stage(ADMM_AND_NEWTON, 4000, warm=True),
        Stage("clarabel"),
    ),
}
"""After sweeps and Newton steps on blocks."""
PYRAMIDS: dict[str, Plan] = {
    "coulomb": (Stage("admm", 2000, warm=True), Stage(PROOF), Stage("lemke"), Stage("admm", warm=True)),
    "convex": (Stage("admm", 2000, warm=True), Stage(PROOF), Stage("daqp"), Stage("admm", warm=True)),
}
GENERAL: Plan = (
    Stage("set_newton", 30),
    Stage(SETS, 300),
    Stage(PROOF),
    Stage(SETS, 10_000, warm=True),
    Stage("set_admm", 20_000),
)
"""For contacts of any kind."""
