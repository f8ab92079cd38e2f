"""Output that nobody reads: the command goes on, writes its files and ends with its own exit code."""

from __future__ import annotations

import os
from typing import Any, TextIO, cast


class _Pipe:
    """A text stream that goes on into nothing once its reader is gone, as `head` is after ten lines."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, or drop what nobody reads."""
        try:
            return self._stream.write(text)
        except BrokenPipeError:
            self._drop()
            return len(text)

    def flush(self) -> None:
        """Flush, or drop what nobody reads."""
        try:
            self._stream.flush()
        except BrokenPipeError:
            self._drop()

    def _drop(self) -> None:
        with open(os.devnull, "w", encoding="utf-8") as nowhere:
            os.dup2(nowhere.fileno(), self._stream.fileno())


def heard(stream: TextIO | None) -> TextIO:
    """Return a stream for output that takes all, also where the shell (None) or its reader closed it."""
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8")
    return cast("TextIO", _Pipe(stream))
