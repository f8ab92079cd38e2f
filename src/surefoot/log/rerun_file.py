"""Logs as Rerun recordings (.rrd), and in its viewer: pose, joints, forces, cones, curves.

Entities: ``robot/base`` (its pose), ``robot/skeleton``, ``contacts/forces`` (red outside their cone),
``contacts/cones``, and the curves ``normal_force/FOOT``, ``friction_use/FOOT``, ``gap/FOOT``, over the log's
time.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import MissingExtra
from surefoot.log import scene
from surefoot.log.log import Log
from surefoot.log.skeleton import skeleton_of

APPLICATION = "surefoot"
_GREY, _DARK = (128, 128, 128, 180), (60, 60, 60, 255)
_BLUE, _RED = (25, 100, 230, 255), (230, 50, 25, 255)


def import_rerun() -> Any:
    """Return the module `rerun`, or raise `MissingExtra`."""
    try:
        import rerun
    except ModuleNotFoundError as error:
        raise MissingExtra("rerun-sdk", "rerun") from error
    return rerun


def write(log: Log, path: Path) -> None:
    """Write a log into an .rrd file.

    Raises
    ------
    MissingExtra
        If rerun-sdk is not installed.
    """
    rerun = import_rerun()
    with rerun.RecordingStream(APPLICATION) as stream:
        stream.save(str(path))
        _fill(rerun, stream, log)
        stream.flush()
        stream.disconnect()


def show(log: Log) -> None:
    """Open a log in Rerun's viewer.

    Raises
    ------
    MissingExtra
        If rerun-sdk is not installed.
    """
    rerun = import_rerun()
    stream = rerun.RecordingStream(APPLICATION)
    stream.spawn()
    _fill(rerun, stream, log)


def _fill(rerun: Any, stream: Any, log: Log) -> None:
    """Send the curves in columns, and the scene picture by picture."""
    time = np.nan_to_num(np.asarray(log["time"], dtype=np.float64))
    for name, values in _curves(log):
        at = rerun.TimeColumn("time", duration=time)
        stream.send_columns(name, indexes=[at], columns=rerun.Scalars.columns(scalars=values))
    pose, skeleton, weight = scene.pose_of(log), skeleton_of(log), scene.weight_of(log)
    for row in scene.pictures(time):
        stream.set_time("time", duration=float(time[row]))
        if pose is not None and np.isfinite(pose[row]).all():
            turn = rerun.Quaternion(xyzw=pose[row, 3:])
            stream.log("robot/base", rerun.Transform3D(translation=pose[row, :3], quaternion=turn))
        if skeleton is not None and np.isfinite(log["q"][row]).all():
            lines = skeleton.segments(log["q"][row])
            stream.log("robot/skeleton", rerun.LineStrips3D(lines, colors=_DARK))
        contacts = list(scene.contacts(log, row, weight))
        if contacts or "forces" in log:
            stream.log("contacts/forces", _arrows(rerun, contacts))
            strips = [line for c in contacts for line in c.cone_lines()]
            stream.log("contacts/cones", rerun.LineStrips3D(strips, colors=_GREY))


def _arrows(rerun: Any, contacts: list[scene.DrawnContact]) -> Any:
    return rerun.Arrows3D(
        origins=[c.place for c in contacts],
        vectors=[c.arrow for c in contacts],
        colors=[_RED if c.broken else _BLUE for c in contacts],
    )


def _curves(log: Log) -> Iterator[tuple[str, FloatArray]]:
    """Yield name and (T,) values of the curves of every contact."""
    names = scene.contact_names(log)
    for k, name in enumerate(names):
        if "forces" in log:
            force = np.asarray(log["forces"])[:, k]
            yield f"normal_force/{name}", force[:, 2]
            sideways = np.hypot(force[:, 0], force[:, 1])
            loaded = force[:, 2] > 1e-3 * scene.weight_of(log)
            yield f"friction_use/{name}", np.where(loaded, sideways / np.where(loaded, force[:, 2], 1.0), 0.0)
        if "gaps" in log:
            yield f"gap/{name}", np.asarray(log["gaps"])[:, k]
