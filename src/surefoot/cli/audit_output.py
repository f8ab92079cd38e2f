"""What `surefoot audit` says and leaves, whatever the log is of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from surefoot.cli.console import say_verdict
from surefoot.cli.output import new_run_folder, to_json
from surefoot.cli.page import Table, print_tables


def tell(
    console: Console,
    facts: dict[str, Any],
    tables: Sequence[Table],
    lines: Sequence[str],
    verdicts: Sequence[tuple[str, bool]],
    as_json: bool,
) -> None:
    """Print the facts as JSON (the console is quiet then), or tables, lines and verdicts."""
    if as_json:
        print(to_json(facts))
    print_tables(console, tables, lines)
    for line, good in verdicts:
        say_verdict(console, line, good)


def new_audit_folder(out: Path, log: Path, facts: dict[str, Any]) -> Path:
    """Return a new folder with audit.json in it."""
    folder = new_run_folder(out, f"audit-{log.stem}")
    (folder / "audit.json").write_text(to_json(facts) + "\n", encoding="utf-8")
    return folder
