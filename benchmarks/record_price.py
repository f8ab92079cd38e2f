"""The price of `sf.record` beside `mj_step`'s own: CPU time of the thread, both in one run.

Gymnasium's Ant and Humanoid where gymnasium is installed (`GYMNASIUM_ASSETS` names the folder of its models
otherwise), else figures like them; Go2 and G1 in `MujocoWorld`'s own model, held by joint control.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.worlds.mujoco.mujoco_world import import_mujoco

ROUNDS = 3
"""Runs of each kind; the least counts."""
STIFF, DAMPED = 4.0, 0.02
"""Joint control that holds a robot: stiffness over m g [m/rad], damping over stiffness [s]."""
LIMB = (
    "<body pos='{at}'><joint name='{n}a' axis='{axis}' range='-40 40' limited='true' damping='1'"
    " armature='.1'/><geom type='capsule' fromto='0 0 0 {out}' size='.07' density='60'/><body pos='{out}'>"
    "<joint name='{n}b' axis='{axis}' range='-60 60' limited='true' damping='1' armature='.1'/>"
    "<geom type='capsule' fromto='0 0 0 {end}' size='.07' density='60'/></body></body>"
)


@dataclass(frozen=True)
class Price:
    """What a step costs [µs of the thread's CPU].

    Attributes
    ----------
    name
        Of the model.
    step, recorded
        `mj_step` in a plain loop, and in the same loop inside `sf.record`.
    read
        A row, when the log is first read.
    contacts
        At the end of the loop.
    """

    name: str
    step: float
    recorded: float
    read: float
    contacts: int

    @property
    def ratio(self) -> float:
        """Recorded over plain."""
        return self.recorded / self.step


def _figure(name: str, limbs: dict[str, tuple[str, str, str, str]], option: str) -> Any:
    """Return a model with a round trunk and limbs of two joints: place, axis, upper and lower end."""
    body = "".join(
        LIMB.format(n=n, at=at, axis=axis, out=out, end=end) for n, (at, axis, out, end) in limbs.items()
    )
    motors = "".join(
        f"<motor joint='{n}{j}' gear='30' ctrlrange='-1 1' ctrllimited='true'/>" for n in limbs for j in "ab"
    )
    return import_mujoco().MjModel.from_xml_string(
        f"<mujoco model='{name}'><option {option}/><worldbody><geom type='plane' size='40 40 1' condim='3'/>"
        f"<body pos='0 0 .75'><freejoint/><geom size='.25' density='60'/>{body}</body></worldbody>"
        f"<actuator>{motors}</actuator></mujoco>"
    )


def _ant_like() -> Any:
    spots = {"n": (0.2, 0.2), "e": (0.2, -0.2), "s": (-0.2, -0.2), "w": (-0.2, 0.2)}
    legs = {
        n: (f"{x} {y} 0", f"{-y} {x} 0", f"{x} {y} 0", f"{2 * x} {2 * y} -.4") for n, (x, y) in spots.items()
    }
    return _figure("ant-like", legs, "timestep='.01' integrator='RK4'")


def _humanoid_like() -> Any:
    limbs = {
        f"{n}{side}": (f"0 {y} {z}", axis, f"0 {y} {-0.3 if z < 0 else 0.1}", f"0 0 {-0.3 if z < 0 else 0.3}")
        for n, z, axis in (("leg", -0.2, "0 1 0"), ("arm", 0.15, "1 0 0"))
        for side, y in (("l", 0.15), ("r", -0.15))
    }
    return _figure("humanoid-like", limbs, "timestep='.003' solver='PGS' iterations='50'")


def models() -> Iterator[tuple[str, Any, Any]]:
    """Yield name, model and data, in the pose from which a loop starts."""
    mujoco = import_mujoco()
    folder = os.environ.get("GYMNASIUM_ASSETS", "")
    spec = None if folder else find_spec("gymnasium")
    if spec is not None and spec.origin:
        folder = str(Path(spec.origin).parent / "envs" / "mujoco" / "assets")
    for name, own in (("ant", _ant_like), ("humanoid", _humanoid_like)):
        file = Path(folder) / f"{name}.xml"
        model = mujoco.MjModel.from_xml_path(str(file)) if folder and file.is_file() else own()
        yield name if folder and file.is_file() else f"{name}-like", model, mujoco.MjData(model)
    for name in ("go2", "g1"):
        robot = sf.load_robot(name)
        world = sf.MujocoWorld(robot)
        world.reset(sf.place(robot, sf.FlatTerrain()))
        yield name, world.model, world.data


def price(name: str, model: Any, data: Any, steps: int) -> Price:
    """Measure one model."""
    mujoco, q, v = import_mujoco(), data.qpos.copy(), data.qvel.copy()
    held = model.opt.timestep < 0.002  # a robot of ours: its motors are torques on all its joints
    noise = np.random.default_rng(0).uniform(-0.3, 0.3, (steps, model.nu))
    joints = model.actuator_trnid[:, 0]
    at, dof = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
    stiff = STIFF * float(model.body_subtreemass[0]) * 9.81 / max(model.nu, 1)

    def loop() -> float:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = q, v
        used = 0.0
        for k in range(steps):
            data.ctrl[:] = noise[k]
            if held:
                data.ctrl[:] += stiff * (q[at] - data.qpos[at] - DAMPED * data.qvel[dof])
            begun = time.thread_time()
            mujoco.mj_step(model, data)
            used += time.thread_time() - begun
        return 1e6 * used / steps

    loop()
    plain, recorded = [], []
    for _ in range(ROUNDS):
        plain.append(loop())
        with sf.record(model, data) as log:
            recorded.append(loop())
    begun = time.thread_time()
    rows = len(log)
    return Price(name, min(plain), min(recorded), 1e6 * (time.thread_time() - begun) / rows, int(data.ncon))


def measure(steps: int = 2000) -> Iterator[Price]:
    """Yield the price on every model."""
    for name, model, data in models():
        yield price(name, model, data, steps)
