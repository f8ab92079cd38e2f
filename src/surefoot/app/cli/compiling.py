"""Tells on stderr that kernels are being compiled, which happens on the first call on a machine."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

LOG = logging.getLogger("surefoot.compilation")
CLEAR = "\r\x1b[K"
"""Back to the start of a terminal's line, and nothing left on it."""


class CompilationNotice(logging.Handler):
    """One line for the first compilation that takes long, and on a terminal how far each of them is.

    Parameters
    ----------
    terminal
        Whether stderr is one.
    """

    def __init__(self, terminal: bool) -> None:
        super().__init__(logging.DEBUG if terminal else logging.WARNING)
        self.terminal = terminal

    def emit(self, record: logging.LogRecord) -> None:
        """Print a warning as a line, and everything else over the line before."""
        if record.levelno >= logging.WARNING:
            print(f"surefoot: {record.getMessage()}", file=sys.stderr, flush=True)
        if not self.terminal:
            return
        share, name = getattr(record, "share", 1.0), getattr(record, "kernel", "")
        text = f"compiling {name}: {100.0 * share:.0f} %" if share < 1.0 else ""
        print(CLEAR + text, end="", file=sys.stderr, flush=True)


def announce_compilation() -> None:
    """Tell of compilations on stderr, from now on."""
    if not any(isinstance(handler, CompilationNotice) for handler in LOG.handlers):
        notice = CompilationNotice(sys.stderr.isatty())
        LOG.addHandler(notice)
        LOG.setLevel(notice.level)
        LOG.propagate = False


@contextmanager
def silent() -> Iterator[None]:
    """Tell nothing while the context lasts."""
    before = LOG.level
    LOG.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        LOG.setLevel(before)
