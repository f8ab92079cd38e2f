"""Work in ranges on threads: everything once, in any number of threads, and errors that come out."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.cores import cores, in_ranges


@pytest.mark.parametrize("threads", [1, 3, 40])
@pytest.mark.parametrize("count", [0, 1, 31, 32, 1000])
def test_every_item_is_worked_on_once(threads: int, count: int) -> None:
    seen = np.zeros(count, dtype=int)

    def work(a: int, b: int) -> None:
        seen[a:b] += 1

    in_ranges(work, count, threads)
    assert (seen == 1).all()


def test_an_error_in_a_thread_is_raised() -> None:
    def work(a: int, b: int) -> None:
        if a <= 500 < b:
            raise ValueError("item 500")

    with pytest.raises(ValueError, match="item 500"):
        in_ranges(work, 1000, 2)


def test_there_is_a_processor() -> None:
    assert cores() >= 1
