"""A Dask cluster, or one started on this machine."""

from __future__ import annotations

from typing import Any

from surefoot.errors import MissingExtra, ProblemError
from surefoot.sweep.pools.pool import Chunk, Ended, Pool, cores, one_thread, reach
from surefoot.sweep.worker import Task, run_chunk


class DaskPool(Pool):
    """Dask's workers. A scheduler of this machine tells of every lost one; another's may retry first."""

    def __init__(self, task: Task, workers: int | None = None, address: str | None = None) -> None:
        try:
            import dask
            import distributed
        except ImportError as error:
            raise MissingExtra("distributed", "scale") from error
        if address is not None:
            reach("Dask scheduler", address)
        self._dask: Any = distributed
        self._cluster = None
        count = workers or cores()
        # spawned workers take their environment from here; no nanny's retries hide a lost one
        environment = {f"distributed.nanny.pre-spawn-environ.{k}": int(v) for k, v in one_thread().items()}
        self._settings = dask.config.set({"distributed.scheduler.allowed-failures": 0, **environment})
        if address is None:
            self._cluster = distributed.LocalCluster(
                n_workers=count, threads_per_worker=1, dashboard_address=None, silence_logs=50
            )
        try:
            self._client = distributed.Client(self._cluster or address, timeout=20)
        except (OSError, ValueError) as error:
            raise ProblemError(f"no Dask scheduler answers at {address}: {error}") from error
        self.workers = workers or max(1, sum(self._client.nthreads().values()))
        self._task, self._running = task, dict[Any, Chunk]()

    def submit(self, chunk: Chunk) -> None:
        """Have a chunk run."""
        self._running[self._client.submit(run_chunk, self._task, chunk, pure=False)] = chunk

    def wait(self, seconds: float) -> list[Ended]:
        """Return the chunks that have ended."""
        if not self._running:
            return []
        try:
            over = self._dask.wait(list(self._running), timeout=seconds, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            return []
        return [self._ended(future) for future in over]

    def _ended(self, future: Any) -> Ended:
        error = future.exception() if future.status == "error" else None
        lost = future.status in ("lost", "cancelled") or isinstance(error, self._dask.scheduler.KilledWorker)
        return Ended(self._running.pop(future), None if lost else future.result())

    def close(self) -> None:
        """Leave the cluster, or end the one that was started."""
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()
        self._settings.__exit__(None, None, None)
