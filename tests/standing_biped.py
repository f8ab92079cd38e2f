"""Made-up robots on two legs of six joints, whose feet are given as text: URDF and MJCF."""

from __future__ import annotations

from pathlib import Path

BOX = '<collision><origin xyz="0.03 0 -0.04"/><geometry><box size="0.2 0.1 0.03"/></geometry></collision>'
SPHERES = "".join(
    f'<geom{{name{k}}} class="contact" type="sphere" size="0.01" pos="{x} {y} -0.05"/>'
    for k, (x, y) in enumerate([(0.11, 0.03), (0.11, -0.03), (-0.05, 0.03), (-0.05, -0.03)])
)
JOINTS = (
    ("yaw", "0 0 1", "0 0 0", 0.5), ("roll", "1 0 0", "0 0 0", 1.0), ("pitch", "0 1 0", "0 0 0", 2.0),
    ("knee", "0 1 0", "0 0 -0.35", 1.5), ("ankle", "0 1 0", "0 0 -0.35", 0.3),
    ("foot", "1 0 0", "0 0 0", 0.6),
)  # fmt: skip
"""Name, axis, place in the parent and mass [kg] of a leg's links; the last one is the foot."""
RANGES = {"knee": "0 2.2", "pitch": "-1.6 1.0"}


def write_biped(
    folder: Path, foot: str, *, body: str = "", roll: bool = True, ankle_rpy: str = "0 0 0", toe: str = ""
) -> Path:
    """Write the robot as URDF, with the collision elements of both feet and of the body.

    Without `roll` the foot is fixed to the ankle; with a `toe`, collision elements, it has a toe joint. The
    foot's frame is turned by `ankle_rpy` [rad].
    """
    sides = (("left", 0.1), ("right", -0.1))
    legs = "".join(
        _urdf_leg(side, y, foot, roll, ankle_rpy) + (_toe(side, toe) if toe else "") for side, y in sides
    )
    inertia = '<inertia ixx="0.4" iyy="0.4" izz="0.3" ixy="0" ixz="0" iyz="0"/>'
    text = (
        f'<robot name="biped"><link name="body"><inertial><origin xyz="0 0 0.25"/><mass value="20"/>{inertia}'
    )
    path = folder / "biped.urdf"
    path.write_text(f"{text}</inertial>{body}</link>{legs}</robot>")
    return path


def _toe(side: str, shape: str) -> str:
    return (
        f'<link name="{side}_toe"><inertial><mass value="0.1"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" '
        f'ixy="0" ixz="0" iyz="0"/></inertial>{shape}</link><joint name="{side}_toe_joint" type="revolute">'
        f'<parent link="{side}_foot"/><child link="{side}_toe"/><origin xyz="0.13 0 -0.04"/>'
        '<axis xyz="0 1 0"/>'
        '<limit lower="-0.5" upper="0.5" effort="20" velocity="20"/></joint>'
    )


def _urdf_leg(side: str, y: float, foot: str, roll: bool, ankle_rpy: str) -> str:
    out, parent = "", "body"
    for name, axis, place, mass in JOINTS:
        at = f"0 {y} 0" if parent == "body" else place
        last = name == "foot"
        moment = 0.01 * mass
        kind = "fixed" if last and not roll else "revolute"
        low, high = RANGES.get(name, "-1.2 1.2").split()
        turned = ankle_rpy if last else "0 0 0"
        out += (
            f'<link name="{side}_{name}"><inertial><origin xyz="0 0 -0.02"/><mass value="{mass}"/>'
            f'<inertia ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0"/></inertial>'
            f'{foot if last else ""}</link><joint name="{side}_{name}_joint" type="{kind}">'
            f'<parent link="{parent}"/><child link="{side}_{name}"/><origin xyz="{at}" rpy="{turned}"/>'
            f'<axis xyz="{axis}"/><limit lower="{low}" upper="{high}" effort="200" velocity="20"/></joint>'
        )
        parent = f"{side}_{name}"
    return out


def write_biped_mjcf(
    folder: Path, foot: str, named: bool = False, *, asset: str = "", body: str = ""
) -> Path:
    """Write the robot as MJCF with default classes, with the geoms of both feet and of the body.

    "{name0}" to "{name3}" in the feet's geoms become names if they are `named`.
    """
    legs = "".join(_mjcf_leg(side, y, foot, named) for side, y in (("left", 0.1), ("right", -0.1)))
    path = folder / "biped.xml"
    body = body.replace("<geom", '<geom contype="1"')
    path.write_text(
        '<mujoco><compiler angle="radian" autolimits="true"/><default><geom contype="0" conaffinity="0"/>'
        '<default class="contact"><geom contype="1" conaffinity="1"/><default class="pad">'
        '<geom type="box" size="0.09 0.04 0.01"/></default></default>'
        '<default class="drawn"><geom group="2"/></default></default>'
        f'{asset}<worldbody><body name="body" pos="0 0 1"><freejoint/><inertial pos="0 0 0.25" mass="20" '
        f'diaginertia="0.4 0.4 0.3"/>{body}{legs}</body></worldbody></mujoco>'
    )
    return path


def _mjcf_leg(side: str, y: float, foot: str, named: bool) -> str:
    out = ""
    for name, axis, place, mass in JOINTS:
        at = f"0 {y} 0" if not out else place
        moment = 0.01 * mass
        out += (
            f'<body name="{side}_{name}" pos="{at}"><inertial pos="0 0 -0.02" mass="{mass}" '
            f'diaginertia="{moment} {moment} {moment}"/><joint name="{side}_{name}_joint" axis="{axis}" '
            f'range="{RANGES.get(name, "-1.2 1.2")}" actuatorfrcrange="-200 200"/>'
        )
    for k in range(4):
        foot = foot.replace(f"{{name{k}}}", f' name="{side}_ball_{k}"' if named else "")
    return out + foot + "</body>" * len(JOINTS)
