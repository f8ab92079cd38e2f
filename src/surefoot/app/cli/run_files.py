"""Write what a run leaves: log, summary, plots, film and report, into one new folder."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console

from surefoot.app.cli.console import Table, print_tables, say, say_verdict
from surefoot.app.cli.output import to_json
from surefoot.app.cli.run_output import busy_line
from surefoot.app.viz import report
from surefoot.base.errors import MissingExtra, SurefootError, WriteError
from surefoot.mechanics import Robot, Terrain
from surefoot.records import Log

PARTS = "log.parts"
"""Folder that the log's rows go to during a run; log.npz takes its place at the end."""
CAPTIONS = {
    "normal_forces": ("Normal forces", "How hard the ground pushes each foot; zero in the air, never less."),
    "cone_use": (
        "Every force inside the cross-section of its cone",
        "Each dot is a force along the ground over its normal force; the circle is the friction there is.",
    ),
    "base": ("Base", "How far the body moved and leant from where it began."),
    "torques": ("Joint torques", "What the motors gave, against what they can."),
    "velocity": ("Velocity", "What was commanded, and how the robot moved."),
    "footfalls": ("Footfalls", "Which feet were on the ground, and when."),
    "path": ("Path", "The way of the body over the ground from above."),
}  # fmt: skip
"""Name of a plot to its title and what is seen in it."""
Draw = Callable[[Log, Path], list[Path]]
"""Draws a log's plots into a folder and returns their paths."""


class RunFiles:
    """What a run leaves, file by file; a full disk costs the files that do not fit, and no others.

    A run must not be lost for want of a picture either: what cannot be drawn is a line on the screen.

    Parameters
    ----------
    log, folder
        What is written, and where to.

    Attributes
    ----------
    unwritten
        One line for each file that could not be written.
    """

    def __init__(self, log: Log, folder: Path) -> None:
        self.log, self.folder = log, folder
        self.unwritten: list[str] = []
        self._film: Path | None = None
        self._plots: list[Path] = []
        self._notes: list[str] = []
        self._missing: list[MissingExtra] = []

    def write(self, name: str, write: Callable[[Path], object]) -> None:
        """Write a file of the folder, or note why it is not there; no half file stays."""
        path = self.folder / name
        try:
            write(path)
        except WriteError as error:
            self.unwritten.append(str(error))
        except OSError as error:
            self.unwritten.append(str(WriteError(path, error)))
            path.unlink(missing_ok=True)

    def write_summary(self, facts: dict[str, Any]) -> None:
        """Write summary.json."""
        self.write("summary.json", lambda path: path.write_text(to_json(facts) + "\n", encoding="utf-8"))

    @contextmanager
    def _drawing(self, path: Path) -> Iterator[None]:
        """Note why what is drawn in this context cannot be."""
        try:
            yield
        except MissingExtra as error:
            self._missing.append(error)
        except SurefootError as error:
            self._notes.append(str(error))
        except OSError as error:
            self._notes.append(str(WriteError(path, error)))
            if path.is_file():
                path.unlink()

    def film(
        self, robot: Robot, terrain: Terrain, progress: Callable[[float], None] | None, hd: bool = False
    ) -> None:
        """Film the run, in 720 or 1080 lines, or note why not: no package, no OpenGL, no patience."""
        from surefoot.app.viz.film import write_video

        path = self.folder / "film.mp4"
        try:
            with self._drawing(path):
                self._film = write_video(self.log, robot, terrain, path, progress, 1080 if hd else 720)
        except KeyboardInterrupt:
            self._notes.append("no video: interrupted")

    def publish(
        self,
        console: Console,
        title: str,
        verdict: tuple[str, bool],
        figures: tuple[Sequence[Table], Sequence[str]],
        draw: Draw | None,
        opening: Sequence[tuple[str, str]] = (),
    ) -> None:
        """Print what came of a run and write its page.

        Parameters
        ----------
        console
            Where to.
        title
            Of the page.
        verdict
            One line, and whether it is good news.
        figures
            Tables, and lines below them.
        draw
            Draws the plots; None for no page.
        opening
            Sections of the page before the tables.
        """
        figures = figures[0], [*figures[1], *busy_line(self.log)]
        print_tables(console, *figures)
        page = self.folder / "report.html"
        if draw is not None:
            with self._drawing(self.folder):
                self._plots = draw(self.log, self.folder)
            sections = [*opening, *report_sections(*figures), *self._sections()]
            self.write(page.name, lambda path: write_page(path, title, [verdict], sections))
        missing = [f"pictures left out: {MissingExtra.of(self._missing)}"] if self._missing else []
        say(console, *missing, *self._notes, *self.unwritten)
        say_verdict(console, *verdict)
        if page.exists():
            say(console, f"report: {page}")
        elif any(self.folder.iterdir()):
            say(console, f"files: {self.folder}")

    def _sections(self) -> list[tuple[str, str]]:
        """Return the report's sections for film and plots."""
        found = []
        if self._film is not None:
            note = "Forces as the world reports them; a force inside its cone ends inside the rim."
            found.append(("Film", report.embed_film(self._film) + report.paragraph(note)))
        for plot in self._plots:
            title, seen = CAPTIONS.get(plot.stem, (plot.stem.replace("_", " "), ""))
            found.append((title, report.embed_picture(plot) + report.paragraph(seen)))
        return found


def report_sections(tables: Sequence[Table], lines: Sequence[str]) -> list[tuple[str, str]]:
    """Return a page's sections of tables and figures."""
    written = [(one.title, report.table(one.header, one.rows)) for one in tables]
    return [*written, ("Figures", "".join(report.paragraph(line) for line in lines))]


def write_page(
    path: Path, title: str, verdicts: Sequence[tuple[str, bool]], sections: Sequence[tuple[str, str]]
) -> Path:
    """Write the page of the command that runs to a new file and return its path.

    Parameters
    ----------
    path, title, sections
        See `surefoot.app.viz.report.write_report`.
    verdicts
        Lines, and whether each is good news; together they are one line.
    """
    verdict = "; ".join(line for line, _ in verdicts), all(good for _, good in verdicts)
    return report.write_report(path, title, verdict, sections, shlex.join(["surefoot", *sys.argv[1:]]))
