"""What C++ parsers say on the process's own stdout and stderr, caught as text."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def parser_output() -> Iterator[list[str]]:
    """Catch the lines that are written to file descriptors 1 and 2; the list fills on leaving.

    It redirects the whole process, so the context should hold no more than the parser's call. Where a
    descriptor is closed nothing is caught.
    """
    lines: list[str] = []
    sys.stdout.flush()
    sys.stderr.flush()
    try:
        kept = [os.dup(1), os.dup(2)]
    except OSError:
        yield lines
        return
    with tempfile.TemporaryFile() as sink:
        try:
            for descriptor in (1, 2):
                os.dup2(sink.fileno(), descriptor)
            yield lines
        finally:
            for descriptor, original in zip((1, 2), kept, strict=True):
                os.dup2(original, descriptor)
                os.close(original)
            sink.seek(0)
            lines += sink.read().decode(errors="replace").splitlines()
