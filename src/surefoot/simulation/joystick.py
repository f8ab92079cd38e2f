"""A gamepad as Linux shows it, /dev/input/js*: read without any library.

A device gives events of eight bytes: a time in milliseconds, a value, a kind and a number [1]_. At first it
tells the state of every axis and button that way, marked as such.

References
----------
.. [1] Linux kernel, Documentation/input/joydev/joystick-api.rst.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from surefoot.errors import ProblemError

EVENT = struct.Struct("<IhBB")
"""time [ms], value, kind, number."""
BUTTON, AXIS, INITIAL = 0x01, 0x02, 0x80
FULL = 32767
"""Value of an axis at its end."""
DEAD = 0.12
"""Share of an axis about its middle that counts as the middle."""
FOLDER = Path("/dev/input")


class JoystickEvent(NamedTuple):
    """What changed on a gamepad.

    Attributes
    ----------
    axis
        Whether it was an axis; else a button.
    number
        Which.
    value
        Of an axis -1 to 1, to the right and downwards positive; of a button 1 or 0.
    initial
        Whether it is not a change, but how things stand at first.
    """

    axis: bool
    number: int
    value: float
    initial: bool


def parse_events(data: bytes) -> tuple[list[JoystickEvent], bytes]:
    """Return the whole events in some bytes, and the rest of an event that has not come in full.

    Events of another kind are left out.

    >>> parse_events(EVENT.pack(5, -32767, AXIS, 1) + b"ab")
    ([JoystickEvent(axis=True, number=1, value=-1.0, initial=False)], b'ab')
    """
    whole = len(data) - len(data) % EVENT.size
    found = []
    for _, value, kind, number in EVENT.iter_unpack(data[:whole]):
        what = kind & ~INITIAL
        if what in (BUTTON, AXIS):
            share = max(value / FULL, -1.0) if what == AXIS else float(value)
            found.append(JoystickEvent(what == AXIS, number, share, bool(kind & INITIAL)))
    return found, data[whole:]


def outside_dead_zone(value: float) -> float:
    """Return an axis's value without its dead zone: 0 within it, from there on rising to 1 evenly.

    >>> outside_dead_zone(0.05), outside_dead_zone(-1.0)
    (0.0, -1.0)
    """
    size = max(abs(value) - DEAD, 0.0) / (1.0 - DEAD)
    return size if value >= 0.0 else -size


def find_joysticks(folder: Path = FOLDER) -> list[Path]:
    """Return the gamepads of this machine that can be read; none where the system has no such files."""
    return [path for path in sorted(folder.glob("js*")) if os.access(path, os.R_OK)]


class Joystick:
    """An open gamepad; `events` never waits.

    Parameters
    ----------
    path
        Of its device.

    Raises
    ------
    ProblemError
        If it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._rest = b""
        try:
            self._file: int | None = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        except OSError as error:
            raise ProblemError(f"cannot read the gamepad {path}: {error.strerror}") from error

    def events(self) -> Sequence[JoystickEvent]:
        """Return what happened since the last call; nothing for a gamepad that was unplugged."""
        if self._file is None:
            return ()
        try:
            data = os.read(self._file, 64 * EVENT.size)
        except BlockingIOError:
            return ()
        except OSError:
            self.close()
            return ()
        found, self._rest = parse_events(self._rest + data)
        return found

    def close(self) -> None:
        """Close the device."""
        if self._file is not None:
            os.close(self._file)
            self._file = None
