"""Check the docs: every relative link leads somewhere, every shown `surefoot` command is one.

Run: python docs/check.py (exit code 1 and a line per fault if something is wrong).
"""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path
from typing import Any

import typer

from surefoot.cli.main import UsageError, app

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "CHANGELOG.md",
    *sorted((ROOT / "docs").glob("*.md")),
]
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
BLOCK = re.compile(r"```(?:bash|sh|console)\n(.*?)```", re.DOTALL)


def broken_links(page: Path) -> list[str]:
    """Return a line for every relative link of a page that leads nowhere."""
    targets = [t for t in LINK.findall(page.read_text(encoding="utf-8")) if "://" not in t]
    return [f"{page.relative_to(ROOT)}: no {t}" for t in targets if not (page.parent / t).exists()]


def wrong_commands(page: Path) -> list[str]:
    """Return a line for every shown `surefoot` command that the command line would refuse to parse."""
    out = []
    for block in BLOCK.findall(page.read_text(encoding="utf-8")):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            if words[:1] == ["surefoot"]:
                fault = parse(typer.main.get_command(app), words[1:])
                if fault:
                    out.append(f"{page.relative_to(ROOT)}: {line.strip()}: {fault}")
    return out


def parse(command: Any, words: list[str]) -> str | None:
    """Return why a command line does not parse, or None."""
    while hasattr(command, "commands"):
        if not words or words[0] not in command.commands:
            return None if words == ["--help"] else f"no such command {' '.join(words[:1])}"
        command, words = command.commands[words[0]], words[1:]
    if "--help" in words or "..." in words:
        return None
    try:
        command.make_context(command.name, list(words))
    except UsageError as error:
        return str(error.format_message())
    return None


def main() -> int:
    """Check all pages, print the faults and return the exit code."""
    faults = [fault for page in PAGES for fault in broken_links(page) + wrong_commands(page)]
    print("\n".join(faults) if faults else f"{len(PAGES)} pages checked")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
