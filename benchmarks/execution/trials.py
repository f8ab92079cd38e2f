"""Plans executed in MuJoCo from many seeds: who lands, within which limits, and what the audit says.

A seed moves the body over its feet at the start by up to 2 cm along each axis and turns it by up to 2 degrees
about each (lying robots are moved as a whole), changes the ground's friction by up to 20 % and the mass and
inertia of all links by up to 5 %. The controller knows of none of it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from surefoot.mechanics.robot.motor_limits import MOTOR_MODELS
from surefoot.motion.planning import Plan
from surefoot.motion.planning.tracking import Reference
from surefoot.worlds.running.plan_execution import Execution, execute


@dataclass(frozen=True)
class Row:
    """A plan under one motor model.

    Attributes
    ----------
    task, motors
        What and how.
    seeds, landed, lawful
        Runs, those that landed, and those of them that broke no law.
    torque_use_max, speed_use_max
        Worst of all runs, over the URDF's limits.
    moved
        Mean distance that the feet's middle went along x [m].
    turned
        Mean angle about the lateral axis [deg].
    failures, laws
        Why runs did not land, and the laws broken, each with how often.
    """

    task: str
    motors: str
    seeds: int
    landed: int
    lawful: int
    torque_use_max: float
    speed_use_max: float
    moved: float
    turned: float
    failures: tuple[str, ...]
    laws: tuple[str, ...]


def measure(
    plan: Plan | Reference,
    task: str,
    seeds: int,
    motors: tuple[str, ...] = MOTOR_MODELS,
    tell: Callable[[float], None] | None = None,
    dt: float | None = None,
) -> list[Row]:
    """Execute a plan from every seed under every motor model.

    Parameters
    ----------
    plan, task
        What to execute, and its name.
    seeds
        How many.
    motors
        Names of motor models.
    tell
        Called with the share that is done.
    dt
        Length of a step [s]; None for the usual one.
    """
    rows = []
    for number, model in enumerate(motors):
        runs = []
        for seed in range(seeds):
            runs.append(execute(plan, "mujoco", model, seed, dt=dt))
            if tell is not None:
                tell((number + (seed + 1) / seeds) / len(motors))
        rows.append(_row(task, model, runs))
    return rows


def _row(task: str, motors: str, runs: list[Execution]) -> Row:
    failures = Counter(run.why for run in runs if run.why)
    laws = Counter(law for run in runs for law in run.laws)
    turned = float(np.degrees(np.mean([run.turned for run in runs])))
    return Row(
        task, motors, len(runs), sum(run.landed for run in runs),
        sum(run.landed and run.verdict == "lawful" for run in runs),
        max(run.torque_use_max for run in runs), max(run.speed_use_max for run in runs),
        float(np.mean([run.moved[0] for run in runs])), turned,
        tuple(f"{count} x {why}" for why, count in failures.most_common()),
        tuple(f"{count} x {law}" for law, count in laws.most_common()),
    )  # fmt: skip
