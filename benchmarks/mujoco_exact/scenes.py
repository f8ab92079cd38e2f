"""Scenes of the benchmark of MuJoCo's step beside the exact one."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

import surefoot as sf

BOX = (
    '<body pos="{at}"><freejoint/>'
    '<geom type="box" size="{size}" mass="{mass}" friction="{mu}" condim="{dim}"/></body>'
)
HOLD, SLOW = 2.0, 0.02
"""Stiffness of a joint over the weight [m/rad], and its damping over the stiffness [s]."""
PLANE = (("slide", "1 0 0"), ("slide", "0 0 1"), ("hinge", "0 1 0"))
"""Joints of what moves in a plane: type and axis."""
GRASP = 0.03
"""Half the width of what is pinched [m]."""


def bodies(*parts: str, option: str = "", extra: str = "", mu: float = 0.5) -> Any:
    """Return a model of bodies over a plane, elliptic cones."""
    floor = f'<geom name="ground" type="plane" size="99 99 1" friction="{mu}"/>'
    world = f"<worldbody>{floor}{''.join(parts)}</worldbody>"
    text = f'<mujoco><option cone="elliptic" {option}/>{world}{extra}</mujoco>'
    return mujoco.MjModel.from_xml_string(text)


def box(
    at: str = "0 0 0.1", size: str = "0.1 0.1 0.1", mass: float = 1.0, mu: float = 0.5, dim: int = 3
) -> str:
    """Return a free box."""
    return BOX.format(at=at, size=size, mass=mass, mu=mu, dim=dim)


def stack(count: int) -> Any:
    """Return boxes on each other."""
    return bodies(*(box(f"0 0 {0.1 + 0.2 * k}") for k in range(count)))


def painleve_rod(half: float = 0.5, steep: float = np.arctan(2.0), mu: float = 2.0) -> Any:
    """Return a rod in a plane, its lower tip ahead and on the ground.

    Sliding has no solution beyond mu = (1 + 3 c²) / (3 s c), with c and s of the angle to the ground: the rod
    jams at once (P. Painlevé, "Sur les lois du frottement de glissement", Comptes rendus 121, 1895).
    """
    x, z, thin = half * np.cos(steep), half * np.sin(steep), 1e-3
    joints = "".join(f'<joint type="{kind}" axis="{axis}"/>' for kind, axis in PLANE)
    inertia = f'mass="1" pos="0 0 0" diaginertia="{half**2 / 3.0} {half**2 / 3.0} {half**2 / 3.0}"'
    tip = f'pos="{x} 0 {-z}"'
    return bodies(
        f'<body pos="0 0 {z + thin}">{joints}<inertial {inertia}/><site {tip}/>'
        f'<geom size="{thin}" {tip} friction="{mu}"/></body>',
    )  # fmt: skip


def pinch() -> Any:
    """Return a part between two fingers on slides, pressed by motors, off the ground."""
    finger = (
        '<body pos="{x} 0 1"><joint name="{n}" type="slide" axis="1 0 0" damping="5"/>'
        '<geom type="sphere" size="0.02" mass="0.1" friction="1" condim="4"/></body>'
    )
    left = finger.format(x=-GRASP - 0.02, n="left")
    right = finger.format(x=GRASP + 0.02, n="right")
    part = box("0 0 1", f"{GRASP} {GRASP} {GRASP}", mass=0.1, mu=1.0, dim=4)
    return bodies(
        left, right, part,
        extra='<actuator><motor joint="left"/><motor joint="right"/></actuator>',
    )  # fmt: skip


def hand() -> Any:
    """Return a ball in a cup of 32 small spheres on dry slides."""
    parts = []
    for k in range(32):
        angle, height = 2.0 * np.pi * (k % 16) / 16, 0.05 + 0.05 * (k // 16)
        x, y = 0.12 * np.cos(angle), 0.12 * np.sin(angle)
        parts.append(
            f'<body pos="{x:.6f} {y:.6f} {height}"><joint type="slide" axis="{-x:.6f} {-y:.6f} 0" '
            'stiffness="50" springref="0.03" damping="2"/>'
            '<geom size="0.02" mass="0.02" contype="2" conaffinity="1"/></body>'
        )
    ball = (
        '<body pos="0 0 0.1"><freejoint/>'
        '<geom type="sphere" size="0.1" mass="1" contype="1" conaffinity="3"/></body>'
    )
    return bodies(*parts, ball)


def robot(name: str) -> tuple[Any, Any]:
    """Return the model of a robot that its joints' springs hold, and its start."""
    world = sf.MujocoWorld(sf.load_robot(name), mu=0.7)
    model, start = world.model, world.data
    joints, weight = world.robot.joints, world.robot.mass * 9.81
    # springs at the joints and damping that Euler's method takes implicitly: explicit
    # control of wrists is not stable
    model.jnt_stiffness[-joints:], model.qpos_spring[-joints:] = HOLD * weight, start.qpos[-joints:]
    model.dof_damping[-joints:] = SLOW * HOLD * weight
    return model, start


def still(data: Any) -> None:
    """Ask nothing of the motors."""


def press(data: Any) -> None:
    """Press both fingers with 4 N."""
    data.ctrl[:] = 4.0, -4.0
