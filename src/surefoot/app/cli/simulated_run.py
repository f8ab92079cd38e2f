"""Run a simulation and account for it: what `surefoot stand` and `surefoot walk` share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

from rich.console import Console

from surefoot.app.cli.console import Table, progress_bar, say
from surefoot.app.cli.options import Leaving
from surefoot.app.cli.output import to_json
from surefoot.app.cli.resuming import Keep
from surefoot.app.cli.run_files import PARTS, Draw, RunFiles
from surefoot.app.cli.run_output import law_table
from surefoot.app.cli.signals import ends_softly
from surefoot.mechanics import Robot, Terrain
from surefoot.motion import Controller
from surefoot.records import Ending, Log
from surefoot.records.audit import RunSummary
from surefoot.worlds.interface.world import World
from surefoot.worlds.mujoco.engine_warnings import engine_warnings
from surefoot.worlds.running.observers import Observer, RunProgress
from surefoot.worlds.running.run import run
from surefoot.worlds.running.run_state import RunState
from surefoot.worlds.running.scenario import Scenario

S = TypeVar("S", bound=RunSummary)


@dataclass(frozen=True)
class Account(Generic[S]):
    """How a run is summed up.

    Attributes
    ----------
    doing
        "standing" or "walking".
    summarise
        The summary of a log.
    headline, tables, lines
        What a summary says: in one line, in tables (the laws come after them), in further figures.
    draw
        Draws the plots.
    opening
        Sections of the report before those of the summary.
    more
        Further entries of summary.json.
    """

    doing: str
    summarise: Callable[[Log], S]
    headline: Callable[[S], str]
    tables: Callable[[S], list[Table]]
    lines: Callable[[S], list[str]]
    draw: Draw
    opening: Sequence[tuple[str, str]] = ()
    more: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class SimulatedRun:
    """A robot on its terrain, the folder of its run (new and empty) and what it is to leave.

    Everything else is said on the console.
    """

    robot: Robot
    terrain: Terrain
    folder: Path
    leaving: Leaving
    console: Console

    def carry_out(
        self,
        world: World,
        controller: Controller,
        scenario: Scenario,
        account: Account[Any],
        observers: Sequence[Observer] = (),
        keep: Keep | None = None,
        start: RunState | None = None,
    ) -> int:
        """Simulate, write everything that the run leaves and return the exit code.

        `observers` watch beside the progress bar, `keep` keeps states, and `start` is one to go on from.
        The code is 0 if the robot did it, no law or limit was broken and every file was written.
        """
        with ends_softly() as stop:
            shown = not self.leaving.as_json
            with progress_bar(shown, account.doing, scenario.duration) as tell, engine_warnings() as warned:
                watching = [*observers, *([] if tell is None else [RunProgress(tell)])]
                parts = self.folder / PARTS
                keeper = None if keep is None else keep.into(parts)
                log = run(world, controller, scenario, watching, parts, keep=keeper, resume=start)
            say(self.console, *warned)
            summary, entries = self._write(log, account)
            if self.leaving.as_json:
                print(to_json(entries))
        if summary.outcome == Ending.INTERRUPTED:
            return stop.code
        return 0 if summary.good and not entries["unwritten"] else 1

    def _write(self, log: Log, account: Account[Any]) -> tuple[RunSummary, dict[str, Any]]:
        """Write everything that the run leaves, print the tables, and return the summary, also for JSON."""
        files = RunFiles(log, self.folder)
        files.write("log.npz", log.save)
        summary: RunSummary = account.summarise(log)
        entries = {**summary.as_dict(), **account.more, "unwritten": files.unwritten}
        files.write_summary(entries)
        if self.leaving.video and summary.outcome != Ending.INTERRUPTED:
            with progress_bar(not self.console.quiet, "filming", 1.0) as tell:
                files.film(self.robot, self.terrain, tell, self.leaving.hd)
        files.publish(
            self.console, f"{self.robot.name} {account.doing}", (account.headline(summary), summary.good),
            ([*account.tables(summary), law_table(summary)], account.lines(summary)),
            account.draw if self.leaving.report else None, account.opening,
        )  # fmt: skip
        return summary, entries
