"""SIGTERM and a closed terminal end a run as Ctrl-C does: what there is so far is written."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

import typer

INTERRUPTED = 130
"""Exit code after Ctrl-C."""
AGAIN = 0.02
"""Time after which a signal is sent anew that was swallowed [s]."""
NAMES = ("SIGTERM", "SIGHUP")
SWALLOWED = "hear_swallowed"
"""Name of the function that hears of swallowed exceptions."""


class Termination(KeyboardInterrupt):
    """A signal that asks the process to end."""


class EndSignal:
    """Which signal asked for the end, if any."""

    number: int | None = None
    heeded = False
    """Whether the end has come: what is still under way of a signal does nothing then."""

    def __init__(self) -> None:
        self._timers: list[threading.Timer] = []

    def send_again(self) -> None:
        """Send the signal anew, a little later."""
        if self.number is not None:
            timer = threading.Timer(AGAIN, os.kill, (os.getpid(), self.number))
            timer.daemon = True
            self._timers.append(timer)
            timer.start()

    def heed(self) -> None:
        """Send nothing any more."""
        self.heeded = True
        for timer in self._timers:
            timer.cancel()
            timer.join()

    def act(self) -> None:
        """End what runs."""
        if not self.heeded:
            raise Termination

    @property
    def code(self) -> int:
        """The exit code of an interrupted run: 128 and the signal's number, as shells count."""
        return INTERRUPTED if self.number is None else 128 + self.number


def say_interrupted(stop: EndSignal, folder: Path) -> int:
    """Say that a run that was interrupted can go on from its folder; return the exit code."""
    from surefoot.app.cli.console import plain_console, say

    line = f"interrupted; what is done is in {folder}, the same command goes on from there"
    say(plain_console(stderr=True), line)
    return stop.code


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
        if _is_inside(frame, SWALLOWED):  # what is raised there is swallowed, too
            stop.send_again()
            return
        clock = sys.modules.get("surefoot.base.compilation.clock")  # no kernel is compiled without it
        if clock is None or not clock.after_kernel(stop.act):
            stop.act()

    earlier: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for name in NAMES:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) in _handlers_to_replace(name, emergency):
                earlier[number] = signal.signal(number, end)
        if emergency and signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
            earlier[signal.SIGINT] = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with _signals_again(stop):
            yield stop
    except Termination:
        print("terminated", file=sys.stderr)
        raise typer.Exit(stop.code) from None
    finally:
        for number, handler in earlier.items():
            signal.signal(number, handler)


@contextmanager
def _signals_again(stop: EndSignal) -> Iterator[None]:
    """Send a signal anew whose exception C has swallowed, as it does in callbacks and destructors."""
    earlier = sys.unraisablehook

    def hear_swallowed(lost: Any) -> None:
        if isinstance(lost.exc_value, Termination):
            stop.send_again()
        else:
            earlier(lost)

    sys.unraisablehook = hear_swallowed
    try:
        yield
    finally:
        sys.unraisablehook = earlier
        stop.heed()


def _is_inside(frame: FrameType | None, name: str) -> bool:
    """Return whether a function of this file is under way."""
    while frame is not None:
        if frame.f_code.co_name == name and frame.f_code.co_filename == __file__:
            return True
        frame = frame.f_back
    return False


def _handlers_to_replace(name: str, emergency: bool) -> tuple[Any, ...]:
    """Return the handlers of a signal that are replaced."""
    obeyed = emergency and name == "SIGTERM"
    return (signal.SIG_DFL, signal.SIG_IGN) if obeyed else (signal.SIG_DFL,)
