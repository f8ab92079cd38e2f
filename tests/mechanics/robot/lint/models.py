"""A small four-legged robot of our own making, as URDF and as MJCF, for faults to be put in."""

from __future__ import annotations

LEGS = {"FL": (0.2, 0.1), "FR": (0.2, -0.1), "RL": (-0.2, 0.1), "RR": (-0.2, -0.1)}
FEET = ",".join(f"{leg}_foot" for leg in LEGS)


def _link(name: str, mass: float, moment: float, shape: str) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="0 0 -0.01"/><mass value="{mass}"/>'
        f'<inertia ixx="{moment}" ixy="0" ixz="0" iyy="{moment}" iyz="0" izz="{moment}"/></inertial>'
        f"<collision><geometry>{shape}</geometry></collision></link>\n"
    )


def _hinge(name: str, parent: str, child: str, place: str, axis: str, low: float, high: float) -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}"/><axis xyz="{axis}"/>'
        f'<limit lower="{low}" upper="{high}" effort="30" velocity="20"/>'
        f'<dynamics damping="0.01"/></joint>\n'
    )


def urdf() -> str:
    """Return the robot as a URDF file without a fault."""
    out = ['<robot name="dog">\n', _link("trunk", 8.0, 0.1, '<box size="0.4 0.2 0.1"/>')]
    for leg, (x, y) in LEGS.items():
        side = 0.05 if y > 0.0 else -0.05
        out += [
            _link(f"{leg}_hip", 0.5, 5e-4, '<sphere radius="0.02"/>'),
            _link(f"{leg}_thigh", 0.8, 4e-3, '<box size="0.03 0.03 0.1"/>'),
            _link(f"{leg}_calf", 0.2, 1e-3, '<box size="0.02 0.02 0.1"/>'),
            _link(f"{leg}_foot", 0.05, 1e-5, '<sphere radius="0.02"/>'),
            _hinge(f"{leg}_roll", "trunk", f"{leg}_hip", f"{x} {y} 0", "1 0 0", -0.8, 0.8),
            _hinge(f"{leg}_pitch", f"{leg}_hip", f"{leg}_thigh", f"0 {side} 0", "0 1 0", -2.0, 2.5),
            _hinge(f"{leg}_knee", f"{leg}_thigh", f"{leg}_calf", "0 0 -0.2", "0 1 0", -2.7, -0.3),
            f'<joint name="{leg}_ankle" type="fixed"><parent link="{leg}_calf"/>'
            f'<child link="{leg}_foot"/><origin xyz="0 0 -0.2"/></joint>\n',
        ]
    return "".join([*out, "</robot>\n"])


def _inertial(mass: float, moment: float) -> str:
    return f'<inertial pos="0 0 -0.01" mass="{mass}" diaginertia="{moment} {moment} {moment}"/>'


def mjcf() -> str:
    """Return the robot as an MJCF file without a fault: firm contacts, a floor, motors and a keyframe."""
    firm = 'solref="0.004 1" solimp="0.99 0.999 0.001"'
    out = [
        '<mujoco model="dog">\n<compiler angle="radian"/>\n<option timestep="0.002"/>\n'
        '<default><joint damping="0.01" armature="0.01"/></default>\n<worldbody>\n'
        f'<geom name="floor" type="plane" size="5 5 1" {firm}/>\n'
        '<body name="trunk" pos="0 0 0.4"><freejoint/>'
        + _inertial(8.0, 0.1)
        + '<geom type="box" size="0.2 0.1 0.05"/>\n'
    ]
    for leg, (x, y) in LEGS.items():
        side = 0.05 if y > 0.0 else -0.05
        out.append(
            f'<body name="{leg}_hip" pos="{x} {y} 0">{_inertial(0.5, 5e-4)}'
            f'<joint name="{leg}_roll" axis="1 0 0" range="-0.8 0.8"/>\n'
            f'<body name="{leg}_thigh" pos="0 {side} 0">{_inertial(0.8, 4e-3)}'
            f'<joint name="{leg}_pitch" axis="0 1 0" range="-2 2.5"/>\n'
            f'<body name="{leg}_calf" pos="0 0 -0.2">{_inertial(0.2, 1e-3)}'
            f'<joint name="{leg}_knee" axis="0 1 0" range="-2.7 -0.3"/>'
            f'<geom name="{leg}_foot" type="sphere" size="0.02" pos="0 0 -0.2" {firm}/>'
            f"</body></body></body>\n"
        )
    motors = "".join(
        f'<motor name="{leg}_{part}_motor" joint="{leg}_{part}" ctrlrange="-30 30"/>\n'
        for leg in LEGS
        for part in ("roll", "pitch", "knee")
    )
    pose = "0 0 0.331 1 0 0 0 " + " ".join(["0 0.7 -1.4"] * 4)
    out.append(f"</body></worldbody>\n<actuator>\n{motors}</actuator>\n")
    out.append(f'<keyframe><key name="home" qpos="{pose}"/></keyframe>\n</mujoco>\n')
    return "".join(out)
