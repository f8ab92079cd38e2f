"""`surefoot bench execution`: plans executed in MuJoCo from 20 seeds, with two motor models."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli.console import progress_bar
from surefoot.app.cli.output import check_out
from surefoot.base.errors import ProblemError, unknown_name

if TYPE_CHECKING:
    from benchmarks.execution.trials import Row
    from surefoot.motion.planning import Plan

TASKS: dict[str, float | None] = {"jump": 0.4, "backflip": None, "stand-up": None}
"""Tasks and their numbers."""
QUICK_STEP = 1e-3
"""Length of a step of --quick [s]."""


def execution(
    task: Annotated[list[str] | None, typer.Option(help="Only this task; may be repeated.")] = None,
    plan: Annotated[Path | None, typer.Option(help="Execute this saved plan instead.")] = None,
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Runs of each.")] = 20,
    matrix: Annotated[bool, typer.Option("--matrix", help="Four quadrupeds, eight jumps, a flip.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="The stand-up alone, two seeds.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write the JSON to a new folder below this one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Execute a jump, a backflip and a stand-up of Go2 in MuJoCo; print who lands, within which limits.

    The start, the friction and the mass are off by what the seed says; the motors are a box of the URDF's
    torque and speed, or give less torque the faster they turn.
    """
    from benchmarks.execution.trials import measure
    from surefoot.app.cli import extras
    from surefoot.motion.planning import Plan as SavedPlan

    check_out(out)
    extras.require((*extras.robot_packages("go2"), "mujoco"))
    if quick:
        task, seeds = task or ["stand-up"], min(seeds, 2)
    if matrix:
        measure_matrix(seeds, quick, as_json, out)
        return
    chosen = tuple(task or TASKS)
    for name in chosen:
        if name not in TASKS:
            raise ProblemError(unknown_name("task", name, tuple(TASKS)))
    rows: list[Row] = []
    if plan is not None:
        read = SavedPlan.read(plan)
        with progress_bar(not as_json, f"execute {plan.name}", 1.0) as show:
            rows += measure(read, read.task, seeds, tell=show)
    else:
        for name in chosen:
            made = planned(name, quick)
            with progress_bar(not as_json, f"execute {name}", 1.0) as show:
                rows += measure(made, name, seeds, tell=show, dt=QUICK_STEP if quick else None)
    record = [asdict(row) for row in rows]
    report(record, as_json, lambda console: _print(console, rows), out=out, name="execution")


def measure_matrix(seeds: int, quick: bool, as_json: bool, out: Path | None) -> None:
    """Plan and execute the cells of the matrix, quickly the first alone, and print them."""
    from benchmarks.execution.matrix import Cell, cells, measured

    made, chosen = list[Cell](), cells()[:1] if quick else cells()
    with progress_bar(not as_json, "matrix", 1.0) as show:
        for number, cell in enumerate(chosen):
            made.append(measured(*cell, seeds))
            if show is not None:
                show((number + 1) / len(chosen))

    def printed(console: Console) -> None:
        runs = [c.runs for c in made if c.runs is not None]
        lawful, count = sum(r.lawful for r in runs), sum(r.seeds for r in runs)
        rows = [
            (
                c.robot,
                c.task,
                c.status,
                f"{c.seconds:.1f}",
                f"{c.runs.lawful} of {c.runs.seeds}" if c.runs else "",
            )
            for c in made
        ]
        solved = sum(c.status == "solved" for c in made)
        title = f"{solved} of {len(made)} cells solved, {lawful} of {count} executions landed lawfully"
        console.print(table(("robot", "task", "status", "CPU [s]", "landed lawfully"), rows, title, 2))

    report([asdict(c) for c in made], as_json, printed, out=out, name="execution-matrix")


def planned(task: str, quick: bool = False) -> Plan:
    """Return the plan of a task for Go2; a quick stand-up is looked for in MuJoCo, which is faster."""
    from surefoot.mechanics.robot import load_robot
    from surefoot.motion.planning.planner import plan as make_plan
    from surefoot.motion.planning.stand_up.stand_up_task import StandUp
    from surefoot.motion.planning.tasks.task import PlanRequest
    from surefoot.worlds.mujoco.mujoco_world import MujocoWorld

    robot = load_robot("go2")
    if task == "stand-up" and quick:
        model = MujocoWorld(robot, dt=2e-3, collision="full")
        return StandUp(model=model).plan(PlanRequest(robot, 180.0, dt=2e-3), lambda iteration: None)
    return make_plan(robot, task, TASKS[task])


def _print(console: Console, rows: list[Row]) -> None:
    names = (
        "task", "motors", "landed", "lawful", "torque use", "speed use", "moved [m]", "turned [deg]",
        "failures",
    )  # fmt: skip
    cells = [
        (
            row.task, row.motors, f"{row.landed} of {row.seeds}", str(row.lawful),
            f"{row.torque_use_max:.2f}", f"{row.speed_use_max:.2f}", f"{row.moved:.2f}", f"{row.turned:.0f}",
            "; ".join((*row.failures, *row.laws)) or "none",
        )
        for row in rows
    ]  # fmt: skip
    title = "Go2 in MuJoCo: start, friction and mass as no plan expects them"
    console.print(table(names, cells, title, 2, names[-1:]))
