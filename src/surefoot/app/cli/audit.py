"""`surefoot audit`: which law a log broke, when, where, and why."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.app.cli import options
from surefoot.app.cli.checklist import ANSWER, answers
from surefoot.app.cli.console import Cell, Table, plain_console, print_tables, say, say_verdict
from surefoot.app.cli.log_options import LogOptions
from surefoot.app.cli.output import check_out, new_run_folder, to_json
from surefoot.base.errors import MissingExtra, ProblemError
from surefoot.worlds.interface.world_names import WORLDS

if TYPE_CHECKING:
    from surefoot.mechanics import Robot
    from surefoot.records import Log
    from surefoot.records.audit import AuditReport
    from surefoot.worlds.replay.windows import ReplayReport

MOST = 40
"""Rows of a table on the screen and on the page; the JSON has all."""
SHOWN = 6
"""Columns of a finding on the screen; the page has all."""

Replay = Annotated[
    str | None,
    typer.Option(help=f"Replay the motion in another world ({', '.join(WORLDS)}): does it survive there?"),
]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust", help="Replay in the whole model beside a recording (.mjb), which MuJoCo reads as it is."
    ),
]


def audit(
    log: Annotated[
        Path,
        typer.Argument(help="A log: .npz or any other format that sf.read_log reads."),
    ],
    *,
    given: LogOptions,
    replay: Replay = None,
    trust: Trust = False,
    template: Annotated[
        Path | None,
        typer.Option(help="Judge nothing: write the mapping that is guessed to this new file (- prints it)."),
    ] = None,
    checklist: Annotated[
        bool, typer.Option("--checklist", help="Answer ten questions on contact first, from the log.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder for report.html and audit.json; None for no files.")
    ] = None,
    as_json: options.AsJson = False,
) -> int:
    """Tell which law of contact a log broke, when, where, and what the likely cause is.

    Exit code 0 if it is lawful, its task did not fail and it survives its replay; 1 if not; 2 for wrong
    input; 3 if one cannot tell.
    """
    from surefoot.records import audit_log

    check_out(out)
    if template is not None:
        return _write_template(log, given, template)
    read, whose = given.read(log)
    again = _replay(read, replay, whose, given, log.with_suffix(".mjb"), trust)
    read = given.complete_log(read, whose, replayed=again is not None)
    report = audit_log(read, whose)
    verdicts, facts = [(report.sentence, report.passed)], report.as_dict()
    if again is not None:
        verdicts.append((again.sentence, again.survives))
        facts["replay"] = again.as_dict()
    tables = _tables(report, again)
    if checklist:
        tables.insert(0, _checklist(report, read, facts))
    console, lines = plain_console(quiet=as_json), _lines(read, report)
    if as_json:
        print(to_json(facts))
    say(console, str(report.story))
    print_tables(console, tables, lines)
    for line, good in verdicts:
        say_verdict(console, line, good)
    if out is not None:
        page = _write_page(
            log, new_run_folder(out, f"audit-{log.stem}"), read, report, facts, verdicts, tables, lines
        )
        say(console, f"report: {page}")
    return report.exit_code or (0 if again is None or again.survives else 1)


def _replay(
    log: Log, world: str | None, robot: Robot | None, given: LogOptions, beside: Path, trust: bool
) -> ReplayReport | None:
    """Replay a log in a world, if one is asked for, on its ground, a given one, or in the model beside it."""
    if world is None:
        if trust:
            raise ProblemError("--trust is for the model of a --replay")
        return None
    from surefoot.worlds.replay.replay import replay_log

    if trust:
        return replay_log(log, world, robot, given.ground(), given.mu, beside)
    try:
        return replay_log(log, world, robot, given.ground(), given.mu)
    except ProblemError as error:
        if not beside.exists():
            raise
        raise ProblemError(f"{error}; its whole model is in {beside}: --trust replays in that") from error


def _checklist(report: AuditReport, log: Log, facts: dict[str, Any]) -> Table:
    """Return the answers to the ten questions, which join the facts."""
    rows = answers(report, log)
    facts["checklist"] = [dict(zip(ANSWER, row, strict=True)) for row in rows]
    return Table("Checklist", ANSWER, rows)


def _write_template(log: Path, given: LogOptions, path: Path) -> int:
    """Write the mapping that is guessed for a log to a new file."""
    from surefoot.app.cli.mapping_template import template

    text = template(log, given.names(), given.rate)
    if str(path) == "-":
        print(text, end="")
        return 0
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise ProblemError(f"{path} exists already") from error
    print(f"mapping: {path}; complete it, then: surefoot audit {log} --mapping {path}")
    return 0


def _tables(report: AuditReport, again: ReplayReport | None) -> list[Table]:
    """Return the tables of symptoms, violations, coverage, friction and of a replay's windows."""
    where: dict[str, Cell] = {
        "foot": lambda one: one.contact,
        "from [s]": lambda one: f"{one.start:.3f}",
        "to [s]": lambda one: f"{one.end:.3f}",
    }
    finding: dict[str, Cell] = {
        "symptom": lambda f: f.name,
        **where,
        "evidence": lambda f: f.evidence,
        "likely cause": lambda f: f.cause,
        "confirm": lambda f: f.confirm,
        "cure": lambda f: f.cure,
    }
    broken: dict[str, Cell] = {
        "law": lambda v: v.law,
        **where,
        "value": lambda v: f"{v.value:.4g} {v.unit}",
        "limit": lambda v: f"{v.limit:.4g}",
    }
    friction: dict[str, Cell] = {
        "foot": lambda f: f.contact,
        "from [s]": lambda f: f"{f.start:.2f}",
        "to [s]": lambda f: f"{f.end:.2f}",
        "at least": lambda f: f"{f.low:.3f}",
        "at most": lambda f: f"{f.high:.3f}" if f.high < math.inf else "unknown",
        "slid [s]": lambda f: f"{f.slid:.3f}",
    }
    windows: dict[str, Cell] = {
        "from [s]": lambda w: f"{w.start:.3f}",
        "to [s]": lambda w: f"{w.end:.3f}",
        "way [m]": lambda w: f"{w.way:.3f} of {w.logged_way:.3f}",
        "lean [deg]": lambda w: f"{math.degrees(w.tilt):.1f}",
        "drift [m]": lambda w: f"{w.drift:.3f}",
        "result": lambda w: w.lost or "holds",
    }
    covered = [[name, why or "judged"] for name, why in report.coverage.items()]
    found = [
        Table.of("Symptoms", report.symptoms[:MOST], finding, SHOWN),
        Table.of("Command", report.command[:MOST], finding, SHOWN),
        Table.of("Violations", report.violations[:MOST], broken),
        Table("What could be judged", ("law", "judged"), covered),
        Table.of("Friction of the ground", report.friction, friction),
    ]
    if again is not None:
        found.append(Table.of(f"Replay in the world {again.world}", again.windows[:MOST], windows))
    return [table for table in found if table.rows]


def _lines(log: Log, report: AuditReport) -> list[str]:
    """Return what was computed, notes, and how many violations are not shown."""
    made = [f"computed: {line}" for line in log.facts.get("computed", ())]
    hidden = len(report.violations) - MOST + sum(report.more.values())
    return [*made, *report.notes, *([f"and {hidden} violations more"] if hidden > 0 else [])]


def _write_page(
    path: Path,
    folder: Path,
    log: Log,
    report: AuditReport,
    facts: dict[str, Any],
    verdicts: list[tuple[str, bool]],
    tables: list[Table],
    lines: list[str],
) -> Path:
    """Write audit.json, pictures and the page on the log of a path; return the page."""
    from surefoot.app.cli.run_files import report_sections, write_page

    (folder / "audit.json").write_text(to_json(facts) + "\n", encoding="utf-8")
    pictures = [_story(report, folder), _picture(log, report, folder)]
    sections = [*pictures, *report_sections(tables, lines)]
    return write_page(folder / "report.html", f"Audit of {path.name}", verdicts, sections)


def _story(report: AuditReport, folder: Path) -> tuple[str, str]:
    """Draw the story into the folder; return the page's section of the picture, or of why there is none."""
    from surefoot.app.viz.report import embed_picture, paragraph

    try:
        from surefoot.app.viz.story_plots import draw_story

        drawn = embed_picture(draw_story(report, folder / "story.png"))
    except MissingExtra as error:
        drawn = paragraph(f"picture left out: {error}")
    return "What happened", paragraph(str(report.story)) + drawn


def _picture(log: Log, report: AuditReport, folder: Path) -> tuple[str, str]:
    """Draw into the folder; return the page's section of the picture, or of why there is none."""
    from surefoot.app.viz.report import embed_picture, paragraph

    try:
        from surefoot.app.viz.audit_plots import draw_timeline

        return "Timeline", embed_picture(draw_timeline(log, report, folder / "timeline.png"))
    except MissingExtra as error:
        return "Timeline", paragraph(f"picture left out: {error}")
