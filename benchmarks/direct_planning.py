"""What the direct method finds, at what price, and how far off it is when run again: docs/direct-planning.md.

Run: python -m benchmarks.direct_planning [--quick] [--json]. Every motion is planned with coarse knots, then
with finer ones from there. A plan's torques are then replayed in the rigid world: by the same steps, and by
its own, of second order and 1 ms.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.printing import options, show, table
from surefoot.audit import audit_log
from surefoot.planning.direct import (
    DirectPlan,
    DirectProblem,
    finer,
    plan_direct,
    planar_biped,
    planar_hopper,
    rest_to_rest,
)
from surefoot.planning.direct.planner import SMOOTHINGS
from surefoot.planning.trajectory import Trajectory
from surefoot.planning.transcription.follow import follow
from surefoot.planning.transcription.judge import departure
from surefoot.simulation.rigid import RigidWorld

AGAIN, LAST = (1e-2, 1e-4, 1e-6, 1e-8), 1e-8
"""Smoothings from a plan that is there, and the last of all [J]."""


@dataclass(frozen=True)
class Case:
    """A motion, and by how much its knots are made finer in the end."""

    name: str
    problem: DirectProblem
    factor: int


def cases(quick: bool) -> list[Case]:
    """Return the motions; the first alone where it has to be quick."""
    out = [Case("hopper, 0.3 m on", rest_to_rest(planar_hopper(), 0.3), 3)]
    if quick:
        return out
    return [
        *out,
        Case("hopper, 0.3 m on, up by 0.15 m", rest_to_rest(planar_hopper(), 0.3, 0.15), 3),
        Case("biped, 0.4 m on", rest_to_rest(planar_biped(), 0.4), 3),
    ]


def replayed(problem: DirectProblem, motion: Trajectory, dt: float, order: int) -> float:
    """Return how far a rigid world gets from a motion under its torques, by q ⊖ q [m, rad]."""
    import pinocchio

    world = RigidWorld(problem.robot, problem.terrain, mu=problem.mu, dt=dt, order=order)
    world.reset(motion.q[0], motion.v[0])
    worst = 0.0
    for k, torques in enumerate(motion.torques):
        for _ in range(round(problem.dt / dt)):
            world.step(torques)
        off = pinocchio.difference(problem.robot.model, motion.q[k + 1], world.state()[0])
        worst = max(worst, float(np.abs(off).max()))
    return worst


def row_of(name: str, problem: DirectProblem, found: DirectPlan, spent: float) -> list[str]:
    """Return the cells of one plan."""
    plan, motion = found.plan, found.trajectory
    alone = follow(problem, found.motion, feedback=False)
    report = audit_log(plan, problem.robot)
    worst = ", ".join(dict.fromkeys(f"{v.law} {v.value:.2g} {v.unit}" for v in report.violations[:2]))
    feet = "; ".join(
        f"{foot} " + " ".join(f"{p.start:.2f}-{p.end:.2f}" for p in plan.contacts if p.foot == foot)
        for foot in problem.robot.foot_names
    )
    return [
        name, f"{problem.knots} x {1e3 * problem.dt:.0f} ms", plan.status.value, f"{spent:.1f}",
        str(plan.iterations), f"{plan.cost:.4g}", f"{plan.law_residual:.1e}",
        f"{found.departure:.1e}", f"{departure(problem.robot, found.motion, alone):.1e}",
        f"{replayed(problem, motion, problem.dt, 1):.1e}", f"{replayed(problem, motion, 1e-3, 2):.2g}",
        f"{report.verdict} {worst}".strip(), feet,
    ]  # fmt: skip


def timed(problem: DirectProblem, **settings: Any) -> tuple[DirectPlan, float]:
    """Return a plan and the processor time that it took [s]."""
    begin = time.process_time()
    return plan_direct(problem, **settings), time.process_time() - begin


def _figures(found: DirectPlan, spent: float) -> tuple[str, ...]:
    """Return status, iterations, cost and time."""
    plan = found.plan
    return plan.status.value, str(plan.iterations), f"{plan.cost:.4g}", f"{spent:.1f}"


def plan_table(chosen: Sequence[Case]) -> Table:
    """Return the table of plans, coarse and fine."""
    columns = (
        "motion", "knots", "status", "CPU s", "iterations", "cost", "law residual",
        "off with feedback", "off without", "rigid world, same step", "rigid world, 1 ms", "audit",
        "contacts [s]",
    )  # fmt: skip
    rows = []
    for case in chosen:
        coarse, spent = timed(case.problem, smoothings=SMOOTHINGS)
        rows.append(row_of(case.name, case.problem, coarse, spent))
        problem = finer(case.problem, case.factor)
        fine, spent = timed(problem, guess=coarse.trajectory, smoothings=AGAIN)
        rows.append(row_of("  finer, from there", problem, fine, spent))
    return table(columns, rows, "motions whose contacts nobody gave", left=len(columns))


def start_table(problem: DirectProblem, firsts: Sequence[float]) -> Table:
    """Return what comes of the first smoothing."""
    rows = []
    for first in firsts:
        found, spent = timed(problem, smoothings=[e for e in SMOOTHINGS if LAST <= e <= first])
        rows.append((f"{first:g}", *_figures(found, spent)))
    columns = ("first eps [J]", "status", "iterations", "cost", "CPU s")
    return table(columns, rows, "the first smoothing decides which motion is found")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    given = options(__doc__, "the hopper only").parse_args(arguments)
    show(_tables(given.quick), given.json, Console(width=230))


def _tables(quick: bool) -> Iterator[Table]:
    yield plan_table(cases(quick))
    firsts = (1.0, 1e-8) if quick else (1.0, 1e-2, 1e-4, 1e-8)
    yield start_table(rest_to_rest(planar_hopper(), 0.3), firsts)


if __name__ == "__main__":
    main()
