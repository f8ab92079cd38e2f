"""All trials of a bench: spread over processes, kept one by one, and gone on with after an interruption."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.stacks.judging import Trial
from benchmarks.stacks.pins import environment
from benchmarks.stacks.setting import HARD, Setting
from benchmarks.stacks.stack import Stack
from benchmarks.stacks.tasks import Task
from benchmarks.stacks.trial import carry_out
from surefoot.base.errors import ProblemError
from surefoot.base.text_files import plain_value

TRIALS = "trials.jsonl"
"""File of a bench's folder: what was measured with what in its first line, then a line for each trial."""


@dataclass(frozen=True)
class Bench:
    """What is to be measured.

    Attributes
    ----------
    stacks, tasks
        Each stack does each task that is for its robots.
    seeds
        Trials of each, numbered from 0.
    setting
        What is real about the world.
    """

    stacks: tuple[Stack, ...]
    tasks: tuple[Task, ...]
    seeds: int
    setting: Setting = HARD

    def trials(self) -> list[tuple[Stack, Task, int]]:
        """Return all trials, seed after seed: what an interruption leaves says a little of every task."""
        pairs = [(s, t) for t in self.tasks for s in self.stacks if s.walks(t.robot)]
        return [(stack, task, seed) for seed in range(self.seeds) for stack, task in pairs]

    def header(self) -> dict[str, Any]:
        """Return what the figures belong to."""
        versions = {stack.name: stack.version() for stack in self.stacks}
        return {"setting": asdict(self.setting), "stacks": versions, "environment": environment()}


class Kept:
    """The trials that are kept in a folder; new ones are added as they come.

    Parameters
    ----------
    folder
        Of the bench; None to keep nothing.
    header
        See `Bench.header`.

    Raises
    ------
    ProblemError
        If the folder holds trials of another setting or version, or what is no trial.
    """

    def __init__(self, folder: Path | None, header: dict[str, Any]) -> None:
        self.trials: dict[tuple[str, str, int], Trial] = {}
        self._path = None if folder is None else folder / TRIALS
        if self._path is None:
            return
        if not self._path.exists():
            self._path.write_text(json.dumps(plain_value(header)) + "\n", encoding="utf-8")
            return
        for trial in read_trials(self._path, header):
            self.trials[trial.stack, trial.task, trial.seed] = trial
        if not self._path.read_bytes().endswith(b"\n"):
            with self._path.open("a", encoding="utf-8") as file:
                file.write("\n")  # behind a line that was cut off

    def add(self, trial: Trial) -> None:
        """Keep a trial."""
        self.trials[trial.stack, trial.task, trial.seed] = trial
        if self._path is not None:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(plain_value(trial.as_dict())) + "\n")


def read_trials(path: Path, header: dict[str, Any]) -> Iterator[Trial]:
    """Yield the trials of a file; a last line that was cut off is none.

    Raises
    ------
    ProblemError
        If they were measured with another setting or version than `header` says.
    """
    lines = path.read_text(encoding="utf-8").splitlines()
    try:
        found = json.loads(lines[0])
    except (IndexError, json.JSONDecodeError) as error:
        raise ProblemError(f"{path} is no file of trials: {error}") from error
    expected = plain_value(header)
    if found != expected:
        other = next(k for k in sorted({*found, *expected}) if found.get(k) != expected.get(k))
        raise ProblemError(
            f"{path} was measured with another {other}: {found.get(other)}, now {expected.get(other)}; "
            "start anew without --resume"
        )
    for line in lines[1:]:
        try:
            yield Trial.from_dict(json.loads(line))
        except json.JSONDecodeError:
            continue  # the process was killed while it wrote


def measure(
    bench: Bench,
    folder: Path | None = None,
    workers: int = 1,
    tell: Callable[[Trial, int, int], None] | None = None,
) -> list[Trial]:
    """Carry out what is not kept yet and return all trials, also after Ctrl-C: those that there are.

    Parameters
    ----------
    bench
        What to measure.
    folder
        Where trials are kept, and taken from; None for nowhere.
    workers
        Processes.
    tell
        Told every new trial, how many are done and how many there are.
    """
    kept, wanted = Kept(folder, bench.header()), bench.trials()
    open_ones = [t for t in wanted if (t[0].name, t[1].name, t[2]) not in kept.trials]
    done = len(wanted) - len(open_ones)
    try:
        for trial in _carried_out(open_ones, bench.setting, workers):
            kept.add(trial)
            done += 1
            if tell is not None:
                tell(trial, done, len(wanted))
    except KeyboardInterrupt:
        pass  # what there is so far is the answer
    order = {(stack.name, task.name, seed): k for k, (stack, task, seed) in enumerate(wanted)}
    return sorted(
        (t for k, t in kept.trials.items() if k in order), key=lambda t: order[t.stack, t.task, t.seed]
    )


def _carried_out(
    trials: Sequence[tuple[Stack, Task, int]], setting: Setting, workers: int
) -> Iterator[Trial]:
    """Yield trials as they are done; Ctrl-C ends it after those that have begun in other processes."""
    if workers == 1:
        for stack, task, seed in trials:
            yield carry_out(stack, task, seed, setting)
        return
    pool = ProcessPoolExecutor(workers, initializer=_leave_signals)
    open_ones: list[Future[Trial]] = []
    try:
        open_ones += [pool.submit(carry_out, stack, task, seed, setting) for stack, task, seed in trials]
        for future in as_completed(list(open_ones)):
            open_ones.remove(future)
            yield future.result()
    except KeyboardInterrupt:
        begun = [future for future in open_ones if not future.cancel()]
        for future in as_completed(begun):
            yield future.result()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _leave_signals() -> None:
    """Let Ctrl-C be the first process's matter: trials that have begun are finished."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
