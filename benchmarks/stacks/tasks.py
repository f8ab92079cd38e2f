"""The tasks: plain data, so that a trial is a task, a stack and a seed, and nothing else.

Every task walks for a while with one thing wrong, or nothing. A bound is what the task should be done within;
staying upright, on course and lawful is asked for in all of them (`benchmarks.stacks.judging`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from surefoot.base.errors import ProblemError, unknown_name
from surefoot.records.audit.limits import LIMITS

NEWTONS, PUSH_TIME, PUSH_AT = 150.0, 0.1, 2.5
"""A push on Go2 [N], its length, and the time from which on its phase of the gait is waited for [s]."""
BIPED_NEWTONS = 60.0
SHOVES = (100, 200, 300, 400)
"""Pushes on Go2 beyond what has to be held, 100 N included [N]."""
BIPED_SHOVES = (150.0, 200.0)
"""The same on G1 [N]."""
DIRECTIONS = ("forward", "forward-left", "left", "back-left", "back", "back-right", "right", "forward-right")
"""Of a push, every 45 degrees."""
LADDER = (0.2, 0.5, 0.8, 1.0, 1.1, 1.4, 1.7, 2.0)
"""Speeds of Go2 [m/s]."""
FROUDE = 0.5
"""Speed of the other quadrupeds in units of sqrt(g hip height)."""
QUADRUPEDS = ("anymal_c", "a1", "go1", "b1", "solo12", "hyq", "laikago")


@dataclass(frozen=True)
class Bound:
    """A measure of `benchmarks.stacks.measures.Measures` that a trial must keep, at most or at least."""

    measure: str
    limit: float
    least: bool = False

    def kept(self, value: float | None) -> bool:
        """Return whether a value keeps it; what was not measured does not."""
        if value is None or math.isnan(value):
            return False
        return value >= self.limit if self.least else value <= self.limit

    def __str__(self) -> str:
        return f"{self.measure} {'>=' if self.least else '<='} {self.limit:g}"


@dataclass(frozen=True)
class Task:
    """A walk with one thing wrong.

    Attributes
    ----------
    name, title
        On the command line, and in tables.
    asked
        (forward, left, yaw rate) [m/s, rad/s].
    robot
        A name of the catalogue.
    froude
        Takes the place of the forward speed, in units of sqrt(g hip height); None for `asked`.
    duration
        [s].
    terrain
        The ground, as `surefoot walk --terrain` takes it.
    knowledge
        What a stack may know of the ground: "exact", or "map", a height map from a range sensor.
    believed_mu, mu
        Friction that the stacks count on; that of the ground (before the seed varies it).
    push
        (x, y) force [N] on the base for `PUSH_TIME`, in the gait's phase that the seed says; None for none.
    payload, payload_at
        Point mass on the base, unknown [kg], and where it is [m].
    noise
        Of the sensors, in ordinary sensors' units.
    delay
        Of the torques [s].
    dropouts
        Times in which the stack is told the state before them, again and again: (start, duration) [s].
    torque_loss
        Share of its torque that one joint loses, which the seed chooses.
    bounds
        What it should be done within.
    must
        Whether it is one of those that a release has to hold.
    """

    name: str
    title: str
    asked: tuple[float, float, float] = (0.5, 0.0, 0.0)
    robot: str = "go2"
    froude: float | None = None
    duration: float = 8.0
    terrain: str = "flat"
    knowledge: str = "exact"
    believed_mu: float = 0.6
    mu: float = 0.6
    push: tuple[float, float] | None = None
    payload: float = 0.0
    payload_at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    noise: float = 1.0
    delay: float = 0.0
    dropouts: tuple[tuple[float, float], ...] = ()
    torque_loss: float = 0.0
    bounds: tuple[Bound, ...] = ()
    must: bool = True


SLIP = Bound("slip", 0.01)
MOTORS = (Bound("torque_use", 1.0), Bound("speed_use", LIMITS.motors.over_speed))
"""Joint torque and speed inside their limits."""
ESTIMATE = (Bound("estimate_velocity", 0.05), Bound("estimate_drift", 0.02))
"""Error of the estimated velocity [m/s rms], drift over the way."""


def _follow(speed: float) -> Bound:
    """Return the bound on the velocity: 3 %, or 0.02 m/s."""
    return Bound("velocity_error", max(0.03 * speed, 0.02))


def _ladder() -> Iterator[Task]:
    for speed in LADDER:
        yield Task(
            f"speed-{speed:g}", f"{speed:g} m/s", (speed, 0.0, 0.0), bounds=(_follow(speed), SLIP, *MOTORS)
        )
    yield Task("speed-2.5", "2.5 m/s", (2.5, 0.0, 0.0), bounds=(_follow(2.5), SLIP, *MOTORS), must=False)
    turn = (Bound("turn_error", 0.09), SLIP, *MOTORS)
    yield Task("turn-3", "turning on the spot, 3 rad/s", (0.0, 0.0, 3.0), bounds=turn, must=False)


def _pushes(
    robot: str, newtons: float, every: int, speed: float, prefix: str, must: bool = True
) -> Iterator[Task]:
    for k in range(0, len(DIRECTIONS), every):
        angle = 2.0 * math.pi * k / len(DIRECTIONS)
        yield Task(
            f"{prefix}-{DIRECTIONS[k]}", f"{newtons:g} N for {PUSH_TIME:g} s, {DIRECTIONS[k]}",
            (speed, 0.0, 0.0), robot, duration=6.0 if robot == "go2" else 10.0,
            push=(newtons * math.cos(angle), newtons * math.sin(angle)), bounds=MOTORS, must=must,
        )  # fmt: skip


def _faults() -> Iterator[Task]:
    level = (Bound("tilt", 4.0), *MOTORS)
    yield Task("payload-centred", "5 kg on the back", payload=5.0, payload_at=(0.0, 0.0, 0.08), bounds=level)
    yield Task(
        "payload-off-centre", "5 kg at (0.1, 0.08, 0.08) m", payload=5.0, payload_at=(0.1, 0.08, 0.08),
        bounds=level,
    )  # fmt: skip
    yield Task("ice", "mu 0.2, 0.6 believed", mu=0.2, bounds=MOTORS)
    yield Task("slope-up", "20 degrees up", duration=10.0, terrain="slope:20", bounds=MOTORS)
    yield Task("slope-down", "20 degrees down", duration=10.0, terrain="slope:-20", bounds=MOTORS)
    for knowledge, end, title in (("exact", "", ""), ("map", "-map", ", seen")):
        for name, rise in (("up", "0.12"), ("down", "-0.12")):
            yield Task(
                f"stairs-{name}{end}", f"ten stairs of 12 cm by 30 cm, {name}{title}", (0.4, 0.0, 0.0),
                duration=12.0, terrain=f"stairs:{rise},0.3", knowledge=knowledge, bounds=MOTORS,
            )  # fmt: skip
    for knowledge in ("map", "blind"):
        yield Task(
            f"rough-{knowledge}", f"rough ground of 8 cm, {knowledge}", duration=8.0, terrain="rough:1,0.08",
            knowledge=knowledge, must=False,
        )  # fmt: skip
    yield Task("pit", "a pit of 40 cm by 10 cm, known", duration=8.0, terrain="pit:1,0.4,0.1", must=False)
    yield Task(
        "dropouts", "no new state for 80 ms, twice", dropouts=((2.5, 0.08), (3.7, 0.08)), must=False,
    )  # fmt: skip
    yield Task("delay", "torques 5 ms late", delay=0.005, bounds=MOTORS)
    yield Task("noise", "sensors three times as noisy", noise=3.0, must=False)
    yield Task("weak-joint", "one joint gives 70 % of its torque", torque_loss=0.3, must=False)


def _others() -> Iterator[Task]:
    for robot in QUADRUPEDS:
        yield Task(
            f"robot-{robot}", f"{robot} at {FROUDE:g} sqrt(g h)", robot=robot, froude=FROUDE,
            bounds=MOTORS,
        )  # fmt: skip
    for speed in (0.0, 0.3, 0.6):
        yield Task(
            f"g1-{speed:g}",
            f"G1 at {speed:g} m/s",
            (speed, 0.0, 0.0),
            "g1",
            duration=10.0,
            bounds=(_follow(speed),),
        )
    yield Task("g1-turn", "G1 at 0.3 m/s, turning 0.3 rad/s", (0.3, 0.0, 0.3), "g1", duration=10.0)
    for name, angle in (("up", "10"), ("down", "-10")):
        yield Task(
            f"g1-slope-{name}", f"G1, 10 degrees {name}", (0.3, 0.0, 0.0), "g1", duration=10.0,
            terrain=f"slope:{angle}",
        )  # fmt: skip
    yield Task(
        "g1-rough", "G1 on 3 cm of rough ground", (0.3, 0.0, 0.0), "g1", duration=10.0,
        terrain="rough:1,0.03",
    )  # fmt: skip
    yield from _pushes("g1", BIPED_NEWTONS, 2, 0.3, "g1-push")
    for newtons in BIPED_SHOVES:
        yield from _pushes("g1", newtons, 1, 0.3, f"g1-shove-{newtons:g}", must=False)
    yield Task(
        "g1-payload", "G1 with 3 kg at (0.08, 0, 0.15) m", (0.3, 0.0, 0.0), "g1", duration=10.0, payload=3.0,
        payload_at=(0.08, 0.0, 0.15), must=False,
    )  # fmt: skip
    for newtons in SHOVES:
        yield from _pushes("go2", newtons, 1, 0.5, f"shove-{newtons}", must=False)


def _cost() -> Iterator[Task]:
    yield Task("estimate", "the state estimate over 20 s", duration=20.0, bounds=ESTIMATE)
    pace = (Bound("real_time", 4.0, least=True),)
    yield Task("real-time", "controller, estimator and log at 1 kHz", duration=10.0, bounds=pace)


TASKS: dict[str, Task] = {
    task.name: task
    for task in (*_ladder(), *_pushes("go2", NEWTONS, 1, 0.5, "push"), *_faults(), *_others(), *_cost())
}
QUICK, QUICK_TIME = ("speed-0.5", "push-left"), 5.0


def choose_tasks(names: Sequence[str] | None) -> tuple[Task, ...]:
    """Return the named tasks, or all; a name that ends in a hyphen stands for all that begin with it.

    >>> [task.name for task in choose_tasks(["slope-", "ice"])]
    ['slope-up', 'slope-down', 'ice']

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    if not names:
        return tuple(TASKS.values())
    chosen: dict[str, Task] = {}
    for name in names:
        found = [n for n in TASKS if n == name or (name.endswith("-") and n.startswith(name))]
        if not found:
            raise ProblemError(unknown_name("task", name, TASKS))
        chosen |= {n: TASKS[n] for n in found}
    return tuple(chosen.values())
