"""What an audit says: a verdict, violations, symptoms, and what could be judged."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal, TypeAlias

from surefoot.base.drawn import Drawn
from surefoot.base.errors import SurefootError, count_of
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.story.told import Cause, Story
from surefoot.records.log import Log

Judgement: TypeAlias = Literal["lawful", "broken", "cannot tell"]
"""Every law that could be judged holds; one at least is broken; the log does not let one know."""

Task: TypeAlias = Literal["attained", "failed", "unknown"]
"""The run did what it was for; it did not; the log does not say."""

MASSES = "masses and outside forces"
TOPICS = {
    MASSES: ("motion", "balance", "acceleration"),
    "slides": ("work", "dissipation"),
    "rebounds": ("restitution", "flight"),
}
"""What a verdict names where none of its laws could be judged."""


class LawBroken(SurefootError, AssertionError):
    """Raised by `assert_lawful`; carries the report.

    Attributes
    ----------
    report
        The whole audit.
    """

    def __init__(self, report: AuditReport) -> None:
        self.report = report
        super().__init__("\n".join([report.sentence, *report.lines()]))


@dataclass(frozen=True)
class Violation:
    """A law broken by a contact over a time.

    Attributes
    ----------
    law
        Its name, see `surefoot.records.audit.CHECKS`; "finite" and "clock" for the log itself.
    contact
        Name of the contact, or "body".
    start, end
        [s].
    value, limit
        Worst measure in between and what it may be, in `unit`.
    unit
        Of both.
    """

    law: str
    contact: str
    start: float
    end: float
    value: float
    limit: float
    unit: str = ""

    def __str__(self) -> str:
        where = f"{self.contact}, {self.start:.3f} to {self.end:.3f} s"
        return f"{self.law}: {where}: {self.value:.3g} {self.unit} (limit {self.limit:.3g})"


@dataclass(frozen=True)
class Finding:
    """A symptom with its likely cause.

    Attributes
    ----------
    name
        Of the symptom, see `surefoot.records.audit.SYMPTOMS`.
    contact
        Name of the contact, "all" or "body".
    start, end
        [s].
    evidence
        The figures that speak for it.
    cause, confirm, cure
        What it likely is, the check that would confirm it, what usually helps.
    strength
        From 0 to 1: what explains more of what was measured comes first. An order, and no probability.
    """

    name: str
    contact: str
    start: float
    end: float
    evidence: str
    cause: str
    confirm: str
    cure: str
    strength: float

    def __str__(self) -> str:
        where = f"{self.contact}, {self.start:.3f} to {self.end:.3f} s"
        return f"{self.name}: {where}: {self.evidence}"


@dataclass(frozen=True)
class FrictionInterval:
    """What a log tells about the friction under a foot over a time; a foot has several where it changed.

    Attributes
    ----------
    contact
        Its name.
    low
        Highest friction used while it stuck: the ground has that much at least.
    high
        Friction while it slid: the ground has no more; infinite where it never slid.
    slid
        Time of sliding that `high` rests on [s].
    start, end
        When [s].
    """

    contact: str
    low: float
    high: float
    slid: float
    start: float = float("nan")
    end: float = float("nan")

    @property
    def words(self) -> str:
        """The interval in words."""
        if self.high == float("inf"):
            return f"at least {self.low:.2f}"
        return f"{self.low:.2f}" if self.high - self.low < 0.005 else f"{self.low:.2f} to {self.high:.2f}"


MOST_LEFT = 4
"""Laws that were not judged whose names a sentence has."""


@dataclass(frozen=True, repr=False)
class AuditReport(Drawn):
    """The whole audit of a log.

    Attributes
    ----------
    verdict
        "lawful", "broken" or "cannot tell".
    violations
        By time; of each law and contact the first hundred.
    more
        Name of a law to the number of its violations beyond those.
    symptoms
        The strongest first.
    coverage
        Name of a law to "" where it was judged, else to the reason why it was not.
    friction
        What each contact tells of the ground's friction.
    notes
        What was assumed or doubted.
    rows, start, end
        Of the log [1, s, s].
    contacts
        Their names.
    weight
        m g that forces were judged against [N].
    reason
        Why one cannot tell; empty for another verdict.
    task
        Whether the run did what it was for: "attained", "failed", or "unknown" where the log does not say.
    task_reason
        How it failed; empty otherwise.
    command
        Where the controller asked for what no contact can give, or did not get what it asked for.
    limits
        What the log was judged by; `limits.lines()` prints it.
    story
        What happened and why; `str(story)` is a paragraph.
    log
        What was audited, for pictures.
    limits_broken
        A line for each limit of the robot's own that was not kept: speeds of its motors, what its links
        touched, as `surefoot.summarise_walk` has them. No law of contact is broken by it.
    episodes
        A report of each episode, where the state was reset in between; empty where it never was.
    load_doubt
        What is odd about the mean load, where no law judges masses; empty for nothing.
    """

    verdict: Judgement
    violations: tuple[Violation, ...]
    more: dict[str, int]
    symptoms: tuple[Finding, ...]
    coverage: dict[str, str]
    friction: tuple[FrictionInterval, ...]
    notes: tuple[str, ...]
    rows: int
    start: float
    end: float
    contacts: tuple[str, ...]
    weight: float
    reason: str = ""
    task: Task = "unknown"
    task_reason: str = ""
    command: tuple[Finding, ...] = ()
    limits: AuditLimits = LIMITS
    story: Story = field(default_factory=Story)
    log: Log | None = field(default=None, repr=False, compare=False)
    limits_broken: tuple[str, ...] = ()
    episodes: tuple[AuditReport, ...] = ()
    load_doubt: str = ""

    def __repr__(self) -> str:
        count = len(self.violations) + sum(self.more.values())
        return (
            f"AuditReport({self.verdict!r}, {count} violations, {len(self.symptoms)} symptoms, "
            f"task={self.task!r}, {self.rows} rows)"
        )

    def __str__(self) -> str:
        physics = self._physics
        limits = f" {self._own_limits[0].upper()}{self._own_limits[1:]}." if self.limits_broken else ""
        return f"{self.story} {physics[0].upper()}{physics[1:]}.{limits}"

    @property
    def causes(self) -> tuple[Cause, ...]:
        """What explains how the run went wrong, the likeliest first; empty where nothing did."""
        return self.story.causes

    @property
    def first_cause(self) -> Cause | None:
        """The first of `causes`."""
        return self.story.causes[0] if self.story.causes else None

    @property
    def lawful(self) -> bool:
        """Whether the verdict is "lawful"."""
        return self.verdict == "lawful"

    @property
    def judged(self) -> tuple[str, ...]:
        """Names of the laws that could be judged."""
        return tuple(name for name, why in self.coverage.items() if not why)

    @property
    def not_judged(self) -> tuple[str, ...]:
        """What of a motion no law looked at, in words: "masses and outside forces", "slides", "rebounds"."""
        unknown = {topic for topic, laws in TOPICS.items() if all(self.coverage.get(law) for law in laws)}
        return tuple(topic for topic in TOPICS if topic in unknown)

    @property
    def sentence(self) -> str:
        """The verdict in one sentence: whether physics held, and whether the task was attained."""
        task = {"attained": "; the task was attained", "failed": f"; the task failed: {self.task_reason}"}
        asked = f"; the command: {self.command[0]}" if self.command else ""
        why = "" if self.first_cause is None else f"; first cause: {self.first_cause}"
        limits = f"; {self._own_limits}" if self.limits_broken else ""
        return self._several + self._physics + limits + task.get(self.task, "") + asked + why

    @property
    def _several(self) -> str:
        """What came of several episodes."""
        if not self.episodes:
            return ""
        counts = Counter(one.verdict for one in self.episodes)
        told = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        return f"{len(self.episodes)} episodes, {told}; "

    @property
    def passed(self) -> bool:
        """Whether it is lawful, and the task did not fail."""
        return self.lawful and self.task != "failed"

    @property
    def exit_code(self) -> int:
        """0: lawful, and the task did not fail; 1: a law is broken or the task failed; 3: one cannot tell."""
        if self.verdict == "broken" or self.task == "failed":
            return 1
        return 0 if self.lawful else 3

    @property
    def _own_limits(self) -> str:
        """What is to say of the robot's own limits."""
        return f"limits not kept: {', '.join(self.limits_broken)}"

    @property
    def _physics(self) -> str:
        """What is to say of the laws."""
        span = f"{self.rows} rows, {self.end - self.start:.3g} s"
        if self.verdict == "lawful":
            known = "" if not self.symptoms else f", but look at: {self.symptoms[0]}"
            if MASSES in self.not_judged:
                doubt = f"; {self.load_doubt}" if self.load_doubt else ""
                rest = "".join(f", nor were {topic}" for topic in self.not_judged if topic != MASSES)
                held = f"lawful: friction, gap and sign hold; {MASSES} were not judged{rest}"
                return f"{held} ({span}){doubt}{known}"
            rest = "".join(f"; {topic} were not judged" for topic in self.not_judged)
            return f"lawful: all {len(self.judged)} laws that could be judged hold ({span}){rest}{known}"
        if self.verdict == "cannot tell":
            return f"cannot tell whether it is lawful ({span}): {self.reason}{self._judged_words}"
        count = len(self.violations) + sum(self.more.values())
        first = f"{self.symptoms[0]}" if self.symptoms else f"{self.violations[0]}"
        return f"broken: {count} violations of {', '.join(self.laws_broken)} ({span}); first of all {first}"

    @property
    def _judged_words(self) -> str:
        """How many laws were judged and hold, and how many were not; empty where none was."""
        held = self.judged
        if not held:
            return ""
        all_hold = {1: "and holds", 2: "both hold"}.get(len(held), "all hold")
        count = count_of(len(held), "law")
        left = [name for name, why in self.coverage.items() if why]
        more = f" and {len(left) - MOST_LEFT} more" if len(left) > MOST_LEFT else ""
        rest = f"; {len(left)} not: {', '.join(left[:MOST_LEFT])}{more}" if left else ""
        return f"; {count} judged, {all_hold}: {', '.join(held)}{rest}"

    @property
    def laws_broken(self) -> tuple[str, ...]:
        """Names of the laws that were broken, in the order of the first time."""
        return tuple(dict.fromkeys(v.law for v in self.violations))

    def lines(self, most: int = 10) -> list[str]:
        """Return symptoms and violations, a line each, `most` of either."""
        out = [f"  {s}; likely {s.cause}" for s in self.symptoms[:most]]
        out += [f"  {v}" for v in self.violations[:most]]
        rest = len(self.violations) - most + sum(self.more.values())
        return [*out, f"  and {rest} more"] if rest > 0 else out

    def as_dict(self) -> dict[str, Any]:
        """Return everything but the limits and the log by name, for JSON."""
        found = {"sentence": self.sentence, **asdict(replace(self, log=None, episodes=()))}
        found["episodes"] = [one.as_dict() for one in self.episodes]
        del found["limits"], found["log"]
        return found
