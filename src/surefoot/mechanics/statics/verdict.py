"""The answer to "can it stand here?": forces, or the proof that there are none."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, count_of
from surefoot.contact import Fit
from surefoot.mechanics.stance import Stance
from surefoot.mechanics.statics.limits import ForceLimits, Question, equations
from surefoot.mechanics.statics.margin import BAND, ENDLESS, FEASIBLE, REACH, most_margin

_NONE = np.zeros(0)
_MOST = 1e6
"""Disturbances of more loads than this count as any."""


@dataclass(eq=False, repr=False, slots=True)
class Verdict(Drawn):
    """Whether a stance can give a wrench, with a proof either way; truthy when it can.

    Attributes
    ----------
    question
        What was asked; its parts are `stance`, `com`, `load`, `limits`, `facets` and `fit` here too.
    status
        "possible", "impossible", or "undecided" where rounding leaves neither forces nor a proof: stances
        that only forces beyond ten thousand loads could tell apart.
    feasible
        Whether forces within every contact's friction cone and bounds were found that give the load.
    stacked
        (stance.dim,) contact forces (wrenches of soles) in contact frames [N, N m] with the most
        margin, stacked in the order of the stance, as `stance.grasp_map` takes them; None when impossible.
        `forces` and `world_forces` are the forces alone, a row a contact.
    margin
        Least distance of a contact's force (of a sole corner's) to the boundary of its cone or to a
        bound [N], the largest that any forces can keep. Negative when impossible; infinite where contacts
        can squeeze each other without limit, or beyond a million loads (the forces then keep a tenth of the
        load, mu times the load where friction is below a tenth; where others of the contacts are bounded it
        is the margin that a total of a thousand loads allows); minus infinity where no contact forces at all
        give the load. A cone's margin is at most mu times the normal force and vanishes with mu; a contact
        of mu = 0 has a cone without width and counts its normal force instead.
    certificate
        (6,) separating wrench y, of any length [-, 1/m], when impossible, else None: every admissible set of
        contact forces f has ``y @ grasp_map @ f >= 0``, and ``y @ load < 0``. Where bounds on forces take
        part (normal bounds, joint torques) they enter with `multipliers`; contacts that are off have no
        forces.
    reach
        How far that proof goes [N]: forces that give the load would have normal forces that add up to this
        at least. Infinite where it holds without exception; where contacts can squeeze each other, or load
        and contacts fit only up to rounding, it is finite, and ten thousand loads at least. 0 when possible.
    corner_forces
        (k, 3) forces of the points of `stance.points()` in contact frames [N]; None when impossible.
    multipliers
        (l,) weights >= 0 of the rows of `limits`, on the scale of y [-]; empty without bounds.
    """

    question: Question
    status: Literal["possible", "impossible", "undecided"]
    margin: float
    stacked: FloatArray | None = None
    certificate: FloatArray | None = None
    corner_forces: FloatArray | None = None
    multipliers: FloatArray = field(default_factory=lambda: _NONE)
    reach: float = 0.0

    @property
    def forces(self) -> FloatArray | None:
        """(n, 3) force of each contact in its frame [N]: tangent, tangent, normal; None when impossible."""
        return None if self.stacked is None else self.stance.force_rows(self.stacked)

    @property
    def world_forces(self) -> FloatArray | None:
        """(n, 3) force of each contact in world axes [N]; None when impossible."""
        return None if self.stacked is None else self.stance.force_rows(self.stacked, "world")

    @property
    def feasible(self) -> bool:
        """Whether forces were found that give the load."""
        return self.status == "possible"

    @property
    def stance(self) -> Stance:
        """The contacts that were asked."""
        return self.question.stance

    @property
    def com(self) -> FloatArray:
        """(3,) centre of mass, world axes [m]."""
        return self.question.com

    @property
    def load(self) -> FloatArray:
        """(6,) [force; moment about the centre of mass] to be given, world axes [N, N m]."""
        return self.question.load

    @property
    def limits(self) -> ForceLimits | None:
        """All bounds on the forces beside their cones; None without any."""
        return self.question.limits

    @property
    def facets(self) -> int | None:
        """Sides of the pyramids, None for exact cones."""
        return self.question.facets

    @property
    def fit(self) -> Fit:
        """Whether the pyramids are inside or around the cones."""
        return self.question.fit

    def __bool__(self) -> bool:
        return self.feasible

    def __repr__(self) -> str:
        return f"Verdict({self.status}, margin={self.margin:.3g} N, {len(self.stance)} contacts)"

    def __str__(self) -> str:
        if self.feasible:
            spare = "no end" if math.isinf(self.margin) else f"{self.margin:.3g} N"
            count = count_of(len(self.stance), "contact")
            return f"It can stand: {count}, {spare} to spare until one slips or lifts."
        if self.status == "undecided":
            return "Undecided: rounding leaves neither forces nor a proof that there are none."
        bounds = f"; bounds in the way: {', '.join(self.limiting[:4])}" if self.limiting else ""
        return f"It cannot stand: no forces in the friction cones give the load{bounds}. Proof: .certificate."

    @property
    def limiting(self) -> tuple[str, ...]:
        """Names of the bounds in the proof that it is impossible, the heaviest first."""
        if self.limits is None or not len(self.multipliers):
            return ()
        weight = self.multipliers * np.linalg.norm(self.limits.rows, axis=1)
        order = np.argsort(-weight)
        return tuple(self.limits.names[k] for k in order if weight[k] > 1e-6 * weight[order[0]])

    def by_contact(self) -> list[FloatArray]:
        """Return each contact's force (3,) or wrench (6,) [N, N m] in its frame, in the stance's order."""
        if self.stacked is None:
            return []
        return [self.stacked[part] for part in self.stance.slices]

    def verify(self, tol: float = 1e-9) -> bool:
        """Check the proof with two matrix products; an undecided verdict has none.

        Possible: the forces are in their cones and bounds and add up to the load, within `tol`, relative to
        the load.
        Impossible: the separating wrench does negative work on the load, and no work so negative on any
        admissible forces that add up to less than ten thousand loads.
        """
        if self.status == "undecided":
            return False
        return self._forces_hold(tol) if self.feasible else self._certificate_holds()

    def _scales(self, grasp: FloatArray) -> tuple[float, FloatArray]:
        """Return the load as a force [N], and the six entries' own scales [N, N m]."""
        columns = np.linalg.norm(grasp[3:], axis=0)
        arm = max(float(columns.max(initial=0.0)), 1e-300)
        size = float(np.hypot(np.linalg.norm(self.load[:3]), np.linalg.norm(self.load[3:]) / arm))
        return size, size * np.array([1.0, 1.0, 1.0, arm, arm, arm])

    def _friction(self) -> FloatArray:
        """Return the friction of every corner, widened to the edges of pyramids around the cones."""
        mu = self.stance.points().mu
        return mu / np.cos(np.pi / self.facets) if self.facets is not None and self.fit == "outer" else mu

    def _forces_hold(self, tol: float) -> bool:
        if self.stacked is None or self.corner_forces is None or not np.all(np.isfinite(self.stacked)):
            return False
        if not len(self.stance):
            return not np.any(self.load)
        size, scales = self._scales(self.stance.points().grasp_map(self.com))
        rest = self.stance.grasp_map(self.com) @ self.stacked - self.load
        corners, mu = self.corner_forces, self._friction()
        side = np.hypot(corners[:, 0], corners[:, 1])
        outside = np.maximum(-corners[:, 2], (side - mu * corners[:, 2]) / np.hypot(1.0, mu))
        # The cones are those of the corners: they say nothing of forces that are not the corners' sums.
        apart = np.abs(self.stance.corner_map @ corners.ravel() - self.stacked)
        reach = size * np.linalg.norm(self.stance.corner_map, axis=1)
        inside = bool(np.all(outside <= 2.0 * tol * size)) and bool(np.all(apart <= 10.0 * tol * reach))
        if self.limits is not None:
            rows, bound = self.limits.rows, self.limits.bound
            reach = np.maximum(size * np.linalg.norm(rows, axis=1), np.abs(bound))
            inside &= bool(np.all(rows @ self.stacked - bound <= 2.0 * tol * reach))
        return inside and bool(np.all(np.abs(rest) <= 10.0 * tol * scales))

    def _certificate_holds(self) -> bool:
        """Check the separating wrench contact by contact, on the arithmetic of this file alone."""
        y = self.certificate
        if y is None or not np.all(np.isfinite(y)):
            return False
        on = self.stance.points().normal_max > 0.0
        if not on.any():
            return float(y @ self.load) < 0.0
        grasp = self.stance.points().grasp_map(self.com)
        force = grasp.T @ y
        work = float(y @ self.load)
        if self.limits is not None and len(self.multipliers):
            if float(self.multipliers.min()) < 0.0:
                return False
            force = force + self.stance.corner_map.T @ (self.limits.rows.T @ self.multipliers)
            work += float(self.multipliers @ self.limits.bound)
        # Forces whose normal parts add up to S do work of at least -lack S: to give the load they need S >=
        # -work / lack. Half of the reach is asked for, since this is other arithmetic than the kernel's.
        lack = float(-self._least_work(force.reshape(-1, 3))[on].min())
        size, _ = self._scales(grasp)
        return work < 0.0 and -work >= 0.5 * REACH * size * lack

    def _least_work(self, z: FloatArray) -> FloatArray:
        """Return the least work of `z` on a force of each cone (pyramid) whose normal component is one."""
        mu = self.stance.points().mu
        if self.facets is None:
            return z[:, 2] - mu * np.hypot(z[:, 0], z[:, 1])
        from surefoot.contact import FrictionPyramid

        rays = [FrictionPyramid(float(m), self.facets, self.fit).rays for m in mu]
        return np.array([float(np.min(r @ part)) for r, part in zip(rays, z, strict=True)])

    def largest_disturbance(self, direction: ArrayLike) -> float:
        """Return how far a wrench in one direction may grow before the stance fails.

        Parameters
        ----------
        direction
            (6,) [force; moment about the centre of mass] on the robot, world axes [N, N m]. The result counts
            in multiples of it: newtons for a unit force.

        Returns
        -------
        float
            How often `direction` fits in [-], enclosed by verdicts that the stance can and cannot; 0 where it
            is impossible already, infinite where the contacts withstand any amount.

        Raises
        ------
        ProblemError
            If the direction is not (6,), finite and nonzero.
        """
        push = finite_array("direction", direction, (6,))
        if not np.any(push):
            raise ProblemError("direction must not be zero")
        if not self.feasible or not len(self.stance):
            return 0.0
        eq = equations(self.question)
        d = np.zeros(len(eq.w))
        # A wrench on the robot takes off the load that contacts have to give: the sign of `needed_wrench`.
        d[:3], d[3:6] = -push[:3], -push[3:] / eq.length
        size = float(np.linalg.norm(d))
        d /= size

        def margin(s: float) -> float:
            # forces and bounds in units of the load with the disturbance: of size one however large that is
            outcome, most, *_ = most_margin(eq.A, eq.e, (eq.w + s * d) / (1.0 + s), eq.lorentz, eq.blocks)
            return most if outcome in (FEASIBLE, ENDLESS) else -math.inf

        low, high = 0.0, 1.0
        while margin(high) > -math.inf:
            if high > _MOST:
                return math.inf
            low, high = high, 2.0 * high
        while high > BAND and high - low > BAND * high:  # a load more or less of the band is none
            middle = 0.5 * (low + high)
            low, high = (middle, high) if margin(middle) > -math.inf else (low, middle)
        return low * eq.scale / size if high > BAND else 0.0
