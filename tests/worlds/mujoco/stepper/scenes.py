"""Small models that more than one test of the stepper uses."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from surefoot.base.arrays import FloatArray

BOX = '<freejoint/><geom name="{name}" type="box" size="{size}" friction="{mu} 0.005 0.0001" condim="{dim}"/>'


def scene(*bodies: str, option: str = 'cone="elliptic"', extra: str = "", mu: float = 0.5) -> Any:
    """Return a model of bodies over a plane."""
    plane = f'<geom name="floor" type="plane" size="9 9 1" friction="{mu} 0.005 0.0001"/>'
    world = f"<worldbody>{plane}{''.join(bodies)}</worldbody>"
    return mujoco.MjModel.from_xml_string(f"<mujoco><option {option}/>{world}{extra}</mujoco>")


def box(
    pos: str = "0 0 0.1",
    size: str = "0.1 0.1 0.1",
    mu: float = 0.5,
    dim: int = 3,
    turn: str = "",
    name: str = "box",
) -> str:
    """Return a free box."""
    return f'<body pos="{pos}" {turn}>{BOX.format(size=size, mu=mu, dim=dim, name=name)}</body>'


def arm(limits: str = "-60 60", extra: str = "", damping: float = 0.0, dry: float = 0.0) -> str:
    """Return two links on hinges, high above the ground."""
    joint = f'damping="{damping}" frictionloss="{dry}" armature="0.01"'
    return (
        f'<body name="one" pos="0 0 3"><joint name="first" axis="0 1 0" range="{limits}" {joint}/>'
        '<geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.04" contype="0" conaffinity="0"/>'
        f'<body name="two" pos="0.5 0 0"><joint name="second" axis="0 1 0" {joint}/>'
        '<geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.04" contype="0" conaffinity="0"/>'
        f"{extra}</body></body>"
    )


def row_velocities(model: Any, data: Any, rows: FloatArray) -> FloatArray:
    """Return what rows (n, nv) of a Jacobian say of the data's velocity now."""
    return np.asarray(rows.reshape(-1, model.nv) @ data.qvel)
