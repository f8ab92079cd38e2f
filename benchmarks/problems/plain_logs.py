"""Thirty lawful logs of which most know no robot: plain MuJoCo loops, exact drops, and runs of our own.

Crates that slide, balls and cubes that are thrown, rods that roll, a quadruped and a hopper under PD, at rows
of 0.5 to 5 ms and with several integrators. A kick is an impulse that a loop writes into its velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

import surefoot as sf
from benchmarks.problems.exact_drops import Drop
from benchmarks.problems.logged_runs import CleanRun
from surefoot.records.log import Log
from surefoot.worlds.mujoco.mujoco_world import import_mujoco

KICK = 1.0
"""Velocity that a kick adds [m/s]."""
GROUND = "<geom name='floor' type='plane' size='9 9 1' friction='{mu}' solref='.004 1'/>"
OBJECTS = {
    "crate": "<geom name='shell' type='box' size='.2 .2 .1' mass='5' friction='{mu}' solref='.004 1'/>",
    "ball": "<geom name='skin' size='.1' mass='2' friction='{mu}' solref='.004 1'/>",
    "cube": "<geom name='cube' type='box' size='.1 .1 .1' mass='1' friction='{mu}' solref='.01 1'/>",
    "rod": "<geom name='rod' type='capsule' size='.05 .15' mass='2' friction='{mu}' solref='.004 1'/>",
    "drum": "<geom name='drum' type='cylinder' size='.1 .1' mass='3' friction='{mu}' solref='.004 1'/>",
}
LEG = (
    "<body pos='{x} {y} 0'><joint axis='0 1 0' damping='.4' armature='.01'/>"
    "<geom type='capsule' fromto='0 0 0 0 0 -.2' size='.02' mass='.4'/>"
    "<body pos='0 0 -.2'><joint axis='0 1 0' damping='.4' armature='.01'/>"
    "<geom type='capsule' fromto='0 0 0 0 0 -.18' size='.015' mass='.2'/>"
    "<geom name='{name}' size='.02' mass='.05' pos='0 0 -.18' contype='1' conaffinity='1'/></body></body>"
)
QUADRUPED = (
    "<body pos='0 0 .402'><freejoint/><geom type='box' size='.22 .12 .05' mass='8'/>"
    + "".join(
        LEG.format(name=f"{side}{end}", x=0.2 if end == "F" else -0.2, y=0.12 if side == "L" else -0.12)
        for end in "FR" for side in "LR"
    ) + "</body>"
)  # fmt: skip
HOPPER = (
    "<body pos='0 0 .535'><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/>"
    "<joint axis='0 1 0'/><geom type='capsule' fromto='0 0 -.1 0 0 .1' size='.06' mass='4'/>"
    "<body pos='0 0 -.1'><joint axis='0 1 0' damping='.5' armature='.01'/>"
    "<geom type='capsule' fromto='0 0 0 0 0 -.4' size='.02' mass='.5'/>"
    "<geom name='toe' size='.03' mass='.1' pos='0 0 -.4' contype='1' conaffinity='1'/></body></body>"
)
PLAIN = "<default><geom contype='0' conaffinity='0' friction='{mu}' solref='.004 1'/></default>"


@dataclass(frozen=True)
class PlainLog:
    """What is logged.

    Attributes
    ----------
    name
        Short and unique.
    make
        From whether it is kicked in its middle to the log.
    """

    name: str
    make: Callable[[bool], Log]


def plain_logs() -> Iterator[PlainLog]:
    """Yield the thirty."""
    for k, dt in enumerate((5e-4, 1e-3, 2e-3, 5e-3)):
        for name in ("crate", "ball", "cube"):
            yield PlainLog(f"{name}-{1e3 * dt:g}ms", partial(_thrown, name, dt, "Euler", k))
    yield PlainLog("rod-1ms", partial(_thrown, "rod", 1e-3, "implicitfast", 4))
    yield PlainLog("rod-4ms", partial(_thrown, "rod", 4e-3, "Euler", 5))
    yield PlainLog("drum-2ms", partial(_thrown, "drum", 2e-3, "Euler", 6))
    yield PlainLog("rod-rk4-2ms", partial(_thrown, "rod", 2e-3, "RK4", 7))
    yield PlainLog("crate-rk4-1ms", partial(_thrown, "crate", 1e-3, "RK4", 8))
    for dt, integrator in ((1e-3, "Euler"), (2e-3, "implicitfast"), (4e-3, "implicitfast")):
        yield PlainLog(f"quadruped-{1e3 * dt:g}ms", partial(_legged, QUADRUPED, dt, integrator, 9))
    for dt in (1e-3, 3e-3):
        yield PlainLog(f"hopper-{1e3 * dt:g}ms", partial(_legged, HOPPER, dt, "implicitfast", 10))
    for seed, dt in enumerate((1e-3, 2e-3, 5e-3)):
        yield PlainLog(f"drop-{1e3 * dt:g}ms", partial(_dropped, seed, dt))
    trot = CleanRun(gait="trot", velocity=(0.4, 0.0, 0.0), duration=1.5, seed=200)
    rigid = CleanRun(world="rigid", gait="trot", velocity=(0.3, 0.0, 0.2), duration=1.5, seed=201)
    pushed = CleanRun(push=(1.5, 0.8, 0.0), duration=1.0, seed=202)
    for run in (trot, rigid, pushed):
        yield PlainLog(run.name, partial(_run, run, True))
    for run in (trot, rigid):
        yield PlainLog(f"{run.name}-robotless", partial(_run, run, False))


def _thrown(name: str, dt: float, integrator: str, seed: int, kicked: bool) -> Log:
    """Return an object that slides, or is thrown and spins."""
    rng = np.random.default_rng([seed, len(name)])
    mu = float(rng.uniform(0.2, 0.8))
    height = 0.1 if name == "crate" else float(rng.uniform(0.25, 0.3 if integrator == "RK4" else 0.6))
    body = f"<body pos='0 0 {height}'><freejoint/>{OBJECTS[name].format(mu=mu)}</body>"
    start = np.zeros(6)
    start[:2] = rng.uniform(1.5, 2.5) * np.array([0.8, 0.6])
    if name != "crate":
        start[2:] = rng.uniform(-1.0, 1.0, 4) * [0.5, 4.0, 4.0, 4.0]
    return _recorded(body, dt, integrator, mu, kicked, start)


def _legged(body: str, dt: float, integrator: str, seed: int, kicked: bool) -> Log:
    """Return a robot that marches, or hops, under PD about a pose that swings."""
    count = 8 if body is QUADRUPED else 1
    rng = np.random.default_rng(seed)
    phase = np.repeat([0.0, np.pi, np.pi, 0.0], 2)[:count] if count > 1 else np.zeros(1)
    knees = np.tile([0.4, -0.8], 4) if count > 1 else np.zeros(1)
    rate, size = 2.0 * np.pi * rng.uniform(1.8, 2.2), 0.3 if count > 1 else 0.1

    def control(data: Any) -> None:
        goal = knees * (1.0 + size * np.sin(rate * data.time + phase))
        data.qfrc_applied[-count:] = 0.0
        data.ctrl[:] = np.clip(80.0 * (goal - data.qpos[-count:]) - 2.0 * data.qvel[-count:], -40.0, 40.0)

    return _recorded(PLAIN.format(mu=0.8) + body, dt, integrator, 0.8, kicked, None, control)


def _recorded(
    body: str, dt: float, integrator: str, mu: float, kicked: bool, start: Any, control: Any = None
) -> Log:
    mujoco = import_mujoco()
    default, _, tree = body.rpartition("</default>")
    default = f"{default}</default>" if default else ""
    names = [f"j{k}" for k in range(tree.count("<joint axis='0 1 0' damping"))]
    for one in names:
        tree = tree.replace("<joint axis='0 1 0' damping", f"<joint name='{one}' axis='0 1 0' damping", 1)
    motors = "".join(f"<motor joint='{one}'/>" for one in names)
    floor = GROUND.format(mu=mu).replace("/>", " contype='1' conaffinity='1'/>")
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><option timestep='{dt}' integrator='{integrator}' cone='elliptic' impratio='10'/>{default}"
        f"<worldbody>{floor}{tree}</worldbody><actuator>{motors}</actuator></mujoco>"
    )
    data = mujoco.MjData(model)
    if start is not None:
        data.qvel[:] = start
    steps = round(1.2 / dt)
    with sf.record(model, data) as log:
        for k in range(steps):
            if control is not None:
                control(data)
            if kicked and k == steps // 2:
                data.qvel[0 if control is not None and model.nv < 6 else 1] += KICK
            mujoco.mj_step(model, data)
    return log


def _dropped(seed: int, dt: float, kicked: bool) -> Log:
    return Drop.seeded(seed).log(dt, kick=KICK if kicked else 0.0)


def _run(run: CleanRun, known: bool, kicked: bool) -> Log:
    """Return a run of our own; its kick is one of the log alone, in one row."""
    log = run.make()
    arrays = {name: np.array(array) for name, array in log.arrays.items()}
    facts = {name: fact for name, fact in log.facts.items() if known or name != "robot"}
    if kicked:
        row = len(log) // 2
        arrays["v"][row, 1] += KICK
        arrays["contact_velocities"][row, :, 1] += KICK
    return Log(arrays, facts, channels=log.channels)
