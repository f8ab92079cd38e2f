"""`surefoot lint`: what in a robot's model would make a walk or a verdict wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console

from surefoot.app.cli import extras, options, robots
from surefoot.app.cli.console import say, say_verdict, show

STYLES = {"error": "red", "warning": "yellow", "note": None}
"""Colours of findings."""


def lint(
    robot: options.RobotName = None,
    feet: options.FootFrames = None,
    as_json: options.AsJson = False,
) -> int:
    """Find what in a robot's model would make a walk or a verdict wrong. Exit code 1 if there are errors."""
    extras.require(extras.robot_packages(robot))
    found = lint_of(robot, feet)
    show(found.as_dict(), as_json, lambda console, facts: _print(console, found))
    return 0 if found.ok else 1


def lint_of(robot: str | None, feet: str | None = None) -> Any:
    """Return the lint of a robot's name or file, also of a file that does not load.

    Raises
    ------
    ModelError
        For an unknown name, no file, or feet that are none of its frames.
    """
    from surefoot.base.errors import ModelError
    from surefoot.mechanics.robot.foot_reading import FootUnread
    from surefoot.mechanics.robot.lint.lint import lint_file

    try:
        return robots.load(robot, feet).lint()
    except ModelError as error:
        path = Path(robot or "")
        known = feet is None or isinstance(error, FootUnread) or not _loads(robot)
        if not robots.is_file(robot) or not path.is_file() or not known:
            raise
        return lint_file(path, str(error))


def lint_line(robot: Any) -> str | None:
    """Return the line that says that the lint of a loaded robot has errors, None where it has none."""
    if robot.source is None:
        return None
    errors = robot.lint().errors
    if not errors:
        return None
    first, count = errors[0], "1 error" if len(errors) == 1 else f"{len(errors)} errors"
    name = robot.source.name if robots.is_file(robot.source.name) else robot.name
    which = f"{first.rule} at {first.place} ({first.value})"
    return f"lint: {count} in its model, as {which}: see surefoot lint {name}"


def _loads(robot: str | None) -> bool:
    """Tell whether a robot loads without feet: then these are at fault."""
    from surefoot.base.errors import ModelError

    try:
        robots.load(robot)
    except ModelError:
        return False
    return True


def _print(console: Console, found: Any) -> None:
    say_verdict(console, found.summary, found.ok)
    for finding in found.findings:
        head = f"{finding.severity} {finding.rule}: {finding.place}: {finding.value}"
        say(console, head, style=STYLES[finding.severity])
        say(console, f"    {finding.detail}", f"    {finding.remedy}")
