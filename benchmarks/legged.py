"""Made-up robots with any number of equal legs on point feet, written as URDF and as MJCF.

Their shapes overlap, as those of many files do: thighs reach into the body.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

WIDE, THIGH, SHANK, FOOT = 0.06, 0.2, 0.2, 0.02
"""How far a thigh is beside its hip, the lengths of thigh and shank, and the foot's radius [m]."""
RANGES = ((-1.0, 1.0), (-1.5, 3.0), (-2.6, -0.4))
"""Of hip, thigh and knee [rad]."""
EFFORT, SPEED = 40.0, 25.0
PARTS = (
    ("hip", 0.6, 0.0, (6e-4, 6e-4, 6e-4)),
    ("thigh", 0.8, -0.08, (3e-3, 3e-3, 6e-4)),
    ("shank", 0.2, -0.09, (8e-4, 8e-4, 5e-5)),
)
"""Name, mass [kg], height of the centre of mass [m] and moments of inertia [kg m²] of a leg's links."""
BODY_MASS, BODY_INERTIA = 6.0, (0.03, 0.09, 0.1)


def leg_places(legs: int) -> dict[str, tuple[float, float]]:
    """Return where the hips are [m]: pairs from front to back, left before right; an odd one is last."""
    rows = legs // 2
    ends = 0.2 * max(rows - 1, 1)
    along = np.linspace(ends, -ends, rows) if rows > 1 else np.array([0.15])
    places = {
        f"{side}{k}": (float(x), y) for k, x in enumerate(along) for side, y in (("l", 0.1), ("r", -0.1))
    }
    if legs % 2:
        places["back"] = (float(along[-1]) - 0.3, 0.0)
    return places


def write_legged(folder: Path, legs: int, form: str = "urdf", limits: bool = True) -> tuple[Path, list[str]]:
    """Write a robot with so many legs as "urdf" or "xml"; return the file and its feet.

    Without `limits` nothing is said of torques and speeds.
    """
    make, whole = (_urdf_leg, _URDF) if form == "urdf" else (_mjcf_leg, _MJCF)
    places = leg_places(legs)
    text = "".join(make(name, x, y, limits) for name, (x, y) in places.items())
    path = folder / f"legged{legs}{'' if limits else '_free'}.{form}"
    xx, yy, zz = BODY_INERTIA
    path.write_text(whole.format(mass=BODY_MASS, xx=xx, yy=yy, zz=zz, legs=text))
    return path, [f"{name}_foot" for name in places]


_URDF = """<robot name="legged"><link name="body"><inertial><mass value="{mass}"/>
<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="0.5 0.3 0.1"/></geometry></collision></link>{legs}</robot>"""
_URDF_PART = """
<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/>
<inertia ixx="{I[0]}" iyy="{I[1]}" izz="{I[2]}" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0 0 -0.1"/><geometry><cylinder radius="0.05" length="0.1"/></geometry></collision>
</link><joint name="{name}_joint" type="revolute"><parent link="{parent}"/><child link="{name}"/>
<origin xyz="{at}"/><axis xyz="{axis}"/>
<limit lower="{low}" upper="{high}" effort="{effort}" velocity="{speed}"/></joint>"""
_URDF_FOOT = """
<link name="{n}_foot"><collision><geometry><sphere radius="{r}"/></geometry></collision></link>
<joint name="{n}_ankle" type="fixed"><parent link="{n}_shank"/><child link="{n}_foot"/>
<origin xyz="0 0 {z}"/></joint>"""
_MJCF = """<mujoco><compiler angle="radian"/><worldbody><body name="body" pos="0 0 0.5"><freejoint/>
<inertial pos="0 0 0" mass="{mass}" diaginertia="{xx} {yy} {zz}"/>
<geom type="box" size="0.25 0.15 0.05"/>{legs}</body></worldbody></mujoco>"""
_MJCF_PART = """
<body name="{name}" pos="{at}"><inertial pos="0 0 {z}" mass="{mass}" diaginertia="{I[0]} {I[1]} {I[2]}"/>
<joint name="{name}_joint" axis="{axis}" range="{low} {high}" {most}/>
<geom type="cylinder" size="0.05 0.05" pos="0 0 -0.1"/>"""
_MJCF_FOOT = '<geom name="{n}_foot" type="sphere" size="{r}" pos="0 0 {z}"/></body></body></body>'


def _parts(n: str, x: float, y: float) -> list[dict[str, object]]:
    """Return the links of a leg as the words of a file."""
    at = f"{x} {y} 0", f"0 {np.sign(y) * WIDE} 0", f"0 0 {-THIGH}"
    axes = "1 0 0", "0 1 0", "0 1 0"
    parents = "body", f"{n}_hip", f"{n}_thigh"
    return [
        {"name": f"{n}_{name}", "mass": mass, "z": z, "I": inertia, "at": at[k], "axis": axes[k],
         "parent": parents[k], "low": RANGES[k][0], "high": RANGES[k][1]}
        for k, (name, mass, z, inertia) in enumerate(PARTS)
    ]  # fmt: skip


def _urdf_leg(n: str, x: float, y: float, limits: bool) -> str:
    most = {"effort": EFFORT, "speed": SPEED} if limits else {"effort": 0, "speed": 0}
    parts = "".join(_URDF_PART.format(**part, **most) for part in _parts(n, x, y))
    return parts + _URDF_FOOT.format(n=n, r=FOOT, z=-SHANK)


def _mjcf_leg(n: str, x: float, y: float, limits: bool) -> str:
    most = f'actuatorfrcrange="{-EFFORT} {EFFORT}"' if limits else ""
    parts = "".join(_MJCF_PART.format(**part, most=most) for part in _parts(n, x, y))
    return parts + _MJCF_FOOT.format(n=n, r=FOOT, z=-SHANK)
