"""Ways to spoil a motion that was executed, each with the frames that it touches."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.records.motions.motion import Motion

TOUCHES = 0.02
"""Height by which a levitating frame is lifted at least: below that feet may touch, and push off [m]."""
Spoilt = tuple[FloatArray, BoolArray]
"""Configurations (T, nq) and the frames (T,) that were touched."""


@dataclass(frozen=True)
class Corruption:
    """A way to spoil a motion.

    Attributes
    ----------
    name
        What is done.
    spoil
        The motion and a random generator to configurations and touched frames.
    causes
        Causes that a report may name for it.
    frames, clips
        Least area under the curve that is expected, by frames and by clips; None where it is not looked at.
    """

    name: str
    spoil: Callable[[Motion, np.random.Generator], Spoilt]
    causes: tuple[str, ...] = ()
    frames: float | None = None
    clips: float | None = None


def _turned(q: FloatArray, turns: FloatArray, about: FloatArray) -> FloatArray:
    """Return configurations turned by (T, 3, 3) rotations of the world about (T, 3) places."""
    from scipy.spatial.transform import Rotation

    out = q.copy()
    out[:, :3] = about + np.einsum("kij,kj->ki", turns, q[:, :3] - about)
    out[:, 3:7] = (Rotation.from_matrix(turns) * Rotation.from_quat(q[:, 3:7])).as_quat()
    return out


def _all(motion: Motion) -> BoolArray:
    return np.ones(len(motion), dtype=np.bool_)


def float_by(height: float) -> Callable[[Motion, np.random.Generator], Spoilt]:
    """Return the corruption that lifts (or sinks) the whole motion [m]."""

    def spoil(motion: Motion, rng: np.random.Generator) -> Spoilt:
        q = motion.q.copy()
        q[:, 2] += height
        return q, _all(motion)

    return spoil


def levitate(
    height: float, time: float = 0.6, ramp: float = 0.05
) -> Callable[[Motion, np.random.Generator], Spoilt]:
    """Return the corruption that lifts the motion for a while [m, s], up and down in `ramp` each."""

    def spoil(motion: Motion, rng: np.random.Generator) -> Spoilt:
        q, t = motion.q.copy(), np.arange(len(motion)) / motion.rate
        lift = np.zeros(len(motion))
        for start in np.arange(0.4 + 0.3 * rng.random(), motion.duration - time - 0.2, 2.0):
            inside = np.minimum(t - start, start + time - t) / ramp
            share = np.clip(inside, 0.0, 1.0)
            lift += height * share * share * (3.0 - 2.0 * share)
        q[:, 2] += lift
        return q, lift > TOUCHES

    return spoil


def glide(speed: float) -> Callable[[Motion, np.random.Generator], Spoilt]:
    """Return the corruption that lets the whole motion drift along the ground [m/s]."""

    def spoil(motion: Motion, rng: np.random.Generator) -> Spoilt:
        q, t, angle = motion.q.copy(), np.arange(len(motion)) / motion.rate, 2.0 * np.pi * rng.random()
        q[:, :2] += speed * t[:, None] * [np.cos(angle), np.sin(angle)]
        return q, _all(motion)

    return spoil


def lean(degrees: float) -> Callable[[Motion, np.random.Generator], Spoilt]:
    """Return the corruption that tilts the whole robot about its lower foot [deg]."""

    def spoil(motion: Motion, rng: np.random.Generator) -> Spoilt:
        from scipy.spatial.transform import Rotation

        angle = 2.0 * np.pi * rng.random()
        turn = Rotation.from_rotvec(np.radians(degrees) * np.array([np.cos(angle), np.sin(angle), 0.0]))
        about = np.array([_lowest(motion, q) for q in motion.q])
        out = _turned(motion.q, np.tile(turn.as_matrix(), (len(motion), 1, 1)), about)
        low = np.array([_lowest(motion, q)[2] for q in out])
        out[:, 2] += about[:, 2] - low
        return out, _all(motion)

    return spoil


def _lowest(motion: Motion, q: FloatArray) -> FloatArray:
    """Return the centre of the lower foot at its lowest point (3,) [m]."""
    robot = motion.robot
    places = robot.foot_positions(q)
    centres = robot.sphere_bottoms(q)
    foot = np.asarray(robot.contact_points.foot)
    lows = [np.min(np.asarray(centres)[foot == k]) for k in range(len(robot.feet))]
    k = int(np.argmin(lows))
    return np.array([*places[k][:2], lows[k]])


def arms(amplitude: float = 1.0, rate: float = 3.0) -> Callable[[Motion, np.random.Generator], Spoilt]:
    """Return the corruption that swings both arms fast [rad, Hz]."""

    def spoil(motion: Motion, rng: np.random.Generator) -> Spoilt:
        q, t = motion.q.copy(), np.arange(len(motion)) / motion.rate
        for name in ("left_shoulder_pitch_joint", "right_shoulder_pitch_joint"):
            q[:, 7 + motion.robot.joint_names.index(name)] += amplitude * np.sin(2.0 * np.pi * rate * t)
        return q, _all(motion)

    return spoil


def spin(rate: float = 2.0) -> Callable[[Motion, np.random.Generator], Spoilt]:
    """Return the corruption that turns the whole body about its own vertical [rad/s]."""

    def spoil(motion: Motion, rng: np.random.Generator) -> Spoilt:
        from scipy.spatial.transform import Rotation

        t = np.arange(len(motion)) / motion.rate
        turns = Rotation.from_rotvec(np.outer(rate * t, [0.0, 0.0, 1.0])).as_matrix()
        return _turned(motion.q, turns, motion.q[:, :3]), _all(motion)

    return spoil


def joint_order(motion: Motion, rng: np.random.Generator) -> Spoilt:
    """Return the motion with its joints taken for breadth-first ones."""
    model = motion.robot.model
    depth = np.array([len(model.supports[j + 2]) for j in range(motion.robot.joints)])
    order = np.argsort(depth, kind="stable")
    q = motion.q.copy()
    q[:, 7:][:, order] = motion.q[:, 7:]
    return q, _all(motion)


def jitter(deviation: float) -> Callable[[Motion, np.random.Generator], Spoilt]:
    """Return the corruption that shakes the root [m]."""

    def spoil(motion: Motion, rng: np.random.Generator) -> Spoilt:
        q = motion.q.copy()
        q[:, :3] += rng.normal(0.0, deviation, (len(motion), 3))
        return q, _all(motion)

    return spoil


def jump_root(motion: Motion, rng: np.random.Generator) -> Spoilt:
    """Return the motion with three jumps of its root by 5 cm."""
    q, touched = motion.q.copy(), np.zeros(len(motion), dtype=np.bool_)
    for k in rng.choice(np.arange(4, len(motion) - 4), 3, replace=False):
        q[k:, :2] += 0.05 * np.array([np.cos(k), np.sin(k)])
        touched[k - 2 : k + 2] = True
    return q, touched


def paced(motion: Motion, factor: float) -> Motion:
    """Return the motion played faster, at its own rate."""
    return resampled(replace(motion, rate=motion.rate * factor), motion.rate)


def warped(motion: Motion, rng: np.random.Generator, depth: float = 0.6, rate: float = 1.0) -> Motion:
    """Return the motion with its time running faster and slower by turns [-, Hz]."""
    t = np.arange(len(motion)) / motion.rate
    wave = depth / (2.0 * np.pi * rate) * np.sin(2.0 * np.pi * rate * t + 2.0 * np.pi * rng.random())
    return replace(motion, q=_at(motion, np.clip((t + wave) * motion.rate, 0.0, len(motion) - 1.0)))


def resampled(motion: Motion, rate: float) -> Motion:
    """Return the motion at another rate [Hz], between its frames by constant velocities."""
    places = np.arange(0.0, motion.duration + 1e-9, 1.0 / rate) * motion.rate
    return replace(motion, q=_at(motion, places), rate=rate, torques=None)


def _at(motion: Motion, places: FloatArray) -> FloatArray:
    """Return the configurations at places between frames."""
    import pinocchio

    first = np.clip(places.astype(int), 0, max(len(motion) - 2, 0))
    model, q = motion.robot.model, motion.q
    return np.array(
        [
            pinocchio.interpolate(model, q[k], q[min(k + 1, len(q) - 1)], float(p - k))
            for k, p in zip(first, places, strict=True)
        ]
    )


CORRUPTIONS = (
    Corruption("floating 3 cm", float_by(0.03), ("hangs",), 0.98, 0.98),
    Corruption("floating 5 cm", float_by(0.05), ("hangs",), 0.98, 0.98),
    Corruption("levitating 8 cm", levitate(0.08), ("hangs", "dynamics in flight"), 0.95, 0.98),
    Corruption("levitating 15 cm", levitate(0.15), ("hangs", "dynamics in flight"), 0.95, 0.98),
    Corruption("gliding 20 cm/s", glide(0.2), ("slides",), 0.90, 0.98),
    Corruption("gliding 50 cm/s", glide(0.5), ("slides",), 0.97, 0.98),
    Corruption("leaning 10 deg", lean(10.0), ("tips over the sole", "torque of a joint"), 0.95, 0.98),
    Corruption("leaning 20 deg", lean(20.0), ("tips over the sole", "torque of a joint"), 0.98, 0.98),
    Corruption("leaning 30 deg", lean(30.0), ("tips over the sole", "torque of a joint"), 0.98, 0.98),
    Corruption("arms at 3 Hz", arms(), ("tips over the sole", "friction", "torque of a joint"), 0.95, 0.98),
    Corruption("turning body", spin(), ("slides", "friction"), 0.97, 0.98),
    Corruption("joint order", joint_order, (), 0.96, 0.98),
)
"""Those that a certificate shall find, by frames and by clips."""


def spoil_each(motions: Sequence[Motion]) -> Iterator[tuple[Corruption, Motion, BoolArray]]:
    """Yield every corruption, each motion spoilt by it, and the frames (T,) that it touched."""
    for corruption in CORRUPTIONS:
        rng = np.random.default_rng(0)
        for motion in motions:
            q, touched = corruption.spoil(motion, rng)
            yield corruption, replace(motion, q=q), touched
