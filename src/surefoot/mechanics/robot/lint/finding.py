"""What a lint finds: one finding a fault, and the rule that found it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from surefoot.base.errors import count_of

if TYPE_CHECKING:
    from surefoot.mechanics.robot.lint.subject import Subject

SEVERITIES = ("error", "warning", "note")
"""An error makes a walk or verdict wrong, or keeps the robot from loading; a warning may; a note explains."""


class Offence(NamedTuple):
    """Where a rule is broken: the place, the value there, what it is measured by, and how grave it is.

    `severity` is empty for the rule's own.
    """

    place: str
    value: str
    detail: str
    severity: str = ""


@dataclass(frozen=True)
class Rule:
    """A rule of the lint.

    Attributes
    ----------
    name
        Its name, as findings have it.
    reads
        What it looks at.
    severity
        Of its findings, unless one says another: one of `SEVERITIES`.
    remedy
        What to do about a finding.
    check
        Yields where a subject breaks it.
    """

    name: str
    reads: str
    severity: str
    remedy: str
    check: Callable[[Subject], Iterable[Offence]]


@dataclass(frozen=True)
class Finding:
    """A fault of a robot's model.

    Attributes
    ----------
    rule
        Name of the rule that is broken.
    severity
        "error": a walk or verdict would be wrong, or the robot does not load; "warning": it may be; "note".
    place
        The link, joint, foot, actuator or file.
    value
        What stands there.
    detail
        What it is measured by.
    remedy
        What to do.
    """

    rule: str
    severity: str
    place: str
    value: str
    detail: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.severity} {self.rule}: {self.place}: {self.value}: {self.detail}. {self.remedy}"


@dataclass(frozen=True)
class Lint:
    """What the lint found in a robot's model.

    Attributes
    ----------
    robot
        Its name or file.
    world
        Where a walk of it happens, and whose contacts count there.
    findings
        Errors first, then warnings, then notes.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> lint = load_robot("go2").lint()
    >>> lint.ok, len(lint.errors)
    (True, 0)
    """

    robot: str
    world: str
    findings: tuple[Finding, ...] = field(default=())

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings that make a walk or a verdict wrong."""
        return self._of("error")

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """The findings that may."""
        return self._of("warning")

    @property
    def notes(self) -> tuple[Finding, ...]:
        """The findings that explain."""
        return self._of("note")

    @property
    def ok(self) -> bool:
        """Whether there is no error."""
        return not self.errors

    @property
    def summary(self) -> str:
        """How many of each, and in which world, in one line."""
        counts = [(len(self._of(one)), one) for one in SEVERITIES]
        parts = ", ".join(count_of(n, one) for n, one in counts)
        return f"{self.robot}: {parts}; walks in {self.world}"

    def __str__(self) -> str:
        return "\n".join([self.summary, *map(str, self.findings)])

    def as_dict(self) -> dict[str, Any]:
        """Return plain values, as `surefoot lint --json` prints them."""
        counts = {f"{one}s": len(self._of(one)) for one in SEVERITIES}
        return {
            "robot": self.robot, "ok": self.ok, "world": self.world, **counts,
            "findings": [vars(finding) for finding in self.findings],
        }  # fmt: skip

    def _of(self, severity: str) -> tuple[Finding, ...]:
        return tuple(finding for finding in self.findings if finding.severity == severity)
