"""One picture of an answer."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

from surefoot.base.arrays import of_kind
from surefoot.base.errors import ProblemError
from surefoot.base.text_files import path_of
from surefoot.records.audit import AuditReport

if TYPE_CHECKING:
    from surefoot.records.certificates.motion_report import MotionReport


def picture(answer: AuditReport | MotionReport, path: Path | str = "picture.png") -> Path:
    """Draw an answer into a new file and return its path.

    Parameters
    ----------
    answer
        An audit's report: its story, the robot at the events, friction, balance and torques over time. A
        certified motion: the robot in a row with the forces that nothing can give, and residuals over time.
    path
        Of the file; its suffix says which kind: .png, .svg or .pdf, of a motion .html as well.

    Raises
    ------
    ProblemError
        For what is no such answer, or a file that exists already.
    MissingExtra
        If matplotlib is not installed.
    """
    if type(answer).__name__ == "MotionReport":  # whose module loads kernels
        return _of_motion(cast("MotionReport", answer), path_of(path))
    of_kind("answer", answer, AuditReport)
    report = cast(AuditReport, answer)
    place = path_of(path)
    _check(place, KINDS)
    from surefoot.app.viz.story_plots import draw_story

    return draw_story(report, place)


KINDS = (".png", ".svg", ".pdf")
"""Suffixes of files of pictures."""


def _check(place: Path, kinds: tuple[str, ...]) -> None:
    """Refuse a file that exists, and other kinds."""
    if place.exists():
        raise ProblemError(f"{place} exists already")
    if place.suffix not in kinds:
        raise ProblemError(f"a picture is one of {', '.join(kinds)}, got {place.suffix or place.name!r}")


def _of_motion(report: MotionReport, place: Path) -> Path:
    """Draw a certified motion, or write its page."""
    from surefoot.app.viz.motion_plots import draw_motion, write_motion_page

    _check(place, (*KINDS, ".html"))
    return write_motion_page(report, place) if place.suffix == ".html" else draw_motion(report, place)
