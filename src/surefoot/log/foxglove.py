"""Logs as MCAP files that Foxglove draws: every row as JSON, and the base, forces and cones as a scene.

Topics: ``/surefoot/log`` (all channels, one message per row; a log reads itself back from there to the last
bit), ``/tf`` (foxglove.FrameTransform of the base) and ``/surefoot/scene`` (foxglove.SceneUpdate). The scene
takes the ground for level where the log has no ``normals``.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import MissingExtra
from surefoot.log.channels import CHANNELS
from surefoot.log.log import Log
from surefoot.log.mapping import LogMapping, Take
from surefoot.spatial import GRAVITY, quaternion_from_rotation, rotation_from_normal

SCENE_PERIOD = 0.02
"""Least time between two pictures of the scene [s]."""
ARROW = 0.5
"""Length of a force of m g [m]."""
CONE = 0.1
"""Height at which a friction cone is drawn [m]."""
OWN_METADATA = "surefoot"
"""Name of the metadata record that holds the mapping back to a log."""
OWN_TOPIC = "/surefoot/log"
SCENE_TOPIC = "/surefoot/scene"
_SEGMENTS = 16
_BLUE, _RED, _GREY = (
    {"r": r, "g": g, "b": b, "a": a}
    for r, g, b, a in ((0.1, 0.4, 0.9, 1.0), (0.9, 0.2, 0.1, 1.0), (0.5, 0.5, 0.5, 0.7))
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
        drawn, pose = -math.inf, _pose_of(log)
        for k, stamp in enumerate(stamps.tolist()):
            _add(writer, rows, stamp, {name: _list(array[k]) for name, array in log.arrays.items()})
            if abs(1e-9 * stamp - drawn) < SCENE_PERIOD:
                continue
            drawn = 1e-9 * stamp
            if pose is not None and np.isfinite(pose[k]).all():
                _add(writer, base, stamp, _transform(stamp, pose[k].tolist()))
            _add(writer, scene, stamp, {"deletions": [], "entities": [_entity(log, k, stamp)]})
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


def _pose_of(log: Log) -> Any:
    """Return the base's (T, 7) position and quaternion x, y, z, w; None where the log has none."""
    if "q" in log and log["q"].shape[1] >= 7:
        return log["q"][:, :7]
    if "base_position" in log and "base_orientation" in log:
        return np.hstack([log["base_position"], log["base_orientation"]])
    return None


def _transform(stamp: int, pose: list[float]) -> dict[str, Any]:
    return {
        "timestamp": _stamp(stamp),
        "parent_frame_id": "world",
        "child_frame_id": "base",
        "translation": dict(zip("xyz", pose[:3], strict=True)),
        "rotation": dict(zip("xyzw", pose[3:], strict=True)),
    }


def _stamp(stamp: int) -> dict[str, int]:
    return {"sec": stamp // 10**9, "nsec": stamp % 10**9}


def _entity(log: Log, row: int, stamp: int) -> dict[str, Any]:
    """Return the forces and cones of a row as a scene entity."""
    arrows: list[Any] = []
    lines: list[Any] = []
    if "forces" in log and "contact_positions" in log:
        forces, places = log["forces"][row], log["contact_positions"][row]
        weight = log.facts.get("mass", 0.0) * GRAVITY or max(float(np.nan_to_num(log["forces"]).max()), 1.0)
        for k in range(len(forces)):
            if not (np.isfinite(forces[k]).all() and np.isfinite(places[k]).all()) or not forces[k].any():
                continue
            R, mu = _frame(log, row, k), _friction(log, row, k)
            broken = math.hypot(forces[k][0], forces[k][1]) > mu * forces[k][2] * (1.0 + 1e-3)
            arrows.append(_arrow(places[k], R @ forces[k] / weight * ARROW, _RED if broken else _BLUE))
            if math.isfinite(mu):
                lines.append(_cone(places[k], R, mu))
    empty = ("metadata", "cubes", "spheres", "cylinders", "triangles", "texts", "models")
    return {
        "timestamp": _stamp(stamp),
        "frame_id": "world",
        "id": "contacts",
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": False,
        "arrows": arrows,
        "lines": lines,
        **{name: [] for name in empty},
    }


def _frame(log: Log, row: int, contact: int) -> FloatArray:
    normal = log["normals"][row, contact] if "normals" in log else np.array([0.0, 0.0, 1.0])
    size = np.linalg.norm(normal)
    return rotation_from_normal(normal / size if 0.0 < size < np.inf else [0.0, 0.0, 1.0])


def _friction(log: Log, row: int, contact: int) -> float:
    """Return a contact's friction; infinite where the log does not tell it."""
    if "contact_friction" in log:
        mu = float(log["contact_friction"][row, contact])
    else:
        mu = float(log["mu"][row]) if "mu" in log else math.inf
    return math.inf if math.isnan(mu) else mu


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


def _cone(place: Any, R: FloatArray, mu: float) -> dict[str, Any]:
    """Return a friction cone as lines: its rim and rays."""
    angles = 2.0 * np.pi * np.arange(_SEGMENTS + 1) / _SEGMENTS
    local = CONE * np.column_stack([mu * np.cos(angles), mu * np.sin(angles), np.ones_like(angles)])
    rim = place + local @ R.T
    points = [p for k in range(_SEGMENTS) for p in (rim[k], rim[k + 1])]
    points += [p for k in range(0, _SEGMENTS, 2) for p in (place, rim[k])]
    return {
        "type": 2,  # pairs of points
        "pose": _ORIGIN,
        "thickness": 1.0,
        "scale_invariant": True,
        "points": [dict(zip("xyz", map(float, p), strict=True)) for p in points],
        "color": _GREY,
        "colors": [],
        "indices": [],
    }
