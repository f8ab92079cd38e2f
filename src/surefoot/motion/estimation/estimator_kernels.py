"""A step of the state estimator in three kernels: on to a reading, corrected by the feet, predicted to now.

What they work on lies in a few arrays, since every array that a kernel is given takes time to unwrap: the
memory of `InvariantFilter` (`filter_arrays`), of `InvariantEkf` (`robot_arrays`), of its `FootKinematics` and
of `Latency` (`waiting_arrays`). n is the number of feet throughout.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import borrowed, inline_kernel, kernel, window
from surefoot.base.spatial import GRAVITY
from surefoot.motion.estimation.foot_kinematics import (
    base_state,
    follow_stances,
    foot_arrays,
    measure_places,
    over_ground,
    roll,
    state_ahead,
)
from surefoot.motion.estimation.inekf_kernels import observe_feet, propagate


@kernel
def all_finite(q: FloatArray, v: FloatArray) -> bool:
    """Return whether all numbers of a state (nq,) [m, -, rad] and (nv,) [m/s, rad/s] are finite."""
    total = 0.0
    for x in q:
        total += 0.0 * x
    for x in v:
        total += 0.0 * x
    return total == 0.0  # NaN and infinity times zero are NaN


@kernel
def credible(X: FloatArray, bias: FloatArray, fastest: float, largest: FloatArray) -> bool:
    """Tell whether a filter's state is one that a robot with working sensors has; never for NaN.

    Parameters
    ----------
    X, bias
        (3, 5 + n) and (6,) state of the filter; its fourth column is the velocity [m/s].
    fastest
        Largest speed [m/s].
    largest
        (2,) largest biases of gyro [rad/s] and accelerometer [m/s²], each of its axes.
    """
    speed = math.sqrt(X[0, 3] ** 2 + X[1, 3] ** 2 + X[2, 3] ** 2)
    # Written so that NaN fails: `speed > fastest` would let it pass.
    if not speed <= fastest:
        return False
    for i in range(6):  # noqa: SIM110  # a loop compiles faster than all()
        if not abs(bias[i]) <= largest[i // 3]:
            return False
    return True


STEPS, HELD, IMU, LEGS, SPEEDS = range(5)
"""Of the counts of `Latency`: steps behind, steps for which an IMU reading is held, lengths of its queues."""
QUEUED = 5
"""Where the numbers of readings in these queues begin."""
FADING = 0.05
"""Time in which a landing's shake falls to 37 % [s]: some periods of a leg's own vibration at 20 to 50 Hz."""
BELIEVED, LANDED, CREDIBLE, TOUCHED = 1, 2, 4, 8
"""Bits of what `settle` returns."""


@inline_kernel
def filter_arrays(memory: FloatArray, n: int) -> tuple[FloatArray, ...]:
    """Return the parts of an `InvariantFilter`'s memory.

    They are X (3, 5 + n), bias (6,), covariance (15 + 3n, 15 + 3n), densities (4 + n,), walks (5,), gate
    (1,), distances (n,) and whitened innovations (n, 3).
    """
    N, at = 15 + 3 * n, 3 * (5 + n)
    end = at + 6 + N * N
    return (
        window(memory, 0, 3, 5 + n), window(memory, at, 1, 6)[0], window(memory, at + 6, N, N),
        window(memory, end, 1, 4 + n)[0], window(memory, end + 4 + n, 1, 5)[0],
        window(memory, end + 9 + n, 1, 1)[0], window(memory, end + 10 + n, 1, n)[0],
        window(memory, end + 10 + 2 * n, n, 3),
    )  # fmt: skip


@inline_kernel
def robot_arrays(memory: FloatArray, n: int, joints: int) -> tuple[FloatArray, ...]:
    """Return the parts of an `InvariantEkf`'s memory.

    They are numbers (dt, SETTLING [s], SLIDING [m/s]) above the IMU's arm, the turn rate and the shake with
    two zeros (4, 3), q, v,
    then of the feet rolling radii, speeds over the ground and ages (3, n), normals, rolls and places (n, 3),
    and rotations (n, 3, 3).
    """
    at, end = 12, 25 + 2 * joints
    return (
        window(memory, 0, 4, 3), window(memory, at, 1, 7 + joints)[0],
        window(memory, at + 7 + joints, 1, 6 + joints)[0], window(memory, end, 3, n),
        window(memory, end + 3 * n, n, 3), window(memory, end + 6 * n, n, 3),
        window(memory, end + 9 * n, n, 3), window(memory, end + 12 * n, 3 * n, 3).reshape((n, 3, 3)),
    )  # fmt: skip


@inline_kernel
def waiting_arrays(memory: FloatArray, counts: IntArray, joints: int) -> tuple[FloatArray, ...]:
    """Return the queues of a `Latency`'s memory, oldest first.

    IMU readings, gyro beside accelerometer (_, 6), angles beside speeds of the joints (_, 2 joints), speeds
    at the filter's times (_, joints), and gyros and accelerometers from the filter's time on (steps, 3).
    """
    legs = 6 * counts[IMU]
    speeds = legs + 2 * joints * counts[LEGS]
    ahead = speeds + joints * counts[SPEEDS]
    return (
        window(memory, 0, counts[IMU], 6), window(memory, legs, counts[LEGS], 2 * joints),
        window(memory, speeds, counts[SPEEDS], joints), window(memory, ahead, counts[STEPS], 3),
        window(memory, ahead + 3 * counts[STEPS], counts[STEPS], 3),
    )  # fmt: skip


@inline_kernel
def _room(queue: FloatArray, counts: IntArray, which: int) -> FloatArray:
    """Return the row for a new reading at the end of a queue; the oldest leaves one that is full."""
    at = QUEUED + which - IMU
    # Rows are moved up, and not gone through in a ring: whoever reads has the oldest in the first row.
    if counts[at] == counts[which]:
        for i in range(counts[which] - 1):
            for j in range(queue.shape[1]):
                queue[i, j] = queue[i + 1, j]
    else:
        counts[at] += 1
    row: FloatArray = queue[counts[at] - 1]
    return row


@inline_kernel
def _wait(
    memory: FloatArray, counts: IntArray, gyro: FloatArray, accelerometer: FloatArray, positions: FloatArray,
    speeds: FloatArray,
) -> None:  # fmt: skip
    """Let a reading wait until those that are later have come."""
    joints = positions.shape[0]
    imu, legs, past, gyros, forces = waiting_arrays(memory, counts, joints)
    row = _room(imu, counts, IMU)
    for r in range(3):
        row[r], row[3 + r] = gyro[r], accelerometer[r]
    row = _room(legs, counts, LEGS)
    for j in range(joints):
        row[j], row[joints + j] = positions[j], speeds[j]
    # The window over which joints' accelerations are taken ends at the filter's time: it gets the speeds of
    # the oldest reading that waits, not those that have just come.
    row = _room(past, counts, SPEEDS)
    for j in range(joints):
        row[j] = legs[0, joints + j]
    last = counts[QUEUED] - 1
    for i in range(last + counts[HELD]):  # the last reading is held
        for r in range(3):
            gyros[i, r], forces[i, r] = imu[min(i + 1, last), r], imu[min(i + 1, last), 3 + r]


@kernel
def fade_shake(before: float, accelerometer: FloatArray, dt: float) -> float:
    """Return the shake [m/s²] after a specific force (3,): its excess over gravity, fading in `FADING`."""
    force = math.sqrt(accelerometer[0] ** 2 + accelerometer[1] ** 2 + accelerometer[2] ** 2)
    return max(abs(force - GRAVITY), before * math.exp(-dt / FADING))


@kernel
def advance(
    body: FloatArray, on: BoolArray, robot: FloatArray, waiting: FloatArray, counts: IntArray,
    gyro: FloatArray, accelerometer: FloatArray, positions: FloatArray, speeds: FloatArray, first: bool,
) -> bool:  # fmt: skip
    """Go on to the filter's time after a reading, to the time itself for the `first`; tell if all is finite.

    Parameters
    ----------
    body, on
        Memory of the filter, and which feet (n,) are in its state and were used: (2, n).
    robot, waiting, counts
        Memory of the filter on its robot and of `Latency`; q, v of the robot are those of the filter then.
    gyro, accelerometer, positions, speeds
        See `Reading`.
    """
    n, joints = on.shape[1], positions.shape[0]
    X, bias, P, densities, _, _, _, _ = filter_arrays(body, n)
    numbers, q, v, _, _, _, _, _ = robot_arrays(robot, n, joints)
    _wait(waiting, counts, gyro, accelerometer, positions, speeds)
    imu, legs, _, _, _ = waiting_arrays(waiting, counts, joints)
    if not first:
        # The oldest of each queue is what belongs to the filter's time, see `Latency`.
        propagate(X, bias, P, borrowed(on)[0], imu[0, :3], imu[0, 3:], densities, numbers[0, 0])
        for r in range(3):
            numbers[2, r] = imu[0, r] - bias[r]
        numbers[3, 0] = fade_shake(numbers[3, 0], imu[0, 3:], numbers[0, 0])
    base_state(X, numbers[2], numbers[1], q, v)
    for j in range(joints):
        q[7 + j], v[6 + j] = legs[0, j], legs[0, joints + j]
    return all_finite(q, v)


@kernel
def stand(
    body: FloatArray, on: BoolArray, robot: FloatArray, feet: FloatArray, standing: BoolArray,
    contact: BoolArray, joints: int,
) -> int:  # fmt: skip
    """Correct by the feet that touch; return BELIEVED if one was, with LANDED if one has just come.

    `feet` is the memory of `FootKinematics`; `standing` (2, n) becomes which feet stand, and which of them
    have just landed; `contact` (n,) says which touch. The rest is as in `advance`.
    """
    n = contact.shape[0]
    X, bias, P, densities, walks, gate, distances, innovations = filter_arrays(body, n)
    numbers, _, _, lines, normals, rolled, places, turned = robot_arrays(robot, n, joints)
    centres, velocities, rotations, spreads, _ = foot_arrays(feet, n)
    touching, landed, used = borrowed(standing)[0], borrowed(standing)[1], borrowed(on)[1]
    radii, pace, age = lines[0], lines[1], lines[2]
    dt, settling, sliding = numbers[0, 0], numbers[0, 1], numbers[0, 2]
    # A foot that moves over the ground is no landmark; one that rolls is, with the roll of its centre taken
    # off.
    over_ground(X, numbers[2], numbers[1], centres, velocities, pace)
    new = follow_stances(contact, pace, sliding, settling, dt, age, touching, landed)
    roll(X, rotations, normals, radii, touching, turned, rolled)
    measure_places(X, centres, numbers[1], rolled, places)
    # the turn rate as the gyro says: less a bias that diverges, it would excuse whatever the feet contradict
    rate2 = 0.0
    for r in range(3):
        rate2 += (numbers[2, r] + bias[r]) ** 2
    observe_feet(
        X, bias, P, borrowed(on)[0], places, spreads, touching, landed, walks, densities, gate[0], distances,
        innovations, used,
    )  # fmt: skip
    # Until the next correction a foot wanders by σ² = σ_0² + (a |ω|)² + (b |u|)² + (c s)², with the body's
    # turn rate ω, the foot's speed u over the ground and the shake s.
    for k in range(n):
        densities[4 + k] += walks[2] * rate2 + walks[3] * pace[k] ** 2 + walks[4] * numbers[3, 0] ** 2
    return (BELIEVED if _some(used) else 0) + (LANDED if new else 0)


@inline_kernel
def _some(flags: BoolArray) -> bool:
    """Tell whether one of them is true."""
    some = False
    for k in range(flags.shape[0]):
        some = some or flags[k]
    return some


@kernel
def write_state(
    body: FloatArray, robot: FloatArray, waiting: FloatArray, counts: IntArray, limits: FloatArray, feet: int,
    q: FloatArray, v: FloatArray,
) -> bool:  # fmt: skip
    """Fill q (nq,) [m, rad] and v (nv,) [m/s, rad/s] of now; return whether the filter's state is credible.

    `limits` (4,) are how far joints go on with their acceleration [s], and what `credible` takes: largest
    speed [m/s] and biases [rad/s], [m/s²]. `feet` is their number, the rest is as in `advance`.
    """
    n, joints = feet, v.shape[0] - 6
    X, bias, _, _, _, _, _, _ = filter_arrays(body, n)
    numbers, known_q, known_v, _, _, _, _, _ = robot_arrays(robot, n, joints)
    if counts[STEPS] == 0 or counts[QUEUED] == 0:
        # Nothing waits: the filter's time is now.
        q[:], v[:] = known_q, known_v
        base_state(X, numbers[2], numbers[1], q, v)
    else:
        _, _, past, gyros, forces = waiting_arrays(waiting, counts, joints)
        count, queued = counts[QUEUED] - 1 + counts[HELD], counts[QUEUED + SPEEDS - IMU]
        span = max(queued - 1, 1) * numbers[0, 0]
        state_ahead(
            X, bias, gyros[:count], forces[:count], numbers[0, 0], numbers[1], known_q[7:], known_v[6:],
            past[0], past[queued - 1], span, limits[0], q, v,
        )  # fmt: skip
    return credible(X, bias, limits[1], limits[2:])


@kernel
def settle(
    body: FloatArray, on: BoolArray, robot: FloatArray, feet: FloatArray, standing: BoolArray,
    waiting: FloatArray, counts: IntArray, limits: FloatArray, contact: BoolArray, meant: BoolArray,
    lost: bool, q: FloatArray, v: FloatArray,
) -> int:  # fmt: skip
    """Correct, unless `lost`, by feet in contact that are meant to stand, (n,) each; fill q and v of now.

    Returns what `stand` does, with CREDIBLE if `write_state` says so and TOUCHED if a foot is in contact.
    The rest is as in these two.
    """
    found = TOUCHED if _some(contact) else 0
    if not lost:
        # A touch that is not meant, as of a foot that brushes the ground in its swing, need not stand still,
        # and a foot that is to stand but feels nothing does not.
        both = np.empty(contact.shape[0], np.bool_)
        for k in range(contact.shape[0]):
            both[k] = contact[k] and meant[k]
        found += stand(body, on, robot, feet, standing, both, v.shape[0] - 6)
    return found + (
        CREDIBLE if write_state(body, robot, waiting, counts, limits, contact.shape[0], q, v) else 0
    )
