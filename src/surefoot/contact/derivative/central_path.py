"""The smoothed law: a point on the central path, and the derivative there.

Every contact's complementarity K ∋ λ ⟂ y ∈ K*, y = u + Γ(u), is replaced by its barrier's::

    λ·y = κ,    mu² λ_n y_t + y_n λ_t = 0        (λ ∘ y = κ e in the cones' Jordan algebra)

so a contact that is open carries κ / u_n and one that sticks creeps. Normal bounds add κ / (high - λ_n) and
take κ / (λ_n - low) off y_n. Coulomb's shift mu ||u_t|| is rounded to mu sqrt(||u_t||² + ε²) with
ε = κ w / s, of the order of the other errors; derivatives hold ε. A primal-dual interior point follows the
path down to κ.

Limits: exact cones; a normal_min of zero is the apex of its cone, and has no rate of its own. With redundant
contacts the system's condition is about s² / (w κ): below 1e-8 of that energy the path may not be reached.

Source: V. Acary, P. Armand, H. M. Nguyen, M. Shpakovych, "Second-order cone programming for frictional
contact mechanics using interior point algorithm", Optim. Methods Softw. 39(3), 2024 (the shift and the path).
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import NoSolution, ProblemError
from surefoot.contact.derivative.path_kernels import (
    fill_epsilon,
    fill_slack_rates,
    fill_slacks,
    path_system,
)
from surefoot.contact.problem.problem import ContactProblem

STEPS = 200
"""Newton steps to the path."""
SHRINK, REACH, SHORTER, TINY = 0.3, 0.9, 0.9, 1e-20
"""How far κ falls at most in a step; how much of the way to the cones' boundary is gone, by how much a step
is shortened until it stays inside, and the share of it at which nothing is left."""
EXACT, NEAR = 1e-13, 1e-8
"""Newton steps, relative to the largest force, after which the point is exact, and good enough where rounding
keeps them from shrinking."""
Point = tuple[FloatArray, FloatArray, float, bool, FloatArray, FloatArray]
"""laws, epsilon, κ, whether the law is convex, forces and velocities, as `path_kernels` take them first."""


class _Path:
    """The path of a problem to κ, as `path_kernels` takes it: laws (3, n), epsilon (n,)."""

    def __init__(self, problem: ContactProblem, kappa: float) -> None:
        fixed = (problem.normal_min == problem.normal_max) & (problem.normal_max > 0.0)
        if fixed.any():
            k = int(np.argmax(fixed))
            raise ProblemError(f"smoothing needs normal_min < normal_max, got equal ones at contact {k}")
        self.problem, self.kappa = problem, kappa
        self.laws, self.epsilon = problem.vectors[1].reshape(3, -1), np.empty(problem.contacts)
        fill_epsilon(problem.scales, kappa, problem.law == "convex", self.epsilon)

    @property
    def kept(self) -> BoolArray:
        """Contacts that obey a cone: neither bilateral nor off."""
        return np.asarray((self.laws[1] > -np.inf) & (self.laws[2] > 0.0))

    def at(self, forces: FloatArray, velocities: FloatArray, kappa: float) -> Point:
        """Return what the kernels take first, at (n, 3) forces and velocities."""
        convex = self.problem.law == "convex"
        return self.laws, self.epsilon, kappa, convex, forces.reshape(-1), velocities.reshape(-1)


class SmoothSystem:
    """The derivative of the path's point: M λ' = -(Q U b + E_mu mu' + ...), u' = G λ' + b.

    `after` is that of `ActiveSystem`.
    """

    def __init__(self, path: _Path, forces: FloatArray, slacks: FloatArray) -> None:
        p, m = path.problem, forces.size
        n = p.contacts
        self.forces, self.velocities = forces, p.velocity(forces)
        M, right = np.empty((m, m)), np.empty((m, m + 3 * n))
        at = path.at(forces, self.velocities, path.kappa)
        path_system(p.G, *at, np.ascontiguousarray(slacks).reshape(-1), M, right)
        forces_after = np.linalg.solve(M, right)
        velocities_after = p.G @ forces_after
        velocities_after[:, : 3 * n] += np.eye(3 * n)
        self.after = forces_after, velocities_after
        self.condition = float(np.linalg.cond(M)) if n else 1.0
        self.rank = self.size = 3 * n
        self.loose = 0.0


def central_path(problem: ContactProblem, forces: FloatArray, kappa: float) -> SmoothSystem:
    """Follow the path from far inside to λ·y = κ; `forces` (n, 3) solve the problem.

    Raises
    ------
    ProblemError
        For normal bounds that leave no room.
    NoSolution
        If the path is not reached.
    """
    path = _Path(problem, kappa)
    with np.errstate(all="ignore"):  # said by the error
        f, y, reached = _follow(path, forces)
        try:
            system = SmoothSystem(path, f, y) if reached else None
        except np.linalg.LinAlgError:
            system = None
    if system is None or not all(np.isfinite(block).all() for block in system.after):
        raise NoSolution(f"the central path was not reached at smoothing={kappa:g}", problem)
    return system


def _follow(path: _Path, forces: FloatArray) -> tuple[FloatArray, FloatArray, bool]:
    """Return forces and slacks where λ·y = κ, and whether they are reached."""
    problem, kappa = path.problem, path.kappa
    f, y = _start(path, forces)
    kept = path.kept
    count = max(int(kept.sum()), 1)
    matrix, right = np.empty((f.size, f.size)), np.empty((f.size, 1))
    moved, last, on_path = 0.0, np.inf, problem.contacts == 0
    for _ in range(STEPS if problem.contacts else 0):
        gap = float((f * y)[kept].sum()) / count
        # at most so much down at once: a point near the path for one κ is a start for the next
        target = max(kappa, SHRINK * gap)
        at = path.at(f, problem.velocity(f), target)
        want = np.empty_like(f)
        fill_slacks(*at, want.reshape(-1))
        path_system(problem.G, *at, y.reshape(-1), matrix, right)
        if not (np.isfinite(matrix).all() and np.isfinite(right).all()):
            return f, y, False
        # least squares: redundant contacts leave the system singular as κ falls, and the least step is wanted
        flat = np.asarray(np.linalg.lstsq(matrix, right[:, 0], rcond=1e-15)[0], dtype=np.float64)
        du, dy, step = np.asarray(problem.G @ flat), np.empty_like(f), flat.reshape(-1, 3)
        fill_slack_rates(*at, flat, du, dy.reshape(-1))
        dy += want - y
        share = _share(path, f, step, y, dy)
        f, y = f + share * step, y + share * dy
        moved = float(np.abs(step).max(initial=0.0)) / max(float(np.abs(f).max(initial=0.0)), 1e-300)
        # only whole steps for κ itself tell by their size how far the point is
        on_path = target == kappa and share == 1.0
        if on_path and (moved <= EXACT or NEAR >= moved >= 0.5 * last):  # as near as rounding lets it
            break
        last = moved if on_path else np.inf
    return f, y, on_path and moved <= NEAR


def _start(path: _Path, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return forces and slacks well inside their cones."""
    p = path.problem
    w, s = p.scales[:2]
    # forces and slacks of the problem's own size, straight up: on the axes of both
    # cones, where y ∘ λ is a multiple of e
    speed = np.maximum(s, np.sqrt(path.kappa * np.where(w > 0.0, w, 1.0)))
    reach = np.divide(speed, w, out=np.ones_like(w), where=w > 0.0)
    f, y = np.zeros_like(forces), np.zeros_like(forces)
    low = np.maximum(p.normal_min, 0.0)
    height = np.maximum(np.maximum(reach, forces[:, 2]), low + reach)
    room = np.isfinite(p.normal_max)
    # no higher than the middle between bounds, where neither barrier is steep
    height[room] = np.minimum(height[room], 0.5 * (low + p.normal_max)[room])
    f[:, 2], y[:, 2] = height, speed
    held, off = p.normal_min == -np.inf, p.normal_max == 0.0
    f[held], y[held], f[off] = forces[held], 0.0, 0.0
    return f, y


def _share(path: _Path, f: FloatArray, df: FloatArray, y: FloatArray, dy: FloatArray) -> float:
    """Return the share of a step that keeps forces and slacks inside, at some way from the boundary."""
    share = 1.0
    while share > TINY and not _inside(path, f + share * df, y + share * dy):
        share *= SHORTER
    # a share of the way to the boundary only: from the boundary itself the next step could not start
    return share if share == 1.0 else REACH * share


def _inside(path: _Path, f: FloatArray, y: FloatArray) -> bool:
    """Tell whether forces and slacks (n, 3) lie inside their cones and bounds."""
    kept, (mu, low, high) = path.kept, path.laws
    within = (np.maximum(low, 0.0) < f[:, 2]) & (f[:, 2] < high) & (y[:, 2] > 0.0)
    # without friction the cone is a ray, and its tangential forces stay zero
    side, slip = np.hypot(f[:, 0], f[:, 1]), mu * np.hypot(y[:, 0], y[:, 1])
    within &= (mu == 0.0) | ((side < mu * f[:, 2]) & (slip < y[:, 2]))
    return bool(within[kept].all())
