"""`surefoot audit`: which law a log broke, when, where, and why."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.cli import options
from surefoot.cli.audit_output import new_audit_folder, tell
from surefoot.cli.console import plain_console, say
from surefoot.cli.output import check_out
from surefoot.cli.page import Table, report_sections, write_page
from surefoot.errors import MissingExtra, SurefootError
from surefoot.simulation.worlds import WORLDS

if TYPE_CHECKING:
    from surefoot.audit import AuditReport
    from surefoot.log import Log
    from surefoot.simulation.replay import ReplayReport

MOST = 40
"""Rows of a table on the screen and on the page; the JSON has all."""


def audit(
    log: Annotated[
        Path,
        typer.Argument(help="A log: .npz or any other format that sf.read_log reads; or tosses of a cube."),
    ],
    robot: options.LogRobot = None,
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
    out: Annotated[
        Path | None, typer.Option(help="Folder for report.html and audit.json; None for no files.")
    ] = None,
    as_json: options.AsJson = False,
) -> int:
    """Tell which law of contact a log broke, when, where, and what the likely cause is.

    Exit code 0 if it is lawful, its task did not fail and it survives its replay; 1 if not; 2 for wrong
    input; 3 if one cannot tell.
    """
    from surefoot.estimation.tosses import holds_tosses

    if holds_tosses(log):
        from surefoot.cli.toss_audit import audit_toss_file

        given = {"--robot": robot, "--replay": replay, "--terrain": terrain}
        return audit_toss_file(log, mu, given, out, as_json)
    from surefoot.audit import audit_log
    from surefoot.log.formats import read_log
    from surefoot.robot import load_robot

    check_out(out)
    read, whose = read_log(log), None if robot is None else load_robot(robot)
    again = None if replay is None else _replay(read, replay, whose, terrain, mu)
    report = audit_log(read, whose)
    verdicts, facts = [(report.sentence, report.passed)], report.as_dict()
    if again is not None:
        verdicts.append((again.sentence, again.survives))
        facts["replay"] = again.as_dict()
    console = plain_console(quiet=as_json)
    tell(console, facts, _tables(report, again), _lines(report), verdicts, as_json)
    if out is not None:
        folder = new_audit_folder(out, log, facts)
        figures = report_sections(_tables(report, again, on_page=True), _lines(report))
        sections = [*_pictures(read, report, folder), *figures]
        say(console, f"report: {write_page(folder, f'Audit of {log.name}', verdicts, sections)}")
    return report.exit_code or (0 if again is None or again.survives else 1)


def _replay(log: Log, world: str, robot: Any, terrain: str | None, mu: float | None) -> ReplayReport:
    """Replay a log in another world, on its own ground or a given one."""
    from surefoot.simulation.replay import replay_log
    from surefoot.terrain import read_terrain

    ground = None if terrain is None else read_terrain(terrain, "--terrain")
    return replay_log(log, world, robot, ground, mu)


def _tables(report: AuditReport, again: ReplayReport | None, on_page: bool = False) -> list[Table]:
    """Return the tables of symptoms, violations, coverage, friction and of a replay's windows."""
    columns = 8 if on_page else 6
    symptoms = [
        [s.name, s.contact, f"{s.start:.3f}", f"{s.end:.3f}", s.evidence, s.cause, s.confirm, s.cure]
        for s in report.symptoms[:MOST]
    ]
    broken = [
        [v.law, v.contact, f"{v.start:.3f}", f"{v.end:.3f}", f"{v.value:.4g} {v.unit}", f"{v.limit:.4g}"]
        for v in report.violations[:MOST]
    ]
    asked = [
        [f.name, f.contact, f"{f.start:.3f}", f"{f.end:.3f}", f.evidence, f.cause, f.confirm, f.cure]
        for f in report.command[:MOST]
    ]
    covered = [[name, why or "judged"] for name, why in report.coverage.items()]
    friction = [
        [f.contact, f"{f.start:.2f}", f"{f.end:.2f}", f"{f.low:.3f}", _high(f.high), f"{f.slid:.3f}"]
        for f in report.friction
    ]
    heads = ("foot", "from [s]", "to [s]")
    words = ("symptom", *heads, "evidence", "likely cause", "confirm", "cure")
    found = [
        Table("Symptoms", words[:columns], [s[:columns] for s in symptoms]),
        Table("Command", words[:columns], [f[:columns] for f in asked]),
        Table("Violations", ("law", *heads, "value", "limit"), broken),
        Table("What could be judged", ("law", "judged"), covered),
        Table("Friction of the ground", (*heads, "at least", "at most", "slid [s]"), friction),
    ]
    found = [table for table in found if table.rows]
    if again is not None and (again.windows or on_page):
        found.append(_replay_table(again))
    return found


def _high(value: float) -> str:
    return f"{value:.3f}" if value < float("inf") else "unknown"


def _replay_table(again: ReplayReport) -> Table:
    """Return what became of every window."""
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


def _pictures(log: Log, report: AuditReport, folder: Path) -> list[tuple[str, str]]:
    """Draw into the folder; return the page's sections of pictures, or of why there are none."""
    from surefoot.viz.report import paragraph, picture

    try:
        from surefoot.viz.audit_plots import draw_audit

        drawn = draw_audit(log, report, folder)
    except MissingExtra as error:
        return [("Pictures", paragraph(f"pictures left out: {error}"))]
    except SurefootError as error:
        return [("Pictures", paragraph(str(error)))]
    titles = {"timeline": "Timeline"}
    return [(titles.get(path.stem, "One of the worst moments"), picture(path)) for path in drawn]
