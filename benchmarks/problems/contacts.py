"""Named contact problems that the package makes itself, the same for the same seed.

`problem_set("robot")` holds robot-scale problems (up to 25 contacts), `problem_set("large")` stacks, walls,
piles and heaps of up to 600 contacts, most of them rank-deficient, some with mass ratios of 1e6. Problems
that need a robot model are left out where the `robot` extra is not installed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec

import numpy as np

from benchmarks.problems.heaps import capsules, cups, masonry, rocks
from benchmarks.problems.judge import judge
from benchmarks.problems.rigid_bodies import Scene
from benchmarks.problems.robot_scenes import robot_delassus as robot
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, unknown_name
from surefoot.contact.problem import ContactProblem

TRIVIAL = 1e-6
"""A drawn problem that no forces at all solve this well is drawn again: nothing touches."""


@dataclass(frozen=True)
class NamedProblem:
    """A problem with a name ("family-number") and its family."""

    name: str
    family: str
    problem: ContactProblem


UP = np.array([0.0, 0.0, 1.0])


def _random_push(rng: np.random.Generator, size: float) -> FloatArray:
    """Return a twist with a horizontal and a turning part."""
    return np.concatenate([size * rng.normal(size=3) * [1, 1, 0.2], size * rng.normal(size=3)])


def _face(half: float, points: int) -> FloatArray:
    """Return points x points places on a square face: (n, 2)."""
    at = np.linspace(-half, half, points)
    return np.array([[x, y] for x in at for y in at])


def cube(rng: np.random.Generator, points: int, push: float, mu: float) -> ContactProblem:
    """Return a cube on the ground that touches in points x points places of its face."""
    scene = Scene()
    size, mass = rng.uniform(0.05, 0.5), rng.uniform(0.2, 20.0)
    body = scene.box(np.array([0, 0, size / 2]), np.full(3, size), mass, push * _random_push(rng, 1.0))
    for x, y in _face(size / 2, points):
        scene.touch(body, -1, np.array([x, y, 0.0]), UP, mu)
    return scene.problem()


def grasp(rng: np.random.Generator, fingers: int, points: int, mu: float) -> ContactProblem:
    """Return an object held by fingers: a hand whose tips (light bodies, pressed inwards) touch it."""
    scene = Scene()
    radius = 0.04
    thing = scene.sphere(np.zeros(3), radius, rng.uniform(0.05, 0.8), _random_push(rng, 0.05))
    for f in range(fingers):
        angle = 2 * np.pi * (f + 0.3 * rng.random()) / fingers
        inwards = -np.array([np.cos(angle), np.sin(angle), 0.4 * rng.normal()])
        inwards /= np.linalg.norm(inwards)
        press = rng.uniform(0.5, 4.0) * scene.time_step / 0.05  # a fingertip's force over its mass
        tip = scene.sphere(
            -(radius + 0.01) * inwards, 0.01, 0.05, np.concatenate([press * inwards, np.zeros(3)])
        )
        for _ in range(points):
            spot = -radius * inwards + 0.004 * rng.normal(size=3)
            scene.touch(thing, tip, spot, inwards + 0.05 * rng.normal(size=3), mu)
    return scene.problem()


def feet(rng: np.random.Generator, legs: int, points: int, push: float, mu: float) -> ContactProblem:
    """Return a body on flat feet with `points` contacts each, the joints taken as locked."""
    scene = Scene()
    body = scene.box(
        np.array([0, 0, 0.6]), np.array([0.5, 0.3, 0.2]), rng.uniform(10, 60), push * _random_push(rng, 1.0)
    )
    for k in range(legs):
        foot = np.array([0.3 * np.cos(2.1 * k + 0.4), 0.25 * np.sin(2.1 * k + 0.4), 0.0])
        corners = np.array([[0.1, 0.04, 0], [0.1, -0.04, 0], [-0.1, 0.04, 0], [-0.1, -0.04, 0]])
        for corner in corners[:points]:
            scene.touch(body, -1, foot + corner, UP, mu)
    return scene.problem()


def small_pile(rng: np.random.Generator, mu: float) -> ContactProblem:
    """Return 25 contacts of three boxes on each other and two balls: rank-deficient."""
    scene = Scene()
    below, height = -1, 0.0
    for _ in range(3):
        size = rng.uniform(0.1, 0.3)
        box = scene.box(
            np.array([0, 0, height + size / 2]),
            np.full(3, size),
            rng.uniform(0.5, 5.0),
            _random_push(rng, 0.02),
        )
        for x, y in _face(0.05, 2 if below >= 0 else 3):
            scene.touch(box, below, np.array([x, y, height]), UP, mu)
        below, height = box, height + size
    for side in (-1.0, 1.0):
        ball = scene.sphere(np.array([0.05 * side, 0, height + 0.05]), 0.05, 0.3, _random_push(rng, 0.02))
        for _ in range(3):
            spot = np.array([0.05 * side, 0, height]) + 0.004 * rng.normal(size=3)
            scene.touch(ball, below, spot, UP + 0.05 * rng.normal(size=3), mu)
    wall = scene.contacts[-1]
    scene.touch(wall[0], -1, np.array([0.1, 0, height + 0.05]), np.array([-1.0, 0, 0]), mu)
    scene.touch(below, -1, np.array([0.15, 0.0, height - 0.02]), np.array([-1.0, 0, 0]), mu)
    return scene.problem()


Maker = Callable[[np.random.Generator], ContactProblem]

_ROBOT: dict[str, tuple[int, Maker]] = {
    "cube-sticking": (4, lambda r: cube(r, 2, 0.01, r.uniform(0.6, 1.0))),
    "cube-sliding": (4, lambda r: cube(r, 2, 1.0, r.uniform(0.1, 0.6))),
    "cube-face9": (4, lambda r: cube(r, 3, 0.3, r.uniform(0.2, 0.8))),
    "cube-face25": (2, lambda r: cube(r, 5, 0.2, r.uniform(0.2, 0.8))),
    "grasp-3": (4, lambda r: grasp(r, 3, 1, r.uniform(0.5, 1.0))),
    "grasp-5x4": (4, lambda r: grasp(r, 5, 4, r.uniform(0.4, 0.9))),
    "feet-2x4": (4, lambda r: feet(r, 2, 4, 0.2, r.uniform(0.3, 0.9))),
    "feet-4x4": (4, lambda r: feet(r, 4, 4, 0.2, r.uniform(0.3, 0.9))),
    "pile-25": (4, lambda r: small_pile(r, r.uniform(0.2, 0.8))),
}

_MODELS: dict[str, tuple[int, Maker]] = {
    "go2-standing": (4, lambda r: robot(r, "go2", 4, 1, 0.0, r.uniform(0.5, 0.9))),
    "go2-stiff": (4, lambda r: robot(r, "go2", 4, 1, 0.1, r.uniform(0.4, 0.9), gain=20.0)),
    "go2-trotting": (4, lambda r: robot(r, "go2", 2, 1, 0.1, r.uniform(0.5, 0.9))),
    "go2-sliding": (4, lambda r: robot(r, "go2", 4, 1, 1.0, r.uniform(0.1, 0.4))),
    "go2-takeoff": (4, lambda r: robot(r, "go2", 4, 1, 0.3, r.uniform(0.3, 0.8), lift=0.3)),
    "go2-flatfeet": (4, lambda r: robot(r, "go2", 4, 4, 0.3, r.uniform(0.3, 0.8))),
    "g1-standing": (4, lambda r: robot(r, "g1", 2, 4, 0.05, r.uniform(0.5, 0.9))),
    "g1-stiff": (4, lambda r: robot(r, "g1", 2, 4, 0.1, r.uniform(0.4, 0.9), gain=20.0)),
    "g1-sliding": (4, lambda r: robot(r, "g1", 2, 4, 1.0, r.uniform(0.1, 0.5))),
    "g1-one-foot": (4, lambda r: robot(r, "g1", 1, 4, 0.2, r.uniform(0.4, 0.9))),
}


def stack(rng: np.random.Generator, boxes: int, mu: float, ratio: float, push: float) -> ContactProblem:
    """Return a tower of boxes with four contacts between neighbours; masses rise by `ratio` to the top."""
    scene = Scene()
    for k in range(boxes):
        mass = ratio ** (k / max(boxes - 1, 1))
        body = scene.box(np.array([0, 0, k + 0.5]), np.ones(3), mass, push * _random_push(rng, 1.0))
        for x, y in _face(0.5, 2):
            scene.touch(body, body - 1, np.array([x, y, float(k)]), UP, mu)
    return scene.problem()


def wall(rng: np.random.Generator, rows: int, width: int, mu: float, ratio: float) -> ContactProblem:
    """Return a brick wall, each brick on two below: 8 contacts a brick inside."""
    scene = Scene()
    size = np.array([1.0, 0.5, 0.4])
    grid: dict[tuple[int, int], int] = {}
    for row in range(rows):
        for column in range(width):
            x = column + 0.5 * (row % 2)
            mass = ratio ** rng.random()
            centre = np.array([x, 0.0, 0.4 * row + 0.2])
            body = grid[row, column] = scene.box(centre, size, mass, _random_push(rng, 0.01))
            for side in (-1, 1):
                below = -1
                if row > 0:
                    shift = (0 if side > 0 else -1) if row % 2 == 0 else (1 if side > 0 else 0)
                    key = (row - 1, column + shift)
                    if key not in grid:
                        continue
                    below = grid[key]
                for y in (-0.25, 0.25):
                    near, far = x + side * 0.02, x + side * 0.48
                    for at in (near, far):
                        scene.touch(body, below, np.array([at, y, 0.4 * row]), UP, mu)
    return scene.problem()


def pile(rng: np.random.Generator, bodies: int, contacts: int, mu: float, ratio: float) -> ContactProblem:
    """Return a heap of balls that touch the ground and their nearest neighbours."""
    scene = Scene()
    side = max(2.0, bodies ** (1 / 3))
    centres: list[FloatArray] = []
    for _ in range(bodies):
        centre = rng.uniform(0, side, size=3)
        centres.append(centre)
        scene.sphere(centre, 0.6, ratio ** rng.random(), _random_push(rng, 0.05))
    where = np.array(centres)
    distance = np.linalg.norm(where[:, None] - where[None], axis=2) + 1e9 * np.eye(bodies)
    pairs = sorted((float(distance[i, j]), i, j) for i in range(bodies) for j in range(i))
    floor = np.argsort(where[:, 2])[: max(3, bodies // 5)]
    for k in floor:
        scene.touch(int(k), -1, where[k] - [0, 0, 0.6], UP, mu)
    for _, i, j in pairs[: contacts - len(floor)]:
        high, low = (i, j) if where[i, 2] > where[j, 2] else (j, i)
        normal = where[high] - where[low]
        scene.touch(high, low, 0.5 * (where[high] + where[low]), normal, mu)
    return scene.problem()


def platform(rng: np.random.Generator, points: int, mu: float, push: float) -> ContactProblem:
    """Return one plate on points x points contacts: rank 6, whatever the number of contacts."""
    scene = Scene()
    body = scene.box(np.array([0, 0, 0.1]), np.array([2.0, 2.0, 0.2]), 40.0, push * _random_push(rng, 1.0))
    for x, y in _face(1.0, points):
        scene.touch(body, -1, np.array([x, y, 0.0]), UP, mu)
    return scene.problem()


_LARGE: dict[str, tuple[int, Maker]] = {
    "stack-40": (2, lambda r: stack(r, 10, 0.6, 1.0, 0.05)),
    "stack-200": (2, lambda r: stack(r, 50, 0.5, 1.0, 0.01)),
    "stack-600": (1, lambda r: stack(r, 150, 0.5, 1.0, 0.01)),
    "stack-heavy-top-80": (2, lambda r: stack(r, 20, 0.6, 1e6, 0.01)),
    "stack-heavy-bottom-80": (2, lambda r: stack(r, 20, 0.6, 1e-6, 0.01)),
    "wall-100": (2, lambda r: wall(r, 4, 4, 0.6, 1.0)),
    "wall-500": (2, lambda r: wall(r, 8, 9, 0.6, 1.0)),
    "wall-mixed-250": (2, lambda r: wall(r, 6, 6, 0.6, 1e6)),
    "pile-100": (2, lambda r: pile(r, 30, 100, 0.3, 1.0)),
    "pile-300": (2, lambda r: pile(r, 90, 300, 0.5, 1.0)),
    "pile-600": (2, lambda r: pile(r, 180, 600, 0.4, 1.0)),
    "pile-mixed-300": (2, lambda r: pile(r, 90, 300, 0.5, 1e6)),
    "platform-225": (2, lambda r: platform(r, 15, 0.5, 0.1)),
    "capsules-276": (2, lambda r: capsules(r, 100, 276, r.uniform(0.3, 0.7))),
    "capsules-dense-276": (2, lambda r: capsules(r, 60, 276, r.uniform(0.3, 0.7), push=0.01)),
    "rocks-463": (2, lambda r: rocks(r, 100, 463, r.uniform(0.4, 0.8))),
    "rocks-dense-463": (2, lambda r: rocks(r, 60, 463, r.uniform(0.4, 0.8), push=0.01)),
    "rocks-mixed-463": (2, lambda r: rocks(r, 100, 463, 0.6, 1e3)),
    "cups-240": (2, lambda r: cups(r, 20, 12, r.uniform(0.3, 0.6), 0.02)),
    "cups-dense-240": (2, lambda r: cups(r, 10, 24, r.uniform(0.3, 0.6), 0.01)),
    "masonry-544": (2, lambda r: masonry(r, 4, 5, 4, 0.6)),
}


_SCALES = {"robot": {**_ROBOT, **_MODELS}, "large": _LARGE}


def families(scale: str | None = None) -> tuple[str, ...]:
    """Return the names of the families of a scale ("robot", "large"), or of both."""
    return tuple(name for own, table in _SCALES.items() for name in table if scale in (own, None))


def problem_set(scale: str = "robot", seed: int = 0, copies: float = 1.0) -> list[NamedProblem]:
    """Return the named problems of a scale.

    Parameters
    ----------
    scale
        "robot" (up to 25 contacts) or "large" (40 to 600).
    seed
        Each problem has a random stream of its own, from this seed, its family and its number.
    copies
        Times the usual number of problems in each family (at least one each).

    Raises
    ------
    ProblemError
        If the scale is unknown.

    Examples
    --------
    >>> [p.name for p in problem_set("robot")][:2]
    ['cube-sticking-0', 'cube-sticking-1']
    """
    if scale not in _SCALES:
        raise ProblemError(unknown_name("scale", scale, _SCALES))
    found = []
    for family, (count, maker) in _SCALES[scale].items():
        if family in _MODELS and not _has_models():
            continue
        for k in range(max(1, round(count * copies))):
            stream = np.random.default_rng([seed, k, *family.encode()])
            problem = maker(stream)
            while judge(problem, np.zeros((problem.contacts, 3))) < TRIVIAL:
                problem = maker(stream)
            found.append(NamedProblem(f"{family}-{k}", family, problem))
    return found


def _has_models() -> bool:
    """Tell whether the robot extra is installed."""
    try:
        distribution("example-robot-data")
    except PackageNotFoundError:
        return False
    return find_spec("pinocchio") is not None
