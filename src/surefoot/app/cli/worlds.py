"""`surefoot worlds`: the same experiments in every world that is here, against closed forms."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.app.cli import extras, options
from surefoot.app.cli.console import plain_console, table
from surefoot.app.cli.output import check_out, to_json
from surefoot.base.errors import MissingExtra, ProblemError, check_name

if TYPE_CHECKING:
    from rich.console import Console

    from surefoot.worlds.experiments.experiment import WorldsOutcome

NAMES = "drop, bounce, slide, stick, tip, spin, roll"


def worlds(
    names: Annotated[list[str] | None, typer.Argument(help=f"Experiments, all if none: {NAMES}.")] = None,
    world: Annotated[
        list[str] | None, typer.Option(help="A world, repeatable; all that are here if none.")
    ] = None,
    dt: Annotated[float, typer.Option(help="Step; it is doubled and halved for its error [s].")] = 1e-3,
    out: options.PictureOut = Path("runs"),
    pictures: Annotated[bool, typer.Option("--pictures/--no-pictures", help="Draw --defaults.")] = True,
    defaults: Annotated[
        bool, typer.Option("--defaults", help="Engines as they come, at their own steps: error and cost.")
    ] = False,
    as_json: options.AsJson = False,
) -> int:
    """Run the same experiments in every world that is here and hold them against closed forms.

    Exit code 0 if every world keeps to every closed form within its own step error, 1 if not, 2 for wrong
    input; with --defaults 0, whatever engines make of it.
    """
    check_out(out if pictures else None)
    if defaults:
        return _defaults(names or [], world, out if pictures else None, as_json)
    from surefoot.worlds.experiments import EXPERIMENTS, carry_out
    from surefoot.worlds.interface.world_names import WORLDS, packages_of

    if not 1e-5 <= dt <= 0.02:
        raise ProblemError(f"--dt must be between 1e-05 and 0.02 s, got {dt:g}")
    for name in names or ():
        check_name("experiment", name, EXPERIMENTS)
    for name in world or ():
        check_name("world", name, WORLDS)
    chosen = [EXPERIMENTS[name] for name in dict.fromkeys(names or EXPERIMENTS)]
    console = plain_console(quiet=as_json, highlight=False, soft_wrap=True)
    wanted = list(dict.fromkeys(world or WORLDS))
    absent = {name: error for name in wanted if (error := extras.missing(packages_of(name))) is not None}
    here = [name for name in wanted if name not in absent]
    if not here:
        raise MissingExtra.of(absent.values())
    extras.require(extras.robot_packages(None))
    status = plain_console(stderr=True, quiet=as_json)
    outcomes = []
    for experiment in chosen:
        with status.status(f"{experiment.name} (a first run compiles)") as line:
            outcomes.append(carry_out(experiment, here, dt, line.update))
        _print(outcomes[-1], console)
    for name, why in absent.items():
        console.print(f"{name}: not here: {why}")
    agrees = all(outcome.agrees for outcome in outcomes)
    if as_json:
        print(to_json({
            "dt": dt, "worlds": here, "absent": {name: str(error) for name, error in absent.items()},
            "agrees": agrees, "experiments": {o.experiment.name: _facts(o) for o in outcomes},
        }))  # fmt: skip
    console.print(_headline(outcomes, agrees))
    return 0 if agrees else 1


def _defaults(names: list[str], world: list[str] | None, out: Path | None, as_json: bool) -> int:
    """Print what engines at their defaults make of a few scenes, beside tuned ones."""
    from surefoot.worlds.experiments.engines.defaults import CASES, ENGINES, measured
    from surefoot.worlds.experiments.engines.runners import NEWTON_PYTHON
    from surefoot.worlds.interface.world_names import WORLDS, packages_of

    needed = {name: packages_of(name) for name in WORLDS}
    needed |= {"mjx": ("mujoco", "jax", "mujoco-mjx"), "newton": ()}
    for name in names:
        check_name("scene of --defaults", name, CASES)
    for name in world or ():
        check_name("engine", name, needed)
    extras.require(extras.robot_packages(None))
    console, status = (plain_console(stderr=e, quiet=as_json, highlight=False) for e in (False, True))
    absent = {name: str(e) for name in world or needed if (e := extras.missing(needed[name])) is not None}
    if "newton" in (world or needed) and NEWTON_PYTHON not in os.environ:
        absent["newton"] = f"{NEWTON_PYTHON} names an interpreter that has the package newton"
    found: dict[str, dict[str, tuple[float, float]]] = {}
    with status.status("") as line:
        for engine, made in ENGINES.items():
            if made.world in (world or needed) and made.world not in absent:
                line.update(f"{engine} (a first run may compile)")
                found[engine] = {case: measured(engine, case) for case in names or CASES}
    if as_json:
        keys = ("engine", "case", "unit", "error", "cost", "step")
        rows = [(e, c, CASES[c].unit, *x, ENGINES[e].step) for e, by in found.items() for c, x in by.items()]
        named = [dict(zip(keys, row, strict=True)) for row in rows]
        print(to_json({"rows": named, "absent": absent}))
    if found:
        costs = {e: f"{sum(cost for _, cost in by.values()) / len(by):.2g}" for e, by in found.items()}
        cells = [
            (e, f"{1e3 * ENGINES[e].step:.3g}", *(f"{x:.1e}" for x, _ in by.values()), costs[e])
            for e, by in found.items()
        ]
        title = "errors against closed forms; CPU seconds per simulated second, their mean"
        console.print(
            table(("engine", "step [ms]", *(names or CASES), "CPU"), cells, title, left=("engine",))
        )
    for name, reason in absent.items():
        console.print(f"{name}: not here: {reason}")

    def draw(folder: Path) -> Path:
        from surefoot.app.viz.world_plots import draw_defaults

        return draw_defaults(found, folder / "defaults.png")

    path, note = extras.draw_into(out is not None and bool(found), out or Path(), "worlds", draw)
    if path or note:
        console.print(note or f"picture: {path}")
    return 0


def _headline(outcomes: list[WorldsOutcome], agrees: bool) -> str:
    rows = [row for outcome in outcomes for row in outcome.rows]
    failures = sum(len(outcome.failures) for outcome in outcomes)
    good = sum(row.verdict == "agrees" for row in rows)
    failed = f", {failures} not run to their end" if failures else ""
    return f"{good} of {len(rows)} quantities within their world's own step error{failed}" + (
        "" if agrees else ": not every world keeps to the closed forms"
    )


def _print(outcome: WorldsOutcome, console: Console) -> None:
    rows: list[tuple[str, ...]] = []
    order, last = list(dict.fromkeys(row.quantity for row in outcome.rows)), ""
    for row in sorted(outcome.rows, key=lambda row: order.index(row.quantity)):
        name = f"{row.quantity} [{row.unit}]" if row.unit else row.quantity
        numbers = (f"{size:.1e}" for size in (row.error, row.step_error, row.tolerance))
        place = ("" if name == last else name, f"{row.exact:.6g}", row.world, f"{row.value:.6g}")
        rows.append((*place, *numbers, row.verdict))
        last = name
    if rows:
        header = ("quantity", "closed form", "world", "value", "off by", "step error", "tolerance", "")
        title = f"{outcome.experiment.name}: {outcome.experiment.says}"
        console.print(table(header, rows, title, left=("quantity", "world", "")))
    for world, why in outcome.failures.items():
        console.print(f"{outcome.experiment.name} in {world}: {why}")


def _facts(outcome: WorldsOutcome) -> dict[str, Any]:
    experiment = outcome.experiment
    return {
        "says": experiment.says,
        "compares": experiment.compares,
        "agrees": outcome.agrees,
        "rows": [row.as_dict() for row in outcome.rows],
        "failures": outcome.failures,
    }
