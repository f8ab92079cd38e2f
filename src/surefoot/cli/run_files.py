"""Write what a run leaves: log, summary, plots, film and report, into one new folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from surefoot.cli.console import say, say_verdict
from surefoot.cli.output import to_json
from surefoot.cli.page import Table, print_tables, report_sections, write_page
from surefoot.errors import MissingExtra, SurefootError, WriteError
from surefoot.log import Log
from surefoot.robot import Robot
from surefoot.terrain import Terrain

PARTS = "log.parts"
"""Folder that the log's rows go to during a run; log.npz takes its place at the end."""
CAPTIONS = {
    "normal_forces": "Normal forces",
    "cone_use": "Every force inside the cross-section of its cone",
    "base": "Base",
    "pressure": "Centre of pressure in the soles (amber while pushed)",
    "torques": "Joint torques",
    "step_times": "Controller step",
    "velocity": "Velocity",
    "footfalls": "Footfalls",
    "cone_over_time": "Use of the cones over time",
    "path": "Path",
}


class Written:
    """What a run leaves, file by file; a full disk costs the files that do not fit, and no others.

    Attributes
    ----------
    notes
        One line for each file that could not be written.
    """

    def __init__(self) -> None:
        self.notes: list[str] = []

    def attempt(self, path: Path, write: Callable[[], object]) -> None:
        """Write a file, or note why it is not there; no half file stays."""
        try:
            write()
        except WriteError as error:
            self.notes.append(str(error))
        except OSError as error:
            self.notes.append(str(WriteError(path, error)))
            path.unlink(missing_ok=True)


class Pictures:
    """Film and plots of a run, and why there are none: a run must not be lost for want of a picture.

    Parameters
    ----------
    log, folder
        What is drawn, and where to.
    """

    def __init__(self, log: Log, folder: Path) -> None:
        self._log, self._folder = log, folder
        self._film: Path | None = None
        self._plots: list[Path] = []
        self._notes: list[str] = []
        self._missing: list[MissingExtra] = []

    def film(self, robot: Robot, terrain: Terrain, progress: Callable[[float], None] | None) -> None:
        """Film the run, or note why not: no package, no OpenGL, no patience."""
        from surefoot.viz.film import write_video

        path = self._folder / "film.mp4"
        try:
            self._film = write_video(self._log, robot, terrain, path, progress=progress)
        except MissingExtra as error:
            self._missing.append(error)
        except SurefootError as error:
            self._notes.append(str(error))
        except OSError as error:
            self._notes.append(str(WriteError(path, error)))
            path.unlink(missing_ok=True)
        except KeyboardInterrupt:
            self._notes.append("no video: interrupted")

    def plot(self, draw: Callable[[Log, Path], list[Path]]) -> None:
        """Draw the plots, or note why not."""
        try:
            self._plots = draw(self._log, self._folder)
        except MissingExtra as error:
            self._missing.append(error)
        except SurefootError as error:
            self._notes.append(str(error))
        except OSError as error:
            self._notes.append(str(WriteError(self._folder, error)))

    def notes(self) -> list[str]:
        """Return why pictures are missing, a line each; all missing packages are one line."""
        missing = [f"pictures left out: {MissingExtra.of(self._missing)}"] if self._missing else []
        return missing + self._notes

    def sections(self) -> list[tuple[str, str]]:
        """Return the report's sections for film and plots."""
        from surefoot.viz.report import film, paragraph, picture

        found = []
        if self._film is not None:
            note = paragraph("Forces as the world reports them; a force inside its cone ends inside the rim.")
            found.append(("Film", film(self._film) + note))
        titled = [(CAPTIONS.get(p.stem, p.stem.replace("_", " ")), picture(p)) for p in self._plots]
        return found + titled


def write_summary(summary: dict[str, Any], folder: Path) -> Path:
    """Write summary.json into the folder and return its path."""
    path = folder / "summary.json"
    path.write_text(to_json(summary) + "\n", encoding="utf-8")
    return path


def publish(
    console: Console,
    folder: Path,
    written: Written,
    shown: Pictures,
    title: str,
    verdict: tuple[str, bool],
    figures: tuple[Sequence[Table], Sequence[str]],
    draw: Callable[[Log, Path], list[Path]] | None,
    opening: Sequence[tuple[str, str]] = (),
) -> None:
    """Print what came of a run and write its page.

    Parameters
    ----------
    console, folder
        Where to.
    written, shown
        Told of the page and of the plots; what they note is printed.
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
    print_tables(console, *figures)
    page = folder / "report.html"
    if draw is not None:
        shown.plot(draw)
        sections = [*opening, *report_sections(*figures), *shown.sections()]
        written.attempt(page, lambda: write_page(folder, title, [verdict], sections))
    say(console, *shown.notes(), *written.notes)
    say_verdict(console, *verdict)
    say(console, f"report: {page if page.exists() else folder}")
