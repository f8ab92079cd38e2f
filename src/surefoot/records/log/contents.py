"""The contents of a log as files hold them: arrays, facts and definitions, without the checks of a `Log`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

from surefoot.records.log.channels import Channel

MEMORY = 64 << 20
"""Largest log that is held in memory; a longer one is mapped from files [bytes]."""


class LogContents(Protocol):
    """What a format writes of a log: a `Log` has it, and so has what a reader returns.

    Attributes
    ----------
    arrays
        Name to array of one row per step.
    facts
        Scalars and lists about the run.
    channels
        Name to definition of every array.
    """

    @property
    def arrays(self) -> Mapping[str, Any]:
        """Name to array of one row per step."""

    @property
    def facts(self) -> Mapping[str, Any]:
        """Scalars and lists about the run."""

    @property
    def channels(self) -> Mapping[str, Channel]:
        """Name to definition of every array."""


class StoredLog(NamedTuple):
    """The contents that a reader found in a file; see `LogContents`."""

    arrays: dict[str, Any]
    facts: dict[str, Any]
    channels: dict[str, Channel]
