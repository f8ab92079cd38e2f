"""SIGTERM and a closed terminal end a run as Ctrl-C does: what there is so far is written."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import typer

INTERRUPTED = 130
"""Exit code after Ctrl-C."""
NAMES = ("SIGTERM", "SIGHUP")


class Termination(KeyboardInterrupt):
    """A signal that asks the process to end."""


class EndSignal:
    """Which signal asked for the end, if any."""

    number: int | None = None

    @property
    def code(self) -> int:
        """The exit code of an interrupted run: 128 and the signal's number, as shells count."""
        return INTERRUPTED if self.number is None else 128 + self.number


@contextmanager
def ends_softly(emergency: bool = False) -> Iterator[EndSignal]:
    """Let SIGTERM and SIGHUP raise a `KeyboardInterrupt` while the context lasts.

    Signals that are ignored (nohup) or handled by somebody else stay as they are, and so does everything
    outside the main thread. A signal that nothing catches inside ends the command with the signal's code.

    Parameters
    ----------
    emergency
        Whether Ctrl-C and SIGTERM are an emergency stop: then they are obeyed even where they were ignored,
        as a shell's script leaves SIGINT for what it starts with ``&``.
    """
    stop = EndSignal()

    def end(number: int, frame: FrameType | None) -> None:
        stop.number = number
        raise Termination

    earlier: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for name in NAMES:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) in _handlers_to_replace(name, emergency):
                earlier[number] = signal.signal(number, end)
        if emergency and signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
            earlier[signal.SIGINT] = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield stop
    except Termination:
        print("terminated", file=sys.stderr)
        raise typer.Exit(stop.code) from None
    finally:
        for number, handler in earlier.items():
            signal.signal(number, handler)


def _handlers_to_replace(name: str, emergency: bool) -> tuple[Any, ...]:
    """Return the handlers of a signal that are replaced."""
    obeyed = emergency and name == "SIGTERM"
    return (signal.SIG_DFL, signal.SIG_IGN) if obeyed else (signal.SIG_DFL,)
