"""What a loop on the wire needs of whatever carries its messages: DDS, or a made-up one in tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from surefoot.motion.drive.wire.packed import PackedMessage


class Transport(Protocol):
    """Carries states to the loop and commands from it; `surefoot.motion.drive.wire.link.WireEnd` is DDS's."""

    def send(self, message: PackedMessage) -> None:
        """Send a command."""

    def receive(self, timeout: float) -> PackedMessage | None:
        """Return the newest state that has not been received yet, None if none comes in time [s]."""

    def rivals(self) -> Sequence[str]:
        """Return the other programs that may command the robot, in words."""

    def neighbours(self) -> Sequence[str]:
        """Return the other programs on the wire, whatever they say, in words."""

    def partners(self) -> int:
        """Return how many programs are there that may say the next state."""
