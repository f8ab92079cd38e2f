"""One end of the wire: a robot's side or a controller's, over DDS."""

from __future__ import annotations

import atexit
import struct
from functools import cache
from typing import Any

from surefoot.base.arrays import real_number, whole_number
from surefoot.base.errors import ProblemError, needs
from surefoot.motion.drive.wire.dialect import Dialect
from surefoot.motion.drive.wire.packed import PackedMessage

STATE, COMMAND = "rt/lowstate", "rt/lowcmd"
"""Names of the topics."""
CONFIG = (
    "<CycloneDDS><Domain Id='any'><General><Interfaces><NetworkInterface name='{}' priority='default' "
    "multicast='default'/></Interfaces></General></Domain></CycloneDDS>"
)
"""CycloneDDS on one interface."""
LAST_DOMAIN = 232
"""The ports of DDS domains beyond it are no ports."""
AT_ONCE = 16
"""Messages that are taken at once; the newest counts."""


@cache
def open_domain(domain: int, interface: str) -> Any:
    """Return DDS's domain on an interface, opened once a process: it is not opened twice."""
    from cyclonedds.domain import Domain

    # DDS lets go of a participant in a thread of its own, which takes the interpreter's lock: once the
    # interpreter ends, that thread is gone, and a domain that is deleted then waits for it for ever
    atexit.register(open_domain.cache_clear)
    return Domain(domain, CONFIG.format(interface))


class WireEnd:
    """Sends and receives the messages of a dialect; `close` it at the end.

    Parameters
    ----------
    dialect
        Whose messages.
    robot_side
        Whether states are sent and commands received, or the other way round.
    interface, domain
        Of the network, and of DDS: 0 on Unitree's robots, 1 in its simulator.
    topics
        Names of the topics of states and commands.

    Raises
    ------
    ProblemError
        For an interface or a domain that DDS does not open.
    """

    def __init__(
        self, dialect: Dialect, robot_side: bool, interface: str, domain: int,
        topics: tuple[str, str] = (STATE, COMMAND),
    ) -> None:  # fmt: skip
        with needs("cyclonedds", "wire"):
            from cyclonedds.core import (
                DDSException,
                InstanceState,
                ReadCondition,
                SampleState,
                ViewState,
                WaitSet,
            )
            from cyclonedds.domain import DomainParticipant
            from cyclonedds.pub import DataWriter
            from cyclonedds.sub import DataReader
            from cyclonedds.topic import Topic

        domain = whole_number("domain", domain)
        real_number("domain", domain, low=0.0, high=LAST_DOMAIN)
        try:
            open_domain(domain, interface)
            party = DomainParticipant(domain)
        except DDSException as error:
            raise ProblemError(
                f"DDS does not open interface {interface!r}, domain {domain}: {error}"
            ) from error
        kinds = dialect.state, dialect.command
        states, commands = (Topic(party, name, kind) for name, kind in zip(topics, kinds, strict=True))
        said, heard = (states, commands) if robot_side else (commands, states)
        self._writer, self._reader = DataWriter(party, said), DataReader(party, heard)
        self._waiting, self._party = WaitSet(party), party
        self._heard = commands.data_type if robot_side else states.data_type
        self._carrier: Any = object.__new__(said.data_type)
        fresh = ReadCondition(self._reader, SampleState.NotRead | ViewState.Any | InstanceState.Any)
        self._waiting.attach(fresh)

    def send(self, message: PackedMessage) -> None:
        """Send a message."""
        self._carrier.data = bytes(message.data)
        self._writer.write(self._carrier)

    def receive(self, timeout: float) -> PackedMessage | None:
        """Return the newest message that has not been received yet, None if none comes in time [s]."""
        if timeout > 0.0:
            self._waiting.wait(round(timeout * 1e9))
        newest = self._reader.take(AT_ONCE)
        if not newest or not isinstance(newest[-1], self._heard):
            return None
        try:
            return PackedMessage(self._heard, newest[-1].data)
        except struct.error:  # cut off on its way
            return None

    def close(self) -> None:
        """Leave the wire."""
        del self._waiting, self._writer, self._reader, self._party
