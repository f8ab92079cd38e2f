"""One picture of an answer."""

from __future__ import annotations

from pathlib import Path

from surefoot.base.arrays import of_kind
from surefoot.base.errors import ProblemError
from surefoot.base.text_files import path_of
from surefoot.records.audit import AuditReport


def picture(answer: AuditReport, path: Path | str = "picture.png") -> Path:
    """Draw an answer into a new file and return its path.

    Parameters
    ----------
    answer
        An audit's report: its story, the robot at the events, friction, balance and torques over time.
    path
        Of the file; its suffix says which kind: .png, .svg or .pdf.

    Raises
    ------
    ProblemError
        For what is no such answer, or a file that exists already.
    MissingExtra
        If matplotlib is not installed.
    """
    of_kind("answer", answer, AuditReport)
    place = path_of(path)
    if place.exists():
        raise ProblemError(f"{place} exists already")
    if place.suffix not in KINDS:
        raise ProblemError(f"a picture is one of {', '.join(KINDS)}, got {place.suffix or place.name!r}")
    from surefoot.app.viz.story_plots import draw_story

    return draw_story(answer, place)


KINDS = (".png", ".svg", ".pdf")
"""Suffixes of files of pictures."""
