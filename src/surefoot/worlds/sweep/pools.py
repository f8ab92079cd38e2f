"""Where samples are run: processes of this machine, a Ray or a Dask cluster, one function each.

All of them give futures of `concurrent.futures`. joblib's `Parallel` is not used above its executor loky:
with Ray it cannot give results as they come, and when a worker dies it does not tell which samples were lost.
"""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from functools import partial
from typing import Any, NamedTuple

from surefoot.base.arrays import whole_number
from surefoot.base.cores import cores
from surefoot.base.errors import ProblemError, check_name, needs
from surefoot.worlds.sweep.sweep_worker import Row, SweepTask, run_chunk, start_local_worker

Chunk = tuple[int, ...]
"""Indices of samples that a worker is given together."""
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)
"""Environment that keeps a worker to one thread: its sums are then the same everywhere."""


class Workers(NamedTuple):
    """Workers that were started or joined.

    Attributes
    ----------
    submit
        From a chunk to the future of its rows.
    workers
        How many chunks run at a time.
    death_errors
        Exceptions of a future whose worker died.
    close
        Ends what was started; a cluster that was only joined stays.
    """

    submit: Callable[[Chunk], Future[list[Row]]]
    workers: int
    death_errors: tuple[type[BaseException], ...]
    close: Callable[[], object]


def loky(task: SweepTask, workers: int | None, address: str | None) -> Workers:
    """Start processes of this machine, through joblib's executor. When one is killed it gives up all."""
    with needs("joblib", "sweep"):
        from joblib.externals.loky import ProcessPoolExecutor
    count = workers or cores()
    executor = ProcessPoolExecutor(
        count, initializer=start_local_worker, initargs=(os.getpid(),), env=ONE_THREAD
    )
    return Workers(
        lambda chunk: executor.submit(run_chunk, task, chunk), count, (BrokenExecutor,),
        lambda: executor.shutdown(wait=True, kill_workers=True),
    )  # fmt: skip


def ray(task: SweepTask, workers: int | None, address: str | None) -> Workers:
    """Join a Ray cluster or start one. Ray itself would run a lost task again; here the driver does."""
    with needs("ray", "scale"):
        import ray
    settings: dict[str, Any] = {
        "log_to_driver": False, "logging_level": logging.ERROR, "runtime_env": {"env_vars": ONE_THREAD},
    }  # fmt: skip
    if address is None:
        settings |= {"num_cpus": workers or cores(), "include_dashboard": False}
    else:
        _reach("Ray cluster", address)
    try:
        ray.init(address or "local", **settings)
    except (ConnectionError, ValueError, RuntimeError) as error:
        raise ProblemError(f"no Ray cluster answers at {address}: {error}") from error
    run, sent, gone = ray.remote(max_retries=0)(run_chunk), ray.put(task), ray.exceptions
    return Workers(
        lambda chunk: run.remote(sent, chunk).future(),
        workers or max(1, int(ray.cluster_resources().get("CPU", 1.0))),
        (gone.WorkerCrashedError, gone.OutOfMemoryError, gone.NodeDiedError, gone.ObjectLostError),
        ray.shutdown,
    )


def dask(task: SweepTask, workers: int | None, address: str | None) -> Workers:
    """Join a Dask cluster or start one, whose scheduler reports every lost worker (others may retry)."""
    with needs("distributed", "scale"):
        import dask
        import distributed
    cluster = None
    if address is None:
        # spawned workers take their environment from here; no nanny's retries hide a lost one
        environment = {f"distributed.nanny.pre-spawn-environ.{k}": int(v) for k, v in ONE_THREAD.items()}
        with dask.config.set({"distributed.scheduler.allowed-failures": 0, **environment}):
            cluster = distributed.LocalCluster(
                n_workers=workers or cores(), threads_per_worker=1, dashboard_address=None, silence_logs=50
            )
    else:
        _reach("Dask scheduler", address)
    try:
        client = distributed.Client(cluster or address, timeout=20)
    except (OSError, ValueError) as error:
        raise ProblemError(f"no Dask scheduler answers at {address}: {error}") from error
    executor = client.get_executor(pure=False)

    def close() -> None:
        client.close()
        if cluster is not None:
            cluster.close()

    return Workers(
        lambda chunk: executor.submit(run_chunk, task, chunk),
        workers or max(1, sum(client.nthreads().values())),
        (distributed.scheduler.KilledWorker, CancelledError),
        close,
    )


def serial(task: SweepTask, workers: int | None, address: str | None) -> Workers:
    """Run chunks in the driver's own process, for debuggers. A sample that kills it ends the sweep."""

    def submit(chunk: Chunk) -> Future[list[Row]]:
        future: Future[list[Row]] = Future()
        future.set_result(run_chunk(task, chunk))
        return future

    return Workers(submit, 1, (), lambda: None)


BACKENDS: dict[str, Callable[[SweepTask, int | None, str | None], Workers]] = {
    "loky": loky, "ray": ray, "dask": dask, "serial": serial,
}  # fmt: skip
"""What `--backend` chooses from."""


def check_backend(backend: str, workers: int | None, address: str | None) -> None:
    """Refuse a backend that is not known, or that knows no cluster at an address, and fewer workers than one.

    Raises
    ------
    ProblemError
        Naming what is wrong.
    """
    check_name("backend", backend, BACKENDS)
    if workers is not None:
        whole_number("workers", workers, low=1)
    if address is not None and backend not in ("ray", "dask"):
        raise ProblemError(f"--address is of --backend ray or dask: {backend} runs on this machine")
    if backend == "serial" and workers not in (None, 1):
        raise ProblemError(f"--backend serial has one worker, not {workers}")


class Pool:
    """Runs chunks on a backend's workers, and tells which were lost with one.

    Parameters
    ----------
    backend
        A name of `BACKENDS`.
    task
        What the workers are to run.
    workers
        Number of workers; None for one per core, or for all that a cluster has.
    address
        Of a running cluster; None to start one on this machine.

    Raises
    ------
    ProblemError
        For an unknown name, an address for a backend that has none, or a cluster that does not answer.
    MissingExtra
        If the backend is not installed.
    """

    def __init__(self, backend: str, task: SweepTask, workers: int | None, address: str | None) -> None:
        self._open: Callable[[], Workers] = partial(BACKENDS[backend], task, workers, address)
        self._backend = self._open()
        self.workers = self._backend.workers
        self._running = dict[Future[list[Row]], Chunk]()

    @property
    def waiting(self) -> int:
        """Number of chunks that have not been returned."""
        return len(self._running)

    def submit(self, chunk: Chunk) -> None:
        """Have a chunk run."""
        try:
            future = self._backend.submit(chunk)
        except BrokenExecutor as error:  # a worker died since the last look
            future = Future()
            future.set_exception(error)
        self._running[future] = chunk

    def wait(self, seconds: float) -> list[tuple[Chunk, list[Row] | None]]:
        """Return the chunks that have ended and their rows, None where the worker ended first.

        It waits for one if there is none yet, but no longer than `seconds` [s].
        """
        over = wait(self._running, timeout=seconds, return_when=FIRST_COMPLETED).done
        if any(isinstance(_failure(future), BrokenExecutor) for future in over):
            self._backend.close()
            self._backend = self._open()
            over = set(self._running)  # what is not done by now never will be
        return [(self._running.pop(future), self._rows(future)) for future in over]

    def _rows(self, future: Future[list[Row]]) -> list[Row] | None:
        lost = not future.done() or isinstance(_failure(future), self._backend.death_errors)
        return None if lost else future.result()

    def close(self) -> None:
        """End what this pool has started, whatever it is at."""
        self._backend.close()


def _failure(future: Future[Any]) -> BaseException | None:
    return CancelledError() if future.cancelled() else future.exception()


def _reach(kind: str, address: str) -> None:
    """Refuse an address, HOST:PORT perhaps behind a scheme, that nobody answers at.

    Clients would try for minutes. Other addresses ("auto") are left to them.
    """
    host, _, port = address.rpartition("//")[2].rpartition(":")
    if host and port.isdigit():
        try:
            socket.create_connection((host, int(port)), timeout=10.0).close()
        except (OSError, OverflowError) as error:
            raise ProblemError(f"no {kind} answers at {address}: {error}") from error
