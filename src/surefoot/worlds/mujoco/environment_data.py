"""The MjModel and MjData of environments for reinforcement learning, whoever wrote them."""

from __future__ import annotations

from typing import Any

from surefoot.base.errors import ProblemError


def model_and_data(mujoco: Any, core: Any, who: str = "AuditWrapper") -> tuple[Any, Any]:
    """Return the MjModel and MjData of an environment without wrappers; `who` asks for them.

    Raises
    ------
    ProblemError
        If it has none.
    """
    model, data = getattr(core, "model", None), getattr(core, "data", None)
    if isinstance(model, mujoco.MjModel) and isinstance(data, mujoco.MjData):
        return model, data
    physics = getattr(core, "physics", None) or getattr(getattr(core, "_env", None), "physics", None)
    model, data = (getattr(getattr(physics, name, None), "ptr", None) for name in ("model", "data"))
    if isinstance(model, mujoco.MjModel) and isinstance(data, mujoco.MjData):
        return model, data
    raise ProblemError(
        f"{who} takes an environment with MuJoCo's .model and .data, or dm_control's .physics, got "
        f"{type(core).__name__}"
    )
