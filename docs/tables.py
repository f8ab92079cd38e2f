"""Measured tables of the docs: kept in docs/tables with command and date, and set into their pages.

Run: python -m docs.tables [NAME...] measures anew (without a name all but the long ones) and sets the tables
into the pages; with --check nothing is measured or written, and the exit code is 1 if a page says something
else. --told FILE takes the JSON of a command that has run already, as a long one writes with --out.
A table that waits to be measured has no file; what stands in its place is left alone, and --check names it.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from docs import planning_tables, robot_tables, sole_tables, solver_tables, walking_tables

DOCS = Path(__file__).resolve().parent
FOLDER = DOCS / "tables"
PLACE = re.compile(r"<!-- table (?P<name>\w+) -->\n.*?<!-- end of table -->", re.DOTALL)


TABLES = (
    solver_tables.TABLES | sole_tables.TABLES | planning_tables.TABLES | walking_tables.TABLES
    | robot_tables.TABLES
)  # fmt: skip


def measure(names: Iterable[str], files: Sequence[Path] = ()) -> None:
    """Run the commands of tables, each once, or take what is in files, and write their tables' files."""
    answers: dict[str, str] = {}
    for name in names:
        table = TABLES[name]
        for command, file in zip(table.commands, files, strict=False):
            answers[command] = file.read_text(encoding="utf-8")
        for command in table.commands:
            if command not in answers:
                answers[command] = answer(command, table.reads is json.loads)
        found = [table.reads(answers[command]) for command in table.commands]
        kept = {
            "command": table.command,
            "date": datetime.date.today().isoformat(),
            "machine": machine(),
            "columns": table.columns,
            "rows": table.rows(found if len(found) > 1 else found[0]),
        }
        FOLDER.mkdir(exist_ok=True)
        text = json.dumps(kept, indent=1, ensure_ascii=False) + "\n"
        (FOLDER / f"{name}.json").write_text(text, encoding="utf-8")


def answer(command: str, as_json: bool = True) -> str:
    """Run a command, asked for JSON or not, and return what it prints, whatever its exit code says.

    Raises
    ------
    RuntimeError
        If it prints nothing, with what it said on the way.
    """
    print(command, flush=True)
    words = shlex.split(command)
    start = [sys.executable, "-m", "surefoot"] if words[0] == "surefoot" else [sys.executable]
    start += [*words[1:], *(["--json"] if as_json else [])]
    path = os.pathsep.join([str(DOCS.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    with tempfile.TemporaryDirectory() as folder:  # what an earlier run has left is not gone on with
        (Path(folder) / "examples").symlink_to(DOCS.parent / "examples")
        env = os.environ | {"PYTHONPATH": path}
        run = subprocess.run(start, cwd=folder, env=env, capture_output=True, text=True, check=False)
    if not run.stdout:
        raise RuntimeError(f"{command} printed nothing: {run.stderr[-2000:]}")
    return run.stdout


def machine() -> str:
    """Return the processor's name and how many cores this process may use."""
    info = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*:\s*(.+)", info.read_text()) if info.exists() else None
    cores = len(os.sched_getaffinity(0))
    return f"{found[1] if found else platform.machine()}, {cores} core{'s' if cores > 1 else ''}"


def markdown(name: str) -> str:
    """Return a kept table as it stands in its page, with its markers."""
    kept = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    lines = [kept["columns"], ["---"] * len(kept["columns"]), *kept["rows"]]
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    commands = TABLES[name].said or "; ".join(f"`{one}`" for one in kept["command"].split("; "))
    caption = f"({commands}, {kept['date']}, {kept['machine']}.)"
    return f"<!-- table {name} -->\n{table}\n\n{caption}\n<!-- end of table -->"


def filled(text: str) -> str:
    """Return a page with all its tables as they are kept; places of tables that wait stay as they are."""

    def place(found: re.Match[str]) -> str:
        kept = (FOLDER / f"{found['name']}.json").exists()
        return markdown(found["name"]) if kept else found[0]

    return PLACE.sub(place, text)


def main() -> int:
    """Measure and set, or check; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"tables to measure, of {', '.join(TABLES)} (default: all)")
    parser.add_argument(
        "--told", type=Path, action="append", default=[],
        help="what the tables' command has printed as JSON; once for each of several commands; names needed",
    )  # fmt: skip
    parser.add_argument("--check", action="store_true", help="measure and write nothing")
    given = parser.parse_args()
    unknown = sorted(set(given.names) - set(TABLES))
    if unknown:
        parser.error(f"no table {', '.join(unknown)}; there are {', '.join(TABLES)}")
    if given.told and not given.names:
        parser.error("--told needs the names of the tables that it is for")
    if given.told and len({TABLES[name].command for name in given.names}) > 1:
        parser.error("--told is for tables of one command")
    if not given.check:
        measure(given.names or [name for name, table in TABLES.items() if not table.long], given.told)
    wrong = 0
    for page in sorted({table.page for table in TABLES.values()}):
        text = (DOCS / page).read_text(encoding="utf-8")
        if filled(text) != text:
            wrong += 1
            if given.check:
                print(f"docs/{page}: a table is not that of docs/tables; python -m docs.tables sets it")
            else:
                (DOCS / page).write_text(filled(text), encoding="utf-8")
    waiting = [name for name in TABLES if not (FOLDER / f"{name}.json").exists()]
    if given.check and waiting:
        print(f"not measured yet: {' '.join(waiting)}")
    return 1 if given.check and wrong else 0


if __name__ == "__main__":
    sys.exit(main())
