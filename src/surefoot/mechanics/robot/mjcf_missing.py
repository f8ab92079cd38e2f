"""MJCF files some of whose meshes are not there: each costs the shapes that it draws, and is named."""

from __future__ import annotations

import math
import re
from pathlib import Path, PurePath
from typing import Any

from surefoot.base.errors import ModelError, one_line

_OPENING = re.compile(
    r"rror opening file '([^']*)'|resource not found[^']*'([^']*)'|file not found[^']*'([^']*)'"
)


def compile_present(mujoco: Any, path: Path) -> tuple[Any, dict[str, list[str]]]:
    """Return MuJoCo's model of a file, and the meshes that it had to do without, by body.

    Textures and height fields are no part of a robot's mechanics: those that are missing are left out
    unnamed.

    Raises
    ------
    ModelError
        For a body whose mass would come from a mesh that is missing.
    ValueError, OSError
        From MuJoCo, for a file that it cannot read for another reason.
    """
    try:
        return mujoco.MjModel.from_xml_path(str(path)), {}
    except ValueError as error:
        if _missing_file(error) is None:
            raise
    return _without_missing(mujoco, path)[1:]


def read_present(mujoco: Any, path: Path) -> tuple[Any, Any]:
    """Return the MjSpec of a file and its model, without the meshes that are not there.

    Raises
    ------
    ModelError
        For a body whose mass would come from a mesh that is missing.
    ValueError, OSError
        From MuJoCo, for a file that it cannot read for another reason.
    """
    return _without_missing(mujoco, path)[:2]


def _without_missing(mujoco: Any, path: Path) -> tuple[Any, Any, dict[str, list[str]]]:
    """Return specification and model of a file without what is missing, and the missing meshes by body."""
    gone: list[str] = []
    while True:
        # a specification that failed to compile cannot be changed any more: read it again
        spec = mujoco.MjSpec.from_file(str(path))
        missing: dict[str, list[str]] = {}
        for name in gone:
            _drop_mesh(spec, name, path, missing)
            _drop_picture(spec, name)
        try:
            return spec, spec.compile(), missing
        except ValueError as error:
            file = _missing_file(error)
            if file is None or file in gone:
                raise
            gone.append(file)


def _missing_file(error: Exception) -> str | None:
    """Return the name, without its folder, of the file that MuJoCo did not find."""
    found = _OPENING.search(one_line(error))
    return None if found is None else PurePath(next(name for name in found.groups() if name)).name


def _drop_mesh(spec: Any, file: str, path: Path, missing: dict[str, list[str]]) -> None:
    """Take the meshes of a file and their geoms out of an MjSpec."""
    gone = [mesh for mesh in spec.meshes if PurePath(mesh.file).name == file]
    names = {mesh.name or PurePath(mesh.file).stem for mesh in gone}
    for body in spec.bodies:
        for geom in [geom for geom in body.geoms if geom.meshname in names]:
            weighs = (geom.density if math.isnan(geom.mass) else geom.mass) > 0.0
            if weighs and not body.explicitinertial and body.name != "world":
                raise ModelError(
                    f"{path}: the mass of body {body.name} is that of the mesh {file}, which is not there. "
                    "Put the file where the model looks for it"
                )
            if geom.contype or geom.conaffinity:
                listed = missing.setdefault(body.name, [])
                listed += [] if file in listed else [file]
            spec.delete(geom)
    for mesh in gone:
        spec.delete(mesh)


def _drop_picture(spec: Any, file: str) -> None:
    """Take textures and height fields of a file out of an MjSpec."""
    gone = [t for t in spec.textures if PurePath(t.file).name == file or file in map(_name, t.cubefiles)]
    for texture in gone:
        for material in spec.materials:
            material.textures = ["" if name == texture.name else name for name in material.textures]
        spec.delete(texture)
    fields = [field for field in spec.hfields if PurePath(field.file).name == file]
    for field in fields:
        for geom in [g for body in spec.bodies for g in body.geoms if g.hfieldname == field.name]:
            spec.delete(geom)
        spec.delete(field)


def _name(file: str) -> str:
    return PurePath(file).name
