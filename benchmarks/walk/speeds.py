"""How fast robots walk within their limits: velocity, slip, joint speeds, torques and their rates, by seed.

A seed disturbs the start (`Scenario.seed`), changes the mass that the controller believes in by up to 5 % and
the ground's friction by up to 10 %; the controller knows of none of it. Each row is one commanded velocity.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks import walks
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.records.audit import summarise_walk
from surefoot.records.audit.motion import heading_velocity
from surefoot.records.log import Ending, Log

MASS_ERROR, FRICTION_ERROR, MU = 0.05, 0.1, 0.6
"""Largest errors of the believed mass and of the friction, as shares; the friction."""
DURATION, JUDGED = 7.0, 2.5
"""Length of a run, and of its end that is judged [s]."""
SHARE, FLOOR, SLIP = 0.03, 0.02, 0.01
"""A velocity is met within this share or this much [m/s, rad/s]; the most that a foot may slide [m]."""
FROUDE = 0.5
"""Speed of the other robots, as a share of sqrt(g h)."""
LADDER = (
    (0.2, 0.0, 0.0), (0.5, 0.0, 0.0), (1.0, 0.0, 0.0), (1.5, 0.0, 0.0), (2.0, 0.0, 0.0), (2.5, 0.0, 0.0),
    (0.0, 0.0, 3.0),
)  # fmt: skip
"""Velocities of Go2: forward, left [m/s], turn rate [rad/s]."""


@dataclass(frozen=True)
class Figures:
    """What a run came to: error of the velocity [m/s, rad/s], slip [m], shares of limits, rates [N m/ms]."""

    error: float
    slip: float
    speed_use: float
    torque_use: float
    rate: float
    usual_rate: float
    laws: tuple[str, ...]


@dataclass(frozen=True)
class Trial(Figures):
    """One run; whether it ended upright, and went as it should."""

    walked: bool
    good: bool


@dataclass(frozen=True)
class SpeedRow(Figures):
    """One commanded velocity of a robot; worst values of all seeds.

    Attributes
    ----------
    robot, wanted, commanded
        Who; the velocity asked for, and what limits left of it.
    seeds, walked, good, lawful
        Runs; those that ended upright; those of them with velocity, slip and joint speeds as they should be;
        those that broke no law.
    error, slip, speed_use, torque_use
        Of the velocity [m/s, rad/s], [m], over the limits.
    rate, usual_rate
        Largest change of a torque in a millisecond, and that exceeded in one step of a thousand [N m].
    laws
        Those broken, each with how often.
    """

    robot: str
    wanted: tuple[float, float, float]
    commanded: tuple[float, float, float]
    seeds: int
    walked: int
    good: int
    lawful: int


def pace_of(robot: str) -> tuple[float, float, float]:
    """Return the velocity of a robot at `FROUDE`: (forward, 0, 0) [m/s]."""
    model = walks.known_robot(robot)
    return round(FROUDE * math.sqrt(GRAVITY * float(model.com(model.nominal)[2])), 2), 0.0, 0.0


def measure(
    robot: str,
    velocities: tuple[tuple[float, float, float], ...],
    seeds: int,
    world: str,
    gait: str = "trot",
    tell: Callable[[float], None] | None = None,
) -> list[SpeedRow]:
    """Walk at every velocity from every seed.

    Parameters
    ----------
    robot
        A known one.
    velocities
        Forward, left [m/s], turn rate [rad/s].
    seeds
        How many.
    world, gait
        Where, and how.
    tell
        Called with the share that is done.
    """
    rows = []
    for number, velocity in enumerate(velocities):
        trials, commanded = [], velocity
        for seed in range(seeds):
            log, left = walk(robot, velocity, seed, world, gait)
            trials.append(judge(log))
            commanded = (float(left[0]), float(left[1]), float(left[2]))
            if tell is not None:
                tell((number + (seed + 1) / seeds) / len(velocities))
        rows.append(_row(robot, velocity, commanded, trials))
    return rows


def walk(
    name: str, velocity: tuple[float, float, float], seed: int, world: str, gait: str
) -> tuple[Log, FloatArray]:
    """Return the log of a walk, and the (3,) velocity that was left after limits [m/s, rad/s]."""
    rng = np.random.default_rng([seed, 17])
    mass, friction = (1.0 + e * rng.uniform(-1.0, 1.0) for e in (MASS_ERROR, FRICTION_ERROR))
    chosen = walks.Walk(
        name, velocity, gait, mu=MU * friction, believed_mu=MU, believed_mass=mass, world=world
    )
    controller: Any = chosen.controller(walks.known_robot(name), FlatTerrain())
    return chosen.log(seed, DURATION), controller.command.at(0.0)


def judge(log: Log) -> Trial:
    """Return what a run came to."""
    summary, limits = summarise_walk(log), walks.known_robot(log.fact("robot")).speed_limits
    late = log["time"] > log["time"][-1] - JUDGED
    wanted, measured = log["command"][late].mean(axis=0), heading_velocity(log)[late].mean(axis=0)
    error = np.abs(measured - wanted)
    met = bool((error <= np.maximum(SHARE * np.abs(wanted), FLOOR)).all())
    slip = max(foot.slip for foot in summary.feet)
    use = float((np.abs(log["v"][:, 6:]) / limits).max())
    rates = np.abs(np.diff(log["torques"], axis=0)).max(axis=1)
    walked = log.fact("outcome") == Ending.DONE
    laws = tuple(law.split(" of ")[0].split(":")[0] for law in summary.laws_broken)
    good = walked and met and slip < SLIP and use <= 1.0
    usual = float(np.quantile(rates, 0.999))
    return Trial(
        float(error.max()), slip, use, summary.torque_use_max, float(rates.max()), usual, laws, walked, good
    )


def _row(
    robot: str, wanted: tuple[float, float, float], commanded: tuple[float, float, float], trials: list[Trial]
) -> SpeedRow:
    laws = Counter(law for trial in trials for law in trial.laws)

    def worst(name: str) -> float:
        return max(float(getattr(trial, name)) for trial in trials)

    broken = tuple(f"{n} x {law}" for law, n in laws.most_common())
    return SpeedRow(
        worst("error"), worst("slip"), worst("speed_use"), worst("torque_use"), worst("rate"),
        worst("usual_rate"), broken, robot, wanted, commanded, len(trials), sum(t.walked for t in trials),
        sum(t.good for t in trials), sum(not t.laws for t in trials),
    )  # fmt: skip
