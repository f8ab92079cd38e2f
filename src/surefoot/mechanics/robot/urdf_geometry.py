"""The shapes of a URDF file, of which a mesh that is not there costs itself alone."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from surefoot.mechanics.robot.parser_output import parser_output
from surefoot.mechanics.robot.urdf_ranges import spell_infinities

UNPACKED = 3
"""Folders above a file in which a package's files are sought without the package's own folder."""


def urdf_geometry(
    model: Any, path: Path, kind: Any, folders: Sequence[Path]
) -> tuple[Any, dict[str, list[str]]]:
    """Return Pinocchio's GeometryModel of a file, and the meshes that were not found or read, by link.

    Parameters
    ----------
    model
        Pinocchio's Model of the file.
    path
        The URDF file.
    kind
        Pinocchio's GeometryType.
    folders
        Where packages lie.
    """
    import pinocchio

    packages = [str(f) for f in folders]
    try:
        with parser_output():
            return pinocchio.buildGeomFromUrdf(model, str(path), kind, package_dirs=packages), {}
    except (ValueError, RuntimeError):  # a mesh that cannot be found or read stops the parser
        pass
    tag = "collision" if kind == pinocchio.GeometryType.COLLISION else "visual"
    try:
        tree = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError, UnicodeDecodeError, LookupError):
        return pinocchio.GeometryModel(), {}
    spell_infinities(tree)
    missing = _drop_missing(tree, tag, path, folders)
    built = _build_shapes(model, tree, kind, packages)
    if built is None:  # a mesh is there and no mesh: ask one by one
        for name in _meshes(tree, tag):
            alone = _only(tree, tag, name)
            if _build_shapes(model, alone, kind, packages) is None:
                _note(missing, _drop(tree, tag, name))
        built = _build_shapes(model, tree, kind, packages)
    return (pinocchio.GeometryModel() if built is None else built), missing


def mesh_file(filename: str, path: Path, folders: Sequence[Path]) -> Path | None:
    """Return the file that a URDF's word for a mesh means, None if there is none.

    Packages are looked for in the folders; a package without its own folder around it, as copies often are,
    in the file's folder and those above it.
    """
    plain = filename.removeprefix("file://")
    scheme, _, rest = filename.partition("://")
    inside = Path(rest) if scheme in ("package", "model") else Path(plain)
    if inside.is_absolute():
        return inside if inside.is_file() else None
    places = [folder / inside for folder in (path.parent, *folders)]
    if scheme in ("package", "model") and len(inside.parts) > 1:
        unpacked = Path(*inside.parts[1:])
        places += [folder / unpacked for folder in (path.parent, *path.resolve().parents[1 : UNPACKED + 1])]
    return next((place for place in places if place.is_file()), None)


def _drop_missing(tree: Any, tag: str, path: Path, folders: Sequence[Path]) -> dict[str, list[str]]:
    """Leave shapes out whose mesh is not there, and return them; the others get their files' full names."""
    missing: dict[str, list[str]] = {}
    for name in _meshes(tree, tag):
        found = mesh_file(name, path, folders)
        if found is None:
            _note(missing, _drop(tree, tag, name))
            continue
        for mesh in tree.iter("mesh"):
            if mesh.get("filename") == name:
                mesh.set("filename", str(found.resolve()))
    return missing


def _meshes(tree: Any, tag: str) -> list[str]:
    """Return the different meshes of a tree's collision or visual shapes."""
    names = [mesh.get("filename") or "" for shape in tree.iter(tag) for mesh in shape.iter("mesh")]
    return list(dict.fromkeys(names))


def _drop(tree: Any, tag: str, name: str) -> list[tuple[str, str]]:
    """Take the shapes of a mesh out of a tree; return their links, each with the mesh."""
    out = []
    for link in tree.iter("link"):
        for shape in list(link.findall(tag)):
            if any((mesh.get("filename") or "") == name for mesh in shape.iter("mesh")):
                link.remove(shape)
                out.append((link.get("name") or "", name))
    return out


def _only(tree: Any, tag: str, name: str) -> Any:
    """Return a tree with no other mesh than one."""
    import copy

    alone = copy.deepcopy(tree)
    for other in _meshes(alone, tag):
        if other != name:
            _drop(alone, tag, other)
    return alone


def _note(missing: dict[str, list[str]], dropped: Sequence[tuple[str, str]]) -> None:
    for link, name in dropped:
        names = missing.setdefault(link, [])
        if name not in names:
            names.append(name)


def _build_shapes(model: Any, tree: Any, kind: Any, packages: Sequence[str]) -> Any:
    """Return the GeometryModel of a tree, None where a mesh in it stops the parser."""
    import pinocchio

    text = ElementTree.tostring(tree, encoding="unicode")
    try:
        with parser_output():
            return pinocchio.buildGeomFromUrdfString(model, text, kind, package_dirs=list(packages))
    except (ValueError, RuntimeError):
        return None
