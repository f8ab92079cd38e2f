"""A plan: a log of a motion that has not happened yet, with how it was found and what it is worth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import NoSolution, ProblemError
from surefoot.base.loaded import ACTS, loaded_feet
from surefoot.base.numerics.phases import runs_of
from surefoot.base.spatial import GRAVITY
from surefoot.contact import Status
from surefoot.mechanics import FlatTerrain, Robot, Terrain, loaded_robot, read_terrain
from surefoot.motion.planning.certificate import certify
from surefoot.motion.planning.trajectory import TOLERANCE, Trajectory, rollout
from surefoot.records import Log, read_log

if TYPE_CHECKING:
    from surefoot.motion.planning.transcription.direct_problem import DirectProblem


@dataclass(frozen=True)
class Phase:
    """A foot on the ground from `start` to `end` [s]."""

    foot: str
    start: float
    end: float


@dataclass(frozen=True)
class PlanSearch:
    """How a plan was looked for.

    Attributes
    ----------
    task
        Its name.
    method
        The way that was taken.
    cost
        Of what was found.
    reached
        Whether the goal is reached within the task's tolerance, judged on the trajectory.
    iterations
        Of the optimiser.
    seconds
        Wall time of the search [s].
    goal
        What was asked for and what was reached, in one line.
    stopped
        Why the search ended where the goal is not reached: a `Status` that is not SOLVED.
    """

    task: str
    method: str
    cost: float
    reached: bool
    iterations: int
    seconds: float
    goal: str = ""
    stopped: Status = Status.STALLED


@dataclass(repr=False, eq=False)
class Plan(Log):
    """A motion with its forces, as a log; one row per knot.

    A row holds the state at a knot's start, and the forces that act until the next; gaps and positions are
    those at the knot's end, where the contact laws of an exact first-order step hold. A plan is SOLVED only
    where its own rollout obeys the laws to 1e-8 and reaches the goal, and its `certificate` holds; where that
    alone fails, it is ALMOST.

    Attributes
    ----------
    robot, terrain
        Who moves where; None for a plan from a file.

    Examples
    --------
    >>> import surefoot as sf
    >>> from surefoot.motion.planning import rollout
    >>> robot = sf.load_robot("go2")
    >>> motion = rollout(robot, sf.place(robot), np.zeros(18), np.zeros((10, 12)), dt=0.01)
    >>> search = PlanSearch("fall", "none", cost=0.0, reached=True, iterations=0, seconds=0.0)
    >>> plan = plan_from(motion, robot, search)
    >>> plan.status.value, plan.law_residual < 1e-8, len(plan), len(plan.contacts)
    ('solved', True, 10, 4)
    """

    robot: Robot | None = field(default=None, repr=False, compare=False)
    terrain: Terrain | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        return f"Plan({self.task!r}, {self.status.name}, {len(self)} knots, method={self.method!r})"

    def __str__(self) -> str:
        laws = f"its laws hold to {self.law_residual:.0e}"
        size = f"{len(self)} knots, {self.duration:.3g} s"
        return f"Plan of {self.task!r} by {self.method}: {self.status.name}, {size}; {laws}."

    @property
    def status(self) -> Status:
        """SOLVED, or why not."""
        return Status(self.facts["status"])

    @property
    def task(self) -> str:
        """What it does."""
        return str(self.facts["task"])

    @property
    def method(self) -> str:
        """The way that found it."""
        return str(self.facts["method"])

    @property
    def cost(self) -> float:
        """Of the method's own objective, in the unit of that."""
        return float(self.facts["cost"])

    @property
    def law_residual(self) -> float:
        """Largest velocity error of its contact problems, see `Trajectory.law_residual`."""
        return float(self.facts["law_residual"])

    @property
    def iterations(self) -> int:
        """Of the method."""
        return int(self.facts["iterations"])

    @property
    def time(self) -> float:
        """Wall time of the search [s]."""
        return float(self.facts["search_time"])

    @property
    def contacts(self) -> list[Phase]:
        """When which foot is on the ground, in the order of the feet."""
        return contact_phases(self)

    def again(self, robot: Robot | None = None, terrain: Terrain | None = None) -> Trajectory:
        """Return where the plan's torques lead when they are run once more, by exact steps.

        What a file says of itself can be checked so: `law_residual` of the result, and its states (N + 1, nq)
        against the rows' ``q`` and the fact ``end_q``.

        Parameters
        ----------
        robot, terrain
            Who moves where; None for those that the plan was made with.

        Raises
        ------
        ProblemError
            For a plan from a file without a robot, or a robot that does not fit.
        """
        who = self.robot if robot is None else loaded_robot(robot, float(self.facts.get("payload", 0.0)))
        if who is None:
            raise ProblemError("a plan from a file does not know its robot: give it, as in plan.again(robot)")
        where = planned_ground(self) if terrain is None else terrain
        dt, mu = float(self.fact("dt")), float(self["mu"][0])
        return rollout(who, self["q"][0], self["v"][0], self["torques"], dt=dt, mu=mu, terrain=where)

    def raise_if_failed(self) -> Plan:
        """Return the plan if it is SOLVED.

        Raises
        ------
        NoSolution
            If it is not; the error carries the plan as `solution`.
        """
        if self.status is not Status.SOLVED:
            said = f"the plan for {self.task} is {self.status.value}: {self.facts['goal']}"
            raise NoSolution(said, None, self)
        return self

    @classmethod
    def read(cls, path: Path | str) -> Plan:
        """Return a plan that was saved with `save`.

        Raises
        ------
        ProblemError
            If the file is no log, or a log that is no plan.
        """
        return cls.of(read_log(path))

    @classmethod
    def of(cls, log: Log) -> Plan:
        """Return a log as the plan that it holds.

        Raises
        ------
        ProblemError
            If it does not tell what a plan tells.
        """
        facts = dict(log.facts)
        if "road" in facts:  # as plans of 0.1.0's first weeks call it
            facts.setdefault("method", facts.pop("road"))
        plan = cls(log.arrays, facts, channels=log.channels)
        for name in ("task", "method", "status", "cost", "law_residual", "iterations", "search_time", "goal"):
            plan.fact(name)
        return plan


def planned_ground(plan: Log) -> Terrain | None:
    """Return the ground of a plan: its own, else what its file says; None for flat ground."""
    own, text = plan.terrain if isinstance(plan, Plan) else None, str(plan.facts.get("terrain", ""))
    return own or (read_terrain(text) if text else None)


def plan_from(
    trajectory: Trajectory,
    robot: Robot,
    search: PlanSearch,
    terrain: Terrain | None = None,
    problem: DirectProblem | None = None,
    **facts: Any,
) -> Plan:
    """Return a trajectory and how it was found as a plan.

    Parameters
    ----------
    trajectory
        From `rollout`, or linked by knots of the same kind.
    robot
        Who moves.
    search
        How it was found.
    terrain
        None for flat ground.
    problem
        Whose bodies touch beside feet on the ground; None for none.
    facts
        Further facts for the log.

    Returns
    -------
    Plan
        SOLVED only where the trajectory is lawful to 1e-8, the goal reached and the certificate holds (see
        `certify`), else ALMOST; where it is not lawful, STALLED whatever the search says, and INVALID where
        it is not finite. Rows after a loss are left out.
    """
    rows = int(np.isfinite(trajectory.q[1:]).all(axis=1).sum())
    terrain = FlatTerrain() if terrain is None else terrain
    arrays = _arrays(trajectory, robot, terrain, rows)
    status = _status(trajectory, search, rows)
    if status is Status.SOLVED:
        certificate = certify(trajectory, robot, terrain, problem)
        status = Status.SOLVED if certificate.holds else Status.ALMOST
        search = replace(search, goal=f"{search.goal}; {certificate}")
        facts |= certificate.facts
    said = plan_facts(
        robot, search, status, trajectory.law_residual, (trajectory.dt, trajectory.mu),
        (trajectory.q[rows], trajectory.v[rows]),
    ) | {
        "duration": trajectory.dt * len(trajectory),
        "outcome": "done" if rows == len(trajectory) else "invalid",
        **({"terrain": terrain.text} if terrain.text else {}),
    }  # fmt: skip
    return Plan(arrays, said | facts, robot=robot, terrain=terrain)


def plan_facts(
    robot: Robot,
    search: PlanSearch,
    status: Status,
    law_residual: float,
    numbers: tuple[float, float],
    end: tuple[FloatArray, FloatArray],
) -> dict[str, Any]:
    """Return what is said once of a plan.

    Parameters
    ----------
    robot, search, status, law_residual
        Who moves, how the plan was found, and what it is worth.
    numbers
        Length of a row [s] and friction.
    end
        (nq,), (nv,) the last state.
    """
    points, (dt, mu) = robot.contact_points, numbers
    return {
        "kind": "plan", "task": search.task, "method": search.method, "status": status.value,
        "goal": search.goal, "cost": float(search.cost), "law_residual": law_residual,
        "iterations": int(search.iterations), "search_time": float(search.seconds), "robot": robot.name,
        "world": "first-order steps", "mass": robot.mass, "mass_controller": robot.mass, "dt": dt,
        "duration": 0.0, "feet": list(robot.foot_names), "joints": list(robot.joint_names),
        "contact_foot": points.foot, "contact_centres": points.centres, "effort_limits": robot.effort_limits,
        "normal_min": 0.0, "normal_max": float("inf"), "mu_controller": mu, "outcome": "done",
        "end_q": end[0].copy(), "end_v": end[1].copy(),
    }  # fmt: skip


def _status(trajectory: Trajectory, search: PlanSearch, rows: int) -> Status:
    """Return what may be said of a plan."""
    if rows < len(trajectory):
        return Status.INVALID
    if not (trajectory.lawful and trajectory.law_residual <= TOLERANCE):
        return Status.STALLED
    if search.reached:
        return Status.SOLVED
    return Status.STALLED if search.stopped is Status.SOLVED else search.stopped


def _arrays(trajectory: Trajectory, robot: Robot, terrain: Terrain, rows: int) -> dict[str, Any]:
    """Return the log's channels: (rows, ...)."""
    t, now, end = trajectory, slice(0, rows), slice(1, rows + 1)
    motion = {
        "q": t.q[now], "v": t.v[now], "torques": t.torques[now], "forces": t.impulses[now] / t.dt,
        "gaps": t.gaps[end], "contact_velocities": t.speeds[now], "contact_positions": t.positions[end],
    }  # fmt: skip
    return plan_channels(motion, (t.dt, t.mu), terrain, robot.effort_limits)


def plan_channels(
    motion: dict[str, Any], numbers: tuple[float, float], terrain: Terrain, effort: FloatArray
) -> dict[str, Any]:
    """Return the channels of a plan: those of its motion, and what follows from them.

    Parameters
    ----------
    motion
        By name, (rows, ...) each: q, v, torques, forces, gaps, contact_velocities, contact_positions.
    numbers
        Length of a row [s] and friction.
    terrain, effort
        The ground, and (joints,) torque limits [N m].
    """
    forces, (dt, mu) = motion["forces"], numbers
    rows = len(forces)
    return {
        "time": dt * np.arange(rows, dtype=np.float64), **motion, "forces_commanded": forces.copy(),
        "normals": terrain.normal(motion["contact_positions"][..., :2]),
        "active": forces[:, :, 2] > 0.0, "attained": np.ones(rows, dtype=bool),
        "saturated": (np.abs(motion["torques"]) >= effort * (1.0 - 1e-6)).any(axis=1),
        "push": np.zeros((rows, 3)), "mu": np.full(rows, mu),
    }  # fmt: skip


def contact_phases(log: Log) -> list[Phase]:
    """Return when the feet of a log are on the ground: spans of rows with a normal force, foot by foot."""
    feet: Sequence[str] = log.fact("feet")
    foot = np.asarray(log.fact("contact_foot"), dtype=np.int64)
    dt, weight = float(log.fact("dt")), float(log.fact("mass")) * GRAVITY
    out = []
    for number, name in enumerate(feet):
        loads: FloatArray = log["forces"][:, foot == number, 2].sum(axis=1)
        out += [
            Phase(name, round(a * dt, 9), round(b * dt, 9))
            for a, b in runs_of(loaded_feet(loads, weight, ACTS))
        ]
    return out
