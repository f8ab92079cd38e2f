"""Heaps and nested bodies with many contacts per pair of bodies: sparse, redundant problems of any size.

Bodies are capsules or rocks (clumps of overlapping balls), dropped and pushed out of each other until they
rest in a mound on open ground. Every free velocity is that of bodies (no gap terms) and no wall closes the
scene, so there is a motion of the bodies that opens all contacts strictly within the dual cones: the problem
has a solution, and it is not a borderline one (`tests/benchmarks/test_heaps.py` asks a cone solver).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.problems.rigid_bodies import Scene
from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact.problem import ContactProblem

UP = np.array([0.0, 0.0, 1.0])
ROUNDS = 120
"""Steps of the settling; each pushes overlapping balls apart once."""


@dataclass
class _Clumps:
    """Rigid clumps of balls: centres and rotations of the bodies, and the balls in body axes."""

    centre: FloatArray  # (bodies, 3)
    rotation: FloatArray  # (bodies, 3, 3)
    ball: FloatArray  # (balls, 3), in the axes of its body
    radius: FloatArray  # (balls,)
    body: IntArray  # (balls,)

    def places(self) -> FloatArray:
        """Return the balls' centres in the world: (balls, 3)."""
        turned = np.einsum("bij,bj->bi", self.rotation[self.body], self.ball)
        return np.asarray(self.centre[self.body] + turned)


def random_rotation(rng: np.random.Generator) -> FloatArray:
    """Return a rotation drawn uniformly: (3, 3)."""
    q = rng.normal(size=4)
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def _small_turns(vectors: FloatArray) -> FloatArray:
    """Return the rotations of small rotation vectors, by Rodrigues' formula: (n, 3, 3)."""
    angle = np.linalg.norm(vectors, axis=1)
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    S = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    first = np.sinc(angle / np.pi)[:, None, None]
    second = 0.5 * np.sinc(0.5 * angle / np.pi)[:, None, None] ** 2
    return np.asarray(np.eye(3) + first * S + second * (S @ S))


def _settle(heap: _Clumps, size: float) -> None:
    """Let clumps sink and draw together, and push the overlapping ones apart, in place."""
    bodies = heap.centre.shape[0]
    for k in range(ROUNDS):
        sink = 0.15 * size * (1.0 - k / ROUNDS)
        heap.centre -= sink * UP
        heap.centre[:, :2] *= 1.0 - 0.2 * sink / size / 6.0
        for _ in range(3):
            at = heap.places()
            pairs = cKDTree(at).query_pairs(2.0 * float(heap.radius.max()), output_type="ndarray")
            a, b = pairs[heap.body[pairs[:, 0]] != heap.body[pairs[:, 1]]].T
            apart = at[a] - at[b]
            length = np.maximum(np.linalg.norm(apart, axis=1), 1e-9)
            deep = heap.radius[a] + heap.radius[b] - length
            hit = deep > 0.0
            push = 0.5 * (deep / length)[hit, None] * apart[hit]
            down = heap.radius - at[:, 2]
            low = np.flatnonzero(down > 0.0)
            balls = np.concatenate([a[hit], b[hit], low])
            moves = np.concatenate([push, -push, down[low, None] * UP])
            _move(heap, at, balls, moves, bodies, size)


def _move(
    heap: _Clumps, at: FloatArray, balls: IntArray, moves: FloatArray, bodies: int, size: float
) -> None:
    """Move bodies by the mean of what is asked of their balls, and turn them likewise."""
    body = heap.body[balls]
    count = np.maximum(np.bincount(body, minlength=bodies), 1)[:, None]
    shift, turn = np.zeros((bodies, 3)), np.zeros((bodies, 3))
    np.add.at(shift, body, moves)
    np.add.at(turn, body, np.cross(at[balls] - heap.centre[body], moves) / size**2)
    heap.centre += 1.2 * shift / count
    heap.rotation = _small_turns(np.clip(turn / count, -0.2, 0.2)) @ heap.rotation


def _dropped(rng: np.random.Generator, bodies: int, size: float) -> tuple[FloatArray, FloatArray]:
    """Return places in a tall loose column, and rotations."""
    side = size * max(bodies / 6.0, 1.0) ** (1.0 / 3.0)
    centre = rng.uniform(-side, side, size=(bodies, 3))
    centre[:, 2] = 1.5 * size + 2.0 * (centre[:, 2] + side)
    return centre, np.array([random_rotation(rng) for _ in range(bodies)])


def _twist(rng: np.random.Generator, push: float) -> FloatArray:
    """Return a twist with a horizontal and a turning part."""
    return push * np.concatenate([rng.normal(size=3) * [1, 1, 0.2], rng.normal(size=3)])


def rocks(
    rng: np.random.Generator, bodies: int, contacts: int, mu: float, ratio: float = 1.0, push: float = 0.05
) -> ContactProblem:
    """Return a mound of rocks: clumps of six balls, which touch in several places at once.

    Parameters
    ----------
    rng
        Where everything random comes from.
    bodies, contacts
        How many rocks, and at most how many of their closest contacts are kept.
    mu
        Friction coefficient.
    ratio
        Densities are spread over this factor.
    push
        Speed of the rocks before the step [m/s], [rad/s].
    """
    size, per = 0.3, 6
    centre, rotation = _dropped(rng, bodies, size)
    ball = rng.normal(size=(bodies, per, 3))
    ball *= (size * rng.uniform(0.35, 0.6, size=(bodies, per)) / np.linalg.norm(ball, axis=2))[:, :, None]
    radius = size * rng.uniform(0.45, 0.65, size=(bodies, per))
    weight = radius**3
    ball -= (np.einsum("bp,bpi->bi", weight, ball) / weight.sum(axis=1)[:, None])[:, None]
    heap = _Clumps(centre, rotation, ball.reshape(-1, 3), radius.ravel(), np.repeat(np.arange(bodies), per))
    _settle(heap, size)
    scene = Scene()
    for k in range(bodies):
        masses = 2000.0 * ratio ** rng.random() * 4.0 / 3.0 * np.pi * weight[k]
        square = 0.4 * radius[k] ** 2 + np.sum(ball[k] ** 2, axis=1)
        inertia = (masses @ square) * np.eye(3) - np.einsum("p,pi,pj->ij", masses, ball[k], ball[k])
        R = heap.rotation[k]
        scene.body(heap.centre[k], float(masses.sum()), R @ inertia @ R.T, _twist(rng, push))
    at = heap.places()
    pairs = cKDTree(at).query_pairs(2.4 * float(radius.max()), output_type="ndarray")
    a, b = pairs[heap.body[pairs[:, 0]] != heap.body[pairs[:, 1]]].T
    apart = at[a] - at[b]
    gap = np.linalg.norm(apart, axis=1) - heap.radius[a] - heap.radius[b]
    point = at[b] + apart * (heap.radius[b] / (heap.radius[a] + heap.radius[b]))[:, None]
    floor = np.arange(at.shape[0])
    _touch_closest(
        scene,
        np.concatenate([gap, at[:, 2] - heap.radius]),
        np.concatenate([heap.body[a], heap.body[floor]]),
        np.concatenate([heap.body[b], np.full(floor.size, -1)]),
        np.concatenate([point, at * [1.0, 1.0, 0.0]]),
        np.concatenate([apart, np.tile(UP, (floor.size, 1))]),
        contacts, mu,
    )  # fmt: skip
    return scene.problem()


def _touch_closest(
    scene: Scene, gap: FloatArray, body: IntArray, other: IntArray, point: FloatArray, normal: FloatArray,
    contacts: int, mu: float,
) -> None:  # fmt: skip
    """Add the contacts of the smallest gaps."""
    for k in np.argsort(gap, kind="stable")[:contacts]:
        scene.touch(int(body[k]), int(other[k]), point[k], normal[k], mu)


def capsules(
    rng: np.random.Generator, bodies: int, contacts: int, mu: float, ratio: float = 1.0, push: float = 0.05
) -> ContactProblem:
    """Return a mound of capsules; those that lie along each other touch in up to three places.

    The arguments are those of `rocks`.
    """
    radius, per = 0.05, 7
    half = radius * rng.uniform(1.5, 4.0, size=bodies)
    centre, rotation = _dropped(rng, bodies, 3.0 * radius)
    along = np.linspace(-1.0, 1.0, per)
    ball = np.zeros((bodies, per, 3))
    ball[:, :, 2] = half[:, None] * along
    count = bodies * per
    heap = _Clumps(
        centre, rotation, ball.reshape(-1, 3), np.full(count, radius), np.repeat(np.arange(bodies), per)
    )
    _settle(heap, 3.0 * radius)
    scene = Scene()
    for k in range(bodies):
        mass, inertia = _capsule(radius, half[k], 1000.0 * ratio ** rng.random())
        R = heap.rotation[k]
        scene.body(heap.centre[k], mass, R @ inertia @ R.T, _twist(rng, push))
    axis = half[:, None] * heap.rotation[:, :, 2]
    gaps, who, with_whom, points, normals = [], [], [], [], []
    near = cKDTree(heap.centre).query_pairs(2.0 * float(half.max()) + 2.4 * radius, output_type="ndarray")
    for i, j in np.sort(near, axis=1)[np.lexsort((near.max(axis=1), near.min(axis=1)))]:
        for p, q in _segment_contacts(heap.centre[i], axis[i], heap.centre[j], axis[j], radius):
            gaps.append(float(np.linalg.norm(p - q)) - 2.0 * radius)
            who.append(i)
            with_whom.append(j)
            points.append(0.5 * (p + q))
            normals.append(p - q)
    for end in (-1.0, 1.0):
        tip = heap.centre + end * axis
        gaps += list(tip[:, 2] - radius)
        who += range(bodies)
        with_whom += [-1] * bodies
        points += list(tip * [1.0, 1.0, 0.0])
        normals += [UP] * bodies
    _touch_closest(
        scene, np.array(gaps), np.array(who), np.array(with_whom), np.array(points), np.array(normals),
        contacts, mu,
    )  # fmt: skip
    return scene.problem()


def _capsule(radius: float, half: float, density: float) -> tuple[float, FloatArray]:
    """Return mass and inertia of a capsule along z whose axis is 2 half long."""
    rod, caps = density * np.pi * radius**2 * 2.0 * half, density * 4.0 / 3.0 * np.pi * radius**3
    round_ = 0.5 * rod * radius**2 + 0.4 * caps * radius**2
    across = rod * (0.25 * radius**2 + half**2 / 3.0)
    across += caps * (0.4 * radius**2 + half**2 + 0.75 * half * radius)
    return float(rod + caps), np.diag([across, across, round_])


def _segment_contacts(
    c: FloatArray, a: FloatArray, d: FloatArray, b: FloatArray, radius: float
) -> list[tuple[FloatArray, FloatArray]]:
    """Return up to three pairs of near points of two segments (centre and half length along each)."""
    aa, bb, ab, r = float(a @ a), float(b @ b), float(a @ b), c - d
    found = []
    for s in (-1.0, 1.0):  # the ends of each, against the nearest point of the other
        t = float(np.clip(b @ (r + s * a) / bb, -1.0, 1.0))
        found.append((c + s * a, d + t * b))
        t = float(np.clip(a @ (s * b - r) / aa, -1.0, 1.0))
        found.append((c + t * a, d + s * b))
    det = aa * bb - ab * ab
    if det > 1e-3 * aa * bb:
        s = float(ab * (b @ r) - bb * (a @ r)) / det
        t = float(aa * (b @ r) - ab * (a @ r)) / det
        if abs(s) < 1.0 and abs(t) < 1.0:
            found.append((c + s * a, d + t * b))
    found.sort(key=lambda pair: float(np.linalg.norm(pair[0] - pair[1])))
    kept: list[tuple[FloatArray, FloatArray]] = []
    for p, q in found:
        close = np.linalg.norm(p - q) < 2.3 * radius
        fresh = all(np.linalg.norm(p + q - x - y) > radius for x, y in kept)
        if close and fresh and len(kept) < 3:
            kept.append((p, q))
    return kept


def cups(rng: np.random.Generator, bodies: int, around: int, mu: float, push: float) -> ContactProblem:
    """Return a stack of nested cups, each resting in the one below on a conical ring of contacts.

    Two neighbours have `around` contacts with as many normals: rank 6 of 3 `around`.
    """
    scene = Scene()
    steep = np.arctan(0.8 / max(mu, 0.2))  # a cup can be lifted out: tan(steep) < 1 / mu
    for k in range(bodies):
        mass = 0.3
        inertia = np.diag([8e-4, 8e-4, 6e-4])
        scene.body(np.array([0.0, 0.0, 0.05 * k]), mass, inertia, _twist(rng, push))
        for spot in range(around):
            turn = 2.0 * np.pi * (spot + 0.2 * rng.random()) / around
            out = np.array([np.cos(turn), np.sin(turn), 0.0])
            height = 0.05 * k - 0.03 + 0.02 * (spot % 3)
            normal = -np.sin(steep) * out + np.cos(steep) * UP
            scene.touch(k, k - 1, 0.05 * out + height * UP, normal, mu)
    return scene.problem()


def masonry(rng: np.random.Generator, rows: int, width: int, points: int, mu: float) -> ContactProblem:
    """Return a brick wall with points x points contacts on every shared face: rank 6 for each pair."""
    scene = Scene()
    size = np.array([1.0, 0.5, 0.4])
    spread = np.linspace(-0.22, 0.22, points)
    bricks: dict[tuple[int, int], int] = {}
    for row in range(rows):
        for column in range(width - row % 2):
            x, height = column + 0.5 * (row % 2), 0.4 * row
            mass = rng.uniform(0.5, 2.0)
            body = scene.box(np.array([x, 0.0, height + 0.2]), size, mass, _twist(rng, 0.01))
            bricks[row, column] = body
            for side in (0, 1):
                below = bricks.get((row - 1, column + side - (row % 2 == 0)), -1)
                if row > 0 and below < 0:
                    continue
                middle = x + 0.25 * (2 * side - 1)
                for along in spread:
                    for across in spread:
                        scene.touch(body, below, np.array([middle + along, across, height]), UP, mu)
    return scene.problem()
