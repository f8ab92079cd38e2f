"""Can they stand, and where may the centre of mass be: the questions to one stance, put to many.

The answers are those of the single calls, by the same compiled code. What is ordinary (exact cones, no bounds
on forces) runs through it array by array; the rest is asked one by one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import (
    LARGEST,
    BoolArray,
    FloatArray,
    IntArray,
    finite_array,
    of_kind,
    positive_number,
)
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, count_of
from surefoot.base.kernels import kernel
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.stance import Stance
from surefoot.mechanics.stance.stance_batch import StanceBatch
from surefoot.mechanics.statics.com_region import com_region
from surefoot.mechanics.statics.margin import ENDLESS, FEASIBLE, LEAST_MU, UNDECIDED, most_margin
from surefoot.mechanics.statics.point_contacts import stand
from surefoot.mechanics.statics.region import Region
from surefoot.mechanics.statics.region_search import ROOM, OutlineProgram, search_certified
from surefoot.mechanics.statics.row_blocks import IN_ONE
from surefoot.mechanics.statics.statics import can_stand, needed_wrench
from surefoot.mechanics.statics.verdict import Verdict


class Verdicts(Drawn):
    """The answers of `can_stand_batch`; `verdicts[k]` is the `Verdict` of `can_stand`, proof included.

    Attributes
    ----------
    status
        (B,) "possible", "impossible" or "undecided".
    margin
        (B,) as `Verdict.margin` [N].
    forces
        (B, n, 3) forces of the points (corners of soles) in contact frames [N]; NaN where there are none,
        zero beyond a stance's number of points.
    certificate
        (B, 6) separating wrenches; NaN where there is none.
    reach
        (B,) as `Verdict.reach` [N].
    com, load
        (B, 3) [m] and (B, 6) [N, N m], as in `Verdict`.
    points
        The stances' points as arrays.
    """

    def __init__(
        self, asked: Sequence[Stance] | StanceBatch, com: FloatArray, masses: FloatArray, wrenches: FloatArray
    ) -> None:
        size = len(asked)
        self.points = asked if isinstance(asked, StanceBatch) else StanceBatch.of(asked)
        self._asked, self.com, self._masses, self._wrenches = asked, com, masses, wrenches
        self.load = np.outer(masses * GRAVITY, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]) - wrenches
        self.status = np.full(size, "undecided", dtype="<U10")
        self.margin, self.reach = np.full(size, np.nan), np.zeros(size)
        self.forces = np.zeros(self.points.positions.shape)
        self.certificate = np.full((size, 6), np.nan)

    def __len__(self) -> int:
        return len(self.status)

    def __iter__(self) -> Iterator[Verdict]:
        return (self[k] for k in range(len(self)))

    def __repr__(self) -> str:
        return f"Verdicts({int(self.feasible.sum())} of {len(self)} possible)"

    def __str__(self) -> str:
        counts = {name: int((self.status == name).sum()) for name in ("possible", "undecided", "impossible")}
        said = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
        finite = self.margin[self.feasible & np.isfinite(self.margin)]
        margins = f"; margins {finite.min():.3g} to {finite.max():.3g} N" if len(finite) else ""
        return f"{count_of(len(self), 'stance')}: {said or 'none'}{margins}."

    @property
    def feasible(self) -> BoolArray:
        """(B,) which can stand."""
        return np.asarray(self.status == "possible")

    def __getitem__(self, k: int) -> Verdict:
        """Return one answer as `can_stand` gives it."""
        k = range(len(self))[k]
        return can_stand(self._asked[k], self.com[k], float(self._masses[k]), self._wrenches[k])

    def _ask_alone(self, k: int) -> None:
        """Take over an answer of the single call."""
        verdict, count = self[k], self.points.counts[k]
        self.status[k], self.margin[k], self.reach[k] = verdict.status, verdict.margin, verdict.reach
        self.forces[k, :count] = np.nan if verdict.corner_forces is None else verdict.corner_forces
        self.certificate[k] = np.nan if verdict.certificate is None else verdict.certificate


def _count(stances: Sequence[Stance] | StanceBatch) -> int:
    """Return how many there are."""
    if not isinstance(stances, StanceBatch):
        for k, stance in enumerate(stances if isinstance(stances, Sequence) else [stances]):
            of_kind(f"stances[{k}]", stance, Stance)
    return len(stances)


def can_stand_batch(
    stances: Sequence[Stance] | StanceBatch,
    com: ArrayLike,
    mass: ArrayLike,
    external_wrench: ArrayLike = 0.0,
) -> Verdicts:
    """Tell of many stances whether contact forces can hold the robot: `can_stand` of each.

    Parameters
    ----------
    stances
        B stances; from arrays (`StanceBatch`) it costs least.
    com
        (3,) or (B, 3) centres of mass, world axes [m].
    mass
        > 0, a number or (B,) [kg].
    external_wrench
        (6,) or (B, 6) as for `can_stand` [N, N m]; 0 for none.

    Returns
    -------
    Verdicts
        `.feasible`, `.status`, `.margin`, `.forces`, `.certificate`, `.reach` as arrays; the k-th as a
        `Verdict` by `verdicts[k]`.

    Raises
    ------
    ProblemError
        As for `can_stand`.

    Examples
    --------
    >>> feet = np.array([[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]])
    >>> candidates = StanceBatch(np.array([feet, feet + [0.15, 0, 0], feet + [0.3, 0, 0]]), mu=0.6)
    >>> verdicts = can_stand_batch(candidates, com=[0.0, 0.0, 0.3], mass=15.0)
    >>> verdicts.feasible
    array([ True,  True, False])
    >>> verdicts[2].verify()
    True
    """
    size = _count(stances)
    about, masses = _per_stance("com", com, size, (3,)), _masses(mass, size)
    wrenches = np.zeros((size, 6))
    given = finite_array("external_wrench", external_wrench)
    if given.ndim or given != 0.0:
        wrenches = _per_stance("external_wrench", external_wrench, size, (6,))
    out = Verdicts(stances, about, masses, wrenches)
    ordinary = _ordinary(stances)
    again = [np.flatnonzero(~ordinary)]  # bounds or no contacts
    for which, count in out.points.groups():
        chosen = which[ordinary[which]]
        if len(chosen):
            again.append(chosen[_stand(out, chosen, count)])
    for k in np.concatenate(again):
        out._ask_alone(int(k))
    return out


def _stand(out: Verdicts, chosen: IntArray, count: int) -> BoolArray:
    """Answer stances of equally many points; return which are undecided, for a second look."""
    points, size = out.points, len(chosen)
    outcomes, margins, reaches = np.empty(size, dtype=np.int64), np.empty(size), np.empty(size)
    forces, proofs = np.empty((size, 3 * count)), np.empty((size, 6))
    stand_each(
        points.positions[chosen, :count], points.rotations[chosen, :count], points.mu[chosen, :count],
        out.com[chosen], out.load[chosen], outcomes, margins, forces, proofs, reaches,
    )  # fmt: skip
    held = (outcomes == FEASIBLE) | (outcomes == ENDLESS)
    undecided = outcomes == UNDECIDED
    never = ~held & ~undecided
    out.status[chosen] = np.where(held, "possible", np.where(never, "impossible", "undecided"))
    out.margin[chosen], out.reach[chosen] = margins, np.where(never, reaches, 0.0)
    out.forces[chosen, :count] = np.where(held[:, None], forces, np.nan).reshape(-1, count, 3)
    out.certificate[chosen] = np.where(never[:, None], proofs, np.nan)
    return np.asarray(undecided)


@kernel
def stand_each(
    positions: FloatArray, rotations: FloatArray, mu: FloatArray, about: FloatArray, loads: FloatArray,
    outcomes: IntArray, margins: FloatArray, forces: FloatArray, proofs: FloatArray, reaches: FloatArray,
) -> None:  # fmt: skip
    """Ask `margin.stand` of stances of n points each: (B, n, ...), the answers written in place."""
    for k in range(len(mu)):
        outcome, margin, x, y, reach = stand(positions[k], rotations[k], mu[k], about[k], loads[k])
        outcomes[k], margins[k], reaches[k] = outcome, margin, reach
        for i in range(x.size):
            forces[k, i] = x[i]
        for i in range(6):
            proofs[k, i] = y[i]


def com_region_batch(
    stances: Sequence[Stance] | StanceBatch,
    mass: ArrayLike,
    tol: float = 1e-3,
    height: ArrayLike | None = None,
) -> list[Region]:
    """Return where the centre of mass may be over each of many stances, at rest: `com_region` of each.

    Parameters
    ----------
    stances
        B stances; from arrays (`StanceBatch`) it costs least.
    mass
        > 0, a number or (B,) [kg].
    tol
        Largest distance between the inner and the outer polygon [m].
    height
        Of the polygons' planes, a number or (B,) [m]; the mean height of each stance's contacts unless given.

    Returns
    -------
    list[Region]
        One for each stance. With accelerations, pyramids or bounds on forces ask `com_region`.

    Raises
    ------
    ProblemError
        As for `com_region`.

    Examples
    --------
    >>> feet = np.array([[0.2, 0.1, 0], [0.2, -0.1, 0], [-0.2, 0.1, 0], [-0.2, -0.1, 0]])
    >>> [round(r.area, 6) for r in com_region_batch(StanceBatch([feet, 0.5 * feet]), mass=15.0)]
    [0.08, 0.02]
    """
    size = _count(stances)
    masses = _masses(mass, size)
    heights = None if height is None else _per_stance("height", height, size, ())
    tol = positive_number("tol", tol, "m")
    points = stances if isinstance(stances, StanceBatch) else StanceBatch.of(stances)
    found: dict[int, Region] = {}
    ordinary = _ordinary(stances)
    for which, count in points.groups():
        chosen = which[ordinary[which]]
        if len(chosen):
            anchors = _anchors(stances, points, chosen, count, heights)
            found |= _regions(points, chosen, count, anchors, tol)
    return [
        found[k] if k in found else com_region(
            stances[k], float(masses[k]), tol, height=None if heights is None else float(heights[k])
        )
        for k in range(size)
    ]  # fmt: skip


def _regions(
    points: StanceBatch, chosen: IntArray, count: int, anchors: FloatArray, tol: float
) -> dict[int, Region]:
    """Return the regions of stances of equally many points, those that hide nothing out of the ordinary.

    The equations of `limits.equations` and `tracing`, for a load that is a weight: it is divided out.
    """
    R, mu = points.rotations[chosen, :count], points.mu[chosen, :count]
    arms = points.positions[chosen, :count] - anchors[:, None, :]
    lengths = np.sqrt((arms**2).sum(axis=(1, 2)) / count)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    # cone coordinates (f_z, f_x / mu, f_y / mu): columns of forces, of moments in units of the length
    forces = np.stack([R[..., 2], mu[..., None] * R[..., 0], mu[..., None] * R[..., 1]], axis=-2)
    moments = np.cross(arms[:, :, None, :] / lengths[:, None, None, None], forces)
    columns = np.concatenate([forces, moments], axis=-1).reshape(len(chosen), 3 * count, 6)
    A = np.ascontiguousarray(np.swapaxes(columns, 1, 2))
    axes = np.zeros((len(chosen), 3 * count))
    axes[:, ::3] = np.where(mu > 0.0, np.sqrt(1.0 + mu * mu) / np.maximum(mu, LEAST_MU), 1.0)
    w = np.array([0.0, 0.0, 1.0, 0.0])  # the weight's force, and no moment about it
    out: dict[int, Region] = {}
    for i, k in enumerate(chosen):
        rows = np.ascontiguousarray(A[i, [0, 1, 2, 5]])
        outcome, margin, start, _, _ = most_margin(rows, axes[i], w, count, IN_ONE)
        if outcome != FEASIBLE or not margin > ROOM:
            continue
        G = np.stack([-lengths[i] * A[i, 4], lengths[i] * A[i, 3]])
        traced = search_certified(
            OutlineProgram(rows, w, axes[i], count, G, anchors[i, :2].copy(), start), None, tol
        )
        if not traced.unbounded:
            out[int(k)] = traced.region(anchors[i, 2], np.array([0.0, 0.0, 1.0]), tol)
    return out


def _anchors(
    stances: Sequence[Stance] | StanceBatch, points: StanceBatch, chosen: IntArray, count: int,
    heights: FloatArray | None,
) -> FloatArray:  # fmt: skip
    """Return the middles of stances' contacts, at the heights of the planes: (b, 3)."""
    if stances is points:
        out = points.positions[chosen, :count].mean(axis=1)
    else:
        out = np.array([stances[k].positions.mean(axis=0) for k in chosen])
    if heights is not None:
        out[:, 2] = heights[chosen]
    return np.asarray(out)


def _ordinary(stances: Sequence[Stance] | StanceBatch) -> BoolArray:
    """Return which stances have contacts and no bounds on them: (B,)."""
    if isinstance(stances, StanceBatch):
        return np.asarray(stances.counts > 0)
    return np.array([bool(s.contacts) and not s.bounded for s in stances], dtype=np.bool_)


def _masses(mass: ArrayLike, size: int) -> FloatArray:
    """Return (B,) masses."""
    masses = _per_stance("mass", mass, size, ())
    for wrong in masses[~(masses > 0.0)][:1]:
        needed_wrench(float(wrong))  # says what is wrong with it
    return masses


def _per_stance(name: str, value: ArrayLike, size: int, shape: tuple[int, ...]) -> FloatArray:
    """Return a value that is given once or for each stance as (B, ...)."""
    given = finite_array(name, value)
    if given.shape not in (shape, (size, *shape)):
        raise ProblemError(f"{name} must have shape {shape} or {(size, *shape)}, got {given.shape}")
    largest = float(np.abs(given).max(initial=0.0))
    if largest > LARGEST:
        raise ProblemError(f"{name} must be within {LARGEST:g}, got {largest:g}")
    return np.array(np.broadcast_to(given, (size, *shape)))
