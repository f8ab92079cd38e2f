"""The answer to "can it stand here?": forces, or the proof that there are none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.stance import Stance

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from surefoot.equilibrium.limits import ForceLimits


class Verdict:
    """Whether a stance can give a wrench, with a proof either way; truthy when it can.

    Attributes
    ----------
    feasible
        Whether forces within every contact's friction cone and bounds give the load.
    forces
        (stance.dim,) contact forces (wrenches of patches) in contact frames [N, N m] with the most
        margin, stacked in the order of the stance; None when impossible.
    margin
        Least distance of a contact's force (of a patch corner's) to the boundary of its cone or to a
        bound [N], the largest that any forces can keep. Negative when impossible; infinite where contacts
        can squeeze each other without limit (the forces then keep a tenth of the load; where others of
        the contacts are bounded it is the margin that a total of a thousand loads allows); minus infinity
        where no contact forces at all give the load. A frictionless contact counts its normal force.
    certificate
        (6,) separating wrench y, or None when possible: every admissible set of contact forces f has
        ``y @ grasp_map @ f >= 0``, and ``y @ load < 0``. Where bounds on forces take part (normal bounds,
        joint torques) they enter with `multipliers`.
    multipliers
        (l,) weights >= 0 of the rows of `limits`; empty without bounds.
    load
        (6,) [force; moment about the centre of mass] that the contacts have to give, world axes.
    stance, com, limits, facets, fit
        What was asked.
    """

    __slots__ = (
        "_corner_forces",
        "certificate",
        "com",
        "facets",
        "feasible",
        "fit",
        "forces",
        "limits",
        "load",
        "margin",
        "multipliers",
        "stance",
    )

    def __init__(
        self,
        stance: Stance,
        com: FloatArray,
        load: FloatArray,
        feasible: bool,
        margin: float,
        forces: FloatArray | None,
        certificate: FloatArray | None,
        corner_forces: FloatArray | None,
        limits: ForceLimits | None = None,
        multipliers: FloatArray | None = None,
        facets: int | None = None,
        fit: Literal["inner", "outer"] = "inner",
    ) -> None:
        self.stance = stance
        self.com = com
        self.load = load
        self.feasible = feasible
        self.margin = margin
        self.forces = forces
        self.certificate = certificate
        self._corner_forces = corner_forces
        self.limits = limits
        self.multipliers = _NONE if multipliers is None else multipliers
        self.facets = facets
        self.fit: Literal["inner", "outer"] = fit

    def __bool__(self) -> bool:
        return self.feasible

    def __repr__(self) -> str:
        word = "possible" if self.feasible else "impossible"
        return f"Verdict({word}, margin={self.margin:.3g} N, {len(self.stance)} contacts)"

    @property
    def corner_forces(self) -> FloatArray | None:
        """(k, 3) forces of the points of `stance.points()` in contact frames [N]; None when impossible."""
        return None if self._corner_forces is None else self._corner_forces.reshape(-1, 3)

    @property
    def limiting(self) -> tuple[str, ...]:
        """Names of the bounds in the proof that it is impossible, the heaviest first."""
        if self.limits is None or not len(self.multipliers):
            return ()
        weight = self.multipliers * np.linalg.norm(self.limits.rows, axis=1)
        order = np.argsort(-weight)
        return tuple(self.limits.names[k] for k in order if weight[k] > 1e-6 * weight[order[0]])

    def by_contact(self) -> list[FloatArray]:
        """Return the force (3,) or wrench (6,) of each contact in its own frame, in the stance's order."""
        if self.forces is None:
            return []
        return [self.forces[part] for part in self.stance.slices]

    def verify(self, tol: float = 1e-9) -> bool:
        """Check the proof with two matrix products; `tol` is relative to the load (the wrench).

        Possible: the forces are in their cones and bounds and add up to the load. Impossible: the
        separating wrench does no negative work on any admissible force, yet negative work on the load.
        """
        if self.feasible:
            return self._forces_hold(tol)
        return self._certificate_holds(tol)

    def _forces_hold(self, tol: float) -> bool:
        if self.forces is None or self._corner_forces is None:
            return len(self.stance) == 0
        scale = max(float(np.linalg.norm(self.load)), 1e-300)
        size = max(scale, float(np.abs(self.forces).max(initial=0.0)))
        rest = self.stance.grasp_map(self.com) @ self.forces - self.load
        corners = self._corner_forces.reshape(-1, 3)
        mu = self.stance.points().mu
        if self.facets is not None and self.fit == "outer":
            mu = mu / np.cos(np.pi / self.facets)
        slack = mu * corners[:, 2] - np.hypot(corners[:, 0], corners[:, 1])
        inside = bool(np.all(slack >= -tol * size)) and bool(np.all(corners[:, 2] >= -tol * size))
        if self.limits is not None:
            rows, bound = self.limits.rows, self.limits.bound
            inside &= bool(np.all(rows @ self.forces - bound <= tol * size * np.linalg.norm(rows, axis=1)))
        return inside and bool(np.abs(rest).max() <= tol * size)

    def _certificate_holds(self, tol: float) -> bool:
        if self.certificate is None:
            return False
        points = self.stance.points()
        grasp = points.grasp_map(self.com)
        force = grasp.T @ self.certificate
        scale = float((np.abs(grasp).T @ np.abs(self.certificate)).max(initial=1e-300))
        work = float(self.certificate @ self.load)
        if self.limits is not None and len(self.multipliers):
            force = force + self.stance.corner_map.T @ (self.limits.rows.T @ self.multipliers)
            work += float(self.multipliers @ self.limits.bound)
            if float(self.multipliers.min()) < 0.0:
                return False
        z = force.reshape(-1, 3)
        depth = z[:, 2] - points.mu * np.hypot(z[:, 0], z[:, 1])
        if self.facets is not None:
            return work < 0.0 and self._pyramids_agree(z, scale, tol)
        return work < 0.0 and bool(np.all(depth >= -tol * scale))

    def _pyramids_agree(self, z: FloatArray, scale: float, tol: float) -> bool:
        """Check the certificate against the rays of the pyramids that stood for the cones."""
        from surefoot.cones import FrictionPyramid

        assert self.facets is not None
        for mu, part in zip(self.stance.points().mu, z, strict=True):
            if np.min(FrictionPyramid(float(mu), self.facets, self.fit).rays @ part) < -tol * scale:
                return False
        return True

    def largest_disturbance(self, direction: ArrayLike) -> float:
        """Return how far a wrench in one direction may grow before the stance fails.

        Parameters
        ----------
        direction
            (6,) [force; moment about the centre of mass] on the robot, world axes. The result counts in
            multiples of it: newtons for a unit force.

        Returns
        -------
        float
            0 where the stance is impossible already, infinite where the contacts withstand any amount.
        """
        from surefoot.equilibrium.push import largest_disturbance

        return largest_disturbance(self, direction)


_NONE = np.zeros(0)
