"""The contact-implicit controller in a loop with MuJoCo: its gait, its pushes, and what a tick costs."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from benchmarks.timing import Stopwatch
from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot import Robot
from surefoot.motion.planning.mpc.contact_implicit_controller import ContactImplicitMpc, MpcSettings
from surefoot.motion.planning.mpc.cost import WalkWeights
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.records.log import Ending, Log
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Push, Scenario

Velocity = tuple[float, float, float]
"""Forward, left [m/s], yaw rate [rad/s]."""
FORWARD: Velocity = (0.5, 0.0, 0.0)
PUSH, PUSH_TIME = 60.0, 0.1
"""Force [N] and length [s] of a push."""
TRIED = WalkWeights()
VARIANTS: dict[str, tuple[WalkWeights, Velocity]] = {
    "diagonal legs not tied": (replace(TRIED, diagonal=0.0, diagonal_speed=0.0), FORWARD),
    "landing 8": (replace(TRIED, landing=8.0), FORWARD),
    "0.25 m/s": (TRIED, (0.25, 0.0, 0.0)),
    "1 m/s": (TRIED, (1.0, 0.0, 0.0)),
    "0.3 m/s backwards": (TRIED, (-0.3, 0.0, 0.0)),
    "0.3 m/s to the left": (TRIED, (0.0, 0.3, 0.0)),
}
"""Other costs and commands."""
SETTLED = 1.5
"""When the gait is looked at, and the first push comes [s]."""
PRESSED = 2.0
"""Normal force from which a foot counts as on the ground [N]."""
DIRECTIONS = {"left": (0.0, 1.0), "right": (0.0, -1.0), "forward": (1.0, 0.0), "back": (-1.0, 0.0)}


@dataclass(frozen=True)
class Walk:
    """What a walk came to.

    Attributes
    ----------
    done
        Whether the robot was still up at the end.
    seconds, speed, tilt
        Simulated time [s], mean forward speed [m/s] and largest lean [deg] after `SETTLED`.
    duty
        Share of the time that a foot is on the ground, mean of the feet.
    together, apart
        Share of the time that both feet of a diagonal do the same, and that the two front feet do not: 1 and
        1 in a trot.
    stride
        Touchdowns of a foot a second.
    clearance, depth
        Highest and deepest point of a foot over the ground, mean of the feet and all [m].
    planned
        Share of the ticks that found a plan.
    """

    done: bool
    seconds: float
    speed: float
    tilt: float
    duty: float
    together: float
    apart: float
    stride: float
    clearance: float
    depth: float
    planned: float


def walk(
    robot: Robot, seconds: float, pushes: list[Push], settings: MpcSettings, velocity: Velocity = FORWARD,
    mu: float = 0.6, payload: float = 0.0,
) -> tuple[Walk, FloatArray]:  # fmt: skip
    """Return a walk and (ticks, 2) processor and wall times of its ticks [s]."""
    watch = Stopwatch(ContactImplicitMpc(robot, VelocityCommand.constant(*velocity), None, settings))
    log = run(MujocoWorld(robot, mu=mu, payload=payload), watch, Scenario(seconds, mu, pushes))
    every = round(settings.interval / float(log.fact("dt")))
    return account(log, velocity), np.column_stack([watch.cpu, watch.wall])[::every]


def account(log: Log, velocity: Velocity) -> Walk:
    """Return what a log says of the gait, the speed along the commanded direction."""
    late = log["time"] >= min(SETTLED, 0.5 * log["time"][-1])
    on, q, dt = log["forces"][late][:, :, 2] > PRESSED, log["q"], float(log.fact("dt"))
    upright = 1.0 - 2.0 * (q[late, 3] ** 2 + q[late, 4] ** 2)
    moved = q[late][-1, :2] - q[late][0, :2]
    seconds = dt * (late.sum() - 1)
    along = np.array(velocity[:2]) / max(float(np.hypot(*velocity[:2])), 1e-9)
    downs = (~on[:-1] & on[1:]).sum(axis=0).mean()
    return Walk(
        log.fact("outcome") == str(Ending.DONE),
        float(log["time"][-1] + dt),
        float(moved @ along / seconds),
        float(np.degrees(np.arccos(np.clip(upright.min(), -1.0, 1.0)))),
        float(on.mean()),
        float(0.5 * ((on[:, 0] == on[:, 3]).mean() + (on[:, 1] == on[:, 2]).mean())),
        float((on[:, 0] != on[:, 1]).mean()),
        float(downs / seconds),
        float(log["gaps"][late].max(axis=0).mean()),
        float(log["gaps"][late].min()),
        float(log["attained"].mean()),
    )


def measure(robot: Robot, quick: bool) -> dict[str, Any]:
    """Return the figures of a walk and of the pushes; times in seconds."""
    settings = MpcSettings()
    long, ticks = walk(robot, 1.6 if quick else 10.0, [], settings)
    times = ticks[1:]  # the first makes a plan from nothing
    pushed = []
    phases = (0.0,) if quick else (0.0, 0.1, 0.2)
    for name, (x, y) in list(DIRECTIONS.items())[: 1 if quick else None]:
        for phase in phases:
            push = Push(SETTLED + phase, (PUSH * x, PUSH * y, 0.0), PUSH_TIME)
            one, _ = walk(robot, SETTLED + 0.5 if quick else SETTLED + 2.5, [push], settings)
            pushed.append({"direction": name, "phase": phase, **asdict(one)})
    chance = np.random.default_rng(0)
    drawn = [asdict(_draw(robot, chance, seed)) for seed in range(0 if quick else 10)]
    variants = {}
    for name, (weights, velocity) in list(VARIANTS.items())[: 0 if quick else None]:
        one, _ = walk(robot, 4.0, [], replace(settings, weights=weights), velocity)
        variants[name] = asdict(one)
    return {
        "knots": settings.knots,
        "dt": settings.dt,
        "interval": settings.interval,
        "iterations": settings.iterations,
        "walk": asdict(long),
        "first_tick": float(ticks[0, 0]),
        "tick": {
            name: {"median": float(np.median(times[:, i])), "p99": float(np.percentile(times[:, i], 99))}
            for i, name in enumerate(("processor", "wall"))
        },
        "pushes": pushed,
        "drawn": drawn,
        "variants": variants,
    }


def _draw(robot: Robot, chance: np.random.Generator, seed: int) -> Walk:
    """Return a walk with friction, payload and two pushes by chance, the controller knowing of none."""
    angle, mu, payload = chance.uniform(0.0, 2.0 * np.pi), chance.uniform(0.5, 0.7), chance.uniform(0.0, 0.8)
    force = PUSH * np.cos(angle), PUSH * np.sin(angle), 0.0
    pushes = [Push(start + chance.uniform(0.0, 0.4), force, PUSH_TIME) for start in (1.2, 2.6)]
    return walk(robot, 4.5, pushes, MpcSettings(seed=seed), FORWARD, mu, payload)[0]
