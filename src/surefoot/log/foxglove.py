"""Logs as MCAP files that Foxglove draws: every row as JSON, and the robot, forces and cones as a scene.

Topics: ``/surefoot/log`` (all channels, one message per row; a log reads itself back from there to the last
bit), ``/tf`` (foxglove.FrameTransform of the base, and of the joints of a robot that Surefoot knows) and
``/surefoot/scene`` (foxglove.SceneUpdate of forces, cones and the robot as lines from joint to joint). The
scene
takes the ground for level where the log has no ``normals``.
"""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import MissingExtra
from surefoot.log.channels import CHANNELS
from surefoot.log.log import Log
from surefoot.log.mapping import LogMapping, Take
from surefoot.log.scene import DrawnContact, contacts, pictures, pose_of, weight_of
from surefoot.log.skeleton import skeleton_of
from surefoot.spatial import quaternion_from_rotation

OWN_METADATA = "surefoot"
"""Name of the metadata record that holds the mapping back to a log."""
OWN_TOPIC = "/surefoot/log"
SCENE_TOPIC = "/surefoot/scene"
_BLUE, _RED, _GREY, _DARK = (
    {"r": r, "g": g, "b": b, "a": a}
    for r, g, b, a in ((0.1, 0.4, 0.9, 1.0), (0.9, 0.2, 0.1, 1.0), (0.5, 0.5, 0.5, 0.7), (0.2, 0.2, 0.2, 1.0))
)
_ORIGIN = {
    "position": {"x": 0.0, "y": 0.0, "z": 0.0},
    "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
}


def write(log: Log, path: Path) -> None:
    """Write a log into an empty file.

    Raises
    ------
    MissingExtra
        If mcap is not installed.
    """
    try:
        from mcap.writer import Writer
    except ModuleNotFoundError as error:
        raise MissingExtra("mcap", "files") from error
    time = np.nan_to_num(np.asarray(log["time"], dtype=np.float64))
    stamps = np.rint(1e9 * (time - (time.min() if len(time) else 0.0))).astype(np.int64)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(library="surefoot")
        writer.add_metadata(OWN_METADATA, {"mapping": _mapping(log).as_yaml()})
        rows = _channel(writer, OWN_TOPIC, "surefoot.Log")
        base = _channel(writer, "/tf", "foxglove.FrameTransform")
        scene = _channel(writer, SCENE_TOPIC, "foxglove.SceneUpdate")
        shown, pose = set(pictures(np.asarray(1e-9 * stamps, dtype=np.float64))), pose_of(log)
        skeleton, weight = skeleton_of(log), weight_of(log)
        for k, stamp in enumerate(stamps.tolist()):
            _add(writer, rows, stamp, {name: _list(array[k]) for name, array in log.arrays.items()})
            if k not in shown:
                continue
            entities = [_contacts(list(contacts(log, k, weight)), stamp)]
            if pose is not None and np.isfinite(pose[k]).all():
                _add(writer, base, stamp, _transform(stamp, "base", pose[k].tolist()))
            if skeleton is not None and np.isfinite(log["q"][k]).all():
                for name, at in zip(
                    skeleton.names[1:], skeleton.poses(log["q"][k])[1:].tolist(), strict=True
                ):
                    _add(writer, base, stamp, _transform(stamp, name, at))
                lines = skeleton.segments(log["q"][k]).reshape(-1, 3)
                entities.append(_entity(stamp, "skeleton", [], [_lines(lines, _DARK)]))
            _add(writer, scene, stamp, {"deletions": [], "entities": entities})
        writer.finish()


def _mapping(log: Log) -> LogMapping:
    """Return the mapping by which the file's own topic is the log again."""
    takes = {name: Take((f"{OWN_TOPIC}.{name}",)) for name in log.arrays}
    facts = {name: np.asarray(value).tolist() for name, value in log.facts.items()}
    own = {name: c for name, c in log.channels.items() if CHANNELS.get(name) != c}
    return LogMapping(takes, facts=facts, define=own)


def _channel(writer: Any, topic: str, kind: str) -> int:
    schema = json.dumps({"title": kind, "type": "object"}).encode()
    number = writer.register_schema(name=kind, encoding="jsonschema", data=schema)
    return int(writer.register_channel(topic=topic, message_encoding="json", schema_id=number))


def _add(writer: Any, channel: int, stamp: int, message: dict[str, Any]) -> None:
    """Add a message; JSON knows neither NaN (null here) nor infinity (a number too large for a double)."""
    text = json.dumps(message, separators=(",", ":"))
    if "NaN" in text or "Infinity" in text:
        text = text.replace("NaN", "null").replace("Infinity", "1e999")
    writer.add_message(channel, log_time=stamp, publish_time=stamp, data=text.encode())


def _list(row: Any) -> list[Any]:
    """Return a row as a list, a single number as a list of one."""
    return np.atleast_1d(row).tolist()  # type: ignore[no-any-return]


def _transform(stamp: int, name: str, pose: list[float]) -> dict[str, Any]:
    return {
        "timestamp": _stamp(stamp),
        "parent_frame_id": "world",
        "child_frame_id": name,
        "translation": dict(zip("xyz", pose[:3], strict=True)),
        "rotation": dict(zip("xyzw", pose[3:], strict=True)),
    }


def _stamp(stamp: int) -> dict[str, int]:
    return {"sec": stamp // 10**9, "nsec": stamp % 10**9}


def _entity(stamp: int, name: str, arrows: list[Any], lines: list[Any]) -> dict[str, Any]:
    """Return a scene entity."""
    empty = ("metadata", "cubes", "spheres", "cylinders", "triangles", "texts", "models")
    return {
        "timestamp": _stamp(stamp),
        "frame_id": "world",
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": False,
        "arrows": arrows,
        "lines": lines,
        **{name: [] for name in empty},
    }


def _contacts(drawn: list[DrawnContact], stamp: int) -> dict[str, Any]:
    """Return forces and cones as a scene entity."""
    arrows = [_arrow(c.place, c.arrow, _RED if c.broken else _BLUE) for c in drawn]
    pairs = [
        np.array([p for line in lines for pair in pairwise(line) for p in pair])
        for c in drawn if (lines := c.cone_lines())
    ]  # fmt: skip
    return _entity(stamp, "contacts", arrows, [_lines(points, _GREY) for points in pairs])


def _arrow(place: Any, vector: FloatArray, color: dict[str, float]) -> dict[str, Any]:
    """Return an arrow; Foxglove's lies along x of its pose."""
    length = float(np.linalg.norm(vector))
    x = vector / length
    side = np.eye(3)[int(np.argmin(np.abs(x)))]
    y = np.cross(x, side) / np.linalg.norm(np.cross(x, side))
    quaternion = quaternion_from_rotation(np.column_stack([x, y, np.cross(x, y)]))
    return {
        "pose": {
            "position": dict(zip("xyz", map(float, place), strict=True)),
            "orientation": dict(zip("xyzw", map(float, quaternion), strict=True)),
        },
        "shaft_length": 0.8 * length,
        "shaft_diameter": 0.01,
        "head_length": 0.2 * length,
        "head_diameter": 0.02,
        "color": color,
    }


def _lines(points: FloatArray, color: dict[str, float]) -> dict[str, Any]:
    """Return lines between pairs of (2 m, 3) points."""
    return {
        "type": 2,  # pairs of points
        "pose": _ORIGIN,
        "thickness": 1.0,
        "scale_invariant": True,
        "points": [dict(zip("xyz", map(float, p), strict=True)) for p in points],
        "color": color,
        "colors": [],
        "indices": [],
    }
