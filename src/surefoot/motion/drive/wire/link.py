"""One end of the wire: a robot's side or a controller's, over DDS."""

from __future__ import annotations

import atexit
import struct
from functools import cache
from typing import Any

from surefoot.base.arrays import real_number, whole_number
from surefoot.base.errors import ProblemError, needs
from surefoot.motion.drive.wire.dds_config import dds_config
from surefoot.motion.drive.wire.dialect import Dialect
from surefoot.motion.drive.wire.packed import PackedMessage

STATE, COMMAND = "rt/lowstate", "rt/lowcmd"
"""Names of the topics."""
LAST_DOMAIN = 232
"""The ports of DDS domains beyond it are no ports."""
AT_ONCE = 16
"""Messages that are taken at once; the newest counts."""
MOST_PROGRAMS = 256
"""Programs on the wire of which DDS is asked at once."""


@cache
def open_domain(domain: int, config: str) -> Any:
    """Return DDS's domain of a configuration, opened once a process: it is not opened twice."""
    from cyclonedds.domain import Domain

    # DDS lets go of a participant in a thread of its own, which takes the interpreter's lock: once the
    # interpreter ends, that thread is gone, and a domain that is deleted then waits for it for ever
    atexit.register(open_domain.cache_clear)
    return Domain(domain, config)


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
    config
        A configuration of Cyclone DDS that has the last word, see `dds_config`; empty for none.

    Raises
    ------
    ProblemError
        For an interface, a domain or a configuration that DDS does not open.
    """

    def __init__(
        self, dialect: Dialect, robot_side: bool, interface: str, domain: int,
        topics: tuple[str, str] = (STATE, COMMAND), config: str = "",
    ) -> None:  # fmt: skip
        with needs("cyclonedds", "wire"):
            from cyclonedds.core import (
                DDSException,
                InstanceState,
                Policy,
                Qos,
                ReadCondition,
                SampleState,
                ViewState,
                WaitSet,
            )
            from cyclonedds.domain import DomainParticipant
            from cyclonedds.pub import DataWriter
            from cyclonedds.sub import DataReader
            from cyclonedds.topic import Topic

            from surefoot.motion.drive.wire.dds_types import carrier_type

        domain = whole_number("domain", domain)
        real_number("domain", domain, low=0.0, high=LAST_DOMAIN)
        try:
            open_domain(domain, dds_config(interface, config))
            party = DomainParticipant(domain)
        except DDSException as error:
            raise ProblemError(
                f"DDS does not open interface {interface!r}, domain {domain}: {error}"
            ) from error
        kinds = zip(topics, (dialect.state, dialect.command), strict=True)
        states, commands = (Topic(party, name, carrier_type(kind)) for name, kind in kinds)
        said, heard = (states, commands) if robot_side else (commands, states)
        self._reader, self._said = DataReader(party, heard), said
        # who only listens is no rival: commands have no writer before the first of them
        self._writer: Any = DataWriter(party, said) if robot_side else None
        # who else writes commands is known to DDS once somebody would read them
        own = Qos(Policy.IgnoreLocal.Participant)
        self._others = None if robot_side else DataReader(party, commands, own)
        self._waiting, self._party = WaitSet(party), party
        self._structure, self._heard = (dialect.command if robot_side else dialect.state), heard.data_type
        self._carrier: Any = object.__new__(said.data_type)
        fresh = ReadCondition(self._reader, SampleState.NotRead | ViewState.Any | InstanceState.Any)
        self._waiting.attach(fresh)

    def send(self, message: PackedMessage) -> None:
        """Send a message."""
        if self._writer is None:
            from cyclonedds.pub import DataWriter

            self._writer = DataWriter(self._party, self._said)
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
            return PackedMessage(self._structure, newest[-1].data)
        except struct.error:  # cut off on its way
            return None

    def rivals(self) -> list[str]:
        """Return the other programs that write commands, in words; none at the robot's side."""
        if self._others is None:
            return []
        ends = [self._others.get_matched_publication_data(h) for h in self._others.get_matched_publications()]
        keys = {end.participant_key for end in ends if end is not None}
        if not keys:
            return []
        known = dict(self._programs())
        return sorted(known.get(key, f"DDS participant {key}") for key in keys)

    def partners(self) -> int:
        """Return how many programs write what is received here."""
        return len(self._reader.get_matched_publications())

    def neighbours(self) -> list[str]:
        """Return the other programs in the domain, in words."""
        own = self._party.get_guid()
        return sorted(words for key, words in self._programs() if key != own)

    def _programs(self) -> list[tuple[Any, str]]:
        """Return the keys of the programs in the domain, and what they say of themselves."""
        from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant

        found = []
        for one in BuiltinDataReader(self._party, BuiltinTopicDcpsParticipant).read(MOST_PROGRAMS):
            if getattr(one, "qos", None) is None:
                continue
            said = {p.key: p.value for p in one.qos if type(p).__name__ == "Property"}
            name, number = said.get("__ProcessName"), said.get("__Pid")
            words = f"{name or 'a program'}, process {number}" if number else f"DDS participant {one.key}"
            host = said.get("__Hostname")
            found.append((one.key, f"{words} on {host}" if host else words))
        return found

    def close(self) -> None:
        """Leave the wire."""
        del self._waiting, self._writer, self._reader, self._others, self._said, self._party
