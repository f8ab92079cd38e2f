"""`surefoot plan`: a motion through contact, and what became of it in a simulator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.app.cli import options
from surefoot.app.cli.console import Table, plain_console, progress_bar
from surefoot.app.cli.output import check_out, new_run_folder, to_json
from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError, check_name

if TYPE_CHECKING:
    from surefoot.motion.planning.plan import Plan
    from surefoot.motion.planning.tasks.task import Iteration


@dataclass(frozen=True, kw_only=True)
class JumpOptions:
    """Where a jump begins, and where it goes."""

    direction: Annotated[float, typer.Option(help="Where to jump, from ahead to the left [deg].")] = 0.0
    turn: Annotated[float, typer.Option(help="By how much to turn left in a jump [deg].")] = 0.0
    terrain: Annotated[
        str | None,
        typer.Option(help="Ground of a jump: slope:DEG, stairs:HEIGHT,DEPTH or pit:START,LENGTH,DEPTH [m]."),
    ] = None
    over: Annotated[float, typer.Option(help="Width of a gap ahead that a jump clears [m].")] = 0.0
    start: Annotated[
        Path | None,
        typer.Option(help="Pose to start from: a list of numbers (YAML, JSON), or where a plan or log ends."),
    ] = None
    near: Annotated[
        Path | None, typer.Option(help="Saved plan of the same task to start the search from: it is shorter.")
    ] = None

    @property
    def numbers(self) -> dict[str, Any]:
        """As `surefoot.plan` takes them."""
        from surefoot.mechanics import read_terrain
        from surefoot.motion.planning.plan import Plan

        return {
            **{name: math.radians(real_number(f"--{name} [deg]", value, low=-180.0, high=180.0))
               for name, value in (("direction", self.direction), ("turn", self.turn))},
            "over": self.over,
            "terrain": None if self.terrain is None else read_terrain(self.terrain, "--terrain"),
            "start": None if self.start is None else _pose(self.start),
            "near": None if self.near is None else Plan.read(self.near),
        }  # fmt: skip


def plan(
    *,
    wanted: Annotated[
        list[str],
        typer.Argument(
            help="ROBOT as for walk (default go2); ball, hopper, push, jump, jump-up, backflip or stand-up "
            "(docs/plan-tasks.md); its number: a distance or height [m], a speed [m/s].",
            metavar="[ROBOT] TASK [AMOUNT]",
        ),
    ],
    feet: options.FootFrames = None,
    mu: options.Friction = 0.6,
    dt: Annotated[float | None, typer.Option(help="Length of a knot [s].")] = None,
    seed: Annotated[int, typer.Option(help="Of random starts, and of the executed run.")] = 0,
    max_iterations: Annotated[int | None, typer.Option(help="Most iterations of the search.")] = None,
    payload: Annotated[float, typer.Option(help="Mass on the base that the plan knows of [kg].")] = 0.0,
    jumping: JumpOptions,
    execute: Annotated[
        str | None,
        typer.Option(help="World to carry it out in: mujoco or mujoco-exact. The audit judges the run."),
    ] = None,
    leaving: options.Leaving,
) -> int:
    """Plan a motion through contact that obeys the laws, and carry it out if asked to.

    Exit code 0 if the plan is solved (and, carried out, landed without a broken law), 1 if not, 2 for wrong
    input.
    """
    from surefoot.app.cli import parsing
    from surefoot.app.cli.signals import ends_softly
    from surefoot.motion.planning.tasks.task_names import find_task

    console = plain_console(quiet=leaving.as_json)
    parsing.friction("--mu", mu)
    robot, task, amount = _words(wanted)
    found = find_task(task)
    if execute is not None:
        check_name("world of --execute", execute, ("mujoco", "mujoco-exact"))
        if not found.robots:
            raise ProblemError(f"--execute is of robots on legs; the task {task} has a body of its own")
    check_out(leaving.out)
    options.require(robot, ("pin", *(["mujoco"] if execute else [])), leaving)
    who = _robot(robot, feet, found)
    numbers = {
        "mu": mu, "dt": dt, "seed": seed, "max_iterations": max_iterations,
        "payload": payload, **jumping.numbers,
    }  # fmt: skip
    with ends_softly() as stop:
        screen = plain_console(stderr=True, quiet=leaving.as_json)
        made = _search(screen, who, task, amount, numbers)
        if execute is not None:
            console.print(f"{made.task}: {made.status.value}; {made.facts['goal']}")
        folder = new_run_folder(leaving.out, f"plan-{task}")
        ended = made.facts.get("interrupted", False) or stop.number is not None
        executed = None if execute is None or ended else _execute(made, execute, seed, folder)
        good = _write(made, executed, folder, leaving, console)
        if ended or stop.number is not None:
            return stop.code
    return 0 if good else 1


def _words(words: list[str]) -> tuple[str | None, str, float | None]:
    """Return robot (None for the default), task and number (None for the task's own)."""
    from surefoot.base.text_files import finite_in_text
    from surefoot.motion.planning.tasks.task_names import TASKS

    first = bool(words[1:]) and words[0] not in TASKS and words[1][:1].isalpha()  # numbers follow a task
    robot, rest = words[0] if first else None, words[first:]
    if len(rest) > 2:
        raise ProblemError(f"plan takes [ROBOT] TASK [AMOUNT], got {' '.join(words)}")
    return robot, rest[0], finite_in_text("AMOUNT", rest[1]) if rest[1:] else None


def _pose(file: Path) -> Any:
    """Return the configuration that a file lists, or that of the end of a plan or log."""
    from surefoot.base.text_files import read_yaml
    from surefoot.records import read_log

    if file.suffix in (".yaml", ".yml", ".json"):
        return read_yaml(file, "the start") or []
    log = read_log(file)
    return log.facts.get("end_q", log["q"][-1])


def _robot(name: str | None, feet: str | None, task: Any) -> Any:
    """Return the robot that was asked for; None for the task's own."""
    from surefoot.app.cli.robots import load

    if not task.robots:
        if name is not None or feet is not None:
            raise ProblemError(f"the task {task.name} has a robot of its own: it takes no {name or '--feet'}")
        return None
    return load(name, feet, feet_needed=True)


def _search(console: Any, robot: Any, task: str, amount: float | None, numbers: dict[str, Any]) -> Plan:
    """Return the plan, after Ctrl-C the best so far; on a terminal the iterations are shown."""
    from surefoot.motion.planning.planner import plan

    with console.status(f"planning {task}") as status:
        return plan(robot, task, amount, tell=lambda one: status.update(_line(task, one)), **numbers)


def _line(task: str, iteration: Iteration) -> str:
    """Return one line about where a search is."""
    said = f"planning {task}: iteration {iteration.number}, cost {iteration.cost:.4g}"
    said += f", law residual {iteration.law_residual:.1e}"
    return f"{said}, {iteration.note}" if iteration.note else said


def _execute(made: Plan, world: str, seed: int, folder: Path) -> Any:
    """Carry a plan out and save the run's log."""
    from surefoot.worlds.running.plan_execution import execute

    executed = execute(made, world=world, seed=seed)
    executed.log.save(folder / "executed.npz")
    return executed


def _facts(made: Plan, executed: Any) -> dict[str, Any]:
    """Return what --json prints."""
    names = ("landed", "why", "laws", "torque_use_max", "speed_use_max")
    done = None if executed is None else {name: getattr(executed, name) for name in names}
    certified = ("momentum_error", "replay_apart", "replay_speed", "replay_time")
    return {
        "task": made.task,
        "robot": made.facts["robot"],
        "method": made.method,
        "status": made.status.value,
        "goal": made.facts["goal"],
        "cost": made.cost,
        "law_residual": made.law_residual,
        **{name: made.facts.get(name) for name in certified},
        "iterations": made.iterations,
        "time": made.time,
        "knots": len(made),
        "dt": made.facts["dt"],
        "contacts": [vars(phase) for phase in made.contacts],
        "executed": done,
    }


def _write(made: Plan, executed: Any, folder: Path, leaving: options.Leaving, console: Any) -> bool:
    """Write all that a plan leaves, say what it is, and return whether all went well."""
    from surefoot.app.cli.run_files import RunFiles
    from surefoot.app.viz.plan_plots import draw_plan
    from surefoot.contact import Status

    files = RunFiles(made if executed is None else executed.log, folder)
    files.write("plan.npz", made.save)
    facts = {**_facts(made, executed), "folder": str(folder), "unwritten": files.unwritten}
    files.write_summary(facts)
    if leaving.video and made.robot is not None and made.terrain is not None:
        with progress_bar(not leaving.as_json, "filming", 1.0) as tell:
            files.film(made.robot, made.terrain, tell, leaving.hd)
    if leaving.as_json:
        print(to_json(facts))
    good, done = made.status is Status.SOLVED, facts["executed"]
    headline = f"{made.task}: {made.status.value}; {made.facts['goal']}"
    if done is not None:
        good = good and done["landed"] and not done["laws"]
        laws = "no law was broken" if not done["laws"] else "laws broken: " + "; ".join(done["laws"])
        headline += f"; carried out: {'landed' if done['landed'] else 'did not land: ' + done['why']}, {laws}"
    files.publish(
        console, f"Plan: {made.task}", (headline, good), (_tables(made, facts), []),
        (lambda log, where: draw_plan(made, where)) if leaving.report else None,
    )  # fmt: skip
    return good and not files.unwritten


def _tables(made: Plan, facts: dict[str, Any]) -> list[Table]:
    """Return the tables of a plan."""
    rows = [
        ["status", facts["status"]],
        ["method", facts["method"]],
        ["cost", f"{facts['cost']:.5g}"],
        ["law residual", f"{facts['law_residual']:.2e}"],
        ["iterations", str(facts["iterations"])],
        ["time of the search [s]", f"{facts['time']:.2f}"],
        ["knots", f"{facts['knots']} of {1e3 * facts['dt']:g} ms"],
    ]
    done = facts["executed"]
    if done is not None:
        rows += [
            ["landed", "yes" if done["landed"] else "no"],
            ["highest torque, share of its limit", f"{done['torque_use_max']:.2f}"],
            ["highest joint speed, share of its limit", f"{done['speed_use_max']:.2f}"],
        ]
    phases: dict[str, list[str]] = {}
    for phase in made.contacts:
        phases.setdefault(phase.foot, []).append(f"{phase.start:.2f} to {phase.end:.2f}")
    return [
        Table("The plan", ("plan", made.task), rows),
        Table("Contacts", ("foot", "on the ground [s]"), [[f, ", ".join(p)] for f, p in phases.items()]),
    ]
