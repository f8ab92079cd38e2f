"""A step of whole-body control in three compiled calls: where all is, the problem of the forces, the torques.

Every call from Python costs a microsecond, and every array that it is given a tenth of one, as much as most
pieces of `whole_body_kernels` take: what follows one another without a decision in between runs in one, on
one block of memory (`step_memory`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel, window
from surefoot.base.numerics.points import contact_jacobian
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import ContactPoints
from surefoot.motion.control.control_settings import BODY_CONTROL
from surefoot.motion.control.whole_body_kernels import (
    base_tasks,
    contact_rows,
    eliminate,
    feet_motion,
    place_points,
    swing_tasks,
)

# sizes, then where each part begins, in the numbers of a `step_memory`
NV, FEET, POINTS, SUPPORT, FLAT, FRAME, FOOT, PARTS = range(8)
# parts of the memory; constants first: weights (8,), of joints (joints,), feet's middles (n, 3) and radii
# (n,), points' centres (p, 3)
WEIGHTS, JOINTS, MIDDLES, RADII, OFFSETS = range(5)
# state: data.J (6, nv); rotations (n, 3, 3) and places (n, 3) of the feet's frames; centres (n, 3), twists
# and drifts (n, 6) of the feet; rotation of the base (3, 3), and with its place (3, 4); centre of mass, its
# velocity and the base's angular one (3, 3)
TWISTS, ROTATIONS, PLACES, CENTRES, MOVING, DRIFTS, BASE, POSE, BODY = range(5, 14)
# what the last step was given and may give, which an answer is told apart by later: accelerations of the
# centre of mass and of the turn, the mass, the outside force in base axes (10,); stance (n,), accelerations
# of the feet (n, 6) and the joints (joints,), forces (3p,), frames (n, 3, 3); the joints' span (5, joints)
WHOLE, STANDS, MOVES, GAINS, PUSHES, GROUNDS, SPAN = range(14, 21)
# the least ½ aᵀ H a - cᵀ a of the tasks (nv, nv), (nv,) under the constraints E a = e + [w; 0] (r, nv), (r,)
H, C, E, WANTED = range(21, 25)
# accelerations are offset + gain w (nv,), (nv, 6), contact forces f cost ½ ||map f - target||² (6, 3p), (6,),
# and push along the rows (3p, nv)
OFFSET, GAIN, ROOT, TARGET, MAP, ROWS = range(25, 31)
# contacts: normals, arms and touching points of the feet (n, 3), frames (p, 3, 3) and places (p, 3) of points
NORMALS, ARMS, TOUCHING, FRAMES, SPOTS = range(31, 36)
NOTED = PARTS + TWISTS, PARTS + H
"""Where the numbers say that the state and what the step was given begin and end in the memory."""
PINNED_SLACK = 1e-6
"""Share of its range by which a torque or an acceleration exceeds it before it is pinned [-]: rounding is
less."""
SPEEDING, STOPPING = BODY_CONTROL.speeding_rate, BODY_CONTROL.stopping_rate
"""Settings, as compiled code folds them."""
SWING, TURN, RATES = range(2, 5)
"""What the weights are, behind two of the base's tasks: of feet in the air, and four rates as for
`contact_rows`."""


def step_memory(
    nv: int, points: ContactPoints, weights: FloatArray, joints: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return the whole numbers and the memory of a step of whole-body control.

    The numbers are sizes, which velocity components move each foot, which feet are flat, their frames, and
    the foot of each of the p points; all the rest is in the memory, see `part`. It has room for r
    constraints, the most that there can be.

    Parameters
    ----------
    nv
        Velocity components of the robot.
    points
        Its contact points.
    weights, joints
        (8,) see `RATES`; (joints,) of the joints' accelerations.
    """
    n, p, j = len(points.flat), len(points.foot), len(joints)
    most = 6 + int(np.where(points.flat, 6, 3).sum()) + j
    lengths = [
        8, j, 3 * n, n, 3 * p, 6 * nv, 9 * n, 3 * n, 3 * n, 6 * n, 6 * n, 9, 12, 9,
        10, n, 6 * n, j, 3 * p, 9 * n, 5 * j,
        nv * nv, nv, most * nv, most, nv, 6 * nv, 36, 6, 18 * p, 3 * p * nv,
        3 * n, 3 * n, 3 * n, 9 * p, 3 * p,
    ]  # fmt: skip
    starts = np.cumsum([0, *lengths])
    whole = [np.asarray(a).ravel() for a in (points.foot_support, points.flat, points.frames, points.foot)]
    ends = np.cumsum([PARTS + len(starts), *(len(a) for a in whole)])
    numbers = np.concatenate([[nv, n, p], ends[:4], starts, *whole], dtype=np.int64, casting="unsafe")
    memory = np.zeros(starts[-1])
    given = weights, joints, points.middles, points.foot_radii, points.centres
    memory[: starts[len(given)]] = np.concatenate([np.ravel(a) for a in given])
    return numbers, memory


def part(numbers: IntArray, memory: FloatArray, which: int, *shape: int) -> FloatArray:
    """Return a part of a `step_memory`, such as `MAP`: a view (...), any unit; one size may be -1."""
    start, end = numbers[PARTS + which : PARTS + which + 2]
    return memory[start:end].reshape(shape)


@inline_kernel
def _matrix(numbers: IntArray, memory: FloatArray, part: int, rows: int, columns: int) -> FloatArray:
    return window(memory, numbers[PARTS + part], rows, columns)  # type: ignore[no-any-return]


@inline_kernel
def _vector(numbers: IntArray, memory: FloatArray, part: int, length: int) -> FloatArray:
    return window(memory, numbers[PARTS + part], 1, length)[0]  # type: ignore[no-any-return]


@inline_kernel
def _matrices(numbers: IntArray, memory: FloatArray, part: int, count: int) -> FloatArray:
    return window(memory, numbers[PARTS + part], 3 * count, 3).reshape(count, 3, 3)  # type: ignore[no-any-return]


@inline_kernel
def _whole(numbers: IntArray, part: int, rows: int, columns: int) -> Any:  # also truth values
    return window(numbers, numbers[part], rows, columns)


@kernel
def kinematics(
    numbers: IntArray, memory: FloatArray, v: FloatArray, twists: FloatArray, rates: FloatArray,
    rotation: FloatArray, place: FloatArray, com: FloatArray, com_velocity: FloatArray,
    frame_rotations: FloatArray, frame_places: FloatArray,
) -> None:  # fmt: skip
    """Put what `ModelViews` show, and the fields of `Kinematics`, into the memory.

    Parameters
    ----------
    numbers, memory
        Those of a `step_memory`.
    v
        (nv,).
    twists, rates
        (6, nv) each: data.J and data.dJ.
    rotation, place, com, com_velocity
        (3, 3) and (3,) of the base, (3,), (3,).
    frame_rotations, frame_places
        (frames, 3, 3), (frames, 3) of all frames of the model.
    """
    nv, n = numbers[NV], numbers[FEET]
    J, places = _matrix(numbers, memory, TWISTS, 6, nv), _matrix(numbers, memory, PLACES, n, 3)
    rotations, frame = _matrices(numbers, memory, ROTATIONS, n), _whole(numbers, FRAME, 1, n)[0]
    J[:] = twists
    for k in range(n):
        places[k], rotations[k] = frame_places[frame[k]], frame_rotations[frame[k]]
    base, pose = _matrix(numbers, memory, BASE, 3, 3), _matrix(numbers, memory, POSE, 3, 4)
    body = _matrix(numbers, memory, BODY, 3, 3)
    for i in range(3):
        # Pinocchio's free flyer has its velocity in base axes; controllers want the angular one in world
        # axes.
        body[0, i], body[1, i], body[2, i], pose[i, 3] = com[i], com_velocity[i], 0.0, place[i]
        for j in range(3):
            base[i, j] = pose[i, j] = rotation[i, j]
            body[2, i] += rotation[i, j] * v[3 + j]
    support, middles = _whole(numbers, SUPPORT, n, nv), _matrix(numbers, memory, MIDDLES, n, 3)
    feet_motion(
        J, rates, support, v, rotations, places, middles, _matrix(numbers, memory, CENTRES, n, 3),
        _matrix(numbers, memory, MOVING, n, 6), _matrix(numbers, memory, DRIFTS, n, 6),
    )  # fmt: skip


@inline_kernel
def _note(
    numbers: IntArray, memory: FloatArray, mass: float, outside: FloatArray, stance: BoolArray,
    com: FloatArray, turn: FloatArray, feet: FloatArray, joints: FloatArray, frames: FloatArray,
    forces: FloatArray,
) -> None:  # fmt: skip
    """Note what a step is given, see `WHOLE`; arguments as for `force_problem`."""
    nv, n, p = numbers[NV], numbers[FEET], numbers[POINTS]
    whole, stands = _vector(numbers, memory, WHOLE, 10), _vector(numbers, memory, STANDS, n)
    moves, grounds = _matrix(numbers, memory, MOVES, n, 6), _matrices(numbers, memory, GROUNDS, n)
    gains, pushes = _vector(numbers, memory, GAINS, nv - 6), _matrix(numbers, memory, PUSHES, p, 3)
    whole[6] = mass
    for i in range(3):
        whole[i], whole[3 + i], whole[7 + i] = com[i], turn[i], outside[i]
    for k in range(n):
        stands[k] = 1.0 if stance[k] else 0.0
        for i in range(6):
            moves[k, i] = feet[k, i]
        for i in range(3):
            for j in range(3):
                grounds[k, i, j] = frames[k, i, j]
    for j in range(nv - 6):
        gains[j] = joints[j]
    for k in range(p):
        for i in range(3):
            pushes[k, i] = forces[k, i]


@kernel
def force_problem(
    numbers: IntArray, memory: FloatArray, M: FloatArray, bias: FloatArray, mass: float,
    outside: FloatArray, stance: BoolArray, com: FloatArray, turn: FloatArray, feet: FloatArray,
    joints: FloatArray, frames: FloatArray, gaps: FloatArray, forces: FloatArray,
) -> tuple[int, bool]:  # fmt: skip
    """Reduce the step after `kinematics` to forces; return the number of constraints, and success.

    Parameters
    ----------
    numbers, memory
        Those of a `step_memory`.
    M, bias
        (nv, nv), (nv,) mass matrix and bias forces.
    mass, outside
        [kg]; (6,) known wrench on the base, base axes [N, N m].
    stance, com, turn, feet, joints, frames, gaps, forces
        Fields of `Tasks`: (n,), (3,), (3,), (n, 6), (joints,), (n, 3, 3), (n,), (p, 3).
    """
    _note(numbers, memory, mass, outside, stance, com, turn, feet, joints, frames, forces)
    # Tasks: ½ aᵀ H a - cᵀ a, set by the base and the joints, then added to by the feet in the air.
    nv, n, p = numbers[NV], numbers[FEET], numbers[POINTS]
    J, base = _matrix(numbers, memory, TWISTS, 6, nv), _matrix(numbers, memory, BASE, 3, 3)
    support, flat = _whole(numbers, SUPPORT, n, nv), _whole(numbers, FLAT, 1, n)[0]
    foot, weights = _whole(numbers, FOOT, 1, p)[0], _vector(numbers, memory, WEIGHTS, 8)
    centres, drifts = _matrix(numbers, memory, CENTRES, n, 3), _matrix(numbers, memory, DRIFTS, n, 6)
    tasks, costs = _matrix(numbers, memory, H, nv, nv), _vector(numbers, memory, C, nv)
    base_tasks(
        M, bias, base, mass, GRAVITY, com, turn, weights[:2], joints,
        _vector(numbers, memory, JOINTS, nv - 6), tasks, costs,
    )  # fmt: skip
    swing_tasks(J, support, flat, stance, centres, drifts, feet, weights[SWING], weights[TURN], tasks, costs)
    normals, arms = _matrix(numbers, memory, NORMALS, n, 3), _matrix(numbers, memory, ARMS, n, 3)
    point_frames, points = _matrices(numbers, memory, FRAMES, p), _matrix(numbers, memory, SPOTS, p, 3)
    place_points(
        frames, foot, _matrices(numbers, memory, ROTATIONS, n), _matrix(numbers, memory, PLACES, n, 3),
        _matrix(numbers, memory, OFFSETS, p, 3), _vector(numbers, memory, RADII, n), normals, arms,
        point_frames, points,
    )  # fmt: skip
    # Constraints E a = e + [w; 0]: the base's six rows of M a + h = outside + w come first, as `eliminate`
    # wants them, then the contacts; rows of pinned joints are appended later, behind `count`.
    most = numbers[PARTS + OFFSET] - numbers[PARTS + WANTED]
    rows, wanted = _matrix(numbers, memory, E, most, nv), _vector(numbers, memory, WANTED, most)
    rates = weights[RATES], weights[RATES + 1], weights[RATES + 2], weights[RATES + 3]
    count = 6 + contact_rows(
        J, support, flat, stance, centres, _matrix(numbers, memory, MOVING, n, 6), drifts, arms, gaps,
        normals, rates, rows[6:], wanted[6:],
    )  # fmt: skip
    touching = _matrix(numbers, memory, TOUCHING, n, 3)
    wanted[:6], rows[:6] = outside - bias[:6], M[:6]
    for k in range(n):
        for i in range(3):
            touching[k, i] = centres[k, i] + arms[k, i]
    contact_jacobian(J, support, foot, points, point_frames, _matrix(numbers, memory, ROWS, 3 * p, nv))
    return count, reduce(numbers, memory, count)


@kernel
def reduce(numbers: IntArray, memory: FloatArray, count: int) -> bool:
    """Eliminate the accelerations under `count` constraints, see `MAP`; False if that fails.

    Numbers and memory are those of a `step_memory`, (k,) each.
    """
    nv, p = numbers[NV], numbers[POINTS]
    root, target = _matrix(numbers, memory, ROOT, 6, 6), _vector(numbers, memory, TARGET, 6)
    sound = eliminate(
        _matrix(numbers, memory, H, nv, nv), _vector(numbers, memory, C, nv),
        _matrix(numbers, memory, E, count, nv), _vector(numbers, memory, WANTED, count),
        _vector(numbers, memory, OFFSET, nv), _matrix(numbers, memory, GAIN, nv, 6), root, target,
    )  # fmt: skip
    if not sound:
        return False
    # w = G f with G the base's six columns of the contact rows, transposed: the cost in forces is ½ ||rootᵀ G
    # f - target||², which is what `ForceDistributor` takes. rootᵀ is upper triangular.
    out, rows = _matrix(numbers, memory, MAP, 6, 3 * p), _matrix(numbers, memory, ROWS, 3 * p, nv)
    for i in range(6):
        # The factors see H and E alone: a wanted acceleration or a bias that is not finite shows here.
        if not math.isfinite(target[i]):
            return False
        for k in range(3 * p):
            total = 0.0
            for j in range(i, 6):
                total += root[j, i] * rows[k, j]
            out[i, k] = total
    return True


@kernel
def torques_of(
    numbers: IntArray, memory: FloatArray, forces: FloatArray, M: FloatArray, bias: FloatArray,
    span: FloatArray, loose: BoolArray,
) -> tuple[FloatArray, FloatArray, FloatArray, tuple[float, float, float, bool]]:  # fmt: skip
    """Return torques (joints,) and accelerations (nv,) of forces, the command, and what is exceeded.

    The command is that of the motors (joints,): the torques inside their range, and what friction takes.
    Exceeded are the largest distances from the range's middle over its half [-] among the joints that no
    contact loads and among the others, at least zero; the largest excess [N m], of either sign; and whether
    all torques are finite. A joint that no contact loads is infinitely far if its acceleration is.

    Parameters
    ----------
    numbers, memory
        Those of a `step_memory`, after `force_problem`.
    forces
        (p, 3) contact frames [N].
    M, bias
        (nv, nv), (nv,) mass matrix and bias forces.
    span
        (5, joints) what motors give and friction takes, see `torque_range` [N m]; the range of the
        accelerations of joints that no contact loads, see `gain_range` [rad/s²].
    loose
        (joints,) which of them no contact loads.
    """
    nv, p = numbers[NV], numbers[POINTS]
    # Jᵀ f on all joints; its first six numbers are the w that fixes the accelerations.
    rows, gain = _matrix(numbers, memory, ROWS, 3 * p, nv), _matrix(numbers, memory, GAIN, nv, 6)
    offset, ground, a = _vector(numbers, memory, OFFSET, nv), np.zeros(nv), np.empty(nv)
    for k in range(p):
        for i in range(3):
            f = forces[k, i]
            if f != 0.0:
                for j in range(nv):
                    ground[j] += rows[3 * k + i, j] * f
    for j in range(nv):
        total = offset[j]
        for i in range(6):
            total += gain[j, i] * ground[i]
        a[j] = total
    torques, command = np.empty(nv - 6), np.empty(nv - 6)
    middle, half, kept = span[0], span[1], _matrix(numbers, memory, SPAN, 5, nv - 6)
    for i in range(5):
        for j in range(nv - 6):
            kept[i, j] = span[i, j]
    light, heavy, most, finite = 0.0, 0.0, -math.inf, True
    for j in range(nv - 6):
        # the joints' rows of M a + h = S' tau + J' f
        total = bias[6 + j] - ground[6 + j]
        for i in range(nv):
            total += M[6 + j, i] * a[i]
        torques[j] = total
        command[j] = min(max(total, middle[j] - half[j]), middle[j] + half[j]) + span[2, j]
        # The motors' range need not lie about zero: at speed a motor brakes with more torque than it drives.
        size = abs(total - middle[j])
        if not math.isfinite(size):
            finite = False
            continue
        # 0 / 0 of a joint that has no range and needs none is no excess.
        share = size / half[j] if size > 0.0 else 0.0
        if loose[j]:
            # Of joints that no contact loads the torque follows from the acceleration: both limits are pinned
            # alike, so an acceleration out of its range counts as an excess without bound.
            beyond = max(span[3, j] - a[6 + j], a[6 + j] - span[4, j])
            light = max(light, math.inf if beyond > PINNED_SLACK * (span[4, j] - span[3, j]) else share)
        else:
            heavy = max(heavy, share)
        most = max(most, size - half[j])
    return torques, a, command, (light, heavy, most, finite)


@kernel
def gain_range(q: FloatArray, v: FloatArray, stops: FloatArray, fastest: FloatArray, out: FloatArray) -> None:
    """Fill the accelerations with which joints neither pass their speed limits nor run into their stops.

    What is left to a speed limit, or to the speed that a joint may have so near to its stop, is taken up at
    the rate `SPEEDING`: least and largest [rad/s²], the last two rows of `out` (5, joints).

    Parameters
    ----------
    q, v
        (joints,) each [rad], [rad/s].
    stops, fastest
        (2, joints) least and largest positions [rad]; (joints,) speed limits [rad/s].
    """
    for j in range(len(v)):
        # v <= STOPPING (stop - q) is first-order decay onto the stop, which never passes it; v̇ <= SPEEDING
        # (limit - v) is the same for the speed. Both together are overdamped, as SPEEDING is more than four
        # times STOPPING: no overshoot.
        out[3, j] = SPEEDING * (max(STOPPING * (stops[0, j] - q[j]), -fastest[j]) - v[j])
        out[4, j] = SPEEDING * (min(STOPPING * (stops[1, j] - q[j]), fastest[j]) - v[j])
