"""The engines whose contact parameters are known."""

from __future__ import annotations

ENGINES: dict[str, tuple[str, str]] = {
    "physical": ("physical", "PhysicalContact"),
    "hunt-crossley": ("physical", "HuntCrossleyContact"),
    "mujoco": ("mujoco", "MujocoContact"),
    "drake": ("drake", "DrakeContact"),
    "drake-hunt-crossley": ("drake", "DrakeHuntCrossleyContact"),
    "drake-hydroelastic": ("drake", "DrakeHydroelasticContact"),
    "physx": ("physx", "PhysxContact"),
    "isaaclab": ("physx", "IsaacLabContact"),
    "ode": ("ode", "OdeContact"),
    "bullet": ("ode", "BulletContact"),
}
"""Name -> (file of this folder, class): an engine is one file and one line."""
