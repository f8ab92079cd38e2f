"""`surefoot audit` of a file of tosses: which frames no lawful rigid contact explains, and why."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from surefoot.cli.audit_output import new_audit_folder, tell
from surefoot.cli.console import plain_console, say
from surefoot.cli.output import check_out
from surefoot.cli.page import Table, report_sections, write_page
from surefoot.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.estimation.toss_audit import TossAudit

MOST = 20
"""Rows of a table on the screen and on the page; the JSON has all."""


def audit_toss_file(
    path: Path, mu: float | None, options: Mapping[str, object], out: Path | None, as_json: bool
) -> int:
    """Audit a file of tosses, say what was found and return the exit code."""
    from surefoot.estimation.toss_audit import audit_tosses
    from surefoot.estimation.tosses import read_tosses

    given = [name for name, value in options.items() if value is not None]
    if given:
        raise ProblemError(f"{path} holds tosses of a cube, for which {given[0]} means nothing")
    check_out(out)
    found = audit_tosses(read_tosses(path), mu)
    console, facts = plain_console(quiet=as_json), found.as_dict()
    tables, lines, verdicts = _tables(found), [_noise(found), *found.notes], [(found.sentence, found.lawful)]
    tell(console, facts, tables, lines, verdicts, as_json)
    if out is not None:
        folder = new_audit_folder(out, path, facts)
        page = write_page(folder, f"Audit of {path.name}", verdicts, report_sections(tables, lines))
        say(console, f"report: {page}")
    return 0 if found.lawful else 1


def _noise(found: TossAudit) -> str:
    """Return what frames were judged against."""
    return (
        f"noise in free flight {1e3 * found.position_noise:.3f} mm and "
        f"{math.degrees(found.rotation_noise):.3f} deg, friction up to {found.mu:.3f}, corners rounded up to "
        f"{found.rounding:.3f} half sides"
    )


def _tables(found: TossAudit) -> list[Table]:
    """Return the tables of laws, of the tosses with most frames beyond noise, and of the worst runs."""
    laws = [
        [name, str(t.judged), str(t.exact), str(t.beyond), str(t.jumps), str(t.tosses)]
        for name, t in found.laws.items()
    ]
    worst = sorted(found.tosses.items(), key=lambda one: -sum(one[1].values()))[:MOST]
    tosses = [[str(toss), *map(str, count.values())] for toss, count in worst]
    runs = sorted(found.violations, key=lambda v: -v.value / v.limit)[:MOST]
    broken = [
        [v.law, str(v.toss), v.contact, f"{v.start:.3f}", f"{v.end:.3f}", f"{v.value:.4g} {v.unit}",
         f"{v.limit:.4g}"] for v in runs
    ]  # fmt: skip
    heads = ("law", "frames judged", "not explained", "nor within noise", "one frame displaced", "tosses")
    tables = [
        Table("Laws", heads, laws),
        Table("Tosses with most frames beyond noise", ("toss", *found.laws), tosses),
        Table("Worst", ("law", "toss", "contact", "from [s]", "to [s]", "value", "noise"), broken),
    ]
    return [one for one in tables if one.rows]
