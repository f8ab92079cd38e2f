"""Check the docs: every relative link leads somewhere, every shown `surefoot` command is one.

Run: python docs/check.py (exit code 1 and a line per fault if something is wrong). A command is shown if it
stands in a code block, in a code span (a command's name alone is only a name), or in the rows of a table
whose first heading is a command and "...".
It is promised to end with exit code 0, unless a comment beside it, its row or what follows its span says
"exit code N". The tests run them all (tests/app/cli/test_shown_commands.py).
"""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from surefoot.app.cli.commands import COMMANDS, UsageError, load

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "CHANGELOG.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "docs" / "cookbook").glob("*.md")),
    *sorted((ROOT / "docs" / "reports").glob("*.md")),
    *sorted((ROOT / "docs" / "zh").glob("*.md")),
    *sorted((ROOT / "course").glob("*/*.md")),
]
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.DOTALL)
SHELLS = ("", "bash", "sh", "console")
SPAN = re.compile(r"`surefoot ([^`]*)`")
ROW = re.compile(r"`([^`]+)`")
EXIT_CODE = re.compile(r"exit code (\d+)")
load_once = cache(load)  # a group of twenty commands takes 50 ms, and pages show hundreds


@dataclass(frozen=True)
class Shown:
    """A command of a page: its words after `surefoot`, and the exit code that the page promises."""

    page: str
    words: tuple[str, ...]
    code: int = 0

    def __str__(self) -> str:
        return f"{self.page}: surefoot {shlex.join(self.words)}"


def shown_commands(page: Path) -> list[Shown]:
    """Return the commands that a page shows, each once, in their order; "..." stands for no command."""
    text, name = page.read_text(encoding="utf-8"), page.name
    found = [*_of_blocks(name, text), *_of_text(name, BLOCK.sub("", text))]
    return [shown for shown in dict.fromkeys(found) if "..." not in " ".join(shown.words)]


def _of_blocks(name: str, text: str) -> Iterator[Shown]:
    """Yield the commands of the blocks, with what the comments behind them promise."""
    for language, block in BLOCK.findall(text):
        for line in block.replace("\\\n", " ").splitlines():
            if language in SHELLS and line.startswith("surefoot "):
                promised = EXIT_CODE.search(line.partition("#")[2])
                words = shlex.split(line, comments=True)[1:]
                yield Shown(name, tuple(words), int(promised[1]) if promised else 0)


def _of_text(name: str, text: str) -> Iterator[Shown]:
    """Yield the commands of code spans, and of tables whose first heading is `surefoot NAME ...`."""
    start: list[str] | None = None
    for line in text.splitlines():
        first = line.split("|")[1].strip() if line.startswith("|") and line.count("|") > 2 else None
        if first is None:
            start = None
        elif first.startswith("`surefoot ") and first.endswith("...`"):
            start = shlex.split(first.strip("`"))[1:-1]
        elif start is not None:
            promised = EXIT_CODE.search(line)
            code = int(promised[1]) if promised else 0
            yield from (Shown(name, (*start, *shlex.split(row)), code) for row in ROW.findall(first))
        for span in SPAN.finditer(line):
            words, behind = tuple(shlex.split(span[1])), EXIT_CODE.match(line[span.end() :].lstrip(" ("))
            if len(words) > 1:
                yield Shown(name, words, int(behind[1]) if behind else 0)


def broken_links(page: Path) -> list[str]:
    """Return a line for every relative link of a page that leads nowhere."""
    targets = [t for t in LINK.findall(page.read_text(encoding="utf-8")) if "://" not in t]
    return [f"{page.relative_to(ROOT)}: no {t}" for t in targets if not (page.parent / t).exists()]


def wrong_commands(page: Path) -> list[str]:
    """Return a line for every shown command that the command line would refuse to parse."""
    out = []
    for shown in shown_commands(page):
        fault = parse(list(shown.words))
        if fault:
            out.append(f"{shown}: {fault}")
    return out


def parse(words: list[str]) -> str | None:
    """Return why a command line does not parse, or None."""
    command: Any = SimpleNamespace(commands={name: load_once(name) for name in COMMANDS if name in words[:1]})
    while hasattr(command, "commands"):
        if not words or words[0] not in command.commands:
            return None if words == ["--help"] else f"no such command {' '.join(words[:1])}"
        command, words = command.commands[words[0]], words[1:]
    if "--help" in words:
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
