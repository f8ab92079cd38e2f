"""`surefoot audit`: which law a log broke, when, where, and why."""

from __future__ import annotations

import math
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.cli.console import plain_console
from surefoot.cli.output import check_out, new_run_folder, to_json
from surefoot.errors import MissingExtra, ProblemError, SurefootError
from surefoot.simulation.worlds import WORLDS

if TYPE_CHECKING:
    from surefoot.audit import AuditReport
    from surefoot.cli.run_output import Table
    from surefoot.log import Log
    from surefoot.simulation.replay import ReplayReport

SHOW = "show"
"""What --rerun takes for its viewer."""
MOST = 40
"""Rows of a table on the screen and on the page; the JSON has all."""


def audit(
    log: Annotated[
        Path,
        typer.Argument(help="A log: .npz or any other format that sf.read_log reads; or tosses of a cube."),
    ],
    robot: Annotated[
        str | None, typer.Option(help="Name or URDF of the robot, where the log does not name it.")
    ] = None,
    replay: Annotated[
        str | None,
        typer.Option(
            help=f"Replay the motion in another world ({', '.join(WORLDS)}): does it survive there?"
        ),
    ] = None,
    terrain: Annotated[
        str | None,
        typer.Option(
            help="Ground of the replay where the log tells none: flat, slope:DEG, stairs:HEIGHT,DEPTH, ..."
        ),
    ] = None,
    mu: Annotated[
        float | None, typer.Option(help="Friction: of the replay, where the log tells none, or under tosses.")
    ] = None,
    rerun: Annotated[
        str | None, typer.Option(help="FILE.rrd to save the log for Rerun, or show to open its viewer.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for report.html and audit.json; None for no files.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Tell which law of contact a log broke, when, where, and what the likely cause is.

    Exit code 0 if it is lawful and survives its replay, 1 if not or if one cannot tell, 2 for wrong input.
    """
    from surefoot.estimation import holds_tosses

    if holds_tosses(log):
        from surefoot.cli.toss_audit import audit_toss_file

        given = {"--robot": robot, "--replay": replay, "--terrain": terrain, "--rerun": rerun}
        return audit_toss_file(log, mu, given, out, as_json)
    from surefoot.audit import audit_log
    from surefoot.log import read_log
    from surefoot.robot import load_robot

    check_out(out)
    _check_rerun(rerun)
    read, whose = read_log(log), None if robot is None else load_robot(robot)
    again = None if replay is None else _replay(read, replay, whose, terrain, mu)
    report = audit_log(read, whose)
    console = plain_console(quiet=as_json)
    if as_json:
        print(to_json({**report.as_dict(), **({} if again is None else {"replay": again.as_dict()})}))
    else:
        _print(console, report, again)
    if rerun is not None:
        _rerun(read, rerun, console)
    if out is not None:
        page = _write(read, report, out, log, again)
        console.print(f"report: {page}", soft_wrap=True, highlight=False)
    return 0 if report.lawful and (again is None or again.survives) else 1


def _replay(log: Log, world: str, robot: Any, terrain: str | None, mu: float | None) -> ReplayReport:
    """Replay a log in another world, on its own ground or a given one."""
    from surefoot.simulation.replay import replay_log
    from surefoot.terrain import read_terrain

    ground = None if terrain is None else read_terrain(terrain, "--terrain")
    return replay_log(log, world, robot, ground, mu)


def _check_rerun(target: str | None) -> None:
    """Refuse what --rerun does not take, before any work."""
    if target is None:
        return
    if target != SHOW and not target.endswith(".rrd"):
        raise ProblemError(f"--rerun takes a file that ends in .rrd, or {SHOW}, got {target!r}")
    from surefoot.log.rerun_file import import_rerun

    import_rerun()


def _rerun(log: Log, target: str, console: Any) -> None:
    """Open a log in Rerun's viewer, or save it for that."""
    from surefoot.log import rerun_file

    if target == SHOW:
        rerun_file.show(log)
    else:
        console.print(f"rerun: {log.save(target)}", soft_wrap=True, highlight=False)


def _tables(report: AuditReport) -> list[Table]:
    """Return the tables of symptoms, violations, coverage and friction."""
    from surefoot.cli.run_output import Table

    symptoms = [
        [s.name, s.contact, f"{s.start:.3f}", f"{s.end:.3f}", s.evidence, s.cause, s.confirm, s.cure]
        for s in report.symptoms[:MOST]
    ]
    broken = [
        [v.law, v.contact, f"{v.start:.3f}", f"{v.end:.3f}", f"{v.value:.4g} {v.unit}", f"{v.limit:.4g}"]
        for v in report.violations[:MOST]
    ]
    covered = [[name, why or "judged"] for name, why in report.coverage.items()]
    friction = [
        [f.contact, f"{f.start:.2f}", f"{f.end:.2f}", f"{f.low:.3f}", _high(f.high), f"{f.slid:.3f}"]
        for f in report.friction
    ]
    heads = ("foot", "from [s]", "to [s]")
    found = [
        Table("Symptoms", ("symptom", *heads, "evidence", "likely cause", "confirm", "cure"), symptoms),
        Table("Violations", ("law", *heads, "value", "limit"), broken),
        Table("What could be judged", ("law", "judged"), covered),
        Table("Friction of the ground", (*heads, "at least", "at most", "slid [s]"), friction),
    ]
    return [table for table in found if table.rows]


def _high(value: float) -> str:
    return f"{value:.3f}" if value < float("inf") else "unknown"


def _replay_table(again: ReplayReport) -> Table:
    """Return what became of every window."""
    from surefoot.cli.run_output import Table

    rows = []
    for w in again.windows[:MOST]:
        way, lean = f"{w.way:.3f} of {w.logged_way:.3f}", f"{math.degrees(w.tilt):.1f}"
        rows.append([f"{w.start:.3f}", f"{w.end:.3f}", way, lean, f"{w.drift:.3f}", w.lost or "holds"])
    heads = ("from [s]", "to [s]", "way [m]", "lean [deg]", "drift [m]", "result")
    return Table(f"Replay in the world {again.world}", heads, rows)


def _lines(report: AuditReport) -> list[str]:
    """Return notes, and how many violations are not shown."""
    hidden = len(report.violations) - MOST + sum(report.more.values())
    return [*report.notes, *([f"and {hidden} violations more"] if hidden > 0 else [])]


def _print(console: Any, report: AuditReport, again: ReplayReport | None) -> None:
    from surefoot.cli.run_output import print_tables

    tables = [t if t.title != "Symptoms" else t._replace(header=t.header[:6], rows=[r[:6] for r in t.rows])
              for t in _tables(report)]  # fmt: skip
    if again is not None and again.windows:
        tables.append(_replay_table(again))
    print_tables(console, tables, _lines(report))
    style = "bold green" if report.lawful else "bold red"
    console.print(report.sentence, style=style, soft_wrap=True, highlight=False)
    if again is not None:
        style = "bold green" if again.survives else "bold red"
        console.print(again.sentence, style=style, soft_wrap=True, highlight=False)


def _write(log: Log, report: AuditReport, out: Path, source: Path, again: ReplayReport | None) -> Path:
    """Write the page and the JSON into a new folder and return the page's path."""
    from surefoot.cli.run_output import report_sections
    from surefoot.viz.report import paragraph, picture, write_report

    folder = new_run_folder(out, f"audit-{source.stem}")
    told = {**report.as_dict(), **({} if again is None else {"replay": again.as_dict()})}
    (folder / "audit.json").write_text(to_json(told) + "\n", encoding="utf-8")
    pictures: list[tuple[str, str]] = []
    try:
        from surefoot.viz.audit_plots import draw_audit

        for path in draw_audit(log, report, folder):
            title = "Timeline" if path.stem == "timeline" else "One of the worst moments"
            pictures.append((title, picture(path)))
    except MissingExtra as error:
        pictures = [("Pictures", paragraph(f"pictures left out: {error}"))]
    except SurefootError as error:
        pictures = [("Pictures", paragraph(str(error)))]
    tables = [*_tables(report), *([] if again is None else [_replay_table(again)])]
    sections = [*pictures, *report_sections(tables, _lines(report))]
    command = shlex.join(["surefoot", *sys.argv[1:]])
    verdict = report.sentence, report.lawful
    if again is not None:
        verdict = f"{report.sentence}; {again.sentence}", report.lawful and again.survives
    return write_report(folder / "report.html", f"Audit of {source.name}", verdict, sections, command)
