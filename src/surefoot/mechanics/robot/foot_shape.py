"""The contact of a foot told from its collision shapes: a ball, a line, or a sole in a frame of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.mechanics.robot.catalog import EDGE
from surefoot.mechanics.robot.foot_parts import FootPart, describe, disc_points
from surefoot.mechanics.robot.outlines import (
    area_of,
    cut_of,
    few_corners,
    hull_of,
    inner_rectangle,
    moved_in,
    turned_rectangle,
)

BAND = 5e-3
"""What lies this near to the lowest plane of a foot touches the ground [m]."""
SHADOW, TIP = 0.03, 0.01
"""Depth of the foot's shape whose outline a sole, and a point, is compared with [m]."""
POINT, LINE = 0.03, 0.012
"""A contact shorter than the first is a point, one narrower than the second a line [m]."""
LINE_WIDTH = 2e-3
"""Width that a line is given, so that it has the corners of a sole [m]."""
LEVEL, AHEAD = np.cos(np.radians(3.0)), np.cos(np.radians(45.0))
"""Least cosines of the vertical with a frame's z axis, and of the heading with its x axis, to use it."""
TILTED = np.cos(np.radians(30.0))
"""A face of a foot that is tilted further in the nominal pose is no underside."""
WELL_EXPLAINED, CLEARLY = 0.8, 1.25
"""A level contact that explains the first share is right; one at a slant has to be better by the second."""
AS_GOOD = 0.85
"""Share of the largest rectangle that one along the frame's axes must have to be taken."""
MOST_CORNERS, CUT_OFF = 8, 0.02
"""Most corners of a sole, and share of its area that fewer of them may cut off [-]: they are rounding."""
SHARP_EDGE = 2e-3
"""Radius of the corners of a polygon [m]: at an acute one the foot ends several times that before its tip."""
ROUND_FIT, LARGEST_BALL = 0.1, 0.08
"""Most misfit of a ball to the lower end of a mesh, in radii, and its largest radius [m]."""


@dataclass(frozen=True, eq=False)
class FootShapeReading:
    """How a foot touches the ground.

    Attributes
    ----------
    centres
        (k, 3) centres of the contact spheres, in axes `axes` about the foot frame's origin [m].
    radius
        Of the spheres [m].
    axes
        (3, 3) columns: the axes of the contact in the foot's frame; the identity where its own do.
    explained
        Share of the shape's area that the contact has, seen from below.
    words
        What it is, in words.
    """

    centres: FloatArray
    radius: float
    axes: FloatArray
    explained: float
    words: str


def foot_shape(
    parts_at: Callable[[FloatArray], Sequence[FootPart]], up: FloatArray, heading: FloatArray
) -> FootShapeReading:
    """Return the contact of a foot's parts.

    Parameters
    ----------
    parts_at
        The parts in the frame of the foot, at least one, where the vertical there is (3,).
    up, heading
        (3,) the vertical and the direction ahead, in the frame of the foot, where it stands.
    """
    parts = parts_at(up)
    level = _at(parts, up, heading)
    fitted = len(level.centres) == 1 and all(part.radius <= 0.0 for part in parts)
    if level.explained >= WELL_EXPLAINED and not fitted and not any(part.axis.any() for part in parts):
        return level
    # a foot that the pose holds at a slant: its largest face near the ground is its underside
    tilted = [_at(parts_at(other), other, heading, up) for other in (*_faces(parts, up), *_sides(parts, up))]
    best = max((one for one in tilted if len(one.centres) > 1), key=_worth, default=level)
    return best if _worth(best) > CLEARLY * _worth(level) else level


def _worth(reading: FootShapeReading) -> float:
    """Return the area of a contact, counted by how much of the shape it explains [m²]."""
    round_by = 2.0 * min(reading.radius, BAND) if len(reading.centres) > 1 else 2.0 * reading.radius
    return reading.explained * float(np.prod(np.ptp(reading.centres[:, :2], axis=0) + round_by))


def _at(
    parts: Sequence[FootPart], up: FloatArray, heading: FloatArray, true_up: FloatArray | None = None
) -> FootShapeReading:
    """Return the contact of parts on a plane that is level to `up`."""
    axes = _axes(up, heading)
    own = np.vstack([part.points for part in parts])
    points = own @ axes
    radii = np.concatenate([np.full(len(part.points), part.radius) for part in parts])
    owner = np.concatenate([np.full(len(part.points), k) for k, part in enumerate(parts)])
    bottoms = points[:, 2] - radii
    low = float(bottoms.min())
    near = bottoms <= low + BAND
    who = [part for k, part in enumerate(parts) if np.any(owner[near] == k)]
    tilt = (
        ""
        if true_up is None
        else f", {np.degrees(np.arccos(np.clip(up @ true_up, -1.0, 1.0))):.0f} degrees off level"
    )
    scene = _Scene(parts, who, own, points, radii, near, low, axes, tilt)
    return _ball(scene, up) or _round_sole(scene) or _sharp(scene)


@dataclass(frozen=True, eq=False)
class _Scene:
    """Parts that touch; (k, 3) points of all parts in the frame's and the contact's axes, (k,) radii [m]."""

    all: Sequence[FootPart]
    parts: list[FootPart]
    own: FloatArray
    points: FloatArray
    radii: FloatArray
    near: BoolArray
    low: float
    axes: FloatArray
    tilt: str

    def share(self, area: float, depth: float) -> float:
        """Return an area as a share of that of the outline of what is within a depth of the lowest plane."""
        within = self.points[:, 2] - self.radii <= self.low + depth
        # a ball is as wide there as its section
        above = np.maximum(self.low + depth - self.points[:, 2], 0.0)
        radii = np.where(above > 0.0, self.radii, np.sqrt(np.maximum(self.radii**2 - above**2, 0.0)))
        outline = disc_points(self.points[within, :2], radii[within])
        cuts = [cut_of(part.points @ self.axes, self.low + depth) for part in self.all if part.radius <= 0.0]
        whole = area_of(hull_of(np.vstack([outline, *cuts])))
        return min(area / whole, 1.0) if whole > 1e-12 else 1.0

    def sole(
        self, turn: float, centres: FloatArray, radius: float, explained: float, words: str
    ) -> FootShapeReading:
        """Return the sole with (k, 3) centres in axes turned about the vertical by an angle [rad]."""
        c, s = np.cos(turn), np.sin(turn)
        turned = self.axes @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return FootShapeReading(centres, radius, turned, explained, words + self.tilt)


def _ball(scene: _Scene, up: FloatArray) -> FootShapeReading | None:
    """Return the contact of a single ball: a sphere, a capsule's end, a round mesh; None for others."""
    near, points, radii = scene.near, scene.points, scene.radii
    best = int(np.argmax(np.where(near, radii, -1.0)))
    if radii[best] > 0.0:
        reach = np.linalg.norm(points[near, :2] - points[best, :2], axis=1)
        if (reach <= np.where(radii[near] > 0.0, BAND, radii[best])).all():
            r = float(radii[best])
            words = f"a ball of {1e3 * r:.0f} mm radius, {describe(scene.parts)}"
            return FootShapeReading(
                scene.own[best : best + 1], r, np.eye(3), scene.share(np.pi * r**2, TIP), words
            )
        return None
    if any(part.kind not in ("mesh", "ellipsoid") for part in scene.parts):
        return None
    centre, r = _fit_ball(points, scene.low)
    if r <= 0.0:
        return None
    place = scene.axes @ centre
    if np.linalg.norm(place) < 0.4 * r and scene.low < -1e-3:
        place, r = np.zeros(3), -scene.low  # its frame is in its middle
    words = f"a ball of {1e3 * r:.0f} mm radius, which {describe(scene.parts)} is like at its lower end"
    return FootShapeReading(place[None, :], r, np.eye(3), scene.share(np.pi * r**2, TIP), words)


def _fit_ball(points: FloatArray, low: float) -> tuple[FloatArray, float]:
    """Return centre and radius of the ball that the lower end of (k, 3) points lies on; 0 if on none."""
    part = points[points[:, 2] <= low + 3.0 * BAND]
    if len(part) < 8:
        return np.zeros(3), 0.0
    middle = part.mean(axis=0)
    rows = np.hstack([2.0 * (part - middle), np.ones((len(part), 1))])
    found, _, rank, _ = np.linalg.lstsq(rows, ((part - middle) ** 2).sum(axis=1), rcond=None)
    if rank < 4:
        return np.zeros(3), 0.0
    centre, r = found[:3] + middle, float(np.sqrt(max(found[3] + found[:3] @ found[:3], 0.0)))
    off = np.sqrt(np.mean((np.linalg.norm(part - centre, axis=1) - r) ** 2))
    fits = off < ROUND_FIT * r and abs(centre[2] - r - low) < ROUND_FIT * r and r < LARGEST_BALL
    return centre, r if fits else 0.0


def _round_sole(scene: _Scene) -> FootShapeReading | None:
    """Return the sole, or the line, of several balls; None if anything else touches."""
    points, radii = scene.points[scene.near], scene.radii[scene.near]
    if (radii <= 0.0).any():
        return None
    r = float(radii.min())
    lowered = np.column_stack([points[:, :2], points[:, 2] - radii + r])
    hull = hull_of(lowered[:, :2])
    words = f"under {describe(scene.parts)}"
    whole = area_of(hull_of(disc_points(points[:, :2], radii)))
    if len(hull) < 3 or _width(hull) < LINE:
        return _line(scene, hull, float(lowered[:, 2].min()), r, scene.share(whole, SHADOW), words)
    if len(points) == 4 and _four_corners(points) and np.ptp(radii) < 1e-9:
        low, high = _inside(points)
        words = f"a sole of {_mm(high - low)}, {words}"
        return scene.sole(0.0, points, r, scene.share(whole, SHADOW), words)
    turn, height = _turn(hull), float(lowered[:, 2].min())
    area, low, high = turned_rectangle(hull, turn)
    if area < WELL_EXPLAINED * area_of(hull):
        corners = few_corners(hull, MOST_CORNERS, CUT_OFF)
        words = f"{_polygon(corners)}, {words}"
        share = scene.share(whole * area_of(corners) / area_of(hull), SHADOW)
        return scene.sole(0.0, _at_height(corners, height), r, share, words)
    area = float(np.prod(high - low + 2.0 * r))
    words = f"a sole of {_mm(high - low)}, the rectangle {words}"
    return scene.sole(turn, _corners(low, high, height), r, scene.share(area, SHADOW), words)


def _sharp(scene: _Scene) -> FootShapeReading:
    """Return the sole, the line or the point of shapes with corners."""
    points, radii = scene.points[scene.near], scene.radii[scene.near]
    hull = hull_of(disc_points(points[:, :2], radii))
    part = f"what lies within {1e3 * BAND:.0f} mm of the lowest plane of {describe(scene.parts)}"
    length = float(np.linalg.norm(hull[:, None] - hull[None, :], axis=-1).max())
    if length < POINT:
        r = max(0.5 * length, EDGE)
        place = np.array([*(0.5 * (hull.min(axis=0) + hull.max(axis=0))), scene.low + r])
        words = f"a point, rounded by {1e3 * r:.0f} mm: {part}"
        share = scene.share(max(area_of(hull), np.pi * EDGE**2), TIP)
        return FootShapeReading((scene.axes @ place)[None, :], r, np.eye(3), share, words)
    if len(hull) < 3 or _width(hull) < LINE:
        share = scene.share(max(area_of(hull), length * LINE_WIDTH), SHADOW)
        return _line(scene, hull, scene.low + EDGE, EDGE, share, part)
    turn = _turn(hull)
    area, low, high = turned_rectangle(hull, turn)
    if area < WELL_EXPLAINED * area_of(hull):
        corners = few_corners(hull, MOST_CORNERS, CUT_OFF)
        words, share = f"{_polygon(corners)}: {part}", scene.share(area_of(corners), SHADOW)
        corners = moved_in(corners, SHARP_EDGE)
        return scene.sole(0.0, _at_height(corners, scene.low + SHARP_EDGE), SHARP_EDGE, share, words)
    edge = min(EDGE, 0.25 * float((high - low).min()))
    words = f"a sole of {_mm(high - low)}: the rectangle inside {part}"
    centres = _corners(low + edge, high - edge, scene.low + edge)
    return scene.sole(turn, centres, edge, scene.share(area, SHADOW), words)


def _line(
    scene: _Scene, hull: FloatArray, height: float, radius: float, explained: float, part: str
) -> FootShapeReading:
    """Return a line between the ends of a flat outline, as a sole that is hardly wide."""
    apart = np.linalg.norm(hull[:, None] - hull[None, :], axis=-1)
    i, j = np.unravel_index(int(apart.argmax()), apart.shape)
    along = hull[j] - hull[i]
    turn = _fold(float(np.arctan2(along[1], along[0])))
    c, s = np.cos(turn), np.sin(turn)
    ends = hull[[i, j]] @ np.array([[c, -s], [s, c]])
    low, high = ends.min(axis=0), ends.max(axis=0)
    thin = (high - low) < LINE_WIDTH
    middle = 0.5 * (low + high)
    low = np.where(thin, middle - 0.5 * LINE_WIDTH, low)
    high = np.where(thin, middle + 0.5 * LINE_WIDTH, high)
    words = f"a line of {1e3 * float(apart.max()):.0f} mm: {part}"
    return scene.sole(turn, _corners(low, high, height), radius, explained, words)


def _turn(hull: FloatArray) -> float:
    """Return by which angle a hull's rectangle is turned [rad]; none where the axes do nearly as well."""
    edges = np.roll(hull, -1, axis=0) - hull
    long = edges[np.argsort(-np.linalg.norm(edges, axis=1))[:8]]
    turns = [0.0, *(_fold(float(np.arctan2(y, x))) for x, y in long)]
    areas = [turned_rectangle(hull, turn)[0] for turn in turns]
    best = int(np.argmax(areas))
    return 0.0 if areas[0] >= AS_GOOD * areas[best] else turns[best]


def _fold(turn: float) -> float:
    """Return an angle less a number of right angles, within 45 degrees of none [rad]."""
    return float((turn + 0.25 * np.pi) % (0.5 * np.pi) - 0.25 * np.pi)


def _axes(up: FloatArray, heading: FloatArray) -> FloatArray:
    """Return the axes of a level contact: the frame's own where they are level and ahead, else new ones."""
    ahead = heading - (heading @ up) * up
    length = float(np.linalg.norm(ahead))
    ahead = ahead / length if length > 0.1 else np.array([up[2], 0.0, -up[0]])
    if up[2] >= LEVEL and ahead[0] >= AHEAD:
        return np.eye(3)
    x = ahead / np.linalg.norm(ahead)
    return np.column_stack([x, np.cross(up, x), up])


def _faces(parts: Sequence[FootPart], up: FloatArray) -> list[FloatArray]:
    """Return what would be up on the largest faces of the hull that look down, up to six."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.vstack([part.points for part in parts])
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return []
    sizes: dict[tuple[float, ...], float] = {}
    for normal, simplex in zip(hull.equations[:, :3], hull.simplices, strict=True):
        if -normal @ up > TILTED:
            a, b, c = points[simplex]
            key = tuple(np.round(normal, 3).tolist())
            sizes[key] = sizes.get(key, 0.0) + 0.5 * float(np.linalg.norm(np.cross(b - a, c - a)))
    largest = sorted(sizes, key=lambda key: -sizes[key])[:6]
    return [-np.array(key) / np.linalg.norm(key) for key in largest]


def _sides(parts: Sequence[FootPart], up: FloatArray) -> list[FloatArray]:
    """Return what would be up if capsules and cylinders lay on their sides, for those that are near to it."""
    out = []
    for part in parts:
        level = up - (up @ part.axis) * part.axis
        length = float(np.linalg.norm(level))
        if part.axis.any() and TILTED < length < 1.0 - 1e-9:
            out.append(level / length)
    return out


def _width(hull: FloatArray) -> float:
    """Return the least width of a hull of (k, 2) corners [m]."""
    edges = np.roll(hull, -1, axis=0) - hull
    normals = np.column_stack([-edges[:, 1], edges[:, 0]])
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return float(np.ptp(hull @ normals.T, axis=0).min())


def _four_corners(points: FloatArray) -> bool:
    """Return whether four points lie one in each quadrant about their middle."""
    ahead, left = (points[:, :2] > points[:, :2].mean(axis=0)).T
    return len({(bool(a), bool(b)) for a, b in zip(ahead, left, strict=True)}) == 4


def _inside(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    return inner_rectangle(hull_of(points[:, :2]))


def _corners(low: FloatArray, high: FloatArray, height: float) -> FloatArray:
    """Return the corners of a rectangle at a height: (4, 3), front left first and clockwise."""
    (x0, y0), (x1, y1) = low, high
    return np.array([[x1, y1, height], [x1, y0, height], [x0, y0, height], [x0, y1, height]])


def _at_height(corners: FloatArray, height: float) -> FloatArray:
    """Return corners (k, 2) at a height: (k, 3)."""
    return np.column_stack([corners, np.full(len(corners), height)])


def _polygon(corners: FloatArray) -> str:
    """Return a convex polygon in words: its corners and how far they reach along the axes."""
    return f"a sole of {len(corners)} corners, {_mm(np.ptp(corners, axis=0))}"


def _mm(size: FloatArray) -> str:
    return f"{1e3 * float(size[0]):.0f} x {1e3 * float(size[1]):.0f} mm"
