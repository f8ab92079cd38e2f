"""Run a simulation and account for it: what `surefoot stand` and `surefoot walk` share."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from surefoot.cli import run_files
from surefoot.cli.engine_warnings import engine_warnings
from surefoot.cli.output import to_json
from surefoot.cli.progress import progress_bar
from surefoot.cli.signals import ends_softly
from surefoot.robot import Robot
from surefoot.simulation.log import Log
from surefoot.terrain import Terrain

Tell = Callable[[float], None] | None


@dataclass(frozen=True)
class Account:
    """How a run is summed up.

    Attributes
    ----------
    doing
        "standing" or "walking".
    success
        The key of the summary that says whether the robot did it.
    summarise
        The summary of a log.
    show
        Prints a summary.
    headline
        One line for a summary.
    sections
        The report's sections for a summary.
    draw
        Draws the plots; None for those of a stand.
    """

    doing: str
    success: str
    summarise: Callable[[Log], dict[str, Any]]
    show: Callable[[Console, dict[str, Any]], None]
    headline: Callable[[dict[str, Any]], str]
    sections: Callable[[dict[str, Any]], list[tuple[str, str]]]
    draw: Callable[[Log, Path], list[Path]] | None = None


@dataclass(frozen=True)
class SimulatedRun:
    """A robot on its terrain, the folder of its run and what is wanted there.

    Attributes
    ----------
    robot, terrain
        Of the film.
    duration
        Simulated time [s].
    folder
        New and empty.
    video, report
        Whether the run is filmed, and drawn.
    as_json
        Whether the summary is all that is printed.
    console
        For everything else.
    """

    robot: Robot
    terrain: Terrain
    duration: float
    folder: Path
    video: bool
    report: bool
    as_json: bool
    console: Console

    def carry_out(self, simulate: Callable[[Tell, Path], Log], account: Account) -> int:
        """Simulate, write everything that the run leaves and return the exit code.

        `simulate` takes what moves the progress bar and the folder of the log's rows. The code is 0 if the
        robot did it, no law was broken and every file was written.
        """
        with ends_softly() as stop:
            shown = not self.as_json
            with progress_bar(shown, account.doing, self.duration) as tell, engine_warnings() as warned:
                log = simulate(tell, self.folder / run_files.PARTS)
            for line in warned:
                self._say(line)
            summary = self._write(log, account)
            if self.as_json:
                print(to_json(summary))
        if summary["outcome"] == "interrupted":
            return stop.code
        good = summary[account.success] and not summary["laws_broken"] and not summary["unwritten"]
        return 0 if good else 1

    def _write(self, log: Log, account: Account) -> dict[str, Any]:
        """Write everything that the run leaves, print the tables, and return the summary."""
        from surefoot.viz.report import write_report

        folder = self.folder
        written, page = run_files.Written(), folder / "report.html"
        written.attempt(folder / "log.npz", lambda: log.save(folder / "log.npz"))
        summary = account.summarise(log)
        summary["unwritten"] = written.notes
        written.attempt(folder / "summary.json", lambda: run_files.write_summary(summary, folder))
        pictures = run_files.Pictures(log, folder)
        if self.video and summary["outcome"] != "interrupted":
            with progress_bar(not self.console.quiet, "filming", 1.0) as tell:
                pictures.film(self.robot, self.terrain, tell)
        account.show(self.console, summary)
        headline = account.headline(summary)
        good = summary[account.success] and not summary["laws_broken"]
        if self.report:
            pictures.plot(account.draw)
            sections = account.sections(summary) + pictures.sections()
            title = f"{self.robot.name} {account.doing}"
            command = shlex.join(["surefoot", *sys.argv[1:]])
            written.attempt(page, lambda: write_report(page, title, (headline, good), sections, command))
        for note in pictures.notes() + written.notes:
            self._say(note)
        self._say(headline, "bold green" if good else "bold red")
        self._say(f"report: {page if page.exists() else folder}")
        return summary

    def _say(self, text: str, style: str | None = None) -> None:
        """Print a line as it is."""
        self.console.print(text, style=style, soft_wrap=True, highlight=False)
