"""Reading motions: files of any known format, arrays and logs, as configurations of a robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, of_kind, positive_number
from surefoot.base.errors import ProblemError, located, unknown_name
from surefoot.base.text_files import path_of
from surefoot.mechanics import Robot, load_robot
from surefoot.records.log.log import Log
from surefoot.records.log.reading import read_log
from surefoot.records.motions.array_files import read_arrays
from surefoot.records.motions.conventions import Conventions, ConventionSearch
from surefoot.records.motions.field_reading import fields_of, motions_in
from surefoot.records.motions.fields import MotionFields
from surefoot.records.motions.motion import Motion
from surefoot.records.motions.rates import find_rate, stated_rate
from surefoot.records.motions.resampling import blend_configurations, blend_rows

UNEVEN = 0.02
"""Deviation of a frame's time from an even rate, in frames' times, from which a motion is resampled."""
RUN_LOG = "log.npz"
"""Log in the folder that a run of the command line leaves."""
SHOWN = 12
"""Names of motions that a message lists."""

Source = Path | str | Log | Mapping[str, Any] | ArrayLike


def read_motion(
    source: Source,
    robot: Robot | str | Path,
    fps: float | None = None,
    order: Any = None,
    quaternion: str | None = None,
    name: str | None = None,
) -> Motion:
    """Read a motion reference as configurations of a robot; what had to be guessed stands in `Motion.notes`.

    Formats are known by their content: tables (CSV) with place, quaternion and joints, pickles of GMR,
    TWIST2, PHC, ASAP and PBHC (of numpy or joblib), archives (.npz) of mjlab, BeyondMimic, holosoma and
    OmniRetarget, rollouts of qpos, arrays of configurations, logs of Surefoot. Pickles are read as data:
    nothing of them is run. See docs/motions.md.

    Parameters
    ----------
    source
        A file; or its contents: an `sf.Log`, a mapping of arrays by their names in such files, a (T, nq)
        array.
    robot
        A robot, or what `load_robot` takes. Joints that the file lacks are held at its nominal angle.
    fps
        Frames per second [Hz], where the file does not say or is wrong.
    order
        Order of the joints' columns: "depth" (MuJoCo's and the URDF's), "breadth" (Isaac Lab's), or the
        joints' names; None for what the file says, or else a guess by ranges and feet.
    quaternion
        "xyzw" or "wxyz"; None for what the file says, or else a guess by the feet and the uprightness.
    name
        Which motion of a file that has several.

    Raises
    ------
    ProblemError
        In one line, for a file that cannot be read, is of no such format, does not fit the robot, or does
        not say its rate; for a file of several motions without `name`.

    Examples
    --------
    >>> import numpy as np
    >>> from surefoot import load_robot, read_motion
    >>> robot = load_robot("go2")
    >>> motion = read_motion(np.tile(robot.nominal, (50, 1)), robot, fps=50, order="depth", quaternion="xyzw")
    >>> len(motion), round(motion.duration, 2)
    (50, 0.98)
    """
    known = robot_of_motion(robot)
    found = dict(_contents(source))
    title = _title(source)
    if name is not None and name not in found:
        raise ProblemError(f"{title}: {unknown_name('motion', name, found)}")
    if name is None and len(found) != 1:
        listed = ", ".join(list(found)[:SHOWN]) + (", ..." if len(found) > SHOWN else "")
        raise ProblemError(
            f"{title} holds {len(found)} motions, say which by name=, or take read_motions: {listed}"
        )
    chosen = name if name is not None else next(iter(found))
    return _motion(source, chosen, found[chosen], known, (fps, order, quaternion))


def read_motions(
    source: Source,
    robot: Robot | str | Path,
    fps: float | None = None,
    order: Any = None,
    quaternion: str | None = None,
) -> Iterator[Motion]:
    """Yield the motions of a file that holds several, such as a pickle of PHC's, one after the other.

    Parameters and errors are those of `read_motion`; a motion's name is its key in the file.
    """
    known = robot_of_motion(robot)
    for name, contents in _contents(source):
        yield _motion(source, name, contents, known, (fps, order, quaternion))


def robot_of_motion(robot: Robot | str | Path) -> Robot:
    """Return the robot that is given or named."""
    known = load_robot(robot) if isinstance(robot, str | Path) else robot
    of_kind("robot", known, Robot)
    first = 7 if known.floating else 0
    if int(known.model.nq) != first + known.joints:
        raise ProblemError(f"motions are read for robots of joints with one angle, {known.name} has others")
    return known


def _title(source: Source) -> str:
    """Return what a message calls a source."""
    return str(source) if isinstance(source, str | Path) else "the motion"


def _contents(source: Source) -> Iterator[tuple[str, Any]]:
    """Yield the motions of a source: names, and logs or fields."""
    if isinstance(source, Log):
        yield "log", source
    elif isinstance(source, str | Path):
        path = path_of(source).expanduser()
        if path.is_dir() and (path / "facts.json").exists():
            yield path.stem, read_log(path)
            return
        if (path / RUN_LOG).is_file():
            yield path.name, read_log(path / RUN_LOG)
            return
        contents = read_arrays(path)
        if isinstance(contents, Mapping) and {"schema", "channels"} <= set(contents):
            yield path.stem, read_log(path)
            return
        with located(path):
            yield from motions_in(contents, path.stem)
    elif isinstance(source, Mapping):
        yield from motions_in(source, "motion")
    else:
        array = None
        if not isinstance(source, bytes):
            with suppress(Exception):  # whatever a foreign object raises that is made an array
                array = np.asarray(source)
        if array is None or array.dtype.kind not in "biuf" or array.ndim < 2:
            raise ProblemError(f"a motion is a file, a log, a mapping of arrays or a (frames, nq) array, got "
                               f"{type(source).__name__}")  # fmt: skip
        yield "motion", {"": array}


def _motion(source: Source, name: str, contents: Any, robot: Robot, options: tuple[Any, Any, Any]) -> Motion:
    """Return one motion of a source's contents."""
    fps, order, quaternion = options
    with located(f"{_title(source)}"):
        if isinstance(contents, Log):
            fields = _log_fields(name, contents, robot)
        else:
            fields = fields_of(name, contents, robot.floating)
        stated = stated_rate(fields) if fps is None else positive_number("fps", fps, "Hz")
        found = ConventionSearch(robot, fields, order, quaternion, stated).find()
        fields.joints = fields.joints[:, list(found.columns)]
        if fields.speeds is not None:
            fields.speeds = fields.speeds[:, list(found.columns)]
        rate, told = find_rate(robot, fields, found.reading.q, fps)
        return _finish(source, robot, fields, found, rate, told)


def _finish(
    source: Source, robot: Robot, fields: MotionFields, found: Conventions, rate: float, told: list[str]
) -> Motion:
    """Return the motion: evenly spaced frames, torques in the robot's order, and all that is told."""
    order, q = found.reading.order, found.reading.q
    absent = tuple(name for name in robot.joint_names if name not in order.joints)
    notes = [*fields.notes, *found.notes, *told]
    if absent:
        notes.append(
            f"{len(absent)} joints are not in the file and held at the nominal angle: {', '.join(absent)}"
        )
    torques = None
    if fields.torques is not None and not absent:
        columns = [order.joints.index(name) for name in robot.joint_names]
        torques = fields.torques[:, list(found.columns)][:, columns]
    at = _even_places(fields.times, rate)
    if at is not None:
        notes.append(f"doubt: rate: frames are not evenly spaced in time; resampled to {rate:.6g} Hz")
        q = blend_configurations(robot, q, at)
        torques = None if torques is None else blend_rows(torques, at)
    path = path_of(source) if isinstance(source, str | Path) else None
    return Motion(robot, q, rate, fields.name, path, absent, torques, tuple(notes), fields.extra)


def _even_places(times: FloatArray | None, rate: float) -> FloatArray | None:
    """Return the places between frames of an even rate, None where times are even or not known."""
    if times is None:
        return None
    elapsed = times - times[0]
    even = np.linspace(0.0, elapsed[-1], len(times))
    if np.abs(elapsed - even).max() * rate < UNEVEN * len(times) ** 0.5:
        return None
    return np.asarray(np.interp(even, elapsed, np.arange(len(times), dtype=np.float64)))


def _log_fields(name: str, log: Log, robot: Robot) -> MotionFields:
    """Return the fields of a log: q as Pinocchio has it, and torques, in the order that the log's facts say.

    Raises
    ------
    ProblemError
        For a log without q, or with one of another robot's size.
    """
    width = int(robot.model.nq)
    if "q" not in log or log["q"].shape[1] != width:
        size = log["q"].shape[1] if "q" in log else "none"
        raise ProblemError(f"the log's q must have {width} columns, as {robot.name} has them, got {size}")
    rows = len(log)
    if rows < 2:
        raise ProblemError(f"the log has {rows} rows; a motion has two or more")
    q = np.asarray(log["q"], dtype=np.float64)
    if not np.isfinite(q).all():
        raise ProblemError(f"the log's q is not finite in row {int(np.argmin(np.isfinite(q).all(axis=1)))}")
    listed = log.facts.get("joints", ())
    first = width - robot.joints
    names = tuple(map(str, listed)) if len(listed) == robot.joints else robot.joint_names
    out = MotionFields(name, q[:, first:], names=names, times=np.asarray(log["time"], dtype=np.float64))
    if robot.floating:
        out.place, out.quaternion, out.turn, out.certain = q[:, :3], q[:, 3:7], "xyzw", True
    if "torques" in log and log["torques"].shape == (rows, robot.joints):
        out.torques = np.asarray(log["torques"], dtype=np.float64)
    return out
