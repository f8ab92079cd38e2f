"""Robots known by name: where their files lie in example-robot-data, and which frames are feet."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from surefoot.errors import MissingExtra, ModelError, unknown_name

STANDARD_FEET = ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
ANYMAL_FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
SOLO_FEET = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")
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
    """Return the shape of a foot or wheel that touches the ground like a sphere about its frame's origin."""
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
    """

    urdf: str
    srdf: str | None = None
    feet: tuple[str, ...] = ()
    fixed_base: bool = False
    shapes: tuple[FootShape, ...] = ()
    pose: str | None = None
    upright: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    unlimited: tuple[str, ...] = ()


# measured on the meshes that the files draw: the largest rectangle inside the part of a foot's underside that
# is level to 4 mm; a test holds them against the meshes
TALOS_SOLES = (sole((-0.104, 0.093), (-0.059, 0.059), 0.0),) * 2
ROMEO_SOLES = (
    sole((-0.069, 0.116), (-0.028, 0.041), 0.001),
    sole((-0.069, 0.116), (-0.041, 0.028), 0.001),
)
ICUB_SOLES = (sole((-0.045, 0.1), (-0.025, 0.025), 0.0),) * 2
ALEXANDER_SOLES = (sole((-0.045, 0.146), (-0.042, 0.042), -0.072),) * 2

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
    "solo8": CatalogEntry("solo_description/robots/solo.urdf", "solo_description/srdf/solo.srdf", SOLO_FEET),
    "b1_z1": CatalogEntry(
        "b1_description/urdf/b1-z1.urdf",
        "b1_description/srdf/b1-z1.srdf",
        STANDARD_FEET,
        pose="standing_with_arm_home",
    ),
    "anymal_kinova": CatalogEntry(
        "anymal_b_simple_description/robots/anymal-kinova.urdf",
        "anymal_b_simple_description/srdf/anymal-kinova.srdf",
        ANYMAL_FEET,
        pose="standing_with_arm_up",
    ),
    "quadruped": CatalogEntry(
        "quadruped_description/urdf/quadruped.urdf",
        None,
        ("FL_contact", "FR_contact", "BL_contact", "BR_contact"),
        unlimited=("FL_KFE", "FR_KFE", "BL_KFE", "BR_KFE"),  # its file leaves them at [0, 0]
    ),
    "centauro": CatalogEntry(
        "centauro_description/urdf/centauro.urdf",
        "centauro_description/srdf/centauro.srdf",
        ("wheel_1", "wheel_2", "wheel_3", "wheel_4"),
        shapes=(ball(0.124),) * 4,
        pose="homing_nominal",
    ),
    "bolt": CatalogEntry(
        "bolt_description/robots/bolt.urdf", "bolt_description/srdf/bolt.srdf", SOLO_FEET[:2]
    ),
    "talos": CatalogEntry(
        "talos_data/robots/talos_reduced.urdf",
        "talos_data/srdf/talos.srdf",
        ("left_sole_link", "right_sole_link"),
        shapes=TALOS_SOLES,
    ),
    "talos_full": CatalogEntry(
        "talos_data/robots/talos_full_v2.urdf",
        "talos_data/srdf/talos.srdf",
        ("left_sole_link", "right_sole_link"),
        shapes=TALOS_SOLES,
    ),
    "romeo": CatalogEntry(
        "romeo_description/urdf/romeo_small.urdf",
        "romeo_description/srdf/romeo_small.srdf",
        ("l_sole", "r_sole"),
        shapes=ROMEO_SOLES,
    ),
    "romeo_full": CatalogEntry(
        "romeo_description/urdf/romeo.urdf",
        "romeo_description/srdf/romeo.srdf",
        ("l_sole", "r_sole"),
        shapes=ROMEO_SOLES,
    ),
    "icub_full": CatalogEntry(
        "icub_description/robots/icub.urdf",
        "icub_description/srdf/icub.srdf",
        ("l_sole", "r_sole"),
        shapes=ICUB_SOLES,
    ),
    "icub": CatalogEntry(
        "icub_description/robots/icub_reduced.urdf",
        "icub_description/srdf/icub.srdf",
        ("l_sole", "r_sole"),
        shapes=ICUB_SOLES,
    ),
    "alexander": CatalogEntry(
        "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf",
        "alexander_description/srdf/alexander.srdf",
        ("LEFT_FOOT", "RIGHT_FOOT"),
        shapes=ALEXANDER_SOLES,
        pose="default",
    ),
    "simple_humanoid": CatalogEntry(
        "simple_humanoid_description/urdf/simple_humanoid.urdf",
        "simple_humanoid_description/srdf/simple_humanoid.srdf",
        ("l_ankle", "r_ankle"),
        unlimited=("LLEG_", "RLEG_"),  # its file gives joints the limits of their neighbours
    ),
    "human": CatalogEntry(  # a skeleton with its y axis up
        "human_description/robots/human.urdf",
        None,
        ("left_foot", "right_foot"),
        shapes=(ball(0.076),) * 2,
        upright=(0.5**0.5, 0.0, 0.0, 0.5**0.5),
    ),
    "g1_with_hands": CatalogEntry(
        "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
        None,
        ("left_ankle_roll_link", "right_ankle_roll_link"),
    ),
    "g1": CatalogEntry(
        "g1_description/urdf/g1_29dof_rev_1_0.urdf", None, ("left_ankle_roll_link", "right_ankle_roll_link")
    ),
    "panda": CatalogEntry("panda_description/urdf/panda.urdf", "panda_description/srdf/panda.srdf", (), True),
    "ur5": CatalogEntry("ur_description/urdf/ur5_robot.urdf", "ur_description/srdf/ur5.srdf", (), True),
}
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
