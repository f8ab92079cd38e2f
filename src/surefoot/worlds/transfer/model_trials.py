"""Runs of an MjModel under its own loop's control, in MuJoCo and in its exact step."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.mujoco.stepper.stepper import MujocoStepper
from surefoot.worlds.transfer.trial import TrialRun
from surefoot.worlds.transfer.variants import Variant

ENGINES = ("mujoco", "mujoco-exact")
"""Worlds of an MjModel."""
SPREAD = 0.01
"""Deviation of the velocities that a seed adds at the start [m/s, rad/s]: a judgement, too small to matter
where nothing stands on an edge."""
LOWEST, STEEPEST = 0.5, math.radians(60.0)
"""A free body has fallen below this share of its first height, or leans more than its first upright [rad]."""
STIFF_STEPS = 2.0
"""Time constant of MuJoCo's stiffest contact, in steps: the least that it takes."""
Loop: TypeAlias = Callable[[Any, Any], Any]
"""Sets the controls of a data before each step; see `surefoot.transfer`."""


class ModelTrials:
    """Runs of a model and a controller, or actions (T, nu), each from the same start but for its seed."""

    engines = ENGINES

    def __init__(
        self, model: Any, control: Any, duration: float | None, start: Any, success: Loop | None
    ) -> None:
        self._mujoco, self._model, self._control = import_mujoco(), model, control
        kinds, step = self._mujoco.mjtWarning, float(model.opt.timestep)
        self._lost = [
            int(kind) for kind in (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
        ]
        if callable(control):
            self._actions = None
            if duration is None:
                raise ProblemError("a controller of an MjModel takes a duration [s]")
        else:
            self._actions = finite_array("actions", control, (None, int(model.nu)))
            duration = len(self._actions) * step if duration is None else duration
        self._steps = max(1, round(duration / step))
        if self._actions is not None and self._steps > len(self._actions):
            raise ProblemError(f"there are {len(self._actions)} actions for {self._steps} steps")
        self._success = success
        self._start = self._first(start)

    def _first(self, start: Any) -> FloatArray:
        """Return the configuration at the start: given, the first keyframe's, or the model's own."""
        model = self._model
        if start is not None:
            return finite_array("start", start, (int(model.nq),))
        return np.array(model.key_qpos[0] if model.nkey else model.qpos0, dtype=np.float64)

    def run(self, variant: Variant, seed: int) -> TrialRun:
        """Return a run in a world."""
        mujoco, model = self._mujoco, self._model_of(variant)
        data = mujoco.MjData(model)
        data.qpos[:] = self._start
        data.qvel[:] = SPREAD * np.random.default_rng(seed).normal(size=model.nv)
        stepper = MujocoStepper(_elliptic(mujoco, model)) if variant.engine == "mujoco-exact" else None
        advance = (lambda: mujoco.mj_step(model, data)) if stepper is None else lambda: stepper.step(data)
        reader = model if stepper is None else stepper.model
        if hasattr(self._control, "reset"):
            self._control.reset()
        (stepper or _Plain(mujoco, model)).forward(data)
        height, up = _base(model, data)
        parts = 2 if variant.halved else 1
        times, rows = np.zeros(self._steps), np.full((self._steps, model.nq), np.nan)
        forces: dict[str, FloatArray] = {}
        for k in range(self._steps):
            times[k], rows[k] = data.time, data.qpos
            if self._actions is None:
                self._control(model, data)
            else:
                data.ctrl[:] = self._actions[k]
            for _ in range(parts):
                advance()
                self._add_forces(reader, data, forces, k, 1.0 / parts)
            if not np.isfinite(data.qpos).all() or any(data.warning[w].number for w in self._lost):
                # MuJoCo resets what it loses: that is no success, whatever comes of it
                return TrialRun(False, times, rows, forces, 0 if stepper is None else stepper.unsolved)
        good = self._stands(model, data, height, up) if self._success is None else self._success(model, data)
        return TrialRun(bool(good), times, rows, forces, 0 if stepper is None else stepper.unsolved)

    def _model_of(self, variant: Variant) -> Any:
        """Return a copy of the model as a world has it."""
        model = copy.copy(self._model)
        if variant.halved:
            model.opt.timestep *= 0.5
        if variant.friction != 1.0:
            model.geom_friction[:] *= variant.friction
            model.pair_friction[:] *= variant.friction
        if variant.stiff:
            ref = [STIFF_STEPS * model.opt.timestep, 1.0]
            model.geom_solref[:], model.pair_solref[:] = ref, ref
        return model

    def _add_forces(
        self, model: Any, data: Any, forces: dict[str, FloatArray], row: int, share: float
    ) -> None:
        """Add each contact's force of a step, in its own axes, to the row of its two geoms."""
        force = np.zeros(6)
        for c in np.flatnonzero(np.asarray(data.contact.efc_address) >= 0).tolist():
            self._mujoco.mj_contactForce(model, data, c, force)
            if force[0] > 0.0:
                name = " on ".join(_geom_name(model, g) for g in data.contact.geom[c].tolist())
                if name not in forces:
                    forces[name] = np.zeros((self._steps, 3))
                frame = np.asarray(data.contact.frame[c]).reshape(3, 3)
                forces[name][row] += share * (force[:3] @ frame)

    def _stands(self, model: Any, data: Any, height: float, up: FloatArray) -> bool:
        """Return whether a free body has not fallen; a model without one has done what it was to do."""
        if math.isnan(height):
            return True
        now, axis = _base(model, data)
        return bool(now > LOWEST * height and float(axis @ up) > math.cos(STEEPEST))


class _Plain:
    """MuJoCo itself, where a stepper is not asked for."""

    def __init__(self, mujoco: Any, model: Any) -> None:
        self._mujoco, self._model = mujoco, model

    def forward(self, data: Any) -> None:
        self._mujoco.mj_forward(self._model, data)


def _elliptic(mujoco: Any, model: Any) -> Any:
    """Return the model with elliptic cones, which the stepper takes without a warning."""
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    return model


def _base(model: Any, data: Any) -> tuple[float, FloatArray]:
    """Return height [m] and upward axis (3,) of the first free body; NaN without one."""
    free = np.flatnonzero(np.asarray(model.jnt_type) == 0)
    if not free.size:
        return math.nan, np.zeros(3)
    body = int(model.jnt_bodyid[free[0]])
    at = int(model.jnt_qposadr[free[0]])
    return float(data.qpos[at + 2]), np.array(data.xmat[body].reshape(3, 3)[2])


def _geom_name(model: Any, geom: int) -> str:
    """Return what a geom is called, else its body with its number."""
    return str(model.geom(geom).name) or f"{model.body(int(model.geom_bodyid[geom])).name or 'world'}:{geom}"
