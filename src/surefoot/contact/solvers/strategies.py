"""What `auto` tries, in which order: data, so that a plan can be read at a glance."""

from __future__ import annotations

from dataclasses import dataclass

PARTS, PROOF = "connected parts apart", "infeasibility proof"
ON_BLOCKS, ADMM_AND_NEWTON = "sweeps and newton on blocks", "admm and newton"
NEWTON_STEPS = "newton where its steps are light"
INTERIOR = "interior point, redundant contacts"
FEW_BODIES, LIGHTEST = "interior point, few bodies", "interior point, lightest steps"
SPARSE, DENSE = "interior point, sparse matrix", "interior point, dense matrix"
HEAVIEST = "interior point, heaviest matrix"
LONG_PATH = "interior point, a long path"
LATER = "later rounds of the compiled call"
"""What is tried besides solvers; see `auto`."""


@dataclass(frozen=True)
class PlanStage:
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


Plan = tuple[PlanStage, ...]
CONES: dict[str, Plan] = {
    "coulomb": (
        PlanStage(PARTS),
        PlanStage(PROOF),
        PlanStage(INTERIOR),
        PlanStage("newton"),
        PlanStage("admm", 1500),
        PlanStage(ON_BLOCKS, 20_000),
        PlanStage("admm", 10_000, warm=True),
    ),
    "convex": (
        PlanStage(PARTS),
        PlanStage(PROOF),
        PlanStage("distribution"),
        PlanStage("admm", 4000, warm=True),
    ),
}
"""After the compiled call on few contacts."""
CONES_MORE: dict[str, Plan] = {
    "coulomb": (
        PlanStage(FEW_BODIES),
        PlanStage(LATER, 40),
        PlanStage(LIGHTEST),
        PlanStage(LATER),
        PlanStage(PARTS),
        PlanStage(PROOF),
        PlanStage(INTERIOR),
        PlanStage(ON_BLOCKS, 20_000),
        PlanStage("newton"),
        PlanStage("admm", 1500),
        PlanStage(ADMM_AND_NEWTON, 10_000, warm=True),
    ),
    "convex": (
        PlanStage(LATER),
        PlanStage(PARTS),
        PlanStage(PROOF),
        PlanStage("distribution"),
        PlanStage("admm", 4000, warm=True),
    ),
}
"""After the first round of the compiled call on more contacts: a dense iteration of ADMM costs more than a
sweep on blocks."""
FIRST_NEWTON, AFTER = PlanStage(NEWTON_STEPS, 60), PlanStage(NEWTON_STEPS, 100, warm=True)
_FIRST = FIRST_NEWTON, PlanStage(PARTS), PlanStage(SPARSE)
"""What comes before and after the first iterations of ADMM: Newton finds the modes of most, and again those
that ADMM's forces suggest."""
_LAST: dict[str, Plan] = {
    "coulomb": (
        PlanStage(DENSE),
        PlanStage(ADMM_AND_NEWTON, 6000, warm=True),
        PlanStage(HEAVIEST),
        PlanStage(PROOF),
        PlanStage(LONG_PATH),
        PlanStage(ADMM_AND_NEWTON, 20_000, warm=True),
        PlanStage(PROOF),
    ),
    "convex": (PlanStage(PROOF), PlanStage(ADMM_AND_NEWTON, 4000, warm=True), PlanStage(PROOF)),
}
"""What is left for the few that all of it leaves open."""
CONES_LARGE = {law: (*_FIRST, PlanStage("admm", 1000), AFTER, *last) for law, last in _LAST.items()}
"""After sweeps and Newton steps on blocks."""
CONES_BODIES = {law: (PlanStage("admm", 3000), *_FIRST, AFTER, *last) for law, last in _LAST.items()}
"""The same where the bodies are known and few, or contacts over 500: an iteration of ADMM is then as light as
a sweep, and Newton steps are heavy."""
PYRAMIDS: dict[str, Plan] = {
    "coulomb": (
        PlanStage("admm", 2000, warm=True),
        PlanStage(PARTS),
        PlanStage(PROOF),
        PlanStage("lemke"),
        PlanStage("admm", warm=True),
    ),
    "convex": (
        PlanStage("admm", 2000, warm=True),
        PlanStage(PARTS),
        PlanStage(PROOF),
        PlanStage("daqp"),
        PlanStage("admm", warm=True),
    ),
}
GENERAL: Plan = (
    PlanStage("newton", 30),
    PlanStage(PARTS),
    PlanStage(ADMM_AND_NEWTON, 300),
    PlanStage(PROOF),
    PlanStage(ADMM_AND_NEWTON, 10_000, warm=True),
    PlanStage("admm", 20_000),
)
"""For contacts of any kind, under any law."""
