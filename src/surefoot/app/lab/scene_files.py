"""Scenes as files of rerun (.rrd) and viser (.viser)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.lab.drawing import Arrows, Ball, Label, Lines, Mesh, Shape
from surefoot.app.lab.scenes import frames_of
from surefoot.base.errors import needs, writing

NAME = "surefoot"
"""What rerun calls the recording's application."""


def write_scene(answer: Any, path: Path, robot: Any = None, terrain: Any = None) -> Path:
    """Write a log, a plan, a motion, a stance or a verdict as a scene into a new file, and return its path.

    Parameters
    ----------
    answer, path
        What is written where: .rrd for rerun, .viser for viser.
    robot, terrain
        Of a log that does not name its own.

    Raises
    ------
    ProblemError
        For what has no scene.
    MissingExtra
        If the viewer's package is not installed.
    WriteError
        If the file cannot be written; none is left.
    """
    frames = frames_of(answer, robot, terrain)
    try:
        with writing(path):
            _WRITERS[path.suffix](frames, path)
    except BaseException:
        path.unlink(missing_ok=True)
        raise
    return path


def _write_viser(frames: Any, path: Path) -> None:
    """Write frames as viser's client plays them back."""
    with needs("viser", "lab"):
        import viser

    from surefoot.app.lab.canvas import Canvas

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        record = server.get_scene_serializer()
        canvas, before = Canvas(server.scene, lambda name, handle: None), 0.0
        for time, shapes in frames:
            if time > before:
                record.insert_sleep(time - before)
            canvas.show(shapes)
            before = time
        path.write_bytes(record.serialize())
    finally:
        server.stop()


def _write_rerun(frames: Any, path: Path) -> None:
    """Write frames on the timeline `time` of a rerun recording."""
    with needs("rerun-sdk", "rerun"):
        import rerun

    recording = rerun.RecordingStream(NAME)
    recording.save(str(path))
    shown: dict[str, Shape] = {}
    for time, shapes in frames:
        recording.set_time("time", duration=time)
        for name in shown.keys() - shapes.keys():
            recording.log(name, rerun.Clear(recursive=True))
            del shown[name]
        for name, shape in shapes.items():
            _LOGGED[type(shape)](rerun, recording, name, shape, shown.get(name))
            shown[name] = shape
    recording.flush()
    recording.disconnect()


def _log_mesh(rerun: Any, recording: Any, name: str, shape: Mesh, before: Any) -> None:
    """Log a surface once, and where it is whenever it moves."""
    if before is None or before.vertices is not shape.vertices or before.colour != shape.colour:
        colour = [*shape.colour, round(255 * shape.opacity)]
        surface = rerun.Mesh3D(
            vertex_positions=shape.vertices, triangle_indices=shape.faces, albedo_factor=colour
        )
        recording.log(name, surface)
    if before is None or (before.position, before.wxyz) != (shape.position, shape.wxyz):
        w, x, y, z = shape.wxyz
        turn = rerun.Quaternion(xyzw=[x, y, z, w])
        recording.log(name, rerun.Transform3D(translation=shape.position, quaternion=turn))


def _log_lines(rerun: Any, recording: Any, name: str, shape: Lines, _: Any) -> None:
    recording.log(name, rerun.LineStrips3D(list(np.asarray(shape.points)), colors=[shape.colour]))


def _log_arrows(rerun: Any, recording: Any, name: str, shape: Arrows, _: Any) -> None:
    starts = shape.points[:, 0] + np.asarray(shape.position)
    vectors = shape.points[:, 1] - shape.points[:, 0]
    recording.log(
        name, rerun.Arrows3D(origins=starts, vectors=vectors, colors=[shape.colour], radii=[shape.width])
    )


def _log_ball(rerun: Any, recording: Any, name: str, shape: Ball, _: Any) -> None:
    recording.log(name, rerun.Points3D([shape.position], radii=[shape.radius], colors=[shape.colour]))


def _log_label(rerun: Any, recording: Any, name: str, shape: Label, _: Any) -> None:
    recording.log(name, rerun.Points3D([shape.position], radii=[0.002], labels=[shape.text]))


_LOGGED: dict[type[Shape], Callable[..., None]] = {
    Mesh: _log_mesh, Lines: _log_lines, Arrows: _log_arrows, Ball: _log_ball, Label: _log_label,
}  # fmt: skip
_WRITERS: dict[str, Callable[[Any, Path], None]] = {".rrd": _write_rerun, ".viser": _write_viser}
