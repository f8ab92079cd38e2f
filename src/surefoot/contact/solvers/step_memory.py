"""What the interior point's steps work in: scalings, the factors of their matrix, and the last motion."""

from __future__ import annotations

import math

import numpy as np

from surefoot.contact.solvers import cone_pairs as pairs
from surefoot.contact.solvers.central_step import Iterate, Scaling, central_step
from surefoot.contact.solvers.path_step import NEAR, Motion, path_step, unequal_shares
from surefoot.contact.solvers.reduced_system import ReducedSystem

LONGER, SHORTENED, LEAST_REACH = 1.5, 0.4, 1e-3
"""By what the reach of steps along turns grows while the path is met, and shrinks where it is lost."""
MOST_SHORT = 200
"""Steps of the least reach in turn after which a path counts as lost: until then some find it again."""
MOST_BACK, NEARER = 4, 0.8
"""Steps back to the path, and the share of its distance that one has to leave at most, else it is lost."""
MOST_AWAY = 20
"""Steps beside a path of equal shares after which it counts as lost: walls of bricks are back within nine,
walls of light bricks and heavy ones within twenty, balls in a pit within three, or mostly not in forty."""

MOST_UNMET = 120
"""Steps after which a path of unequal shares that was never met is lost: balls in a pit meet theirs within
fifteen, walls of light bricks and heavy ones within ninety, and where there is no answer nobody does."""


class StepMemory:
    """What an iteration works in: scalings and the matrix's factors, for a system of n contacts."""

    def __init__(self, system: ReducedSystem, contacts: int) -> None:
        n = contacts
        self.system = system
        self.scaling = Scaling(np.empty((n, 4)), np.empty((n, 3)), np.empty((n, 3, 3)))
        self.residual = np.empty((n, 3))
        self.motion = Motion(np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(1))
        self.equal, self.unequal = np.ones(n), unequal_shares(n)

    def scale(self, point: Iterate, share: float) -> float:
        """Fill the scalings of a point; return its gap, the mean of x · y."""
        return pairs.scale_pairs(*point, share, *self.scaling)

    def advance(self, point: Iterate, gap: float, share: float, least: float) -> tuple[float, Iterate | None]:
        """Take a step with the residual that is there; return its length and the point after it, if any."""
        factors = self.system.factorise(self.scaling.weights)
        if factors is None:
            return 0.0, None
        after = Iterate(*(np.empty_like(part) for part in point))
        length = central_step(
            factors, self.system.rows, point, self.residual, self.scaling, gap, share, least, after
        )
        return length, after if length > 0.0 else None

    def go_along(
        self, point: Iterate, gap: float, unequal: bool = False, reach: float = 1.0
    ) -> tuple[float, float, Iterate | None]:
        """Take a step by the path's length, of which reach is a share, with equal shares of the gap or not.

        Return the change of the log gap, how far off the path the point was, and the point after it.
        """
        factors = self.system.factorise(self.scaling.weights)
        if factors is None:
            return 0.0, np.inf, None
        after = Iterate(*(np.empty_like(part) for part in point))
        # a determinant tells where to go on only along a path without branches: equal bricks branch
        shares, sign = (self.unequal, -factors.sign) if unequal else (self.equal, 0.0)
        length, log, off = path_step(
            factors, self.system.rows, point, self.residual, self.scaling, gap, self.motion, shares, sign,
            reach, after,
        )  # fmt: skip
        return log, off, after if length > 0.0 else None

    def forget(self) -> None:
        """Forget the last step along the path."""
        for part in self.motion:
            part[:] = 0.0


class Turning:
    """Steps along turns of the path: how far they reach, and where the path was met last.

    With unequal shares so many steps in turn may find no smaller gap.
    """

    def __init__(self, unequal: bool, patience: float = math.inf) -> None:
        self.unequal, self.patience = unequal, patience
        self.met: Iterate | None = None
        self.steps, self.reach, self.off, self.back, self.short = 0, 1.0, math.inf, 0, 0
        self.least, self.idle = math.inf, 0

    @property
    def lost(self) -> bool:
        """Whether steps have been as short as they may be, or idle, or beside the path too long."""
        if not self.unequal:
            return self.back >= MOST_AWAY
        if self.met is None and self.steps >= MOST_UNMET:
            return True
        return self.short > MOST_SHORT or self.idle > self.patience

    def step(self, memory: StepMemory, point: Iterate, gap: float) -> tuple[float, Iterate | None]:
        """Return the change of the log gap and the point after a step.

        Where steps do not lead back to the path, they start again from where it was met last, shorter.
        """
        log, off, after = memory.go_along(point, gap, self.unequal, self.reach)
        self.steps += 1
        self.least, self.idle = (gap, 0) if gap < self.least else (self.least, self.idle + 1)
        self.back = 0 if off < NEAR else self.back + 1
        if not self.unequal:
            return log, after
        if off < NEAR:
            self.reach, self.met = min(1.0, LONGER * self.reach), point
        else:
            lost = self.back > MOST_BACK or (self.back > 1 and off > NEARER * self.off)
            if (lost or after is None) and self.met is not None and self.reach > LEAST_REACH:
                self.reach, self.back, off, after = SHORTENED * self.reach, 0, math.inf, self.met
        self.off = off
        self.short = self.short + 1 if self.reach <= LEAST_REACH else 0
        return log, after
