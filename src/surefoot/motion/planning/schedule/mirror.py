"""Problems that ask of the left what they ask of the right: half the variables and rows do.

A motion that is its own mirror image is z = E s with half the numbers, and rows are asked for in the mean
with their images. The sides of a robot differ a little (Go2's by 0.2 % of the base's inertia, A1's by 8 mm
of the base's centre of mass), so that what is found is no motion of the robot: with its multipliers it is
where the search for one begins. Which row is whose image is looked up at random places.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ModelError, ProblemError
from surefoot.base.libraries import import_casadi
from surefoot.mechanics import Robot, mirrored_joints, quadruped_order
from surefoot.motion.planning.schedule.schedule_problem import ScheduleProblem
from surefoot.motion.planning.transcription.nlp import Block, Iterate, Nlp, OnIteration, Sides, pack, unpack

PLACES = 3
"""Random places at which rows are compared."""
ALIKE = 0.05
"""How far left and right may differ: states and bounds [m, rad, m/s], and rows, as a share of their size."""
ACROSS = np.diag([1.0, -1.0, 1.0])
"""The image of a vector in the plane y = 0; of a rotation it is the opposite."""


def reflection(image: IntArray, sign: FloatArray) -> FloatArray:
    """Return the matrix (n, n) that puts n numbers where their (n,) images stand, with (n,) signs."""
    return np.asarray(sign[:, None] * np.eye(len(image))[image])


def robot_reflections(robot: Robot) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return those (n, n) of q, of v, and of the inputs of a knot: torques, and forces in contact axes.

    Raises
    ------
    ModelError, ProblemError
        For a robot without a mirror image, or without one contact point on each of four feet.
    """
    order, joints = np.array(quadruped_order(robot)), reflection(*mirrored_joints(robot))
    if len(robot.contact_points) != len(order):
        raise ProblemError(f"no images are known of feet of several points, {robot.name} has such")
    feet = np.empty_like(order)
    feet[order] = order[[1, 0, 3, 2]]
    forces = np.kron(reflection(feet, np.ones(len(feet))), ACROSS)
    place, speed = (block_diag(ACROSS, -ACROSS, *scalar, joints) for scalar in ([np.eye(1)], []))
    return place, speed, block_diag(joints, forces)


def own_image(robot: Robot, reference: FloatArray) -> bool:
    """Return whether a robot has a mirror image, and (T, nq) configurations are their own."""
    try:
        place = robot_reflections(robot)[0]
    except (ModelError, ProblemError):
        return False
    return bool(np.abs(reference @ place.T - reference).max() <= ALIKE)


def spread(mirror: FloatArray) -> FloatArray:
    """Return E (n, k) of a reflection (n, n): it takes k numbers to all n of what is its own image.

    One of each pair and its image; numbers whose images are their opposites are zero.
    """
    own, image = np.arange(len(mirror)), np.abs(mirror).argmax(axis=1)
    # One number of each pair stands for both; what is its own image with the opposite sign (y, roll, yaw) is
    # zero.
    kept = (own < image) | ((own == image) & (mirror[own, image] > 0.0))
    return np.asarray(np.clip(np.eye(len(mirror)) + mirror, -1.0, 1.0)[:, kept])


def share_columns(E: FloatArray) -> FloatArray:
    """Return E (n, k) with columns that sum to one, signs apart: the mean of images, multipliers shared."""
    return np.asarray(E / np.abs(E).sum(axis=0))


def fold_bounds(E: FloatArray, low: FloatArray, high: FloatArray) -> Sides:
    """Return the bounds (..., k) that keep numbers and their images within (..., n).

    Raises
    ------
    ProblemError
        Where they leave nothing.
    """
    zero = ~E.any(axis=1)
    low, high = low[..., None], high[..., None]
    least = np.where(E > 0.0, low, np.where(E < 0.0, -high, -np.inf)).max(axis=-2)
    most = np.where(E > 0.0, high, np.where(E < 0.0, -low, np.inf)).min(axis=-2)
    if (
        (least > most + ALIKE).any()
        or (low[..., zero, :] > ALIKE).any()
        or (high[..., zero, :] < -ALIKE).any()
    ):
        raise ProblemError("left and right of the bounds differ")
    crossed = np.nonzero(least > most)
    least[crossed] = most[crossed] = 0.5 * (least[crossed] + most[crossed])
    return least, most


def row_reflection(block: Block, *mirrors: FloatArray) -> FloatArray:
    """Return the reflection (m, m) of a block's rows by those (n, n) of its x, u, after and data.

    Raises
    ------
    ProblemError
        Where a row has no image.
    """
    chance = np.random.default_rng(0)
    value = import_casadi().Function("rows", [block.x, block.u, block.after, block.data], [block.rows])
    places = [[chance.uniform(-1.0, 1.0, len(one)) for one in mirrors] for _ in range(PLACES)]
    images = [[one @ part for one, part in zip(mirrors, at, strict=True)] for at in places]
    here, far = (np.array([np.array(value(*at)).ravel() for at in side]) for side in (places, images))
    # Row i at a mirrored place against row j, or its opposite, at the place itself.
    apart = np.array([np.abs(far[:, None] - s * here[:, :, None]).max(axis=0) for s in (1.0, -1.0)])
    image, turned = apart.min(axis=0).argmin(axis=1), apart.min(axis=2).argmin(axis=0)
    own = np.arange(len(image))
    alike = apart[turned, own, image] <= ALIKE * np.abs(here).max(axis=0)
    if not alike.all() or (image[image] != own).any():
        raise ProblemError("left and right of the equations differ")
    return reflection(image, 1.0 - 2.0 * turned)


def folded_block(block: Block, E: FloatArray, of_inputs: FloatArray, of_rows: FloatArray) -> Block:
    """Return a block of motions that are their own images by (n, k) each, with (m, r) rows in the mean."""
    ca = import_casadi()
    maps = E, of_inputs, E
    x, u, after = (ca.SX.sym("s", one.shape[1]) for one in maps)
    whole = [ca.mtimes(ca.sparsify(ca.DM(M)), s) for M, s in zip(maps, (x, u, after), strict=True)]
    value = ca.Function("value", [block.x, block.u, block.after, block.data], [block.cost, block.rows])
    cost, rows = value(*whole, block.data)
    means = ca.mtimes(ca.sparsify(ca.DM(share_columns(of_rows).T)), rows)
    return Block(x, u, after, block.parameter, means, cost, block.data)


def found_in_half(
    problem: ScheduleProblem, block: Block, rows: Sides, bounds: Sides, begin: FloatArray,
    tell: OnIteration | None, **options: Any,
) -> Iterate | None:  # fmt: skip
    """Return the motion that is its own image that Ipopt makes of variables (V,) to begin with.

    Variables, and multipliers of bounds and of all rows of all knots, are those of the whole program; None
    where left and right of the problem differ.
    """
    if not own_image(problem.robot, problem.reference):
        return None
    knots, nx = problem.knots, int(block.x.shape[0])
    place, speed, inputs = robot_reflections(problem.robot)
    try:
        state = block_diag(place, speed)
        parts = spread(state), spread(inputs)
        of_rows = spread(row_reflection(block, state, inputs, state, place))
        low, high = fold_bounds(of_rows, *rows)
        sides = zip(*(unpack(side, nx, knots) for side in bounds), strict=True)
        least, most = zip(*(fold_bounds(E, *side) for E, side in zip(parts, sides, strict=True)), strict=True)
    except ProblemError:
        return None

    def each(maps: Sequence[FloatArray], packed: FloatArray) -> FloatArray:
        """Return packed states and inputs taken through a matrix each."""
        pair = unpack(packed, maps[0].shape[1], knots)
        return pack(*(part @ M.T for M, part in zip(maps, pair, strict=True)))

    kept = np.flatnonzero((np.isfinite(low) | np.isfinite(high)).ravel())
    found = Nlp(folded_block(block, *parts, of_rows), knots, kept).solve(
        each([share_columns(E).T for E in parts], begin), problem.reference[1:], (pack(*least), pack(*most)),
        (low, high), tell=tell, **options,
    )  # fmt: skip
    pushes = np.zeros(low.shape)
    np.put(pushes, kept, found.multipliers[1])
    of_bounds = each([share_columns(E) for E in parts], found.multipliers[0])
    of_rows = (pushes @ share_columns(of_rows).T).ravel()
    return replace(found, variables=each(parts, found.variables), multipliers=(of_bounds, of_rows))
