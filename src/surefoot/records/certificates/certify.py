"""The question whether a motion is possible, put to every frame of it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind, positive_number
from surefoot.base.errors import ProblemError
from surefoot.base.numerics.windows import sliding_mean
from surefoot.mechanics import Robot, Terrain
from surefoot.records.certificates.causes import find_causes
from surefoot.records.certificates.certificate_settings import CertificateSettings
from surefoot.records.certificates.detours import find_detours
from surefoot.records.certificates.frame_data import FrameData, frame_data
from surefoot.records.certificates.frame_kernels import Answer
from surefoot.records.certificates.frame_table import NO_WINDOW, FrameTable
from surefoot.records.certificates.motion_report import MotionReport
from surefoot.records.certificates.segments import find_segments
from surefoot.records.certificates.touching_points import touching_points
from surefoot.records.log.log import Log
from surefoot.records.motions.motion import Motion
from surefoot.records.motions.read_motion import read_motion, robot_of_motion

SAID = 1e-3
"""Height of the whole motion above the ground from which a note says so [m]."""


def certify_motion(
    robot: Robot | str | Path,
    motion: Motion | Log,
    mu: float | ArrayLike = 0.8,
    sliding_mu: Sequence[float] = (0.3, 0.8),
    terrain: Terrain | None = None,
    window: float | None = None,
    *,
    settings: CertificateSettings | None = None,
) -> MotionReport:
    """Return whether the ground and the motors could give the forces that a motion needs, frame by frame.

    A frame is impossible where no forces of its contacts, within friction and torque limits, come nearer to
    what it needs than a tenth of the weight, for so long that the centre of mass would have to leave its way
    by half a centimetre; the proof is in `MotionReport.certificate`. It says nothing of whether a controller
    will track the motion.

    Parameters
    ----------
    robot
        Any with a floating base, or what `load_robot` takes; masses, limits and collision shapes are its
        model's.
    motion
        Configurations of that robot at an even rate, from `read_motion` or from arrays; or a log or a plan,
        which `read_motion` makes one of.
    mu
        Friction of contacts that stick, a number or one a foot, (n,) [-].
    sliding_mu
        Least and largest friction of contacts that slide [-].
    terrain
        The ground; None for level ground at z = 0. Boxes and stairs that are not given are not there.
    window
        Time over which forces are averaged [s]; None for 0.1 s, or 0.2 s where the data are noisy.
    settings
        What counts as a contact, and limits of the verdicts.

    Raises
    ------
    ProblemError
        For a motion of another robot, values that are not finite, or parameters out of range.

    Notes
    -----
    Needed are the rate of the centroidal momentum less the weight, by exact differences over the window.
    Contacts are ends of collision shapes within 2 cm of the ground in the window; slower than 0.15 m/s they
    give forces in the cone of `mu`, faster ones against their velocity only, with friction in `sliding_mu`.
    Impacts are in the mean over a window; joints at their stops carry any torque away from them.
    """
    robot = robot_of_motion(robot)
    if isinstance(motion, Log):
        motion = read_motion(motion, robot)
    of_kind("motion", motion, Motion)
    if terrain is not None:
        of_kind("terrain", terrain, Terrain)
    chosen = CertificateSettings() if settings is None else settings
    slides = _range(sliding_mu)
    given = None if window is None else positive_number("window", window, "s")
    checked = _check_motion(robot, motion)
    points = touching_points(robot, mu)
    data = frame_data(robot, checked, points, slides, terrain, given, chosen)
    answer = data.solve(data.frames)
    noise = chosen.sigmas * data.noise.wrench
    possible = min(max(chosen.floor, noise), chosen.impossible)
    impossible = max(chosen.impossible, noise)
    table = _table(robot, checked, data, answer, possible, impossible, chosen.detour)
    segments = find_segments(data, answer, table, points.links, impossible)
    asked: dict[str, Any] = {
        "mu": mu,
        "sliding_mu": slides,
        "terrain": terrain,
        "window": given,
        "settings": chosen,
    }
    length = data.model.window.length * data.model.window.step
    notes = _notes(robot, checked, data, terrain, impossible, chosen)
    return MotionReport(
        checked, table, segments, length, data.noise.wrench, possible, impossible, notes, chosen, data,
        points, answer.needed, partial(_certify_again, robot=robot, **asked),
    )  # fmt: skip


def _certify_again(motion: Motion, robot: Robot, **asked: Any) -> MotionReport:
    """Return the certificate of another motion under the same assumptions."""
    return certify_motion(robot, motion, **asked)


def _range(sliding_mu: Sequence[float]) -> tuple[float, float]:
    low, high = finite_array("sliding_mu", sliding_mu, (2,)).tolist()
    if not 0.0 <= low <= high:
        raise ProblemError(
            f"sliding_mu must be two numbers with 0 <= least <= largest, got {low:g} and {high:g}"
        )
    return low, high


def _check_motion(robot: Robot, motion: Motion) -> Motion:
    """Return the motion with unit quaternions.

    Raises
    ------
    ProblemError
        For another shape, what is not finite, or quaternions that are none.
    """
    from dataclasses import replace

    positive_number("rate", motion.rate, "Hz")
    q = finite_array("q", motion.q, (None, robot.model.nq))
    if robot.floating and len(q):
        length = np.linalg.norm(q[:, 3:7], axis=1)
        off = np.flatnonzero(np.abs(length - 1.0) > 1e-2)
        if len(off):
            raise ProblemError(
                f"q[{off[0]}, 3:7] must be a unit quaternion, its length is {length[off[0]]:g}"
            )
        q[:, 3:7] /= length[:, None]
    return replace(motion, robot=robot, q=q, rate=float(motion.rate))


def _table(
    robot: Robot, motion: Motion, data: FrameData, answer: Answer, possible: float, impossible: float,
    least_detour: float,
) -> FrameTable:  # fmt: skip
    """Return the frames with their verdicts and causes."""
    count, judged = len(motion), np.isfinite(answer.share)
    verdict = np.full(count, NO_WINDOW, dtype="<U12")
    verdict[judged] = "cannot tell"
    verdict[judged & (answer.share <= possible)] = "possible"
    window = data.model.window
    detour = find_detours(answer.bound, impossible, window.length * window.step, window.step)
    verdict[detour > least_detour] = "impossible"
    lowest = data.model.points.gaps.min(axis=1) if data.model.points.gaps.shape[1] else np.full(count, np.inf)
    names = robot.joint_names if len(data.model.motion.joints) == robot.joints else ()
    bad = np.flatnonzero(detour > 0.0).astype(np.int64)
    cause, joint = find_causes(data, answer, bad, impossible, lowest, names)
    beyond = _beyond_stops(robot, motion)
    return FrameTable(
        np.arange(count) / motion.rate, verdict, answer.wrench[:, :3], answer.wrench[:, 3:], answer.share,
        answer.bound, detour, cause, joint, answer.contacts, answer.sliding, answer.slowest,
        np.maximum(-lowest, 0.0), np.maximum(lowest, 0.0), beyond, _shaking(motion),
    )  # fmt: skip


def _beyond_stops(robot: Robot, motion: Motion) -> FloatArray:
    """Return how far joints are beyond their stops at most: (T,) [rad, m]."""
    first = 7 if robot.floating else 0
    low, high = (
        np.array(x)[first:] for x in (robot.model.lowerPositionLimit, robot.model.upperPositionLimit)
    )
    angles = motion.q[:, first:]
    over = np.maximum(np.maximum(angles - high, low - angles), 0.0)
    return np.asarray(np.max(over, axis=1, initial=0.0))


def _shaking(motion: Motion) -> FloatArray:
    """Return the deviation of the base's place by its fourth difference, over five frames: (T,) [m]."""
    square = np.zeros(len(motion))
    if len(motion) >= 5:
        square[2:-2] = (np.diff(motion.q[:, :3], 4, axis=0) ** 2).sum(axis=1) / (3.0 * 70.0)
    return np.asarray(np.sqrt(np.maximum(sliding_mean(square, 5), 0.0)))


def _notes(
    robot: Robot, motion: Motion, data: FrameData, terrain: Terrain | None, impossible: float,
    settings: CertificateSettings,
) -> tuple[str, ...]:  # fmt: skip
    """Return what was assumed, a line each."""
    out = [*motion.notes]
    if terrain is None:
        out.append("level ground at z = 0; props and steps are not in a motion: give a terrain")
    height = data.model.rules.clearance - settings.clearance
    if height > SAID:
        out.append(
            f"what rests stands {1e3 * height:.0f} mm above the ground throughout: contacts count from there"
        )
    if impossible > settings.impossible:
        out.append(
            f"the data are noisy: {data.noise.wrench:.2f} m g in the needed forces, so impossible is above "
            f"{impossible:.2f} m g"
        )
    if not np.isfinite(robot.effort_limits).all():
        out.append("some joints have no torque limit in the model: theirs are not checked")
    return tuple(out)
