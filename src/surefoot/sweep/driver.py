"""Run what a sweep's folder lacks: chunks out, rows in; workers that die are replaced, killers found."""

from __future__ import annotations

import time as clock
from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from surefoot.sweep.config import SweepConfig
from surefoot.sweep.pools import Pool, open_pool
from surefoot.sweep.pools.pool import Chunk, Ended, split
from surefoot.sweep.store import Store
from surefoot.sweep.worker import CRASHED, Row, Task, row_of

MOST_CRASHES = 3
"""A sample that was alone at work this often when its worker died is recorded as crashed."""
AHEAD = 2
"""Chunks per worker that are handed out: one at work, one waiting."""
LOOK = 0.5
"""Longest time without a look at the clock [s]."""
WRITE_SHARE, WRITE_MOST = 0.02, 60.0
"""A part is written when this share of the time so far (at least 1 s), or this time [s], is unwritten."""


@dataclass(frozen=True)
class SweepResult:
    """What a sweep came to.

    Attributes
    ----------
    config
        What was run.
    folder, path
        Where; the merged table.
    table
        All rows, sorted by index: a pyarrow.Table.
    resumed
        Rows that were there before.
    lost_workers
        How often a worker died.
    wall_time
        Of this run [s].
    notes
        What was found to be wrong, one line each.
    """

    config: SweepConfig
    folder: Path
    path: Path
    table: Any
    resumed: int
    lost_workers: int
    wall_time: float
    notes: tuple[str, ...]


def run_sweep(
    config: SweepConfig,
    folder: str | Path,
    *,
    backend: str = "loky",
    workers: int | None = None,
    address: str | None = None,
    tell: Callable[[int], None] | None = None,
) -> SweepResult:
    """Run the samples that a folder lacks and return the whole table.

    Interrupted or killed at any moment, the same call goes on where it was: what was written is kept, no
    sample is recorded twice. Results do not depend on the backend, on the number of workers or on what was
    killed; wall times do.

    Parameters
    ----------
    config
        What to run, see `read_sweep`.
    folder
        New, empty, or of the same sweep, perhaps with fewer samples.
    backend, workers, address
        See `surefoot.sweep.pools.open_pool`.
    tell
        Called with the number of rows that are there, now and then.

    Raises
    ------
    ProblemError
        For a folder or a backend that will not do.
    MissingExtra
        If pyarrow or the backend is not installed.
    WriteError
        If the disk is full, ...: parts written before are kept.
    """
    begin = clock.perf_counter()
    with Store(folder, config) as store:
        resumed, lost = len(store.done), 0
        todo = store.missing()
        if todo:
            pool = open_pool(backend, Task(config.experiment, config.space), workers, address)
            try:
                lost = _run_missing(store, pool, todo, tell)
            finally:
                pool.close()
        path = store.merge()
        wall = clock.perf_counter() - begin
        return SweepResult(config, store.folder, path, store.table(), resumed, lost, wall, tuple(store.notes))


def _run_missing(store: Store, pool: Pool, todo: list[int], tell: Callable[[int], None] | None) -> int:
    """Run samples and write their rows; return how often a worker died."""
    crew = Crew(pool, store.config, todo)
    begin = written = clock.monotonic()
    try:
        for rows in crew.rows():
            store.add(rows)
            now = clock.monotonic()
            if now - written >= min(max(1.0, WRITE_SHARE * (now - begin)), WRITE_MOST):
                store.flush()
                written = now
            if tell is not None:
                tell(len(store.done))
    finally:
        store.flush()
    return crew.lost


class Crew:
    """Hands out samples to a pool until each has a row.

    When a worker dies, the samples of all chunks that went with it are suspects. Once nothing else is left
    they are run one at a time, with nothing beside them, so that a sample which kills its worker is told
    from one that stood next to it; a worker killed from outside costs time, never a row.

    Attributes
    ----------
    lost
        How often a worker died so far.
    """

    def __init__(self, pool: Pool, config: SweepConfig, todo: list[int]) -> None:
        self._pool, self._config = pool, config
        self._queue = deque(split(todo, self._chunk(len(todo))))
        self._suspects: deque[int] = deque()
        self._crashes: Counter[int] = Counter()
        self._alone = False
        self.lost = 0

    def _chunk(self, count: int) -> int:
        """Return samples per chunk: the experiment's, but few enough that all workers share the end."""
        return max(1, min(self._config.experiment.chunk, count // (4 * self._pool.workers)))

    def rows(self) -> Iterator[list[Row]]:
        """Yield rows as they come; empty lists while there are none."""
        while self._queue or self._suspects or self._pool.waiting:
            self._hand_out()
            over = self._pool.wait(LOOK)
            self.lost += any(ended.rows is None for ended in over)
            yield [row for ended in over for row in self._taken(ended)]

    def _hand_out(self) -> None:
        """Keep the workers busy; in the end, one suspect at a time."""
        pool = self._pool
        while self._queue and pool.waiting < AHEAD * pool.workers:
            pool.submit(self._queue.popleft())
        if self._suspects and not pool.waiting:
            pool.submit((self._suspects.popleft(),))
            self._alone = True

    def _taken(self, ended: Ended) -> list[Row]:
        """Return the rows of a chunk that has ended; samples that were lost become suspects."""
        if ended.rows is not None:
            return ended.rows
        if self._alone:
            return self._accuse(ended.chunk)
        self._suspects.extend(ended.chunk)
        return []

    def _accuse(self, chunk: Chunk) -> list[Row]:
        """Count a death against the one sample that was at work."""
        (index,) = chunk
        self._crashes[index] += 1
        if self._crashes[index] < MOST_CRASHES:
            self._suspects.appendleft(index)
            return []
        (sample,) = self._config.space.sample([index])
        told = f"its worker died {MOST_CRASHES} times with this sample alone at work"
        return [row_of(sample, CRASHED, told, dict.fromkeys(self._config.experiment.columns), None)]
