"""No workers: samples run in the driver's own process, one after the other; for debuggers."""

from __future__ import annotations

from surefoot.errors import ProblemError
from surefoot.sweep.pools.pool import Chunk, Ended, Pool
from surefoot.sweep.worker import Task, run_chunk


class SerialPool(Pool):
    """Runs a chunk when it is waited for. A sample that kills its process ends the sweep."""

    def __init__(self, task: Task, workers: int | None = None, address: str | None = None) -> None:
        if address is not None or workers not in (None, 1):
            raise ProblemError("--backend serial has one worker and no address")
        self.workers, self._task = 1, task
        self._running = {}

    def submit(self, chunk: Chunk) -> None:
        """Have a chunk run."""
        self._running[chunk] = chunk

    def wait(self, seconds: float) -> list[Ended]:
        """Run the next chunk and return it."""
        del seconds
        if not self._running:
            return []
        chunk = self._running.pop(next(iter(self._running)))
        return [Ended(chunk, run_chunk(self._task, chunk))]

    def close(self) -> None:
        """Do nothing."""
