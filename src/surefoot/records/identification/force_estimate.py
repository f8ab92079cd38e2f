"""Contact forces from a motion and its torques, with their uncertainty and the question whether any would do.

    M v̇ + h = S τ + Jᵀ f        (least squares, rows weighted by how well they are known)

References
----------
.. [1] M. Camurri et al., "Probabilistic contact estimation and impact detection for state estimation of
   quadruped robots", IEEE Robotics and Automation Letters 2017 (the statics of it).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, numbers, of_kind, real_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, count_of
from surefoot.mechanics import (
    Robot,
    Stance,
    Terrain,
    Verdict,
    can_stand,
    contact_jacobian,
    generalised_torque,
)

REACH = 3.0
"""Standard deviations within which an acceleration may be wrong."""
EXACT = 1e-4
"""The base has no motor: its rows are so much better known than a torque, apart from the acceleration."""
RANK = 1e-9
"""Singular values below this share of the largest are not seen by the measurements."""


@dataclass(frozen=True, repr=False)
class ForceEstimate(Drawn):
    """Forces that explain a motion best.

    Attributes
    ----------
    stacked
        (sum of dims,) contact forces (wrenches of soles), contact frames, in the stance's order [N, N m].
    std
        (sum of dims,) standard deviation of each [N, N m], from those of torques and acceleration; infinite
        where the measurements do not tell it.
    misfit
        Root mean square of what is left over, in standard deviations [-]: about one for a good model, far
        above one where something else acts on the robot; zero where nothing is over-determined.
    lawful
        Whether the estimated forces themselves obey friction and push, those of soles inside their edges.
    explainable
        Whether any lawful forces of these contacts explain the body's motion: "yes", "no" if none do for any
        acceleration within three standard deviations (`verdict.certificate` proves it), else "cannot tell".
    verdict
        The same question for the acceleration as given, exactly, see `surefoot.can_stand`: two feet span
        no area, so that the least error of an acceleration makes it impossible. None for a robot whose base
        does not float: what holds it may carry anything.
    stance
        The contacts.
    """

    stacked: FloatArray
    std: FloatArray
    misfit: float
    lawful: bool
    explainable: Literal["yes", "no", "cannot tell"]
    verdict: Verdict | None
    stance: Stance

    def __repr__(self) -> str:
        return f"ForceEstimate({len(self.stance)} contacts, misfit={self.misfit:.3g}, lawful={self.lawful})"

    def __str__(self) -> str:
        load = float(np.linalg.norm(self.world_forces.sum(axis=0)))
        kind = "lawful" if self.lawful else "not lawful"
        lawful = {"yes": "lawful forces explain the motion", "no": "no lawful forces explain the motion"}
        said = lawful.get(self.explainable, "whether lawful forces explain the motion cannot be told")
        return f"Forces of {count_of(len(self.stance), 'contact')}, {load:.4g} N together, {kind}; {said}."

    @property
    def forces(self) -> FloatArray:
        """(n, 3) force of each contact in its frame [N]: tangent, tangent, normal."""
        return self.stance.force_rows(self.stacked)

    @property
    def world_forces(self) -> FloatArray:
        """(n, 3) force of each contact in world axes [N]."""
        return self.stance.force_rows(self.stacked, "world")

    def by_contact(self) -> dict[str, FloatArray]:
        """Return the force (3,) [N] or wrench (6,) [N, N m] of each contact by its name."""
        return {c.name: self.stacked[part] for c, part in zip(self.stance, self.stance.slices, strict=True)}


def estimate_forces(
    robot: Robot,
    q: ArrayLike,
    v: ArrayLike,
    a: ArrayLike,
    tau: ArrayLike,
    *,
    feet: Sequence[str] | None = None,
    mu: float | Sequence[float] = 0.6,
    terrain: Terrain | None = None,
    torque_std: float = 0.5,
    acceleration_std: float = 0.2,
) -> ForceEstimate:
    """Return the contact forces that explain a motion and its torques, and whether lawful ones can.

    Parameters
    ----------
    robot
        With a floating base, or with a base that is bolted or runs on rails (``fixed_base=True``) and feet.
    q, v, a
        (nq,) configuration [m, -, rad], (nv,) velocity [m/s, rad/s] and acceleration [m/s², rad/s²] in
        Pinocchio's order and coordinates.
    tau
        (joints,) torques of the joints [N m]; NaN for a joint whose torque nobody knows, such as a rail on
        which a hand holds the base: its row tells nothing then.
    feet
        Names of the feet that touch; None for all.
    mu, terrain
        Friction [-], one or one per foot, and the ground (None: flat); for the question of lawfulness only.
    torque_std
        Standard deviation of a torque [N m].
    acceleration_std
        Standard deviation of the acceleration of a coordinate [m/s^2, rad/s^2].

    Returns
    -------
    ForceEstimate
        `.forces` with `.std`, `.misfit`, `.lawful`, and `.explainable` on all forces that there could be.

    Raises
    ------
    ProblemError
        For wrong shapes, numbers that are not finite, standard deviations that are not positive, or a robot
        that is bolted to the world and has no feet.
    """
    of_kind("robot", robot, Robot)
    import pinocchio

    if not robot.floating and not robot.feet:
        raise ProblemError(
            f"{robot.name} is bolted to the world and has no feet: its base carries what it must"
        )
    model, data = robot.model, robot.model.createData()
    configuration = robot.configuration(q)
    velocity, acceleration = (finite_array(n, x, (model.nv,)) for n, x in (("v", v), ("a", a)))
    noise = real_number("torque_std", torque_std, low=1e-12)
    shaking = real_number("acceleration_std", acceleration_std, low=0.0)
    stance = robot.stance(configuration, mu=mu, terrain=terrain, feet=feet)
    needed = np.array(pinocchio.rnea(model, data, configuration, velocity, acceleration))
    torque = np.array(numbers("tau", tau))
    known = np.ones(model.nv, dtype=bool)
    if torque.shape == (robot.joints,):
        known[robot.base_dof :] = ~np.isnan(torque)
        torque[np.isnan(torque)] = 0.0
    needed = needed - generalised_torque(robot, finite_array("tau", torque, (robot.joints,)))
    M = np.triu(pinocchio.crba(model, data, configuration))
    # An error of the acceleration enters a row of M v̇ + h - τ through that row of M.
    spread = shaking * np.linalg.norm(M + np.triu(M, 1).T, axis=1)
    spread = np.hypot(spread, np.where(np.arange(model.nv) < robot.base_dof, EXACT * noise, noise))
    J = contact_jacobian(robot, configuration, stance)
    forces, std, misfit = _least_squares((J.T / spread[:, None])[known], (needed / spread)[known])
    lawful, verdict = _lawful(stance, forces, std), None
    if robot.floating:
        rate = pinocchio.computeCentroidalMomentumTimeVariation(
            model, data, configuration, velocity, acceleration
        )
        verdict = can_stand(stance, np.array(data.com[0]), robot.mass, -np.array(rate.vector))
    rows = np.flatnonzero(known)[: robot.base_dof or None]
    left = np.abs(needed - J.T @ forces)[rows] <= REACH * spread[rows]
    answer: Literal["yes", "no", "cannot tell"] = "cannot tell"
    moved = shaking * np.array(pinocchio.computeCentroidalMap(model, data, configuration))
    if verdict is not None and _proven(verdict, np.hstack([moved, EXACT * noise * np.eye(6)])):
        answer = "no"
    elif (verdict is not None and verdict.feasible) or (lawful and bool(left.all())):
        answer = "yes"
    return ForceEstimate(forces, std, misfit, lawful, answer, verdict, stance)


def _proven(verdict: Verdict, spread: FloatArray) -> bool:
    """Return whether a certificate holds for every load within `REACH` standard deviations.

    Which are the columns of (6, k) `spread`, each what one unknown does to the load [N, N m].
    """
    y = verdict.certificate
    if y is None or not verdict.verify():
        return False
    return bool(y @ verdict.load < -REACH * np.linalg.norm(y @ spread))


def _least_squares(A: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the solution of least norm, its standard deviations, and the misfit per free row."""
    if not A.shape[1]:
        return np.zeros(0), np.zeros(0), float(np.sqrt(np.mean(b * b)))
    U, sizes, V = np.linalg.svd(A, full_matrices=False)
    seen = sizes > RANK * sizes[0]
    # Pseudoinverse with a rank: where the measurements leave a combination of forces open (inner forces
    # between feet), the least is told, and every force with a part in it has an infinite deviation.
    x = V[seen].T @ ((U[:, seen].T @ b) / sizes[seen])
    variance = ((V[seen].T / sizes[seen]) ** 2).sum(axis=1)
    known = (V[seen] ** 2).sum(axis=0) > 1.0 - 1e-6
    free = len(b) - int(seen.sum())
    misfit = float(np.linalg.norm(b - A @ x) / np.sqrt(free)) if free > 0 else 0.0
    return x, np.where(known, np.sqrt(variance), np.inf), misfit


def _lawful(stance: Stance, forces: FloatArray, std: FloatArray) -> bool:
    """Return whether forces push and stay in their cones, soles' wrenches too, up to two deviations."""
    return all(
        contact.explains(forces[part], 2.0 * np.nan_to_num(std[part], posinf=0.0))
        for contact, part in zip(stance, stance.slices, strict=True)
    )
