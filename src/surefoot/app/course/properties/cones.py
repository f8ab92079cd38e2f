"""52.2: pyramids, the wrench cone of a sole, and OCS2's cone."""

from __future__ import annotations

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near, short

PROPERTIES = Properties()
holds = PROPERTIES.holds


def _pyramid(rng: np.random.Generator) -> tuple[int, float]:
    return int(rng.integers(3, 21)), rng.uniform(0.2, 1.2)


def _edges(corners: np.ndarray) -> np.ndarray:
    """Return the distance of each side's line from the middle."""
    following = np.roll(corners, -1, axis=0)
    along = following - corners
    length = np.linalg.norm(along, axis=1)
    expect((length > 1e-9).all(), f"corners coincide: {short(corners)}")
    distances: np.ndarray = np.abs(corners[:, 0] * along[:, 1] - corners[:, 1] * along[:, 0]) / length
    return distances


def _area(corners: np.ndarray) -> float:
    x, y = corners.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0


@holds("52.2.1", "corners of the inner pyramid lie on the circle, equally far apart")
def _check_inner_corners(answer: Answer, rng: np.random.Generator) -> None:
    k, mu = _pyramid(rng)
    corners = answer.numbers((k, 2), "corners", k, mu, "inner")
    near(np.linalg.norm(corners, axis=1), np.full(k, mu), "the corners' distance")
    near(_edges(corners), np.full(k, _edges(corners).mean()), "the sides' distance")
    near(_area(corners), k / 2 * np.sin(2 * np.pi / k) * mu**2, "the area")


@holds("52.2.1", "sides of the outer pyramid touch the circle")
def _check_outer_sides(answer: Answer, rng: np.random.Generator) -> None:
    k, mu = _pyramid(rng)
    corners = answer.numbers((k, 2), "corners", k, mu, "outer")
    near(_edges(corners), np.full(k, mu), "the sides' distance from the middle")
    near(_area(corners), k * np.tan(np.pi / k) * mu**2, "the area")


@holds("52.2.1", "rows and corners describe one pyramid: each corner lies on two sides")
def _check_one_pyramid(answer: Answer, rng: np.random.Generator) -> None:
    k, mu = _pyramid(rng)
    fit = str(rng.choice(["inner", "outer"]))
    corners = answer.numbers((k, 2), "corners", k, mu, fit)
    rows = answer.numbers((k, 3), "rows", k, mu, fit)
    rows = rows / np.maximum(np.linalg.norm(rows[:, :2], axis=1, keepdims=True), 1e-12)
    values = rows @ np.column_stack([corners, np.ones(k)]).T
    expect(values.max() < 1e-5, f"a corner is outside by {values.max():.3g}")
    touching = (np.abs(values) < 1e-5).sum(axis=0)
    expect((touching == 2).all(), f"corners lie on {short(touching)} sides, expected two each")


@holds("52.2.1", "inner forces are in the cone, and the cone is in the outer pyramid", 40)
def _check_order(answer: Answer, rng: np.random.Generator) -> None:
    k, mu = _pyramid(rng)
    turn, normal = rng.uniform(0, 2 * np.pi), rng.uniform(1, 200)
    direction = np.array([np.cos(turn), np.sin(turn)])
    inside = np.r_[0.999 * mu * normal * direction, normal]
    outer = answer.numbers((k, 3), "rows", k, mu, "outer")
    expect(
        (outer @ inside <= 1e-5 * normal).all(),
        f"the outer pyramid refuses {short(inside)}, which is in the cone",
    )
    outside = np.r_[1.001 * mu * normal * direction, normal]
    inner = answer.numbers((k, 3), "rows", k, mu, "inner")
    expect(
        (inner @ outside > 0).any(), f"the inner pyramid admits {short(outside)}, which is not in the cone"
    )


@holds("52.2.1", "the errors are those of the polygons, inner ones negative")
def _check_errors(answer: Answer, rng: np.random.Generator) -> None:
    k, fit = int(rng.integers(3, 33)), str(rng.choice(["inner", "outer"]))
    found = answer.numbers((2,), "errors", k, fit)
    turns = 2 * np.pi * np.arange(k) / k
    ring = np.column_stack([np.cos(turns), np.sin(turns)])
    middle = np.linalg.norm(ring[0] + ring[1]) / 2.0  # of a side, from the middle
    polygon = ring if fit == "inner" else ring / middle
    worst = middle - 1.0 if fit == "inner" else 1.0 / middle - 1.0
    near(found, [worst, _area(polygon) / np.pi - 1.0], "(worst direction, area)")


def _sole(rng: np.random.Generator) -> tuple[float, float, float]:
    return rng.uniform(0.03, 0.2), rng.uniform(0.03, 0.2), rng.uniform(0.2, 1.0)


def _corner_map(half_x: float, half_y: float) -> np.ndarray:
    """Return the (6, 12) matrix from forces at the four corners to the wrench about the middle."""
    blocks = []
    for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        p = np.array([x * half_x, y * half_y, 0.0])
        blocks.append(np.vstack([np.eye(3), [[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]]]))
    return np.hstack(blocks)


def _rows(answer: Answer, *sole: float) -> np.ndarray:
    found = np.asarray(answer.call("wrench_rows", *sole), float)
    expect(found.ndim == 2 and found.shape[1] == 6, f"it has the shape {found.shape}, expected (m, 6)")
    expect(np.isfinite(found).all(), "it is not finite")
    return found


def _corner_forces(rng: np.random.Generator, mu: float) -> np.ndarray:
    """Return four corner forces, many of them at the edges of their pyramids, some zero."""
    normal = rng.uniform(0, 100, 4) * (rng.random(4) < 0.7)
    side = np.clip(rng.uniform(-2, 2, (4, 2)), -1, 1)
    return np.column_stack([mu * side * normal[:, None], normal])


@holds("52.2.2", "whatever four corners give obeys the rows", 60)
def _check_corners_obey(answer: Answer, rng: np.random.Generator) -> None:
    half_x, half_y, mu = _sole(rng)
    wrench = _corner_map(half_x, half_y) @ _corner_forces(rng, mu).ravel()
    rows = _rows(answer, half_x, half_y, mu)
    worst = (rows @ wrench).max()
    expect(
        worst <= 1e-6 * np.abs(wrench).sum(),
        f"row {int(np.argmax(rows @ wrench))} refuses {short(wrench)}, by {worst:.3g}",
    )


@holds("52.2.2", "what obeys the rows can be given by four corners", 60)
def _check_obeys_and_is_given(answer: Answer, rng: np.random.Generator) -> None:
    from scipy.optimize import linprog

    half_x, half_y, mu = _sole(rng)
    rows = _rows(answer, half_x, half_y, mu)
    scale = np.array([mu, mu, 1.0, half_y, half_x, mu * (half_x + half_y)])
    for one in (0, 1, 3, 4, 5):  # beyond its limit alone: a box of all of them hardly holds such
        alone = scale * np.r_[rng.uniform(-0.1, 0.1, 2), 1.0, rng.uniform(-0.1, 0.1, 3)]
        alone[one] = rng.choice([-1.05, 1.05]) * scale[one]
        expect((rows @ alone).max() > 0, f"all rows admit {short(alone)}, which no corner forces give")
    wrench = 100 * scale * np.r_[rng.uniform(-1.1, 1.1, 2), 1.0, rng.uniform(-1.1, 1.1, 3)]
    limits = np.array([[1, 0, -mu], [-1, 0, -mu], [0, 1, -mu], [0, -1, -mu], [0, 0, -1]])
    for share in (1.0, 0.5):
        found = linprog(
            np.zeros(12),
            A_ub=np.kron(np.eye(4), limits),
            b_ub=np.full(20, 1e-4),
            A_eq=_corner_map(half_x, half_y),
            b_eq=wrench,
            bounds=(None, None),
        )
        if found.status == 2:
            said = (rows @ wrench).max()
            expect(said > 0, f"all rows admit {short(wrench)}, which no corner forces give")
        wrench = wrench * np.array([share, share, 1, share, share, share])


@holds("52.2.2", "the centre of pressure is the mean of the corners, weighted by normal forces")
def _check_pressure_centre(answer: Answer, rng: np.random.Generator) -> None:
    half_x, half_y, mu = _sole(rng)
    forces = _corner_forces(rng, mu) + np.array([0.0, 0.0, 1.0])
    wrench = _corner_map(half_x, half_y) @ forces.ravel()
    corners = np.array([[half_x, half_y], [half_x, -half_y], [-half_x, half_y], [-half_x, -half_y]])
    centre = forces[:, 2] @ corners / forces[:, 2].sum()
    near(answer.numbers((2,), "centre_of_pressure", wrench), centre, "the centre")


@holds("52.2.2", "a row is an equality on the edge, and only there")
def _check_equality_on_the_edge(answer: Answer, rng: np.random.Generator) -> None:
    half_x, half_y, mu = _sole(rng)
    rows = _rows(answer, half_x, half_y, mu)
    edge = rng.uniform(20, 100, 4) * [1, 1, 0, 0]  # the two corners in front
    middle = rng.uniform(20, 100, 4)
    for normal in (edge, middle):
        wrench = _corner_map(half_x, half_y) @ np.column_stack([np.zeros((4, 2)), normal]).ravel()
        found = np.squeeze(np.asarray(answer.call("tight", rows, wrench), bool))
        expect(found.shape == (len(rows),), f"it has the shape {found.shape}, expected ({len(rows)},)")
        right = np.abs(rows @ wrench) <= 1e-6 * wrench[2]
        expect((found == right).all(), f"it says {short(found)}")
        expect(right.any() == (normal is edge), "no row of yours is an equality on the sole's edge alone")


def _force(rng: np.random.Generator) -> tuple[np.ndarray, float, float, float]:
    force = np.r_[rng.normal(size=2) * 40, rng.uniform(10, 200)]
    return force, rng.uniform(0.2, 1.0), rng.choice([0.0, rng.uniform(0, 20)]), rng.uniform(1, 50)


@holds("52.2.3", "the number is zero on the shifted, rounded cone and positive inside")
def _check_zero_on_the_cone(answer: Answer, rng: np.random.Generator) -> None:
    _, mu, gripper, reg = _force(rng)
    turn, side = rng.uniform(0, 2 * np.pi), rng.uniform(0, 100)
    normal = np.hypot(side, np.sqrt(reg)) / mu - gripper
    force = np.array([side * np.cos(turn), side * np.sin(turn), normal])
    near(answer.number("cone_value", force, mu, gripper, reg), 0.0, "the number on the surface")
    more = rng.uniform(1, 50)
    near(
        answer.number("cone_value", force + more * np.eye(3)[2], mu, gripper, reg),
        mu * more,
        "the number above it",
    )


@holds("52.2.3", "without gripper, no force outside of the cone gets a number of zero or more", 40)
def _check_conservative(answer: Answer, rng: np.random.Generator) -> None:
    force, mu, _, reg = _force(rng)
    force[:2] *= rng.uniform(1.0, 1.2) * mu * force[2] / np.hypot(*force[:2])
    found = answer.number("cone_value", force, mu, 0.0, reg)
    expect(found < 0.0, f"it is {found:.4g} for a force that slips")


@holds("52.2.3", "first and second derivatives agree with differences of the number")
def _check_derivatives(answer: Answer, rng: np.random.Generator) -> None:
    force, mu, gripper, reg = _force(rng)
    h = 0.02 * float(np.sqrt(force[0] ** 2 + force[1] ** 2 + reg))  # on the scale of the curvature
    steps = h * np.eye(3)

    def value(at: np.ndarray) -> float:
        return answer.number("cone_value", at, mu, gripper, reg)

    first = [(value(force + step) - value(force - step)) / (2 * h) for step in steps]
    found = answer.numbers((3,), "gradient", force, mu, gripper, reg)
    near(found, first, "the gradient", 1e-3)
    slopes = [
        (
            answer.numbers((3,), "gradient", force + step, mu, gripper, reg)
            - answer.numbers((3,), "gradient", force - step, mu, gripper, reg)
        )
        / (2 * h)
        for step in steps
    ]
    near(answer.numbers((3, 3), "hessian", force, mu, gripper, reg), slopes, "the hessian", 1e-3)
