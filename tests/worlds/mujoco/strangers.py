"""Small MuJoCo loops as strangers write them: a box on a slope, a quadruped that PD holds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

import surefoot as sf
from surefoot.records import Log

CRATE = """<mujoco><option timestep='0.002'/><worldbody>
<geom name='floor' type='plane' size='9 9 1' friction='{mu} .005 0' euler='{tilt} 0 0'/>
<body name='crate' pos='0 0 {height}'><freejoint/>
<geom name='skin' type='box' size='.1 .1 .1' mass='5' friction='.05 .005 0'/></body></worldbody></mujoco>"""
LEG = """<body name='{n}_thigh' pos='{x} {y} 0' euler='0 4 {turn}'>
<joint name='{n}_roll' axis='1 0 0' pos='0 0 .01' damping='.1'/>
<joint name='{n}_hip' axis='0 1 0' damping='.1' armature='.01'/>
<geom name='{n}_upper' type='capsule' fromto='0 0 0 0 0 -.2' size='.02' mass='1'/>
<body name='{n}_shin' pos='0 0 -.2'><joint name='{n}_knee' axis='0 1 0' range='-150 -10'/>
<geom name='{n}_lower' type='capsule' fromto='0 0 0 0 0 -.15' size='.02' mass='.5'/>
<geom name='{n}' type='sphere' pos='0 0 -.2' size='.025' mass='.1'/></body></body>"""
LEGS = (("fl", 0.18, 0.12), ("fr", 0.18, -0.12), ("rl", -0.18, 0.12), ("rr", -0.18, -0.12))
QUADRUPED = (
    "<mujoco model='stray'><option timestep='0.002'/><worldbody>"
    "<geom name='floor' type='plane' size='9 9 .1' friction='.8'/>"
    "<body name='torso' pos='0 0 .36'><freejoint/>"
    "<geom name='trunk' type='box' size='.2 .1 .05' mass='8'/>"
    + "".join(LEG.format(n=n, x=x, y=y, turn=90.0 * y) for n, x, y in LEGS)
    + "</body></worldbody><actuator>"
    + "".join(
        f"<motor name='m_{n}_{j}' joint='{n}_{j}' ctrlrange='-30 30' ctrllimited='true'/>"
        for n, _, _ in LEGS
        for j in ("roll", "hip", "knee")
    )
    + "</actuator></mujoco>"
)
STANCE = np.tile([0.0, 0.6, -1.2], 4)
Hook = Callable[[Any, Any, int], None]


def crate(mu: float = 0.8, tilt: float = 0.0, steps: int = 600, hook: Hook = lambda m, d, i: None) -> Log:
    """Return the log of a crate on a slope [deg]."""
    model = mujoco.MjModel.from_xml_string(CRATE.format(mu=mu, tilt=tilt, height=0.15 if tilt else 0.11))
    return _run(model, steps, lambda data: None, hook)


def thrown_crate(speed: float) -> Log:
    """Return the log of a crate that is thrown flat over a plane [m/s]."""
    text = CRATE.format(mu=0.5, tilt=0, height=0.1001).replace("friction='.05", "friction='.1")
    model = mujoco.MjModel.from_xml_string(text)

    def throw(model: Any, data: Any, step: int) -> None:
        if step == 0:
            data.qvel[0] = speed

    return _run(model, 800, lambda data: None, throw)


def quadruped(steps: int = 700, hook: Hook = lambda m, d, i: None) -> Log:
    """Return the log of a quadruped that stands by PD."""
    model = mujoco.MjModel.from_xml_string(QUADRUPED)

    def control(data: Any) -> None:
        data.ctrl[:] = 60.0 * (STANCE - data.qpos[7:]) - 2.0 * data.qvel[6:]

    return _run(model, steps, control, hook, STANCE)


def _run(model: Any, steps: int, control: Callable[[Any], None], hook: Hook, start: Any = None) -> Log:
    data = mujoco.MjData(model)
    if start is not None:
        data.qpos[7:] = start
    with sf.record(model, data) as log:
        for step in range(steps):
            control(data)
            hook(model, data, step)
            mujoco.mj_step(model, data)
    return log
