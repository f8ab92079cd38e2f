"""Runs the trials of an ablation: everything, then one change after another, each in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.ablation.comparing import Records
from surefoot.base.errors import SurefootError

ROOT = Path(__file__).resolve().parents[2]
Tell = Callable[[str, int, int], None]
"""Told a line, and how many trials are done of how many."""


@dataclass(frozen=True)
class Change:
    """What is different in some trials.

    Attributes
    ----------
    name
        Of the part that is left out, or the value of a setting.
    without
        Name of a behaviour that is left out; empty for none.
    changes
        Settings by "Class.setting".
    """

    name: str
    without: str = ""
    changes: Mapping[str, Any] = field(default_factory=dict)


class TrialError(SurefootError):
    """A process of trials has failed."""


def run_trials(
    change: Change, tasks: Sequence[str], seeds: Sequence[int], longest: float | None = None
) -> Generator[dict[str, Any], None, None]:
    """Yield the records of a change's trials, task after task; closing the generator ends its process.

    Parameters
    ----------
    change, tasks, seeds
        What is tried.
    longest
        When walks end that would last longer [s]; None for each task's own length.
    """
    request = {
        "changes": dict(change.changes), "without": change.without, "tasks": list(tasks),
        "seeds": list(seeds), "longest": longest,
    }  # fmt: skip
    paths = [str(ROOT), str(ROOT / "src"), os.environ.get("PYTHONPATH", "")]
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.ablation.worker", json.dumps(request)], cwd=ROOT,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(part for part in paths if part)},
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    try:
        for line in process.stdout:
            yield json.loads(line)
        if process.wait() != 0:
            raise TrialError(f"the trials of {change.name} ended with exit code {process.returncode}")
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


class Trials:
    """The records of all changes so far; each trial is carried out once.

    Parameters
    ----------
    seeds
        Of all trials.
    total
        How many trials there will be.
    tell
        See `Tell`.
    keep
        File to which records are appended; None for none.
    longest
        See `run_trials`.
    """

    def __init__(
        self, seeds: Sequence[int], total: int, tell: Tell, keep: Path | None = None,
        longest: float | None = None,
    ) -> None:  # fmt: skip
        self.seeds, self.total, self._tell, self._keep = seeds, total, tell, keep
        self._longest = longest
        self.records: dict[str, list[dict[str, Any]]] = {}
        self.done = 0

    def of(
        self, change: Change, tasks: Sequence[str], enough: Callable[[str, Records], bool] | None = None
    ) -> list[dict[str, Any]]:
        """Return a change's records of some tasks, carrying out those that are missing.

        Parameters
        ----------
        change, tasks
            Of what; tasks are carried out in turn.
        enough
            Told a task and the records of its trials when all are done: whether later tasks are left out.
        """
        known = self.records.setdefault(change.name, [])
        missing = [task for task in tasks if task not in {one["task"] for one in known}]
        if missing:
            running = run_trials(change, missing, self.seeds, self._longest)
            for record in running:
                self._note(change, record)
                mine = [one for one in known if one["task"] == record["task"]]
                if enough is not None and len(mine) == len(self.seeds) and enough(record["task"], mine):
                    break
            running.close()
        return [one for one in known if one["task"] in tasks]

    def _note(self, change: Change, record: dict[str, Any]) -> None:
        """Keep a record, and tell of it."""
        self.records[change.name].append(record)
        self.done += 1
        if self._keep is not None:
            with self._keep.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"change": change.name, **record}) + "\n")
        said = "done" if record["done"] else "not done"
        self._tell(f"{change.name}: {record['task']} seed {record['seed']}: {said}", self.done, self.total)
