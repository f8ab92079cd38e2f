"""Robots known by name: where their files lie in example-robot-data, and which frames are feet."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from surefoot.errors import MissingExtra, ModelError, unknown_name

STANDARD_FEET = ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
ANYMAL_FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
SOLO_FEET = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")


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
    """

    urdf: str
    srdf: str | None = None
    feet: tuple[str, ...] = ()
    fixed_base: bool = False


CATALOG: dict[str, CatalogEntry] = {
    "go2": CatalogEntry("go2_description/urdf/go2.urdf", "go2_description/srdf/go2.srdf", STANDARD_FEET),
    "go1": CatalogEntry("go1_description/urdf/go1.urdf", "go1_description/srdf/go1.srdf", STANDARD_FEET),
    "a1": CatalogEntry("a1_description/urdf/a1.urdf", "a1_description/srdf/a1.srdf", STANDARD_FEET),
    "b1": CatalogEntry("b1_description/urdf/b1.urdf", "b1_description/srdf/b1.srdf", STANDARD_FEET),
    "laikago": CatalogEntry("laikago_description/urdf/laikago.urdf", None, STANDARD_FEET),
    "anymal_b": CatalogEntry(
        "anymal_b_simple_description/robots/anymal.urdf",
        "anymal_b_simple_description/srdf/anymal.srdf",
        ANYMAL_FEET,
    ),
    "anymal_c": CatalogEntry(
        "anymal_c_simple_description/urdf/anymal.urdf",
        "anymal_c_simple_description/srdf/anymal.srdf",
        ANYMAL_FEET,
    ),
    "hyq": CatalogEntry(
        "hyq_description/robots/hyq_no_sensors.urdf",
        "hyq_description/srdf/hyq.srdf",
        ("lf_foot", "rf_foot", "lh_foot", "rh_foot"),
    ),
    "solo12": CatalogEntry(
        "solo_description/robots/solo12.urdf", "solo_description/srdf/solo.srdf", SOLO_FEET
    ),
    "g1": CatalogEntry(
        "g1_description/urdf/g1_29dof_rev_1_0.urdf", None, ("left_ankle_roll_link", "right_ankle_roll_link")
    ),
    "panda": CatalogEntry("panda_description/urdf/panda.urdf", "panda_description/srdf/panda.srdf", (), True),
    "ur5": CatalogEntry("ur_description/urdf/ur5_robot.urdf", "ur_description/srdf/ur5.srdf", (), True),
}
ALIASES = {"anymal": "anymal_b", "solo": "solo12"}


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
    if key not in CATALOG:
        raise ModelError(unknown_name("robot", name, CATALOG) + " (or give a URDF file)")
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
