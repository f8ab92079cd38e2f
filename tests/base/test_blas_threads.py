"""BLAS on one thread: inside and in no thread afterwards, whoever else is inside, and after errors."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

import surefoot as sf
from surefoot.base.blas_threads import SHARED_ROWS, light_blas


def now() -> set[int]:
    """Return the threads of all BLAS libraries."""
    import scipy.linalg  # noqa: F401

    return {entry["num_threads"] for entry in ThreadpoolController().info() if entry["user_api"] == "blas"}


@pytest.fixture
def many() -> Iterator[set[int]]:
    """Yield what they take: two, for tests have one otherwise."""
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        if now() != {2}:
            pytest.skip("a BLAS that takes no more than one thread")
        yield {2}


def test_one_thread_inside_and_as_before_outside(many: set[int]) -> None:
    with light_blas(SHARED_ROWS):
        assert now() == {1}
        with light_blas(SHARED_ROWS):
            assert now() == {1}
        assert now() == {1}
    assert now() == many
    with light_blas(SHARED_ROWS - 1):
        assert now() == many


def test_it_is_restored_after_an_error(many: set[int]) -> None:
    with pytest.raises(ValueError, match="inside"), light_blas(1000):
        raise ValueError("inside")
    assert now() == many


def test_another_thread_leaves_it_to_the_first(many: set[int]) -> None:
    inside, leave = threading.Event(), threading.Event()
    seen: list[set[int]] = []

    def other() -> None:
        with light_blas(1000):
            inside.set()
            assert leave.wait(10.0)
        seen.append(now())

    thread = threading.Thread(target=other)
    with light_blas(1000):
        thread.start()
        assert inside.wait(10.0)
    assert now() == many
    leave.set()
    thread.join()
    assert (*seen, now()) == (many, many)


def test_a_large_problem_is_solved_on_one(many: set[int], monkeypatch: pytest.MonkeyPatch) -> None:
    from surefoot.contact.solvers import solver

    seen: list[set[int]] = []
    entry = solver.registry()["nsgs"]

    def look(*given: object) -> object:
        seen.append(now())
        return entry.function(*given)  # type: ignore[arg-type]

    monkeypatch.setitem(solver._REGISTRY, "nsgs", replace(entry, function=look))
    for contacts, threads in ((2, many), (60, {1})):
        g = np.tile([0.1, 0.0, -1.0], contacts)
        assert sf.solve(sf.ContactProblem(np.eye(3 * contacts), g, 0.5), "nsgs").solved
        assert seen.pop() == threads
    assert now() == many
