"""Grade a student's file: start a process for it, read its reports, end it in time."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from surefoot.app.course.exercises import PACKAGE, check_number
from surefoot.base.errors import ProblemError

LARGEST = 1_000_000
"""Bytes of a file that is taken for somebody's exercise."""
START = (
    "import sys; sys.path.append(sys.argv[1]); from surefoot.app.course.child import run; run(*sys.argv[2:])"
)
"""Program of the process: this very package is found there even where the working folder alone has it."""


@dataclass(frozen=True)
class Finding:
    """How a property fared.

    Attributes
    ----------
    words
        The property.
    holds
        Whether no input was found for which it fails.
    inputs
        How many were tried; 0 where one failed.
    call, message
        The call at which it failed, and what was wrong; empty where it holds.
    """

    words: str
    holds: bool
    inputs: int = 0
    call: str = ""
    message: str = ""


@dataclass
class Progress:
    """What the process has reported so far."""

    stage: str = "start"
    findings: list[Finding] = field(default_factory=list)
    words: str = ""
    call: str = ""
    bad: str = ""
    done: bool = False

    def take(self, facts: dict[str, Any]) -> None:
        """Take a report."""
        if "stage" in facts:
            self.stage = facts["stage"]
        elif "property" in facts:
            self.words, self.call = facts["property"], ""
        elif "call" in facts:
            self.call = facts["call"]
        elif "passed" in facts:
            self.findings.append(Finding(self.words, True, facts["passed"]))
        elif "failed" in facts:
            self.fail(facts["failed"])
        self.bad = facts.get("bad", self.bad)
        self.done = self.done or "done" in facts or "bad" in facts

    def fail(self, message: str) -> None:
        """Note that the property under test fails at the last call."""
        self.findings.append(Finding(self.words, False, 0, self.call, message))


def grade(number: str, file: Path, seed: int = 0, time_limit: float = 60.0) -> list[Finding]:
    """Run a file in a process of its own and test the functions of an exercise on random inputs.

    The file runs as `python FILE` would run it, so it may import what is beside it; its standard input is
    empty, and what it prints goes to standard error. Nothing else is run.

    Parameters
    ----------
    number
        Of the exercise, as "52.2.1".
    file
        The student's file.
    seed
        Of the inputs.
    time_limit
        After which the process is ended [s].

    Returns
    -------
    Findings in the order of the exercise's properties; those after one that ended the process are missing.

    Raises
    ------
    ProblemError
        For an unknown exercise, and for a file that cannot be read, does not run, or does not end in time.
    """
    check_number(number)
    _check_file(file)
    if not 0.0 < time_limit < float("inf"):
        raise ProblemError(f"the time limit is {time_limit:g} s, expected a number of seconds above 0")
    progress = Progress()
    with _process([number, str(file), str(seed)]) as (process, reports):
        _read(reports, progress, time.monotonic() + time_limit)
        if not progress.done:
            code = _code(process)
            late = (
                f"no answer within {time_limit:g} s"
                if code is None
                else f"the process ended {_describe_end(code)}"
            )
            if progress.stage != "checks":
                raise ProblemError(f"{file}: {late}, before its functions could be tested")
            progress.fail(late)
    if progress.bad:
        raise ProblemError(f"{file}: {progress.bad}")
    return progress.findings


def _check_file(file: Path) -> None:
    """Refuse what is no file of an ordinary size."""
    if not file.is_file():
        kind = "is no file" if file.exists() else "does not exist"
        raise ProblemError(f"{file} {kind}; write a stub with --stub, then name it with --check")
    if (size := file.stat().st_size) > LARGEST:
        raise ProblemError(f"{file} has {size} bytes, expected a Python file of {LARGEST} at most")


@contextlib.contextmanager
def _process(words: list[str]) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
    """Start the process that runs and tests; yield it and where its reports arrive; end it and its own."""
    reports, theirs = os.pipe()
    try:
        process = subprocess.Popen(
            [sys.executable, "-P", "-c", START, str(PACKAGE.parent), *words, str(theirs)],
            stdin=subprocess.PIPE,  # and closed: a file that asks for input gets its end
            stdout=2,
            pass_fds=[theirs],
            start_new_session=True,
        )
    except BaseException:
        os.close(reports)
        raise
    finally:
        os.close(theirs)
    try:
        if process.stdin is not None:
            process.stdin.close()
        yield process, reports
    finally:
        os.close(reports)
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _read(reports: int, progress: Progress, deadline: float) -> None:
    """Read reports until the last one, the end of the pipe, or the deadline."""
    left = b""
    with selectors.DefaultSelector() as selector:
        selector.register(reports, selectors.EVENT_READ)
        while not progress.done and (rest := deadline - time.monotonic()) > 0:
            if not selector.select(rest):
                return
            if not (piece := os.read(reports, 65536)):
                return
            *lines, left = (left + piece).split(b"\n")
            for line in lines:
                with contextlib.suppress(ValueError):  # a file may write into any descriptor
                    facts = json.loads(line)
                    if isinstance(facts, dict):
                        progress.take(facts)


def _code(process: subprocess.Popen[bytes]) -> int | None:
    """Return the exit code of a process that has closed its pipe, None if it runs on."""
    with contextlib.suppress(subprocess.TimeoutExpired):
        return process.wait(0.5)
    return None


def _describe_end(code: int) -> str:
    if code >= 0:
        return f"by itself, with code {code}"
    return f"by the signal {signal.Signals(-code).name}"
