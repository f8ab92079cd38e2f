"""Processes of this machine, through joblib's executor loky."""

from __future__ import annotations

import os
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from typing import Any

from surefoot.errors import MissingExtra, ProblemError
from surefoot.sweep.pools.pool import Chunk, Ended, Pool, cores, one_thread
from surefoot.sweep.worker import Task, run_chunk, start_local_worker


class LokyPool(Pool):
    """Processes of this machine. When one is killed loky gives up all of them; they are started anew."""

    def __init__(self, task: Task, workers: int | None = None, address: str | None = None) -> None:
        if address is not None:
            raise ProblemError("--address is of --backend ray or dask: loky runs on this machine")
        self.workers = cores() if workers is None else workers
        self._task, self._running = task, dict[Future[Any], Chunk]()
        self._executor = self._start()

    def _start(self) -> Any:
        try:
            from joblib.externals.loky import ProcessPoolExecutor
        except ImportError as error:
            raise MissingExtra("joblib", "sweep") from error
        return ProcessPoolExecutor(
            self.workers, initializer=start_local_worker, initargs=(os.getpid(),), env=one_thread()
        )

    def submit(self, chunk: Chunk) -> None:
        """Have a chunk run."""
        try:
            future = self._executor.submit(run_chunk, self._task, chunk)
        except BrokenExecutor as error:  # a worker died since the last look
            future = Future()
            future.set_exception(error)
        self._running[future] = chunk

    def wait(self, seconds: float) -> list[Ended]:
        """Return the chunks that have ended; all that were running are lost if a worker was."""
        over = wait(self._running, timeout=seconds, return_when=FIRST_COMPLETED).done
        if any(isinstance(future.exception(), BrokenExecutor) for future in over):
            self._executor.shutdown(wait=True, kill_workers=True)
            self._executor = self._start()
            over = set(self._running)  # what is not done by now never will be
        return [self._ended(future) for future in over]

    def _ended(self, future: Future[Any]) -> Ended:
        chunk = self._running.pop(future)
        lost = not future.done() or isinstance(future.exception(), BrokenExecutor)
        return Ended(chunk, None if lost else future.result())

    def close(self) -> None:
        """End the processes, whatever they are at."""
        self._executor.shutdown(wait=True, kill_workers=True)
