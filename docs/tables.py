"""Measured tables of the docs: kept in docs/tables with command and date, and set into their pages.

Run: python -m docs.tables [NAME...] measures anew (without a name all but the long ones) and sets the tables
into the pages; with --check nothing is measured or written, and the exit code is 1 if a page says something
else. --told FILE takes the JSON of a command that has run already, as a long one writes with --out.
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
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from docs import speed_tables
from docs.speed_tables import Rows

DOCS = Path(__file__).resolve().parent
FOLDER = DOCS / "tables"
PLACE = re.compile(r"<!-- table (?P<name>\w+) -->\n.*?<!-- end of table -->", re.DOTALL)


@dataclass(frozen=True)
class Table:
    """A measured table.

    Attributes
    ----------
    command
        What measures it, behind `surefoot`; it is asked for JSON.
    page
        File name below docs/.
    columns
        Headings.
    rows
        Makes cells of the command's JSON.
    long
        Whether it takes hours: measured by name only.
    """

    command: str
    page: str
    columns: tuple[str, ...]
    rows: Callable[[Any], Rows]
    long: bool = False


def _rigid(told: Any) -> Rows:
    def line(name: str, cell: Callable[[Any], str]) -> list[str]:
        return [name, *(cell(world) for world in told)]

    return [
        line("wall time of one simulated second, controller included", lambda w: f"{w['wall']:.3f} s"),
        line("world step, median", lambda w: f"{1e6 * w['step']['median']:.0f} µs"),
        line(
            "resting force against m g, worst of the last half second",
            lambda w: f"{100.0 * w['weight_error']:.3f} %",
        ),
        line("deepest penetration", lambda w: f"{1e3 * w['penetration']:.4f} mm"),
        line(
            "energy beyond the start's and the motors' work",
            lambda w: "" if w["energy_made"] is None else f"{max(0.0, w['energy_made']):.1g} J",
        ),
    ]


def _verdicts(told: Any) -> Rows:
    names = ("possible", "agreed", "in_band", "disagreed", "verified")
    return [[c["rival"], *(f"{c[name]} of {c['cases']}" for name in names)] for c in told["agreement"]]


def _questions(told: Any) -> Rows:
    rows, last = [], ""
    for race in told["speed"]:
        times = (f"{1e6 * race['timing'][key]:.0f}" for key in ("median", "p99"))
        question = race["question"] if race["question"] != last else ""
        rows.append([question, race["who"], *times, f"{race['ratio']:.2f}"])
        last = race["question"]
    return rows


def _solref(told: Any) -> Rows:
    rows = told["experiments"]["solref"]["besides"]["mujoco"]["table"]
    scales = {"time constant [s]": 1.0, "rest depth [m]": 1e3, "deepest [m]": 1e3, "peak load / weight": 1.0}
    return [[f"{scale * row[key]:.3g}" for key, scale in scales.items()] for row in rows]


def _softening(told: Any, table: str) -> Rows:
    """Return a row per form and a column per problem: solved, iterations, time, gap times impulse, cost."""
    cells: dict[str, dict[str, str]] = {}
    for row in told[table]:
        told_of = [f"{row['solved']}/{row['starts']}", f"{row['iterations']:.0f}", f"{row['seconds']:.1f} s"]
        told_of.append(f"{row['product']:.0e}")
        if row["cost"]:  # none where nothing is to be chosen, null where nothing was solved
            told_of.append(f"{row['cost']:.2f}")
        cells.setdefault(row["variant"], {})[row["problem"]] = ", ".join(told_of)
    return [[variant, *(by[name] for name in PROBLEMS)] for variant, by in cells.items()]


def _stacks(told: Any, *beginnings: str, without: tuple[str, ...] = ()) -> Rows:
    """Return a row per task of Surefoot's whose name begins with one of some words, all without any."""

    def cell(value: float | None, digits: int, scale: float = 1.0) -> str:
        return "-" if value is None else f"{scale * value:.{digits}f}"

    rows = []
    for row in told["rows"]:
        name = row["task"]
        if row["stack"] != "surefoot" or not name.startswith(beginnings or ("",)) or name.endswith(without):
            continue
        low, high = (100.0 * row["survival"][end] for end in ("low", "high"))
        faults = "; ".join(f"{fault}: {count}" for fault, count in row["faults"].items())
        rows.append(
            [
                f"`{name}`{'*' if row['must'] else ''}",
                f"{row['survived']}/{row['trials']} ({low:.0f} to {high:.0f} %)",
                str(row["held"]),
                cell(row["forward"], 3),
                cell(row["slip"], 1, 1e3),
                cell(row["cost_of_transport"], 2),
                cell(row["torque_use"], 2),
                cell(row["speed_use"], 2),
                f"{cell(row['step_us'], 0)}, {cell(row['step_p99_us'], 0)}",
                cell(row["real_time"], 1),
                faults.replace("|", "/"),
            ]
        )
    return rows


def _speeds(told: Any) -> Rows:
    rows = []
    for row in told:
        vx, _, turn = row["wanted"]
        name = f"{vx:g} m/s" if vx else f"turning at {turn:g} rad/s"
        if row["wanted"] != row["commanded"]:
            name += f", slowed to {row['commanded'][0]:.3g}"
        rows.append(
            [
                name, str(row["good"]), str(row["lawful"]), f"{row['error']:.3f}", f"{1e3 * row['slip']:.1f}",
                f"{row['speed_use']:.2f}", f"{row['torque_use']:.2f}",
                f"{row['rate']:.1f}, {row['usual_rate']:.1f}",
            ]
        )  # fmt: skip
    return rows


TASKS = "speed- turn-3 push- payload- ice slope- stairs- delay noise weak-joint robot- estimate real-time"
EVERY_TASK = "bench stacks --stack surefoot --seeds 20"
STACKS = " ".join([EVERY_TASK, *(f"--task {name}" for name in TASKS.split())])
STACK_COLUMNS = (
    "task", "survived", "held", "m/s", "slip [mm]", "CoT", "torque", "joint speed", "CPU, 99 % [µs]",
    "x real", "what was wrong",
)  # fmt: skip
PROBLEMS = ("ball", "slide", "hopper", "push", "kicker")
FORCES = "bench forces"
WARM = (
    "trajectory", "cones active in", "iterations", "cold", "warm", "ratio", "loop: cold", "loop: warm",
    "loop: ratio",
)  # fmt: skip
SCENES = ("scene", "Surefoot, exact cones", "fastest QP, 4 or 8 facets", "Clarabel, exact cones")
SOFTENING = "bench softening --table race --table recommended"
TABLES = {
    "rigid": Table("bench rigid go2", "rigid-world.md", ("", "rigid", "MuJoCo"), _rigid),
    "verdicts": Table(
        "bench statics",
        "statics.md",
        ("against", "possible", "agree", "differ within 1e-7 of the load", "differ", "verified"),
        _verdicts,
    ),
    "questions": Table(
        "bench statics", "statics.md", ("question", "who", "median [µs]", "99 % [µs]", "ratio"), _questions
    ),
    "race": Table(SOFTENING, "softening.md", ("form", *PROBLEMS), lambda told: _softening(told, "race")),
    "recommended": Table(
        SOFTENING, "softening.md", ("form", *PROBLEMS), lambda told: _softening(told, "recommended")
    ),
    "stacks": Table(
        STACKS, "stacks.md", STACK_COLUMNS,
        lambda told: _stacks(told, without=("-map", "-blind")), long=True,
    ),
    "bipeds": Table(EVERY_TASK, "bipeds.md", STACK_COLUMNS, lambda told: _stacks(told, "g1-"), long=True),
    "stairs": Table(
        STACKS, "terrain-knowledge.md", STACK_COLUMNS, lambda told: _stacks(told, "stairs-", "ice"), long=True
    ),
    "speeds": Table(
        "bench speeds --seeds 20", "speed-limits.md",
        (
            "velocity", "good", "lawful", "error", "slip [mm]", "joint speed", "torque",
            "rate [N m/ms], 99.9 %",
        ),
        _speeds, long=True,
    ),
    "allocation": Table(
        FORCES, "force-distribution.md", ("", "easy", "near the boundary", "wrench out of reach"),
        speed_tables.allocation,
    ),
    "warm": Table(FORCES, "force-distribution.md", WARM, speed_tables.warm_starts),
    "horizons": Table("bench walk", "mpc.md", SCENES, speed_tables.horizons),
    "steps": Table("bench walk", "walking.md", ("robot", "call", "median / 99 % [µs]"), speed_tables.steps),
    "solref": Table(
        "worlds solref --world mujoco",
        "worlds.md",
        ("time constant [s]", "rest depth [mm]", "deepest [mm]", "peak load / weight"),
        _solref,
    ),
}  # fmt: skip


def measure(names: Iterable[str], told: Path | None = None) -> None:
    """Run the commands of tables, each once, or take the JSON in a file, and write their tables' files."""
    answers: dict[str, Any] = {}
    for name in names:
        table = TABLES[name]
        if told is not None:
            answers[table.command] = json.loads(told.read_text(encoding="utf-8"))
        if table.command not in answers:
            print(f"surefoot {table.command}")
            words = [sys.executable, "-m", "surefoot", *shlex.split(table.command), "--json"]
            said = subprocess.run(words, capture_output=True, text=True, check=True).stdout
            answers[table.command] = json.loads(said)
        kept = {
            "command": f"surefoot {table.command}",
            "date": datetime.date.today().isoformat(),
            "machine": machine(),
            "columns": table.columns,
            "rows": table.rows(answers[table.command]),
        }
        FOLDER.mkdir(exist_ok=True)
        text = json.dumps(kept, indent=1, ensure_ascii=False) + "\n"
        (FOLDER / f"{name}.json").write_text(text, encoding="utf-8")


def machine() -> str:
    """Return the processor's name and how many cores this process may use."""
    info = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*:\s*(.+)", info.read_text()) if info.exists() else None
    return f"{found[1] if found else platform.machine()}, {len(os.sched_getaffinity(0))} cores"


def markdown(name: str) -> str:
    """Return a kept table as it stands in its page, with its markers."""
    kept = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    lines = [kept["columns"], ["---"] * len(kept["columns"]), *kept["rows"]]
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    told = f"(`{kept['command']}`, {kept['date']}, {kept['machine']}.)"
    return f"<!-- table {name} -->\n{table}\n\n{told}\n<!-- end of table -->"


def filled(text: str) -> str:
    """Return a page with all its tables as they are kept."""
    return PLACE.sub(lambda found: markdown(found["name"]), text)


def main() -> int:
    """Measure and set, or check; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"tables to measure, of {', '.join(TABLES)} (default: all)")
    parser.add_argument("--told", type=Path, help="JSON that the tables' command has written; names needed")
    parser.add_argument("--check", action="store_true", help="measure and write nothing")
    given = parser.parse_args()
    unknown = sorted(set(given.names) - set(TABLES))
    if unknown:
        parser.error(f"no table {', '.join(unknown)}; there are {', '.join(TABLES)}")
    if given.told is not None and not given.names:
        parser.error("--told needs the names of the tables that it is for")
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
    return 1 if given.check and wrong else 0


if __name__ == "__main__":
    sys.exit(main())
