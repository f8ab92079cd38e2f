"""What the driver asks of a backend: take chunks of samples, give rows back, tell which chunks were lost."""

from __future__ import annotations

import importlib
import os
import socket
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

from surefoot.arrays import whole_number
from surefoot.errors import ProblemError, unknown_name
from surefoot.sweep.pools.table import BACKENDS
from surefoot.sweep.worker import Row, Task

Chunk = tuple[int, ...]
"""Indices of samples that a worker is given together."""


class Ended(NamedTuple):
    """A chunk that a pool is done with; `rows` is None if its worker ended first."""

    chunk: Chunk
    rows: list[Row] | None


class Pool(ABC):
    """Runs chunks on workers.

    joblib's `Parallel` is not used above its loky executor: with Ray it cannot give results as they come, and
    when a worker dies it does not tell which samples were lost.

    Attributes
    ----------
    workers
        How many chunks run at a time.
    """

    workers: int
    _running: dict[Any, Chunk]
    """What a backend knows a chunk by -> the chunk, until it is returned."""

    @abstractmethod
    def submit(self, chunk: Chunk) -> None:
        """Have a chunk run."""

    @abstractmethod
    def wait(self, seconds: float) -> list[Ended]:
        """Return the chunks that have ended, waiting for one if there is none yet, but not for ever."""

    @property
    def waiting(self) -> int:
        """Number of chunks that have not been returned."""
        return len(self._running)

    @abstractmethod
    def close(self) -> None:
        """End what this pool has started; a cluster that it only joined stays."""


def open_pool(backend: str, task: Task, workers: int | None, address: str | None) -> Pool:
    """Return a pool of a backend.

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
    if backend not in BACKENDS:
        raise ProblemError(unknown_name("backend", backend, BACKENDS))
    if workers is not None:
        whole_number("workers", workers, low=1)
    module, _, title = BACKENDS[backend].partition(":")
    made: Pool = getattr(importlib.import_module(module), title)(task, workers, address)
    return made


def reach(kind: str, address: str) -> None:
    """Refuse an address, HOST:PORT perhaps behind a scheme, that nobody answers at.

    Clients would try for minutes. Other addresses ("auto") are left to them.

    Raises
    ------
    ProblemError
        Naming the address.
    """
    host, _, port = address.rpartition("//")[2].rpartition(":")
    if host and port.isdigit():
        try:
            socket.create_connection((host, int(port)), timeout=10.0).close()
        except (OSError, OverflowError) as error:
            raise ProblemError(f"no {kind} answers at {address}: {error}") from error


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def one_thread() -> dict[str, str]:
    """Return the environment that keeps a worker to one thread: its sums are then the same everywhere."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    return dict.fromkeys(names, "1")


def split(indices: Sequence[int], size: int) -> list[Chunk]:
    """Return indices in chunks of at most `size`.

    >>> split([1, 2, 3], 2)
    [(1, 2), (3,)]
    """
    return [tuple(indices[k : k + size]) for k in range(0, len(indices), size)]
