"""One robot as a user meets it: its feet, its lint, and what `surefoot walk` and `surefoot stand` answer."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

from surefoot.app.cli.lint import lint_of
from surefoot.base.errors import SurefootError
from surefoot.mechanics import load_robot

PUBLISHED = Path(__file__).with_name("published.toml")
"""Robots of other repositories, see there."""
PATIENCE = 1800.0
"""Time after which a command counts as hung [s]."""
WORDS = {
    "walked": "walks", "did not follow": "does not follow its command", "stood": "stands", "fell": "falls",
    "slipped": "slips", "displaced": "is displaced", "impossible": "cannot stand",
}  # fmt: skip
"""Outcomes of summaries in the present tense."""


@dataclass(frozen=True)
class Candidate:
    """A robot to try.

    Attributes
    ----------
    name
        For people.
    robot, feet
        As on the command line; no feet for one of the catalogue.
    true
        What its feet are by drawing and file.
    """

    name: str
    robot: str
    feet: str = ""
    true: str = ""


@dataclass(frozen=True)
class RobotTrial:
    """What became of a robot.

    Attributes
    ----------
    name
        Of the candidate.
    feet, true
        What was read of the first foot, or why nothing was; what it is.
    errors
        Rules of the lint's errors, with how many there are of each; None where it was not asked.
    walk, stand
        What the commands came to, in words; no `stand` where it walks.
    code
        Exit code of the walk.
    seconds
        Processor time of it all [s].
    """

    name: str
    feet: str
    true: str
    errors: dict[str, int] | None
    walk: str
    stand: str
    code: int
    seconds: float


def published(folder: Path) -> list[Candidate]:
    """Return the robots of the list that are below a folder."""
    listed = tomllib.loads(PUBLISHED.read_text(encoding="utf-8"))["robot"]
    found = [Candidate(r["name"], str(folder / r["file"]), r["feet"], r["true"]) for r in listed]
    return [one for one in found if Path(one.robot).is_file()]


def attempt(one: Candidate, duration: float, lint: bool) -> RobotTrial:
    """Read a robot's feet, lint it if asked to, let it walk, and stand where it does not."""
    start = sum(os.times()[:4])
    feet = _feet_words(one)
    errors: dict[str, int] | None = None
    if lint:
        errors = {}
        for finding in lint_of(one.robot, one.feet or None).errors:
            errors[finding.rule] = errors.get(finding.rule, 0) + 1
    code, walk = _command(one, "walk", ["--velocity", "0.3,0,0", "--duration", str(duration)])
    stand = "" if code == 0 else _command(one, "stand", ["--duration", "2"])[1]
    return RobotTrial(one.name, feet, one.true, errors, walk, stand, code, sum(os.times()[:4]) - start)


def _feet_words(one: Candidate) -> str:
    """Return what is read of the first foot, without its name, and how many there are."""
    try:
        feet = load_robot(one.robot, one.feet or None).feet
    except SurefootError as error:
        return _line(str(error), one)
    if not feet:
        return "none"
    return f"{len(feet)}: {feet[0].why.removeprefix(f'{feet[0].name}: ')}"


def _command(one: Candidate, name: str, options: list[str]) -> tuple[int, str]:
    """Run `surefoot walk` or `stand`; return its exit code and what it came to in words."""
    words = [
        sys.executable,
        "-m",
        "surefoot",
        name,
        one.robot,
        *options,
        "--no-video",
        "--no-report",
        "--json",
    ]
    words += ["--feet", one.feet] if one.feet else []
    try:
        run = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        return -1, f"no answer in {PATIENCE:.0f} s"
    said = run.stderr.strip().splitlines()
    if run.returncode not in (0, 1) or not run.stdout.strip():
        lines = [line for line in said if not line.startswith(("compiling", "{"))]
        return run.returncode, f"refused: {_line(' '.join(lines), one)}"
    summary = json.loads(run.stdout)
    outcome = str(summary["outcome"])
    what = WORDS.get(outcome, outcome)
    if outcome == "fell":
        what += f" after {summary['duration']:.1f} s"
    broken = [*summary.get("laws_broken", ()), *summary.get("limits_broken", ())]
    note = f", breaks: {', '.join(broken)}" if broken else ""
    return run.returncode, what + note


def _line(text: str, one: Candidate) -> str:
    """Return a message on one line, without the folder of the robot's file."""
    text = re.sub(r"\s+", " ", text.replace(one.robot, Path(one.robot).name))
    return text.removeprefix("surefoot: ").replace("|", "/")


def clock() -> str:
    """Return the time of day, for people who wait."""
    return time.strftime("%H:%M:%S")
