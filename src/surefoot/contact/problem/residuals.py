"""Every contact law as a number, computed from the problem alone.

Written apart from any solver's stopping test: solvers do not import their projections from here and this
file imports none of theirs, so that a certificate is an independent opinion. Errors are velocities, judged
contact by contact against `problem.scales`, which no answer can inflate: with relative forces as the scale,
forces that run away on a problem without solution would certify themselves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, numbers, of_kind
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.set_residuals import DOUBT, WEIGHTLESS, Numbers, set_certificate
from surefoot.contact.sets.cone_projection import dissipation_limit, nearest
from surefoot.contact.sets.contact import APPROACH

SMALL = 45
"""Number of contacts up to which velocities and residuals are computed in one compiled call."""
SURE = 1e-13
"""A bound on the rounding below this need not be made sharp."""


@dataclass(frozen=True)
class Residuals:
    """How far forces and velocities are from the contact laws; every number is zero at a solution.

    In the convex law the separation mu ||u_t|| that it adds to a sliding contact is taken off first,
    so that the same three laws are read from what is left.

    Attributes
    ----------
    velocity_error
        max_k ε_k / s_k with ε_k = w_k ||λ_k - P_K(λ_k - (u_k + Γ(u_k)) / w_k)|| [m/s], w_k = ||G_kk||₂ and
        s_k the largest velocity in the contact's connected part of the problem at the admissible forces
        nearest to zero (`problem.scales`); Γ = 0 for the convex law. Where a contact below its upper bound
        approaches, at least 0.7 times that speed over s_k: ε_k shows little of it where mu is large.
        Dimensionless. Where s_k = 0 those forces are the solution and others count as infinitely wrong.
    rounding
        max_k 4 eps max(1, mu_k) Σ_j ||G_kj|| ||λ_j|| / s_k, bounded from above: how much of u + Γ(u) double
        precision cannot tell (without mu_k in the convex law, where Γ = 0). Dimensionless. `Status.SOLVED`
        needs it within the tolerance, too.
    energy_gap
        For the convex law the largest λ_k·u_k - min over K of λ·u_k over Σ s_j² / w_j, the energy of its
        connected part: how far each contact is from its share of the least energy [-]; 0 for Coulomb's law. A
        program whose least energy is approached only by ever larger forces shows here, and nowhere else.
        `Status.SOLVED` needs it within the tolerance.
    cone_violation
        Largest distance of a contact's force to its cone, normal bounds included [N].
    penetration_velocity
        Largest approach speed of a contact that is not at its upper normal bound, and largest speed of
        a bilateral one [m/s].
    complementarity
        Largest normal power that the unilateral law says must vanish,
        (λ_n - low) v_n for v_n > 0 and (high - λ_n) |v_n| for v_n < 0 and a finite bound [W].
    dissipation
        Largest gap between the friction power and the most that the cone allows,
        mu λ_n ||u_t|| + λ_t . u_t [W].
    """

    velocity_error: float
    rounding: float
    energy_gap: float
    cone_violation: float
    penetration_velocity: float
    complementarity: float
    dissipation: float

    @property
    def worst(self) -> float:
        """The largest of the first three numbers [-]: what `Status.SOLVED` compares with the tolerance."""
        return max(self.velocity_error, self.rounding, self.energy_gap)


def residuals(problem: ContactProblem, forces: ArrayLike) -> Residuals:
    """Return the residuals of (n, 3) forces [N]; the velocities are recomputed from them.

    Raises
    ------
    ProblemError
        If the forces do not have the shape (n, 3). One force that is not finite makes every number NaN.
    """
    of_kind("problem", problem, ContactProblem)
    f = numbers("forces", forces)
    if f.shape != problem.shape:
        raise ProblemError(f"forces must have shape {problem.shape}, got {f.shape}")
    return Residuals(*certificate(problem, f)[1])


def certificate(problem: ContactProblem, forces: FloatArray) -> tuple[FloatArray, Numbers]:
    """Return the velocities of (n, 3) forces, and the fields of `Residuals`."""
    if problem.contacts == 0:
        return problem.velocity(forces), (0.0,) * 7
    if problem.general:
        return set_certificate(problem, forces)
    f = np.ascontiguousarray(forces, dtype=np.float64).reshape(-1)
    laws = problem.mu, problem.normal_min, problem.normal_max, problem.scales
    kind = problem.facets or 0, problem.fit == "inner", problem.law.shift == 1.0
    if problem.contacts <= SMALL:
        velocities = np.empty(problem.g.size)
        return velocities.reshape(-1, 3), certify_dense(problem.G, problem.g, *laws, *kind, f, velocities)
    with np.errstate(invalid="ignore", over="ignore"):  # said by the numbers
        velocities = np.ascontiguousarray(problem.velocity(forces)).reshape(-1)
    b = problem.blocks
    rounding = _rounding_blocks(b.starts, b.columns, b.values, problem.scales, problem.mu, kind[2], f)
    return velocities.reshape(-1, 3), _measure(f, velocities, *laws, *kind, rounding)


@inline_kernel
def _size(x: float, y: float, z: float) -> float:
    """Return the length of a vector, also where its square overflows or vanishes."""
    square = x * x + y * y + z * z
    return math.sqrt(square) if 1e-250 < square < 1e250 else math.hypot(math.hypot(x, y), z)


@inline_kernel
def _contact_error(
    x: float, y: float, z: float, ux: float, uy: float, uz: float, shift: float, w: float, s: float,
    mu: float, low: float, high: float, facets: int, inner: bool,
) -> float:  # fmt: skip
    """Return ε_k / s_k of one contact, its De Saxcé shift given, or its speed of approach where that is more.

    With v = u + Γ and p = w λ - v the error is v - (P(p) - p) = w λ - P(p). The first form adds velocities to
    velocities: where p is admissible the answer is ||v|| whatever the size of λ. The second keeps w λ where
    a huge Γ (mu ||u_t|| for a large mu) would drown it. For `APPROACH` see `contact.problem.scales`.
    """
    # a part that nothing moves at the least forces has those for its
    # solution: there is no speed to compare with
    if s == 0.0:
        return 0.0 if x == 0.0 and y == 0.0 and z == max(low, 0.0) else np.inf
    # then ε is the distance of -(u + Γ) to the normal cone at λ: a λ large beside s stands for it, its bound
    # where it is zero; also for a bound of 1e-300 N, whose square vanishes
    if w == 0.0:
        length = _size(x, y, z)
        if length == 0.0 and high < np.inf:
            length = high
        if length > 0.0:
            x, y, z, low, high = x / length, y / length, z / length, low / length, high / length
        w = WEIGHTLESS * s if length > 0.0 else 1.0
    # in units of s, so that nothing under- or overflows
    unit = 1.0 / s
    shifted, size = uz + shift, w * unit
    p, q, r = (w * x - ux) * unit, (w * y - uy) * unit, (w * z - shifted) * unit
    # P_K commutes with scaling by w / s, bounds scaled alike: ε / s in one
    # projection, with no λ - u / w formed
    a, b, c = nearest(p, q, r, mu, low * size if low > 0.0 else 0.0, high * size, facets, inner)
    if abs(ux) + abs(uy) + abs(shifted) > w * (abs(x) + abs(y) + abs(z)):
        a, b, c = size * x - a, size * y - b, size * z - c
    else:
        a, b, c = ux * unit - (a - p), uy * unit - (b - q), shifted * unit - (c - r)
    error = _size(a, b, c)
    # 0 <= u_n below the upper bound: the natural map of the unilateral law alone. A NaN stays one
    approach = APPROACH * min(-uz * unit, size * (high - z))
    return approach if approach > error else error


@inline_kernel
def _least_power(uz: float, limit: float, low: float, high: float) -> float:
    """Return the least λ·u over the admissible forces, low (u_n - limit) where it would be without bound."""
    lift = uz - limit
    return lift * (high if lift < 0.0 and high < np.inf else low)


@inline_kernel
def _measure(
    forces: FloatArray, velocities: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray,
    scales: FloatArray, facets: int, inner: bool, coulomb: bool, rounding: float,
) -> Numbers:  # fmt: skip
    """Return the fields of `Residuals` for flat (3n,) forces and velocities."""
    error = violation = approach = normal_power = slip_power = total = 0.0
    gap, lost = 0.0, False
    for k in range(mu.size):
        i = 3 * k
        x, y, z = forces[i], forces[i + 1], forces[i + 2]
        ux, uy, uz = velocities[i], velocities[i + 1], velocities[i + 2]
        total += x + y + z + ux + uy + uz
        w, s = scales[0, k], scales[1, k]
        if low[k] == -np.inf:  # bilateral: any force, no velocity
            speed = math.sqrt(ux * ux + uy * uy + uz * uz)
            approach = max(approach, speed)
            # without a speed of its part any force at all is one too many
            still = 0.0 if x == 0.0 and y == 0.0 and z == 0.0 else np.inf
            own = still if s == 0.0 else speed / s
            error, lost = max(error, own), lost or own != own
            continue
        # Γ(u): with it on the normal row Coulomb's law is K ∋ λ ⟂ u + Γ(u) ∈
        # K*; the convex law is that of u itself
        limit = dissipation_limit(ux, uy, mu[k], facets, inner)
        shift = limit if coulomb else 0.0
        own = _contact_error(x, y, z, ux, uy, uz, shift, w, s, mu[k], low[k], high[k], facets, inner)
        error, lost = max(error, own), lost or own != own
        # the convex program's gap: λ·u above its least over K, over the energy of the part
        if not coulomb:
            own = abs(x * ux + y * uy + z * uz - _least_power(uz, limit, low[k], high[k]))
            if own > 0.0:
                own = own / scales[3, k] if scales[3, k] > 0.0 else np.inf
            gap, lost = max(gap, own), lost or own != own
        # most forces of a round cone lie in it: one comparison instead of a projection
        if facets > 0 or not (z >= 0.0 and low[k] <= z <= high[k] and x * x + y * y <= (mu[k] * z) ** 2):
            a, b, c = nearest(x, y, z, mu[k], low[k], high[k], facets, inner)
            violation = max(violation, math.sqrt((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2))
        # the unilateral law sees the velocity less the convex law's separation
        v = uz if coulomb else uz - limit
        # at its upper bound a contact may be pressed in: the bound is all that holds it
        if v < 0.0 and z < high[k]:
            approach = max(approach, -v)
        power = abs(z - low[k]) * v if v > 0.0 else 0.0
        if v < 0.0 and high[k] < np.inf:
            power = abs(high[k] - z) * -v
        normal_power = max(normal_power, power)
        # maximum dissipation: -λ_t·u_t = mu λ_n ||u_t||
        # the cone's most power is z Γ(u), mu λ_n ||u_t|| for a round one
        slip_power = max(slip_power, abs(z * limit + x * ux + y * uy))
    if lost or not abs(total) < np.inf:
        return np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan
    return error, rounding, gap, violation, approach, normal_power, slip_power


@inline_kernel
def _steepness(mu: float, coulomb: bool) -> float:
    """Return what a rounding of u grows by in u + Γ(u), at least 1: Γ is mu ||u_t|| in Coulomb's law."""
    return mu if coulomb and mu > 1.0 else 1.0


@inline_kernel
def _rounding_bound(scales: FloatArray, mu: FloatArray, coulomb: bool, forces: FloatArray) -> float:
    """Return a bound on Σ_j ||G_kj|| ||λ_j|| / s_k: ||G_kj|| is at most sqrt(trace G_kk trace G_jj)."""
    size = most = 0.0
    for k in range(scales.shape[1]):
        x, y, z, s = forces[3 * k], forces[3 * k + 1], forces[3 * k + 2], scales[1, k]
        product = abs(scales[2, k]) * (x * x + y * y + z * z)
        # a product that underflowed would bound nothing
        if 0.0 < product < 1e-250 and s > 0.0:
            return np.inf
        size += math.sqrt(product)
        steep = _steepness(mu[k], coulomb)
        most = max(most, abs(scales[2, k]) / (s * s) * steep * steep if s > 0.0 else 0.0)
    # Σ_j sqrt(tr G_kk tr G_jj) ||λ_j|| is a product of k's part and a sum: O(n) where the sharp sum is O(n²)
    return math.sqrt(most) * size


@inline_kernel
def _rounding_dense(
    G: FloatArray, scales: FloatArray, mu: FloatArray, coulomb: bool, forces: FloatArray
) -> float:
    """Return the field `rounding`: by `_rounding_bound` if that is small, else by the blocks' norms."""
    n = scales.shape[1]
    bound = _rounding_bound(scales, mu, coulomb, forces)
    if DOUBT * bound <= SURE:
        return DOUBT * bound
    worst = 0.0
    for k in range(n):
        total = 0.0
        for j in range(n):
            i, h = 3 * k, 3 * j
            block = 0.0  # the sum of rows' norms is at least the block's, and nothing vanishes in it
            for a in range(3):
                block += _size(G[i + a, h], G[i + a, h + 1], G[i + a, h + 2])
            total += block * _size(forces[h], forces[h + 1], forces[h + 2])
        # rounding is measured against the motion of the contact's own part, as the error is
        if scales[1, k] > 0.0:
            worst = max(worst, total * _steepness(mu[k], coulomb) / scales[1, k])
    return DOUBT * worst


@kernel
def _rounding_blocks(
    starts: IntArray, columns: IntArray, values: FloatArray, scales: FloatArray, mu: FloatArray,
    coulomb: bool, forces: FloatArray,
) -> float:  # fmt: skip
    """Return the field `rounding` for a block matrix."""
    worst = 0.0
    for k in range(starts.size - 1):
        total = 0.0
        for at in range(starts[k], starts[k + 1]):
            h = 3 * columns[at]
            block = 0.0
            for a in range(3):
                block += _size(values[at, a, 0], values[at, a, 1], values[at, a, 2])
            total += block * _size(forces[h], forces[h + 1], forces[h + 2])
        if scales[1, k] > 0.0:
            worst = max(worst, total * _steepness(mu[k], coulomb) / scales[1, k])
    return DOUBT * worst


@inline_kernel
def certify_dense(
    G: FloatArray, free: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, scales: FloatArray,
    facets: int, inner: bool, coulomb: bool, forces: FloatArray, velocities: FloatArray,
) -> Numbers:  # fmt: skip
    """Fill the flat (3n,) velocities of flat forces, and return the fields of `Residuals`."""
    for j in range(free.size):
        velocities[j] = free[j]
    for i in range(0, free.size, 3):  # row by row: G is symmetric, and sums of rows need no fixed order
        x, y, z = forces[i], forces[i + 1], forces[i + 2]
        if x != 0.0 or y != 0.0 or z != 0.0:
            for j in range(free.size):
                velocities[j] += G[i, j] * x + G[i + 1, j] * y + G[i + 2, j] * z
    rounding = _rounding_dense(G, scales, mu, coulomb, forces)
    return _measure(forces, velocities, mu, low, high, scales, facets, inner, coulomb, rounding)
