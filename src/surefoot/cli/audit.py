"""`surefoot audit`: which law a log broke, when, where, and why."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.cli.console import plain_console
from surefoot.cli.output import check_out, new_run_folder, to_json
from surefoot.errors import MissingExtra, SurefootError

if TYPE_CHECKING:
    from surefoot.audit import AuditReport
    from surefoot.cli.run_output import Table
    from surefoot.log import Log

MOST = 40
"""Rows of a table on the screen and on the page; the JSON has all."""


def audit(
    log: Annotated[Path, typer.Argument(help="A log: .npz, or any other format that sf.read_log reads.")],
    robot: Annotated[
        str | None, typer.Option(help="Name or URDF of the robot, where the log does not name it.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for report.html and audit.json; None for no files.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Tell which law of contact a log broke, when, where, and what the likely cause is.

    Exit code 0 if it is lawful, 1 if not or if one cannot tell, 2 for wrong input.
    """
    from surefoot.audit import audit_log
    from surefoot.log import read_log
    from surefoot.robot import load_robot

    check_out(out)
    read = read_log(log)
    report = audit_log(read, None if robot is None else load_robot(robot))
    console = plain_console(quiet=as_json)
    if as_json:
        print(to_json(report.as_dict()))
    else:
        _print(console, report)
    if out is not None:
        page = _write(read, report, out, log)
        console.print(f"report: {page}", soft_wrap=True, highlight=False)
    return 0 if report.lawful else 1


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
        [f.contact, f"{f.low:.3f}", f"{f.high:.3f}" if f.high < float("inf") else "unknown", f"{f.slid:.3f}"]
        for f in report.friction
    ]
    heads = ("foot", "from [s]", "to [s]")
    found = [
        Table("Symptoms", ("symptom", *heads, "evidence", "likely cause", "confirm", "cure"), symptoms),
        Table("Violations", ("law", *heads, "value", "limit"), broken),
        Table("What could be judged", ("law", "judged"), covered),
        Table("Friction of the ground", ("foot", "at least", "at most", "slid [s]"), friction),
    ]
    return [table for table in found if table.rows]


def _lines(report: AuditReport) -> list[str]:
    """Return notes, and how many violations are not shown."""
    hidden = len(report.violations) - MOST + sum(report.more.values())
    return [*report.notes, *([f"and {hidden} violations more"] if hidden > 0 else [])]


def _print(console: Any, report: AuditReport) -> None:
    from surefoot.cli.run_output import print_tables

    tables = [t if t.title != "Symptoms" else t._replace(header=t.header[:6], rows=[r[:6] for r in t.rows])
              for t in _tables(report)]  # fmt: skip
    print_tables(console, tables, _lines(report))
    style = "bold green" if report.lawful else "bold red"
    console.print(report.sentence, style=style, soft_wrap=True, highlight=False)


def _write(log: Log, report: AuditReport, out: Path, source: Path) -> Path:
    """Write the page and the JSON into a new folder and return the page's path."""
    from surefoot.cli.run_output import report_sections
    from surefoot.viz.report import paragraph, picture, write_report

    folder = new_run_folder(out, f"audit-{source.stem}")
    (folder / "audit.json").write_text(to_json(report.as_dict()) + "\n", encoding="utf-8")
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
    sections = [*pictures, *report_sections(_tables(report), _lines(report))]
    command = shlex.join(["surefoot", *sys.argv[1:]])
    verdict = report.sentence, report.lawful
    return write_report(folder / "report.html", f"Audit of {source.name}", verdict, sections, command)
