"""Puts drawings into a viser scene: what is new is added, what changed is changed in place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from surefoot.app.lab.drawing import Arrows, Ball, Label, Lines, Mesh, Shape

Holder = Callable[[str, Any], None]
"""Called with the name and the handle of a new shape that can be taken with the mouse."""


class Canvas:
    """What one viewer sees.

    Parameters
    ----------
    scene
        Viser's scene of that viewer.
    hold
        See `Holder`.
    """

    def __init__(self, scene: Any, hold: Holder) -> None:
        self._scene, self._hold = scene, hold
        self._shown: dict[str, tuple[Shape, Any]] = {}
        self._hidden: set[str] = set()

    def show(self, shapes: Mapping[str, Shape]) -> None:
        """Change the scene into these shapes; arrows and lines of which there are none are hidden."""
        shapes = {name: s for name, s in shapes.items() if len(getattr(s, "points", s.__dict__)) > 0}
        for name in self._shown.keys() - shapes.keys() - self._hidden:
            self._shown[name][1].visible = False
            self._hidden.add(name)
        for name, shape in shapes.items():
            before = self._shown.get(name)
            if before is None:
                self._add(name, shape)
            else:
                _change(before[1], before[0], shape)
                self._shown[name] = shape, before[1]
            if name in self._hidden:
                self._hidden.discard(name)
                self._shown[name][1].visible = True

    def _add(self, name: str, shape: Shape) -> None:
        """Add a shape; a name keeps its kind from drawing to drawing."""
        handle = _ADDERS[type(shape)](self._scene, name, shape)
        self._shown[name] = shape, handle
        if getattr(shape, "held", False):
            self._hold(name, handle)


def _change(handle: Any, old: Shape, new: Shape) -> None:
    """Send what is another than before; arrays that are the very same objects are not."""
    for name in _CHANGING[type(new)]:
        before, value = getattr(old, name), getattr(new, name)
        if value is before or (not isinstance(value, np.ndarray) and value == before):
            continue
        if name != "colour":
            setattr(handle, name, value.astype(_TYPES[name]) if name in _TYPES else value)
        elif isinstance(new, Lines | Arrows):  # a colour for each end: their array follows the points
            handle.colors = np.array(value, dtype=np.uint8)
        else:
            handle.color = value


def _add_mesh(scene: Any, name: str, shape: Mesh) -> Any:
    return scene.add_mesh_simple(
        name, shape.vertices.astype(np.float32), shape.faces.astype(np.uint32), color=shape.colour,
        opacity=None if shape.opacity >= 1.0 else shape.opacity, side="double",
        flat_shading=len(shape.faces) < 200, position=shape.position, wxyz=shape.wxyz,
        cast_shadow=False, receive_shadow=False,
    )  # fmt: skip


def _add_lines(scene: Any, name: str, shape: Lines) -> Any:
    return scene.add_line_segments(
        name, shape.points.astype(np.float32), shape.colour, thickness=shape.width, thickness_units="screen"
    )


def _add_arrows(scene: Any, name: str, shape: Arrows) -> Any:
    return scene.add_arrows(
        name, shape.points.astype(np.float32), shape.colour,
        shaft_radius=shape.width, head_radius=2.2 * shape.width, head_length=5.0 * shape.width,
        position=shape.position,
    )  # fmt: skip


def _add_ball(scene: Any, name: str, shape: Ball) -> Any:
    return scene.add_icosphere(
        name, shape.radius, shape.colour, subdivisions=2, position=shape.position, cast_shadow=False,
        receive_shadow=False,
    )  # fmt: skip


def _add_label(scene: Any, name: str, shape: Label) -> Any:
    return scene.add_label(name, shape.text, position=shape.position, anchor="bottom-center")


_ADDERS: dict[type[Shape], Callable[..., Any]] = {
    Mesh: _add_mesh, Lines: _add_lines, Arrows: _add_arrows, Ball: _add_ball, Label: _add_label,
}  # fmt: skip
_TYPES = {"vertices": np.float32, "points": np.float32, "faces": np.uint32}
_CHANGING: dict[type[Shape], tuple[str, ...]] = {
    Mesh: ("vertices", "faces", "position", "wxyz", "colour"),
    Lines: ("points", "colour"),
    Arrows: ("points", "position", "colour"),
    Ball: ("position", "radius", "colour"),
    Label: ("position", "text"),
}
"""Shape -> its attributes that may change."""
