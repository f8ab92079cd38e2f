"""What a story says: events, causes, and both as the paragraph that a person would write."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Attributes
    ----------
    name
        What: "fell", "slides", "push", ...
    time
        When it began [s].
    where
        Contact, joint or link; "body" for the robot.
    evidence
        The figures that speak for it.
    because
        Name of the cause without which it would not have happened; empty for a beginning.
    """

    name: str
    time: float
    where: str
    evidence: str
    because: str = ""

    def __str__(self) -> str:
        why = f", because of {self.because}" if self.because else ""
        return f"{self.time:.2f} s: {self.name} ({self.where}): {self.evidence}{why}"


@dataclass(frozen=True)
class Cause:
    """Why a run went wrong.

    Attributes
    ----------
    name
        What it is, see `story.causes.RULES`.
    time
        When it began [s].
    where
        Link, joint, actuator or contact; "body" for the robot, "ground" for all of it.
    evidence
        The figures that speak for it.
    refuted
        What would refute it: it was looked for, and is not so.
    remedy
        What to try.
    without
        What would have been without it, recomputed from the log; empty where the log does not tell.
    """

    name: str
    time: float
    where: str
    evidence: str
    refuted: str
    remedy: str
    without: str = ""

    def __str__(self) -> str:
        return f"{self.name} ({self.where}, from {self.time:.2f} s on): {self.evidence}"


@dataclass(frozen=True)
class Story:
    """What happened.

    Attributes
    ----------
    events
        By time.
    causes
        The likeliest first; empty where nothing went wrong that the log can tell.
    failure
        How it went wrong; None if it did not.
    """

    events: tuple[Event, ...] = ()
    causes: tuple[Cause, ...] = ()
    failure: Event | None = None

    def __str__(self) -> str:
        if self.failure is None and not self.causes:
            return "Nothing went wrong that the log can tell."
        lines = []
        if self.failure is not None:
            f = self.failure
            lines.append(f"At {f.time:.2f} s it {_VERBS.get(f.name, f.name)}: {f.evidence}.")
        for k, cause in enumerate(self.causes[:2]):
            lead = "First cause" if k == 0 else "Else"
            told = f"{lead}: {cause.name} at {cause.where}, from {cause.time:.2f} s on: {cause.evidence}"
            lines.append(f"{told}; {cause.without}." if cause.without else f"{told}.")
        if not self.causes:
            lines.append("The log shows no cause of it.")
        else:
            lines.append(f"Try: {self.causes[0].remedy}.")
        return " ".join(lines)


_VERBS = {
    "fell": "fell",
    "slides": "began to slide",
    "strays": "had lost its way",
    "stands crooked": "began to stand crooked",
    "task failed": "had failed its task",
}
