"""Puts drawings into a viser scene: what is new is added, what changed is changed in place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from surefoot.lab.drawing import Arrows, Ball, Label, Lines, Mesh, Shape

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
            if before is None or type(before[0]) is not type(shape):
                self._add(name, shape, before)
            else:
                _UPDATES[type(shape)](before[1], before[0], shape)
                self._shown[name] = shape, before[1]
            if name in self._hidden:
                self._hidden.discard(name)
                self._shown[name][1].visible = True

    def _add(self, name: str, shape: Shape, before: tuple[Shape, Any] | None) -> None:
        """Add a shape, in the place of one of another kind."""
        if before is not None:
            before[1].remove()
            self._hidden.discard(name)
        handle = _ADDERS[type(shape)](self._scene, name, shape)
        self._shown[name] = shape, handle
        if getattr(shape, "held", False):
            self._hold(name, handle)


def _add_mesh(scene: Any, name: str, shape: Mesh) -> Any:
    return scene.add_mesh_simple(
        name, shape.vertices.astype(np.float32), shape.faces.astype(np.uint32), color=shape.colour,
        opacity=None if shape.opacity >= 1.0 else shape.opacity, side="double",
        flat_shading=len(shape.faces) < 200, position=shape.position, wxyz=shape.wxyz,
        cast_shadow=False, receive_shadow=False,
    )  # fmt: skip


def _change_mesh(handle: Any, old: Mesh, new: Mesh) -> None:
    if new.vertices is not old.vertices:
        handle.vertices = new.vertices.astype(np.float32)
    if new.faces is not old.faces:
        handle.faces = new.faces.astype(np.uint32)
    if new.position != old.position:
        handle.position = new.position
    if new.wxyz != old.wxyz:
        handle.wxyz = new.wxyz
    _change_colour(handle, old, new)


def _add_lines(scene: Any, name: str, shape: Lines) -> Any:
    return scene.add_line_segments(
        name, shape.points.astype(np.float32), shape.colour, thickness=shape.width, thickness_units="screen"
    )


def _change_lines(handle: Any, old: Lines, new: Lines) -> None:
    if new.points is not old.points:
        handle.points = new.points.astype(np.float32)
    _change_colours(handle, old, new)


def _add_arrows(scene: Any, name: str, shape: Arrows) -> Any:
    return scene.add_arrows(
        name, shape.points.astype(np.float32), shape.colour,
        shaft_radius=shape.width, head_radius=2.2 * shape.width, head_length=5.0 * shape.width,
        position=shape.position,
    )  # fmt: skip


def _change_arrows(handle: Any, old: Arrows, new: Arrows) -> None:
    if new.points is not old.points:
        handle.points = new.points.astype(np.float32)
    if new.position != old.position:
        handle.position = new.position
    _change_colours(handle, old, new)


def _add_ball(scene: Any, name: str, shape: Ball) -> Any:
    return scene.add_icosphere(
        name, shape.radius, shape.colour, subdivisions=2, position=shape.position, cast_shadow=False,
        receive_shadow=False,
    )  # fmt: skip


def _change_ball(handle: Any, old: Ball, new: Ball) -> None:
    handle.position = new.position
    if new.radius != old.radius:
        handle.radius = new.radius
    _change_colour(handle, old, new)


def _add_label(scene: Any, name: str, shape: Label) -> Any:
    return scene.add_label(name, shape.text, position=shape.position, anchor="bottom-center")


def _change_label(handle: Any, old: Label, new: Label) -> None:
    handle.position = new.position
    if new.text != old.text:
        handle.text = new.text


def _change_colour(handle: Any, old: Mesh | Ball, new: Mesh | Ball) -> None:
    if new.colour != old.colour:
        handle.color = new.colour


def _change_colours(handle: Any, old: Lines | Arrows, new: Lines | Arrows) -> None:
    """Lines and arrows hold a colour for each end: their array follows the points."""
    if new.colour != old.colour:
        handle.colors = np.array(new.colour, dtype=np.uint8)


_ADDERS: dict[type[Shape], Callable[..., Any]] = {
    Mesh: _add_mesh, Lines: _add_lines, Arrows: _add_arrows, Ball: _add_ball, Label: _add_label,
}  # fmt: skip
_UPDATES: dict[type[Shape], Callable[..., None]] = {
    Mesh: _change_mesh, Lines: _change_lines, Arrows: _change_arrows, Ball: _change_ball,
    Label: _change_label,
}  # fmt: skip
