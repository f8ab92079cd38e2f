"""Run what a sweep's folder lacks: chunks out, rows in; workers that die are replaced, killers found."""

from __future__ import annotations

import time as clock
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from surefoot.base.arrays import of_kind, whole_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError
from surefoot.worlds.sweep.config import SweepConfig
from surefoot.worlds.sweep.pools import Chunk, Pool, check_backend
from surefoot.worlds.sweep.store import Store
from surefoot.worlds.sweep.sweep_worker import CRASHED, Row, SweepTask, row_of

MOST_CRASHES = 3
"""A sample that was alone at work this often when its worker died is recorded as crashed."""
AHEAD = 2
"""Chunks per worker that are handed out: one at work, one waiting."""
LOOK = 0.5
"""Longest time without a look at the clock [s]."""
WRITE_EVERY = 1.0
"""Time between two writings of rows [s]: what a kill can cost."""


@dataclass(frozen=True, repr=False)
class SweepResult(Drawn):
    """What a sweep came to.

    Attributes
    ----------
    config
        What was run.
    folder, path
        Where; the Parquet table.
    table
        All rows, sorted by index: a pyarrow.Table.
    resumed
        Rows that were there before.
    lost_workers
        How often a worker died.
    wall_time
        Of this run [s].
    """

    config: SweepConfig
    folder: Path
    path: Path
    table: Any
    resumed: int
    lost_workers: int
    wall_time: float

    def __repr__(self) -> str:
        return f"SweepResult({self.config.name!r}, {self.table.num_rows} rows, {str(self.path)!r})"

    def __str__(self) -> str:
        before = f", {self.resumed} of them from before" if self.resumed else ""
        lost = f"; {self.lost_workers} workers died" if self.lost_workers else ""
        return f"Sweep {self.config.name!r}: {self.table.num_rows} rows{before}{lost}; in {self.path}."


def run_sweep(
    config: SweepConfig,
    folder: str | Path,
    *,
    backend: str = "loky",
    workers: int | None = None,
    address: str | None = None,
    part: Sequence[float] = (0, 1),
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
        See `surefoot.worlds.sweep.pools.Pool`.
    part
        (k, n): only samples k, k + n, k + 2 n, ... of the sweep, so that n calls with folders of their own
        share it; `merge_sweep` joins them.
    tell
        Called with the number of rows that are there, now and then.

    Raises
    ------
    ProblemError
        For a folder, a backend or a part that will not do.
    MissingExtra
        If pyarrow or the backend is not installed.
    WriteError
        If the disk is full, ...: rows written before are kept.
    """
    of_kind("config", config, SweepConfig)
    check_backend(backend, workers, address)
    share = [whole_number("part", one) for one in part]
    if len(share) != 2 or share[0] >= share[1]:
        raise ProblemError(f"part must be k and n with k < n, got {share}")
    begin = clock.perf_counter()
    with closing(Store(folder, config)) as store:
        resumed, lost = len(store.done), 0
        todo = store.missing(*share)
        if todo:
            pool = Pool(backend, SweepTask(config.experiment, config.space), workers, address)
            try:
                lost = _run_missing(store, pool, todo, tell)
            finally:
                pool.close()
        return _result(store, resumed, lost, begin)


def merge_sweep(config: SweepConfig, folder: str | Path, others: Sequence[str | Path]) -> SweepResult:
    """Take the rows of other folders into one and return the whole table; nothing is run.

    Parameters
    ----------
    config, folder
        As for `run_sweep`; rows that are there stay.
    others
        Folders of the same sweep, or folders of such folders: of its parts, in any number and order.

    Raises
    ------
    ProblemError
        For a folder of no sweep, of another sweep, or of one that is at work.
    """
    of_kind("config", config, SweepConfig)
    begin = clock.perf_counter()
    with closing(Store(folder, config)) as store:
        for other in others:
            store.take(Path(other))
        return _result(store, len(store.done), 0, begin)


def _result(store: Store, resumed: int, lost: int, begin: float) -> SweepResult:
    """Write the table of a folder, and return what there is."""
    table = store.table()
    path = store.write_table(table)
    return SweepResult(store.config, store.folder, path, table, resumed, lost, clock.perf_counter() - begin)


def _run_missing(store: Store, pool: Pool, todo: list[int], tell: Callable[[int], None] | None) -> int:
    """Run samples and write their rows; return how often a worker died."""
    crew, new = ChunkQueue(pool, store.config, todo), list[Row]()
    written = clock.monotonic()
    try:
        for rows in crew.rows():
            new += rows
            if clock.monotonic() - written >= WRITE_EVERY:
                store.add(new)
                new, written = [], clock.monotonic()
            if tell is not None:
                tell(len(store.done) + len(new))
    finally:
        store.add(new)
    return crew.deaths


class ChunkQueue:
    """Hands out samples to a pool until each has a row.

    When a worker dies, the samples of all chunks that went with it are suspects. Once nothing else is left
    they are run one at a time, with nothing beside them, so that a sample which kills its worker is known
    from one that stood next to it; a worker killed from outside costs time, never a row.

    Attributes
    ----------
    deaths
        How often a worker died so far.
    """

    def __init__(self, pool: Pool, config: SweepConfig, todo: list[int]) -> None:
        size = max(1, min(config.experiment.chunk, len(todo) // (4 * pool.workers)))  # all share the end
        self._pool, self._config = pool, config
        self._queue = deque(tuple(todo[k : k + size]) for k in range(0, len(todo), size))
        self._suspects: deque[int] = deque()
        self._crashes: Counter[int] = Counter()
        self._alone = False
        self.deaths = 0

    def rows(self) -> Iterator[list[Row]]:
        """Yield rows as they come; empty lists while there are none."""
        pool = self._pool
        while self._queue or self._suspects or pool.waiting:
            while self._queue and pool.waiting < AHEAD * pool.workers:
                pool.submit(self._queue.popleft())
            if self._suspects and not pool.waiting:
                pool.submit((self._suspects.popleft(),))
                self._alone = True
            over = pool.wait(LOOK)
            self.deaths += any(rows is None for _, rows in over)
            yield [row for chunk, rows in over for row in (self._suspect(chunk) if rows is None else rows)]

    def _suspect(self, chunk: Chunk) -> list[Row]:
        """Suspect the samples of a chunk whose worker died; one alone at work is the cause."""
        if not self._alone:
            self._suspects.extend(chunk)
            return []
        (index,) = chunk
        self._crashes[index] += 1
        if self._crashes[index] < MOST_CRASHES:
            self._suspects.appendleft(index)
            return []
        (sample,) = self._config.space.sample([index])
        said = f"its worker died {MOST_CRASHES} times with this sample alone at work"
        return [row_of(self._config.experiment, sample, CRASHED, said)]
