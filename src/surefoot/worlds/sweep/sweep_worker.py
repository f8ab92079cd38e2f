"""What workers do: run samples, and turn what a sample raises into its row."""

from __future__ import annotations

import os
import platform
import signal
import threading
import time as clock
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from surefoot import __version__
from surefoot.base.errors import ProblemError, SurefootError
from surefoot.worlds.sweep.sample_experiment import SweepExperiment
from surefoot.worlds.sweep.space import Space, SweepSample

DONE, ERROR, CRASHED = "done", "error", "crashed"
"""How a sample ended: with results, with an exception, or thrice with the end of its worker."""
Row = dict[str, Any]


@dataclass(frozen=True)
class SweepTask:
    """What every worker needs to run any sample; `version` is the driver's Surefoot."""

    experiment: SweepExperiment
    space: Space
    version: str = __version__


def run_chunk(task: SweepTask, indices: Sequence[int]) -> list[Row]:
    """Return the rows of some samples.

    Raises
    ------
    ProblemError
        On a worker whose Surefoot is not the driver's: rows of two versions do not belong together.
    """
    if task.version != __version__:
        raise ProblemError(
            f"worker {platform.node()} has Surefoot {__version__}, the driver {task.version}: install the "
            "same"
        )
    return [_row(task.experiment, sample) for sample in task.space.sample(indices)]


def row_of(
    experiment: SweepExperiment, sample: SweepSample, status: str, error: str = "", **results: Any
) -> Row:
    """Return a row: the sample, how it ended, its results; None for what is missing."""
    head = {"index": sample.index, **sample.values, "status": status, "error": " ".join(error.split())}
    return {**head, **dict.fromkeys((*experiment.columns, "wall_time")), **results}


def _row(experiment: SweepExperiment, sample: SweepSample) -> Row:
    """Run one sample. One that fails must not end a sweep of thousands: what it raised is its row."""
    begin, status, said, results = clock.perf_counter(), DONE, "", dict[str, Any]()
    values: dict[str, Any] = {**sample.values}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a sweep visits the edges on purpose
            results = replace(experiment, **values).run(sample.seed)
    except SurefootError as error:
        status, said = ERROR, str(error)
    except Exception as error:
        status, said = ERROR, f"{type(error).__name__}: {error}"
    return row_of(experiment, sample, status, said, **results, wall_time=clock.perf_counter() - begin)


def start_local_worker(driver: int) -> None:
    """Let Ctrl-C be the driver's affair, and end with the driver, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(driver,), daemon=True).start()


def _end_with(driver: int) -> None:
    while os.getppid() == driver:
        clock.sleep(0.5)
    os._exit(1)
