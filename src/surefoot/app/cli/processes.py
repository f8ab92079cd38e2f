"""The same work for many tasks, in processes of their own: results as they come, and an end that ends all."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from surefoot.base.cores import cores

R = TypeVar("R")
TICK = 1.0
"""Time after which the caller is told that nothing is new [s]."""


def results_of(
    work: Callable[..., R],
    tasks: Sequence[tuple[Any, ...]],
    jobs: int | None,
    idle: Callable[[], None] | None = None,
) -> Iterator[tuple[int, R]]:
    """Yield (k, work(*tasks[k])) in the order in which they are done.

    Parameters
    ----------
    work
        A function that processes can import.
    tasks
        Its arguments.
    jobs
        Most processes; None for one a core. A single one is this process.
    idle
        Called once a second while nothing is done.
    """
    workers = min(len(tasks), cores() if jobs is None else jobs)
    if workers <= 1:
        for k, task in enumerate(tasks):
            yield k, work(*task)
        return
    from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
    from multiprocessing import get_context

    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        waiting = {pool.submit(work, *task): k for k, task in enumerate(tasks)}
        left = set(waiting)
        try:
            while left:
                done, left = wait(left, TICK, FIRST_COMPLETED)
                for future in done:
                    yield waiting[future], future.result()
                if not done and idle is not None:
                    idle()
        except BaseException:  # an interrupt, or a task that fails: the others are not waited for
            for process in list(pool._processes.values()):
                process.terminate()
            raise
