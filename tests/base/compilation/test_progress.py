"""What is told of compiling: one line for each tree, also after one that failed."""

from __future__ import annotations

import logging

import pytest

from surefoot.base.compilation.progress import LOG, CompilationProgress
from surefoot.base.compilation.tree import KernelTree


def inner(x: float) -> float:
    return x


def outer(x: float) -> float:
    return x + 1.0


def test_a_tree_that_failed_to_compile_is_not_told_as_compiled(caplog: pytest.LogCaptureFixture) -> None:
    told = CompilationProgress()
    first, second = (KernelTree(lambda _: None, [function]) for function in (outer, inner))
    with caplog.at_level(logging.DEBUG, LOG.name):
        told.start(first)
        told.start(second)  # and never ends
        told.end(first)
        told.passed(outer)  # nothing is running any more
        told.start(second)
        told.passed(inner)
        told.end(second)
    assert told.compiled == 2
    ends = [r for r in caplog.records if "compiled" in r.message]
    assert [r.kernel for r in ends] == [first.name, second.name]  # type: ignore[attr-defined]
    assert [r.share for r in ends] == [1.0, 1.0]  # type: ignore[attr-defined]
    middle = [r for r in caplog.records if "translated" in r.message]
    assert [r.share for r in middle] == [0.7]  # type: ignore[attr-defined]  # the whole tree is one function
