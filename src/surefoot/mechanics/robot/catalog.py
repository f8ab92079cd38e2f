"""Robots known by name: where their files lie in example-robot-data, and which frames are feet."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, distribution
from importlib.resources import files
from pathlib import Path
from typing import Any

from surefoot.base.errors import MissingExtra, ModelError, unknown_name

EDGE = 0.005
"""Radius of the spheres at the corners of a sole that a catalogue entry describes [m]."""


@dataclass(frozen=True)
class FootShape:
    """Contact spheres of a foot, for robots whose files draw none or only meshes.

    Attributes
    ----------
    centres
        Centres of the spheres in the foot's frame [m].
    radius
        Their radius [m].
    """

    centres: tuple[tuple[float, float, float], ...]
    radius: float


def sole(x: tuple[float, float], y: tuple[float, float], z: float) -> FootShape:
    """Return the shape of a flat foot: its ends along the frame's x and y, height of its underside [m]."""
    (back, front), (right, left) = x, y
    back, front, right, left = back + EDGE, front - EDGE, right + EDGE, left - EDGE
    corners = ((front, left), (front, right), (back, right), (back, left))
    return FootShape(tuple((a, b, z + EDGE) for a, b in corners), EDGE)


def ball(radius: float) -> FootShape:
    """Return the shape of a foot that touches like a sphere of `radius` [m] about its frame's origin."""
    return FootShape(((0.0, 0.0, 0.0),), radius)


@dataclass(frozen=True)
class CatalogEntry:
    """A robot of example-robot-data.

    Attributes
    ----------
    urdf, srdf
        Paths below the robots' folder; the SRDF's "standing" or "half_sitting" pose is the nominal one.
    feet
        Frames that touch the ground, front to back, left before right.
    fixed_base
        Whether the robot is bolted to the world.
    shapes
        What touches the ground, foot by foot; empty for the collision geometry's word.
    pose
        Name of the SRDF's pose if it has another name.
    upright
        Quaternion (x, y, z, w) of the base when the robot stands up, without an SRDF pose.
    unlimited
        Beginnings of the names of joints whose position limits in the file are wrong or missing; they get
        half a turn either way.
    effort, speed
        Limits of every joint's motor [N m, rad/s] where the file's are none; zero where they are.
    bent
        Angles [rad] of joints whose names end so, in place of the SRDF's: nobody walks on straight knees.
    """

    urdf: str
    srdf: str | None = None
    feet: tuple[str, ...] = ()
    fixed_base: bool = False
    shapes: tuple[FootShape, ...] = ()
    pose: str | None = None
    upright: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    unlimited: tuple[str, ...] = ()
    effort: float = 0.0
    speed: float = 0.0
    bent: Mapping[str, float] = field(default_factory=dict)


def _entry(table: dict[str, Any]) -> CatalogEntry:
    """Return the entry of one table of robots.toml; `soles` and `ball` there are shapes here."""
    soles, radius = table.pop("soles", ()), table.pop("ball", None)
    for key in ("feet", "upright", "unlimited"):
        if key in table:
            table[key] = tuple(table[key])
    shapes = [sole(*ends) for ends in soles] if radius is None else [ball(radius)] * len(table["feet"])
    return CatalogEntry(**table, shapes=tuple(shapes))


_TABLES = tomllib.loads(files("surefoot.mechanics.robot").joinpath("robots.toml").read_text(encoding="utf-8"))
CATALOG: dict[str, CatalogEntry] = {name: _entry(table) for name, table in _TABLES.items()}
ALIASES = {"anymal": "anymal_b", "solo": "solo12"}
UNREADABLE = {
    "cassie": "example-robot-data has it only as an SDF file with closed linkages, which no URDF can hold; "
    "give a URDF file of it"
}
"""Legged robots of example-robot-data that cannot be loaded, and why."""


def robot_names() -> tuple[str, ...]:
    """Return the names that `load_robot` knows."""
    return tuple(sorted(CATALOG))


def find(name: str) -> CatalogEntry:
    """Return the catalogue entry of a robot.

    Raises
    ------
    ModelError
        If the name is unknown; the message lists the known ones.
    """
    key = ALIASES.get(name, name)
    if key in UNREADABLE:
        raise ModelError(f"{name} cannot be loaded by name: {UNREADABLE[key]}")
    if key not in CATALOG:
        raise ModelError(unknown_name("robot", name, CATALOG) + " (or give a .urdf or .xml file)")
    return CATALOG[key]


def robots_folder() -> Path:
    """Return the folder of example-robot-data that holds the robots' descriptions.

    Raises
    ------
    MissingExtra
        If example-robot-data is not installed.
    """
    try:
        package = distribution("example-robot-data")
    except PackageNotFoundError as error:
        raise MissingExtra("example-robot-data", "robot") from error
    return Path(str(package.locate_file("cmeel.prefix/share/example-robot-data/robots"))).resolve()
