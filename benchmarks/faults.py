"""Which faults a trotting robot survives: for every kind the largest level that no seed falls at.

Each trial is one simulated trot in MuJoCo on an estimated state, or on the true one; the seed moves the
start, the moment of the disturbance within the gait, the noise, and which motor is weak. Levels of a kind are
ordered from harmless to hopeless, and the largest that all seeds survive is found by bisection (survival is
taken to be monotone in the level; every level that was tried is reported with its number of survivors, a
level being left at its first fall).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchmarks import walks
from surefoot.base.errors import ProblemError, unknown_name
from surefoot.mechanics.robot import Robot, load_robot
from surefoot.mechanics.terrain import FlatTerrain, Terrain
from surefoot.motion.control.controller import Controller
from surefoot.records.log import Ending
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.run import Ice, Push
from surefoot.worlds.running.sensors import SensorModel

ESTIMATORS = ("inekf", "truth")
"""Where the controller has its state from."""
DISTURBED = 1.5
"""Time of the disturbance, plus up to one cycle of the gait [s]."""
CYCLE = 0.4
PUSH_TIME = 0.1
"""Length of a push [s]."""
ICE_TIME = 1.5
"""Length of the way over ice [s]."""
HOLE_LENGTH = 0.25
"""Length of a ditch along the way [m]."""


@dataclass(frozen=True)
class Trial(walks.Walk):
    """A trot with something wrong; `noise` is a multiple of that of ordinary sensors."""

    noise: float | None = None

    def controller(self, robot: Robot, terrain: Terrain) -> Controller:
        """Return the walking controller; it takes the ground for flat."""
        return super().controller(robot, FlatTerrain())

    def sensed(self, estimator: str) -> Trial:
        """Return the trial with its noise: that of the sensors, or white noise on the true state."""
        if estimator == "inekf":
            return replace(self, sensors=SensorModel().scaled(1.0 if self.noise is None else self.noise))
        return replace(self, faults=replace(self.faults or Faults(), noise=self.noise or 0.0))


Make = Callable[[Robot, float, np.random.Generator], Trial]


@dataclass(frozen=True)
class Fault:
    """A kind of fault.

    Attributes
    ----------
    title, unit
        For the table.
    levels
        From harmless to hopeless.
    make
        From robot, level and a seeded generator to a trial.
    """

    title: str
    unit: str
    levels: tuple[float, ...]
    make: Make


def _moment(rng: np.random.Generator) -> float:
    return DISTURBED + CYCLE * float(rng.random())


def _push(x: float, y: float, robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    return Trial(pushes=(Push(_moment(rng), (x * level, y * level, 0.0), PUSH_TIME),))


def _ice(robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    start = _moment(rng)
    return Trial(ice=(Ice(start, level), Ice(start + ICE_TIME, 0.6)))


def _payload(robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    return Trial(options={"payload": level * robot.mass})


def _mass(robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    return Trial(believed_mass=level)


def _wrong_mu(robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    push = _push(0.0, 1.0, robot, 3.0 * robot.mass, rng)
    return replace(push, mu=0.3, believed_mu=0.3 * level)


def _noise(robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    return Trial(noise=level)


def _weak(robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    joint = robot.joint_names[int(rng.integers(robot.joints))]
    return Trial(faults=Faults(weak_joint=joint, torque_loss=level))


def _delay(robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    return Trial(faults=Faults(delay=1e-3 * level))


def _hole(robot: Robot, level: float, rng: np.random.Generator) -> Trial:
    return Trial(terrain=f"pit:{0.6 + 0.2 * float(rng.random())},{HOLE_LENGTH},{level}")


PUSHES = (100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 450.0, 500.0, 600.0)

FAULTS: dict[str, Fault] = {
    "push-left": Fault("push to the left, 0.1 s", "N", PUSHES, partial(_push, 0.0, 1.0)),
    "push-right": Fault("push to the right, 0.1 s", "N", PUSHES, partial(_push, 0.0, -1.0)),
    "push-forward": Fault("push forward, 0.1 s", "N", PUSHES, partial(_push, 1.0, 0.0)),
    "push-back": Fault("push back, 0.1 s", "N", PUSHES, partial(_push, -1.0, 0.0)),
    "ice": Fault("1.5 s of ice", "mu", (0.4, 0.3, 0.2, 0.15, 0.1, 0.08, 0.06, 0.04, 0.02), _ice),
    "payload": Fault("unknown payload", "of the mass", (0.2, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0), _payload),
    "too-light": Fault("believed mass too low", "of the mass", (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3), _mass),
    "too-heavy": Fault("believed mass too high", "of the mass", (1.1, 1.2, 1.3, 1.5, 1.7, 2.0, 2.5), _mass),
    "wrong-mu": Fault(
        "believed friction too high, mu 0.3, push of 3 N/kg",
        "times",
        (1.0, 1.5, 2.0, 2.5, 3.0, 4.0),
        _wrong_mu,
    ),
    "noise": Fault(
        "sensor noise", "times ordinary", (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0), _noise
    ),
    "weak-motor": Fault(
        "torque loss of one motor", "of its torque", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0), _weak
    ),
    "hole": Fault(
        "unseen ditch, 0.25 m long", "m deep", (0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.15), _hole
    ),
    "delay": Fault("delay of the torques", "ms", (2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0), _delay),
}


@dataclass(frozen=True)
class FaultRow:
    """What came out for one kind of fault.

    Attributes
    ----------
    name, title, unit
        Which.
    survived
        Largest level that every seed survived; None if even the first did not.
    next_level
        The level after it, which some seed did not survive; None if the last was survived.
    tried
        Level, survivors, and trials of every level that was tried.
    wall_time
        [s].
    """

    name: str
    title: str
    unit: str
    survived: float | None
    next_level: float | None
    tried: list[tuple[float, int, int]]
    wall_time: float


def choose_faults(names: Sequence[str] | None) -> dict[str, Fault]:
    """Return the named kinds, or all.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    if not names:
        return dict(FAULTS)
    for name in names:
        if name not in FAULTS:
            raise ProblemError(unknown_name("fault", name, FAULTS))
    return {name: FAULTS[name] for name in names}


def survives(robot: str, fault: str, level: float, duration: float, estimator: str, seed: int) -> bool:
    """Return whether the robot still walks at the end of one trial."""
    trial = FAULTS[fault].make(walks.known_robot(robot), level, np.random.default_rng([seed, 7]))
    log = replace(trial.sensed(estimator), robot=robot).log(seed, duration)
    return bool(log.facts["outcome"] == Ending.DONE)


def largest_level(
    robot: str, name: str, seeds: int, duration: float, pool: Executor | None, jobs: int, estimator: str
) -> FaultRow:
    """Bisect the levels of one kind of fault."""
    fault, begin = FAULTS[name], time.perf_counter()
    low, high = -1, len(fault.levels)
    tried: list[tuple[float, int, int]] = []
    while high - low > 1:
        at = (low + high) // 2
        count, survivors = 0, 0
        for first in range(0, seeds, jobs):
            batch = range(first, min(first + jobs, seeds))
            work = partial(survives, robot, name, fault.levels[at], duration, estimator)
            results = list(map(work, batch) if pool is None else pool.map(work, batch))
            count, survivors = count + len(results), survivors + sum(results)
            if survivors < count:
                break
        tried.append((fault.levels[at], survivors, count))
        low, high = (at, high) if survivors == count else (low, at)
    survived = fault.levels[low] if low >= 0 else None
    after = fault.levels[high] if high < len(fault.levels) else None
    tried.sort(key=lambda row: fault.levels.index(row[0]))
    return FaultRow(name, fault.title, fault.unit, survived, after, tried, time.perf_counter() - begin)


def measure(
    robot: str = "go2",
    names: Sequence[str] | None = None,
    seeds: int = 20,
    duration: float = 5.0,
    jobs: int = 1,
    progress: Callable[[float], None] | None = None,
    estimator: str = "inekf",
) -> list[FaultRow]:
    """Return a row for every kind of fault.

    Parameters
    ----------
    robot
        A known robot.
    names
        Kinds of fault; None for all.
    seeds
        Trials per level.
    duration
        Length of a trial [s].
    jobs
        Processes.
    progress
        Told the share done.
    estimator
        "inekf" or "truth", see `surefoot walk`.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    chosen = choose_faults(names)
    if estimator not in ESTIMATORS:
        raise ProblemError(unknown_name("estimator", estimator, ESTIMATORS))
    load_robot(robot)
    rows = []
    with ProcessPoolExecutor(jobs) if jobs > 1 else nullcontext(None) as pool:
        for k, name in enumerate(chosen):
            rows.append(largest_level(robot, name, seeds, duration, pool, jobs, estimator))
            if progress is not None:
                progress((k + 1) / len(chosen))
    return rows
