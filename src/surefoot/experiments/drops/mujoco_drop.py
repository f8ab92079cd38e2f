"""A mass on a vertical slide over a plane, in MuJoCo."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import SurefootError
from surefoot.experiments.drops.drop import SlideDrop

PACKAGE, EXTRA = "mujoco", "sim"
RADIUS = 1.0
"""Of the sphere [m]; it only slides up and down."""


def present() -> bool:
    """Return whether MuJoCo can be imported."""
    from surefoot.simulation.mujoco import import_mujoco

    try:
        import_mujoco()
    except SurefootError:
        return False
    return True


def run(drop: SlideDrop) -> tuple[FloatArray, FloatArray]:
    """Return gaps [m] and speeds [m/s] at every step: (T,)."""
    from surefoot.simulation.mujoco import import_mujoco

    mujoco = import_mujoco()
    model = mujoco.MjModel.from_xml_string(_model(drop))
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = drop.gap, drop.speed
    gaps, speeds = np.empty(drop.steps + 1), np.empty(drop.steps + 1)
    gaps[0], speeds[0] = drop.gap, drop.speed
    for k in range(1, drop.steps + 1):
        mujoco.mj_step(model, data)
        gaps[k], speeds[k] = data.qpos[0], data.qvel[0]
        if drop.until == "apart" and gaps[k] > 0.0 and speeds[k] > 0.0:
            return gaps[: k + 1], speeds[: k + 1]
    return gaps, speeds


def _model(drop: SlideDrop) -> str:
    """Return the MJCF; the contact's own numbers are given to the pair, so that nothing is mixed."""
    words = {name: " ".join(f"{x!r}" for x in drop.settings[name]) for name in ("solref", "solimp")}
    return f"""
    <mujoco><option timestep="{drop.dt!r}" gravity="0 0 {-drop.gravity!r}" tolerance="0" iterations="50"
    cone="elliptic"/>
      <worldbody><geom name="ground" type="plane" size="1 1 1"/>
        <body pos="0 0 {RADIUS!r}"><joint type="slide" axis="0 0 1"/>
          <geom name="mass" type="sphere" size="{RADIUS!r}" mass="{drop.mass!r}"/></body></worldbody>
      <contact><pair geom1="ground" geom2="mass" condim="1" solref="{words["solref"]}"
        solimp="{words["solimp"]}"/></contact></mujoco>"""
