"""Cross-check: the motion of a log in another world, and whether its success survives.

Torques alone, replayed open loop, diverge from any log within half a second, in its own world too: a legged
robot is unstable, and where a foot lands a millisecond later all that follows differs. So the joints are
tracked, tau = tau_log + K (q_log - q) + D (v_log - v) within the effort limits, and the replay starts again
from the log's state in every window. What is lost is counted only where the same replay in the log's own
world holds: else it is the tracking that fails, and one cannot tell.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, SimulationError
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics import Robot, Terrain
from surefoot.motion import Command, Controller, RobotState
from surefoot.records import Ending, Log, audit_log, read_log
from surefoot.worlds.interface.world_names import WORLDS, make_world
from surefoot.worlds.replay.replay_task import ReplayTask, replay_task
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Fall, Ice, Push, Scenario

WINDOW = 1.0
"""Time after which the replay starts again from the log's state [s]."""
PROGRESS = 0.8
"""Share of the log's way that a replay must make."""
TILT = math.radians(15.0)
"""Tilt beyond the log's that a replay may show [rad]."""
DRIFT = 0.25
"""A window may end away from the log by this share of the base's height and of the log's way."""
LEAST_WAY = 0.1
"""A log whose windows move the base by less in all has no way to lose [m]."""

Survival: TypeAlias = Literal["survives", "lost", "cannot tell"]
"""Every window holds in the other world; one is lost there and holds in the log's own; neither."""


@dataclass(frozen=True)
class WindowReplay:
    """What became of one window in one world.

    Attributes
    ----------
    start, end
        In the log's time [s]; `end` is where it fell if it did.
    outcome
        "done", "fell" or "invalid".
    way
        Of the base over the ground along the log's own, and the log's [m].
    logged_way
        The log's own [m].
    tilt
        Largest lean of the base against the log's at the same time [rad].
    drift
        Distance of the base from the log's at the end [m].
    broken
        Laws that were broken there, with their worst.
    lost
        Why it does not hold; empty where it does.
    """

    start: float
    end: float
    outcome: str
    way: float
    logged_way: float
    tilt: float
    drift: float
    broken: tuple[str, ...]
    lost: str


@dataclass(frozen=True, repr=False)
class ReplayReport(Drawn):
    """Whether a log's success survives in another world.

    Attributes
    ----------
    world, own
        Names of the worlds; `own` is empty where the log's own is not known here.
    verdict
        "survives", "lost" or "cannot tell".
    reason
        Why, in a line.
    windows, own_windows
        In the other world, and in the log's own where that was needed.
    logs
        Of the windows in the other world.
    """

    world: str
    own: str
    verdict: Survival
    reason: str
    windows: tuple[WindowReplay, ...]
    own_windows: tuple[WindowReplay, ...]
    logs: tuple[Log, ...] = field(repr=False, default=())

    def __repr__(self) -> str:
        return f"ReplayReport({self.world!r}, {self.verdict!r}, {len(self.windows)} windows)"

    def __str__(self) -> str:
        return self.sentence[0].upper() + self.sentence[1:300] + "."

    @property
    def survives(self) -> bool:
        """Whether the verdict says so."""
        return self.verdict == "survives"

    @property
    def progress(self) -> float:
        """Ratio of the way in the other world to the log's; NaN for a log that goes nowhere."""
        return _progress(self.windows)

    @property
    def sentence(self) -> str:
        """The verdict in a sentence."""
        said = {
            "survives": f"the success survives in the world {self.world}",
            "lost": f"the success is lost in the world {self.world}",
            "cannot tell": f"one cannot tell whether the success survives in the world {self.world}",
        }
        return f"{said[self.verdict]}: {self.reason}"

    def as_dict(self) -> dict[str, Any]:
        """Return everything but the logs, for JSON."""
        own = {"sentence": self.sentence, "world": self.world, "own": self.own, "verdict": self.verdict}
        rows = {"windows": self.windows, "own_windows": self.own_windows}
        return {**own, "reason": self.reason, **{k: [asdict(w) for w in ws] for k, ws in rows.items()}}


def replay_log(
    log: Log | Path | str,
    world: str,
    robot: Robot | None = None,
    terrain: Terrain | None = None,
    mu: float | None = None,
) -> ReplayReport:
    """Replay a log's joint motion and torques in another world and tell whether its success survives.

    In every window the robot starts in the log's state, lifted until no foot is in the ground, and tracks its
    joints with the log's torques as feed-forward. A window holds if the robot does not fall, does not lean
    `TILT` more than the log, ends near it (`DRIFT`), and breaks no law there that an audit can judge; all
    windows together must make `PROGRESS` of the log's way. Friction, pushes and payload are the log's.

    Parameters
    ----------
    log
        A log or its path. Needs `q`, `v` and `torques`, evenly spaced. The facts ``joint_stiffness`` and
        ``joint_damping`` give the gains, else they are made from the robot's mass and height.
    world
        Name of a world, see `surefoot.worlds.interface.world_names`.
    robot, terrain, mu
        None for the log's own: the facts ``robot`` and ``terrain``, the channel ``mu`` [-]. Others ask
        whether the success survives there.

    Raises
    ------
    ProblemError
        In one line, for a log that lacks what a replay needs.
    MissingExtra
        If the world's engine is not installed.
    """
    log = log if isinstance(log, Log) else read_log(log)
    task = replay_task(log, robot, terrain, mu)
    make_world(world, task.robot, task.terrain, float(task.mu[0]))  # refused before any work, if it cannot be
    own = _own_world(log)
    fallen = _fall_of_the_log(task)
    if fallen:
        return ReplayReport(world, own, "cannot tell", fallen, (), ())
    pieces = _pieces(len(task.time), max(2, round(WINDOW / (task.dt * task.steps))))
    made = [_replay(task, world, *piece) for piece in pieces]
    windows, logs = tuple(w for w, _ in made), tuple(log for _, log in made)
    if not any(w.lost for w in windows) and not _progress(windows) < PROGRESS:
        return ReplayReport(world, own, "survives", _summary(windows), windows, (), logs)
    compared: tuple[WindowReplay, ...] = ()
    at_home = _at_home(log, task, robot, terrain, mu)
    if own and (own != world or at_home is not task):
        compared = tuple(_replay(at_home, own, *piece)[0] for piece in pieces)
    verdict, reason = _compare(windows, compared, own)
    return ReplayReport(world, own, verdict, reason, windows, compared, logs)


def _at_home(
    log: Log, task: ReplayTask, robot: Robot | None, terrain: Terrain | None, mu: float | None
) -> ReplayTask:
    """Return the task on the log's own ground, where it tells that and another was given."""
    own_ground, own_mu = "terrain" in log.facts, "mu" in log or "contact_friction" in log
    if (terrain is None or not own_ground) and (mu is None or not own_mu):
        return task
    return replay_task(log, robot, None if own_ground else terrain, None if own_mu else mu)


def _own_world(log: Log) -> str:
    """Return the name of the world that a log comes from; empty where that is not one of ours.

    A recording is of a MuJoCo loop: our MuJoCo world is its engine, on ground close to rigid.
    """
    origin = str(log.facts.get("world", ""))
    if not origin and log.facts.get("kind") == "recording":
        return "mujoco"
    return next((name for name in WORLDS if origin and origin == WORLDS.object_name(name)), "")


def _fall_of_the_log(task: ReplayTask) -> str:
    """Return why a log has no success that could survive; empty where it has."""
    height = float(task.q[0, 2] - task.terrain.height(task.q[0, :2]))
    for row in range(0, len(task.q), 5):
        if Fall().happened(task.q[row], height, task.terrain) is not None:
            return f"the robot falls in the log itself, at {task.time[row]:.3f} s"
    return ""


def _pieces(rows: int, length: int) -> list[tuple[int, int]]:
    """Return (first, last) rows of the windows; a short rest belongs to the last."""
    starts = list(range(0, max(rows - length // 2, 1), length))
    return list(zip(starts, [*starts[1:], rows], strict=True))


class ReplayTracking(Controller):
    """Tracks the joints of a log from a row on, its torques as feed-forward, within the effort limits."""

    def __init__(self, task: ReplayTask, first: int, last: int) -> None:
        self._task, self._first, self._last = task, first, last
        self._limits = task.robot.effort_limits

    def step(self, state: RobotState) -> Command:
        """Return the torques at a time [s] from the first row on."""
        task, past = self._task, round(state.time / self._task.dt)
        row = min(self._first + past // task.steps, self._last - 1)
        torques = task.torques[row] + task.stiffness * (task.q[row, 7:] - state.q[7:])
        torques += task.damping * (task.v[row, 6:] - state.v[6:])
        return Command(np.clip(torques, -self._limits, self._limits))


def _replay(task: ReplayTask, name: str, first: int, last: int) -> tuple[WindowReplay, Log]:
    """Replay rows `first` to `last` - 1 in a world, and judge them."""
    at = {"payload_position": task.payload_position} if task.payload_position.any() else {}
    mu, rows, start = float(task.mu[first]), range(first, last), float(task.time[first])
    world = make_world(name, task.robot, task.terrain, mu, dt=task.dt, payload=task.payload, **at)
    length, q, v = task.dt * task.steps, task.q[first].copy(), task.v[first]
    times = [length * (row - first) for row in rows]
    world.reset(q, v)
    q[:3] += max(-float(world.contacts().gaps.min(initial=0.0)), 0.0) * task.terrain.normal(q[:2])
    scenario = Scenario(
        length * len(rows), mu, start=q, velocity=v,
        pushes=[Push(t, tuple(task.push[row]), length) for t, row in zip(times, rows, strict=True)
                if task.push[row].any()],
        ice=[Ice(t, float(task.mu[row])) for t, row in zip(times, rows, strict=True)
             if row > first and task.mu[row] != task.mu[row - 1]],
    )  # fmt: skip
    try:
        log = run(world, ReplayTracking(task, first, last), scenario)
    except SimulationError as error:
        raise ProblemError(f"the replay cannot begin at {start:.3f} s: {error}") from error
    outcome, end = str(log.facts["outcome"]), start + float(log["time"][-1])
    seen = log["q"][:: task.steps]
    logged = task.q[first : first + len(seen)]
    planned = logged[-1, :2] - logged[0, :2]
    moved, length = log["q"][-1, :2] - log["q"][0, :2], float(np.linalg.norm(planned))
    tilt, way = _lean(seen, logged), float(moved @ planned) / length if length > 0.0 else 0.0
    drift = float(np.linalg.norm(log["q"][-1, :3] - logged[-1, :3]))
    report = audit_log(log, task.robot)
    first_of = {v.law: str(v) for v in reversed(report.violations)}
    broken = tuple(first_of[law] for law in report.laws_broken)
    lost = _failure_reason(outcome, end, tilt, broken)
    height = float(task.q[first, 2] - task.terrain.height(task.q[first, :2]))
    if not lost and drift > DRIFT * (abs(height) + length):
        lost = f"it is {drift:.2f} m from the log at {end:.3f} s"
    return WindowReplay(start, end, outcome, way, length, tilt, drift, broken, lost), log


def _failure_reason(outcome: str, end: float, tilt: float, broken: tuple[str, ...]) -> str:
    """Return the reason why a window's replay fails; empty where it does not."""
    if outcome != Ending.DONE:
        return f"it {'falls' if outcome == Ending.FELL else 'cannot go on'} at {end:.3f} s"
    if tilt > TILT:
        return f"it leans {math.degrees(tilt):.0f} deg more than the log before {end:.3f} s"
    return f"it breaks {broken[0]}" if broken else ""


def _lean(q: FloatArray, logged: FloatArray) -> float:
    """Return the largest angle between the bases' vertical axes over rows [rad]."""
    ups = [rotation_from_quaternion(part[:, 3:7])[:, :, 2] for part in (q, logged[: len(q)])]
    chord = np.linalg.norm(ups[0] - ups[1], axis=1)
    return float(2.0 * np.arcsin(min(0.5 * float(chord.max(initial=0.0)), 1.0)))


def _progress(windows: tuple[WindowReplay, ...]) -> float:
    logged = sum(w.logged_way for w in windows)
    return sum(w.way for w in windows) / logged if logged >= LEAST_WAY else math.nan


def _summary(windows: tuple[WindowReplay, ...]) -> str:
    """Return what all windows have in common, in a line."""
    share, count = _progress(windows), len(windows)
    way = "" if math.isnan(share) else f", {100.0 * share:.0f} % of the log's way"
    lean = math.degrees(max(w.tilt for w in windows))
    drift = max(w.drift for w in windows)
    return (
        f"{count} window{'s' if count > 1 else ''} without a fall or a broken law{way}, at most {lean:.1f} "
        f"deg of lean and {drift:.3f} m from the log"
    )


def _compare(
    windows: tuple[WindowReplay, ...], own: tuple[WindowReplay, ...], name: str
) -> tuple[Survival, str]:
    """Return the verdict on windows of which one at least does not hold, by those in the log's own world."""
    failed = [k for k, w in enumerate(windows) if w.lost]
    if not own:
        why = windows[failed[0]].lost if failed else f"it makes {100.0 * _progress(windows):.0f} % of the way"
        rest = "that is the log's own world" if name else "the log's own world is not here to compare"
        return "cannot tell", f"{why}, and {rest}"
    for k in failed:
        if not own[k].lost:
            return "lost", f"{windows[k].lost}; in the log's own world ({name}) the same replay holds"
    if not failed and not _progress(own) < PROGRESS:
        shares = f"{100.0 * _progress(windows):.0f} % of the log's way, {100.0 * _progress(own):.0f} %"
        return "lost", f"it makes {shares} in the log's own world ({name})"
    why = f"in the log's own world ({name}) the same replay fails too"
    return "cannot tell", f"{why}: {next((w.lost for w in own if w.lost), 'it lags behind')}"
