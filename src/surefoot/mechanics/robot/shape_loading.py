"""The shapes of a robot's file, and robots that are pickled without them: meshes are a hundred megabytes."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from surefoot.base.errors import ModelError


def urdf_shapes(model: Any, path: Path, folders: Sequence[Path], kind: str) -> Any:
    """Return Pinocchio's shapes of a kind, "COLLISION" or "VISUAL", of a URDF file; see `urdf_geometry`."""
    import pinocchio

    from surefoot.mechanics.robot.urdf_geometry import urdf_geometry

    return urdf_geometry(model, path, getattr(pinocchio.GeometryType, kind), folders)[0]


def mjcf_shapes(path: Path, fixed_base: bool | None) -> Any:
    """Return Pinocchio's shapes of an MJCF file."""
    from surefoot.mechanics.robot.mjcf import read_mjcf

    return read_mjcf(path, fixed_base).collision


class ShapesOfFile:
    """What has shapes of a file: pickled, it knows where they are, and loads them when they are asked for.

    Attributes
    ----------
    collision
        Pinocchio's geometry model of what may touch.
    """

    collision: Any
    _file: tuple[Path, Callable[[], Any], Any] | None = None
    """The file, what loads the shapes, and the shapes as they were loaded, None for not yet."""

    @property
    def file(self) -> Path | None:
        """The file that the shapes come from, None where they come from none."""
        return None if self._file is None else self._file[0]

    def keep_file(self, path: Path, load: Callable[[], Any]) -> None:
        """Remember where the shapes that it has come from, and what loads them again."""
        self._file = path.resolve(), load, self.collision

    def __getattr__(self, name: str) -> Any:
        """Load what a copy from another process has left in its file.

        Raises
        ------
        ModelError
            If the file is not on this machine.
        """
        file = vars(self).get("_file")
        if name != "collision" or file is None:
            raise AttributeError(f"a {type(self).__name__} has no attribute {name!r}", name=name, obj=self)
        path, load, _ = file
        if not path.is_file():
            raise ModelError(f"the shapes of {vars(self).get('name')} are in {path}, which is not here")
        self.collision = load()
        self._file = path, load, self.collision
        return self.collision

    def __getstate__(self) -> dict[str, Any]:
        """Return all but what is computed or loaded when it is asked for."""
        state = {name: value for name, value in vars(self).items() if name not in ("data", "visual")}
        if self._file is not None and state.get("collision") is self._file[2]:
            state.pop("collision", None)
            state["_file"] = *self._file[:2], None
        return state

    def __copy__(self) -> Any:
        out = object.__new__(type(self))
        vars(out).update(vars(self))
        return out

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        memo[id(self)] = out = object.__new__(type(self))
        vars(out).update(copy.deepcopy(vars(self), memo))
        return out
