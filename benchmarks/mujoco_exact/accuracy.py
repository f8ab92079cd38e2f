"""What a step does to bodies with a closed form: exact, as MuJoCo is, and as MuJoCo is at its best."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

import surefoot as sf
from benchmarks.mujoco_exact.scenes import bodies, box, pinch, stack, still

STIFF = {"impratio": 100.0, "noslip_iterations": 10}
SETTINGS: dict[str, dict[str, float]] = {
    "MuJoCo": {}, "impratio 10": {"impratio": 10.0}, "impratio 100, noslip 10": STIFF,
    "the same at 0.5 ms": {**STIFF, "timestep": 0.0005},
}  # fmt: skip
"""What is compared beside the exact step: MuJoCo with these options, elliptic cones."""


def runs_compared() -> dict[str, tuple[dict[str, float], bool]]:
    """Return what is compared: options of MuJoCo, and whether the step is exact."""
    return {"exact": ({}, True)} | {name: (dict(options), False) for name, options in SETTINGS.items()}


def follow(
    model: Any, options: dict[str, float], exact: bool, seconds: float, prepare: Callable[[Any], None],
    look: Callable[[Any], object] = still, restitution: float = 0.0,
) -> Any:  # fmt: skip
    """Return the data of a model after some seconds, looked at after each step."""
    for name, value in options.items():
        setattr(model.opt, name, value)
    data = mujoco.MjData(model)
    prepare(data)
    stepper = sf.MujocoStepper(model, restitution=restitution)
    step = stepper.step if exact else (lambda d: mujoco.mj_step(model, d))
    for _ in range(round(seconds / model.opt.timestep)):
        step(data)
        look(data)
    return data


def _slope(options: dict[str, float], exact: bool) -> str:
    """Return the creep on a slope of 0.4 under mu 0.5 [µm/s]."""
    a = np.arctan(0.4)
    model = bodies(box(), option=f'gravity="{9.81 * np.sin(a)} 0 {-9.81 * np.cos(a)}"')
    data = follow(model, options, exact, 2.0, still)
    return f"{1e6 * abs(data.qpos[0]) / 2.0:.2g}"


def _pinched(options: dict[str, float], exact: bool) -> str:
    """Return the creep of a part between two fingers [µm/s]."""
    data = follow(pinch(), options, exact, 2.0, lambda d: d.ctrl.__setitem__(slice(None), (4.0, -4.0)))
    return f"{1e6 * abs(data.qpos[4] - 1.0) / 2.0:.2g}"


def _thrown(options: dict[str, float], exact: bool) -> str:
    """Return the way [m] and the tilt [°] of a cube that is thrown flat at 6 m/s on mu 0.5."""
    data = follow(bodies(box()), options, exact, 2.0, lambda d: d.qvel.__setitem__(0, 6.0))
    upright = np.zeros(9)
    mujoco.mju_quat2Mat(upright, data.qpos[3:7])
    return f"{data.qpos[0]:.3f} m, {np.rad2deg(np.arccos(min(1.0, upright[8]))):.2g}°"


def _straight(options: dict[str, float], exact: bool) -> str:
    """Return by how much a flat block misses its closed way along its side [%]."""
    return _way(options, exact, 0.0)


def _diagonal(options: dict[str, float], exact: bool) -> str:
    """Return the same at 45°."""
    return _way(options, exact, 0.25 * np.pi)


def _way(options: dict[str, float], exact: bool, angle: float) -> str:
    """Return by how much a flat block misses its closed way under an angle [%]."""
    speed = 3.0
    model = bodies(box("0 0 0.02", "0.1 0.1 0.02"))
    way = speed * np.cos(angle), speed * np.sin(angle)
    data = follow(model, options, exact, 2.0, lambda d: d.qvel.__setitem__(slice(0, 2), way))
    closed = speed**2 / (2.0 * 0.5 * 9.81) - model.opt.timestep * speed / 2.0
    return f"{100.0 * (np.hypot(*data.qpos[:2]) / closed - 1.0):+.3f}"


def _sunk(options: dict[str, float], exact: bool) -> str:
    """Return how far a stack of six sinks [µm]."""
    data = follow(stack(6), options, exact, 2.0, still)
    return f"{1e6 * max(0.1 + 0.2 * k - data.qpos[7 * k + 2] for k in range(6)):.2g}"


def _spun(options: dict[str, float], exact: bool) -> str:
    """Return by how much a spinning ball misses its closed rate after 0.5 s [%]."""
    ball = (
        '<body pos="0 0 0.1"><freejoint/><geom size="0.1" mass="1" condim="4" friction="0.5 0.01 0"/></body>'
    )
    data = follow(bodies(ball), options, exact, 0.5, lambda d: d.qvel.__setitem__(5, 20.0))
    closed = 20.0 - 0.01 * 9.81 / (0.4 * 0.01) * 0.5
    return f"{100.0 * (data.qvel[5] / closed - 1.0):+.3f}"


def _cradle(options: dict[str, float], exact: bool) -> str:
    """Return the speed of the last of five balls, 5 mm apart, where the first comes at 1 m/s [m/s]."""
    ball = (
        '<body pos="{x} 0 1"><joint type="slide" axis="1 0 0"/>'
        '<geom size="0.05" mass="1" condim="1" solref="-100000 0"/></body>'
    )
    model = bodies(*(ball.format(x=0.105 * k) for k in range(5)))
    data = follow(model, options, exact, 0.1, lambda d: d.qvel.__setitem__(0, 1.0), restitution=1.0)
    return f"{data.qvel[4]:.4f}"


def _energy(options: dict[str, float], exact: bool) -> str:
    """Return the most by which the energy of a box that slides to rest on a slope rises in a step [µJ]."""
    a = np.arctan(0.4)
    model = bodies(box(), option=f'gravity="{9.81 * np.sin(a)} 0 {-9.81 * np.cos(a)}"')
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    found: list[float] = []

    def look(data: Any) -> None:
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        found.append(float(data.energy.sum()))

    follow(model, options, exact, 2.0, lambda d: d.qvel.__setitem__(0, 1.0), look)
    return f"{1e6 * max(0.0, float(np.diff(found).max())):.2g}"


ACCURACY: dict[str, Callable[[dict[str, float], bool], str]] = {
    "creep on a slope [µm/s]": _slope, "creep of a pinched part [µm/s]": _pinched,
    "cube thrown at 6 m/s (3.664 m, 0°)": _thrown,
    "way of a block at 0° [%]": _straight, "way of a block at 45° [%]": _diagonal,
    "the cradle's last ball [m/s] (1)": _cradle,
    "energy rises to rest on a slope by [µJ]": _energy,
    "a stack of six sinks [µm]": _sunk, "spin after 0.5 s [%]": _spun,
}  # fmt: skip
"""Title to what is measured."""
