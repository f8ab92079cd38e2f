"""The ground around a robot as it has seen and touched it: heights on a grid in the estimated frame.

Each cell holds a height and its variance. A point that a range sensor saw is fused as a Kalman filter does;
one that contradicts its cell only makes the cell less sure, so that a stray point does nothing and the second
or third of a kind wins; a cell that a single point has hit counts as unknown if no neighbour is as high.
What is not seen again grows old with the time, for the estimated frame drifts [1]_.
Where feet stand tells how far all of the map is too high or too low: one number follows that. Cells of
which nothing was measured lie on a plane with the slope of the one through the last footholds, as low as the
lowest cell that is known nearby: behind an edge that hides them, low ground is the safer guess.

References
----------
.. [1] P. Fankhauser, M. Bloesch, M. Hutter, "Probabilistic terrain mapping for mobile robots with uncertain
   localization", IEEE Robotics and Automation Letters 2018.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, real_number
from surefoot.base.memory import Remembering
from surefoot.base.settings import Settings, setting
from surefoot.mechanics import Terrain
from surefoot.motion.ground.elevation_kernels import bilinear, fill_unknown, fuse_points, leave_out_strays

MAPPED = "`python -m benchmarks.learnt_ground MapSettings`, 2026-11-26: as good from "
"""How sources begin: other values are tried over what walks have sensed, and those beyond do worse."""


@dataclass(frozen=True)
class MapSettings(Settings):
    """The grid of a height map, and how it weighs what scans and feet measure."""

    spacing: float = setting(0.02, "m", "distance between cells", low=1e-3, high=1.0)
    half: float = setting(1.2, "m", "distance from the robot to the map's border along each axis")
    gate: float = setting(
        3.0,
        "-",
        "standard deviations beyond which a point contradicts its cell",
        low=1e-9,
        tuned=MAPPED + "3 to 9",
    )
    doubt: float = setting(
        0.1, "-", "share of the squared contradiction that is added to a cell's variance", low=0.0
    )
    ageing: float = setting(4e-7, "m²/s", "growth of every cell's variance", low=0.0)
    touch: float = setting(0.006, "m", "standard deviation of a height that a foot measures", low=1e-9)
    anchor: float = setting(
        0.15, "-", "share of a foot's contradiction by which all of the map is moved", low=0.0,
        tuned="`surefoot bench ablation --vary MapSettings.anchor --factor 20 "
        "--task rough-map --seeds 6`, 2026-11-26: as good from 0.0075 to 0.15",
    )  # fmt: skip
    apart: float = setting(
        0.04,
        "m",
        "contradiction from which a foot stands beside what the map shows, and moves nothing",
        low=1e-9,
    )
    window: int = setting(
        3,
        "-",
        "half the width of the square whose plane gives a normal, in cells",
        low=1,
        tuned=MAPPED + "1 to 9",
    )
    neighbour_slope: float = setting(
        0.8, "-", "slope up to which a neighbour belongs to a place's own surface", low=0.0
    )
    neighbour_step: float = setting(
        0.012,
        "m",
        "step, beside the slope, up to which a neighbour belongs to a place's own surface",
        low=0.0,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        real_number("half", self.half, low=4.0 * self.spacing, high=250.0 * self.spacing)


class ElevationMap(Remembering, Terrain):
    """A robot-centric height map that is a `Terrain` for whoever plans on it.

    Parameters
    ----------
    settings
        See `MapSettings`; None for its defaults.

    Attributes
    ----------
    offset
        What feet have measured: by how much the ground is above the map's own heights [m].
    noise
        Height differences below this are noise [m].

    Examples
    --------
    >>> seen = ElevationMap()
    >>> seen.begin([0.0, 0.0], 0.0, [0.0, 0.0])
    >>> x = np.linspace(0.3, 0.7, 400)
    >>> for _ in range(3):
    ...     seen.see(np.column_stack([x, 0.0 * x, 0.12 * (x > 0.5)]), np.full(400, 1e-4))
    >>> seen.height([[0.45, 0.0], [0.6, 0.0], [0.1, 0.5]]).round(3)
    array([0.  , 0.12, 0.  ])
    """

    MEMORY = (
        "_heights",
        "_variances",
        "_filled",
        "_alone",
        "_sure",
        "offset",
        "_corner",
        "_place",
        "_level",
        "_slope",
    )

    noise = 0.012

    def __init__(self, settings: MapSettings | None = None) -> None:
        self.settings = settings or MapSettings()
        count = 2 * math.ceil(self.settings.half / self.settings.spacing) + 1
        self._heights, self._variances = np.zeros((count, count)), np.full((count, count), np.inf)
        self._filled = np.zeros((count, count))
        self._alone, self._sure = np.zeros((count, count), dtype=np.bool_), self._variances.copy()
        steps = np.arange(-self.settings.window, self.settings.window + 1) * self.settings.spacing
        self._around = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
        self.begin(np.zeros(2), 0.0, np.zeros(2))

    def __repr__(self) -> str:
        return f"ElevationMap({len(self._heights)} x {len(self._heights)}, spacing={self.settings.spacing:g})"

    def begin(self, place: ArrayLike, level: float, slope: ArrayLike) -> None:
        """Forget all; what is not seen yet is a plane of height `level` [m] at a (2,) place, (2,) slopes."""
        centre = finite_array("place", place, (2,))
        self._variances[:] = np.inf
        self._heights[:] = 0.0
        self._alone[:] = False
        self._corner = self._corner_of(centre)
        self.offset = 0.0
        self.guess(centre, level, slope)
        self.refresh()

    def guess(self, place: ArrayLike, level: float, slope: ArrayLike) -> None:
        """Set the plane that is assumed where nothing is known; parameters as for `begin`."""
        self._place, self._level = np.asarray(place, dtype=np.float64), float(level)
        self._slope = np.asarray(slope, dtype=np.float64)

    def move(self, place: ArrayLike) -> None:
        """Centre the map on a (2,) place [m]; what leaves it is forgotten."""
        corner = self._corner_of(np.asarray(place, dtype=np.float64))
        shift = np.round((corner - self._corner) / self.settings.spacing).astype(int)
        if not shift.any():
            return
        self._heights[:] = _shift_cells(self._heights, shift, 0.0)
        self._variances[:] = _shift_cells(self._variances, shift, np.inf)
        self._alone[:] = _shift_cells(self._alone.astype(np.float64), shift, 0.0) > 0.0
        self._corner = corner
        self.refresh()

    def see(self, points: FloatArray, variances: FloatArray, elapsed: float = 0.0) -> None:
        """Fuse points that a range sensor saw.

        Parameters
        ----------
        points
            (k, 3) estimated frame [m]; those beside the map, or not finite, are left out.
        variances
            (k,) of their heights [m²].
        elapsed
            Time since the last call [s].
        """
        s = self.settings
        self._variances += s.ageing * elapsed
        fuse_points(
            self._heights, self._variances, self._corner, s.spacing, np.ascontiguousarray(points), variances,
            s.gate, s.doubt, self._alone, False,
        )  # fmt: skip
        self.refresh()

    def touch(self, point: FloatArray) -> None:
        """Learn that a foot stands at a (3,) point [m]."""
        s = self.settings
        if math.isfinite(self.variance(point[:2])):
            error = float(point[2] - self.height(point[:2]))
            if abs(error) < s.apart:
                self.offset += s.anchor * error
        own = np.array([[point[0], point[1], point[2] - self.offset]])
        fuse_points(
            self._heights, self._variances, self._corner, s.spacing, own, np.array([s.touch**2]), s.gate, 1.0,
            self._alone, True,
        )  # fmt: skip

    def variance(self, xy: ArrayLike) -> float:
        """Return the variance of the height at a (2,) place [m²]; infinite where nothing was measured."""
        cell = np.round((np.asarray(xy, dtype=np.float64) - self._corner) / self.settings.spacing).astype(int)
        inside = bool((cell >= 0).all() and (cell < len(self._variances)).all())
        return float(self._sure[cell[0], cell[1]]) if inside else math.inf

    def known(self, xy: FloatArray) -> BoolArray:
        """Return at which of (k, 2) places [m] the height was measured: (k,)."""
        cells = np.round((xy - self._corner) / self.settings.spacing).astype(int)
        inside = ((cells >= 0) & (cells < len(self._sure))).all(axis=1)
        cells[~inside] = 0
        return np.asarray(inside & np.isfinite(self._sure[cells[:, 0], cells[:, 1]]))

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the believed height under (..., 2) places [m]: (...)."""
        places = np.asarray(xy, dtype=np.float64)
        flat = np.ascontiguousarray(places).reshape(-1, 2)
        heights = bilinear(self._filled, self._corner, self.settings.spacing, flat)
        return np.asarray(heights.reshape(places.shape[:-1]) + self.offset)

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the slope along x and y [-] at (..., 2) places [m]: of the plane through each one's surface.

        Neighbours across an edge do not belong to it.
        """
        places = np.asarray(xy, dtype=np.float64)
        around = self._around
        middle = self.height(places)[..., None]
        rise = self.height(places[..., None, :] + around) - middle
        far = np.linalg.norm(around, axis=1)
        own = np.abs(rise) < self.settings.neighbour_slope * far + self.settings.neighbour_step
        own &= own[..., ::-1]  # symmetric about the place, so that its own noise does not tilt the plane
        weights = own.astype(np.float64)
        moments = np.einsum("...k,ki,kj->...ij", weights, around, around)
        moments += 2.0 * self.settings.spacing**2 * np.eye(2)
        loads = np.einsum("...k,ki->...i", weights * rise, around)
        return np.asarray(np.linalg.solve(moments, loads[..., None])[..., 0])

    def _corner_of(self, place: FloatArray) -> FloatArray:
        """Return the place of the first cell when the map is centred on a place."""
        spacing = self.settings.spacing
        return np.asarray(spacing * (np.round(place / spacing) - (len(self._heights) - 1) // 2))

    def refresh(self) -> None:
        """Bring what `height` reads up to date."""
        spacing, corner = self.settings.spacing, self._corner - self._place
        level = self._level - self.offset + float(self._slope @ corner)
        leave_out_strays(self._heights, self._variances, self._alone, self.settings.apart, self._sure)
        fill_unknown(
            self._heights,
            self._sure,
            level,
            self._slope[0] * spacing,
            self._slope[1] * spacing,
            self._filled,
        )


def _shift_cells(array: FloatArray, shift: FloatArray, empty: float) -> FloatArray:
    """Return a square array whose first cell is what was the cell `shift` before; new cells are `empty`."""
    out = np.full_like(array, empty)
    count = len(array)
    take = [slice(max(s, 0), min(count, count + s)) for s in shift.tolist()]
    put = [slice(max(-s, 0), min(count, count - s)) for s in shift.tolist()]
    if all(s.stop > s.start for s in take):
        out[put[0], put[1]] = array[take[0], take[1]]
    return out
