"""A Ray cluster, or one started on this machine."""

from __future__ import annotations

import logging
from typing import Any

from surefoot.errors import MissingExtra, ProblemError
from surefoot.sweep.pools.pool import Chunk, Ended, Pool, cores, one_thread, reach
from surefoot.sweep.worker import Task, run_chunk


class RayPool(Pool):
    """Ray's workers. Ray itself would run a lost task again; here the driver does, which counts."""

    def __init__(self, task: Task, workers: int | None = None, address: str | None = None) -> None:
        try:
            import ray
        except ImportError as error:
            raise MissingExtra("ray", "scale") from error
        if address is not None:
            reach("Ray cluster", address)
        self._ray: Any = ray
        settings: dict[str, Any] = {
            "log_to_driver": False, "logging_level": logging.ERROR, "runtime_env": {"env_vars": one_thread()},
        }  # fmt: skip
        if address is None:
            settings |= {"num_cpus": workers or cores(), "include_dashboard": False, "address": "local"}
        try:
            ray.init(address or settings.pop("address"), **settings)
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise ProblemError(f"no Ray cluster answers at {address}: {error}") from error
        self.workers = workers or max(1, int(ray.cluster_resources().get("CPU", 1.0)))
        self._run: Any = ray.remote(max_retries=0)(run_chunk)
        self._task, self._running = ray.put(task), dict[Any, Chunk]()

    def submit(self, chunk: Chunk) -> None:
        """Have a chunk run."""
        self._running[self._run.remote(self._task, chunk)] = chunk

    def wait(self, seconds: float) -> list[Ended]:
        """Return the chunks that have ended."""
        if not self._running:
            return []
        over, _ = self._ray.wait(list(self._running), timeout=seconds)
        return [self._ended(reference) for reference in over]

    def _ended(self, reference: Any) -> Ended:
        lost = self._ray.exceptions
        try:
            rows = self._ray.get(reference)
        except (lost.WorkerCrashedError, lost.OutOfMemoryError, lost.NodeDiedError, lost.ObjectLostError):
            rows = None
        return Ended(self._running.pop(reference), rows)

    def close(self) -> None:
        """Leave the cluster, or end the one that was started."""
        self._ray.shutdown()
