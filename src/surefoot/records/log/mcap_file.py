"""MCAP files: messages as JSON, protobuf or ROS 2 (CDR) in, a log as JSON out.

A log is written as the topic ``/surefoot/log``, all channels in one message per row, which Foxglove and
PlotJuggler plot; it reads itself back from there to the last bit.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError, needs
from surefoot.records.log.channels import CHANNELS
from surefoot.records.log.contents import LogContents
from surefoot.records.log.mapping import LogMapping, Take
from surefoot.records.log.source import Messages, Source, check_size

OWN_METADATA = "surefoot"
"""Name of the metadata record that holds the mapping back to a log."""
OWN_TOPIC = "/surefoot/log"
_DECODERS = {"protobuf": "mcap_protobuf", "cdr": "mcap_ros2"}
"""Encoding of messages to the module that decodes it."""

Decode = Callable[[bytes], Any]


def import_mcap() -> Any:
    """Return the module `mcap.reader`, with its exceptions, or raise `MissingExtra`."""
    with needs("mcap", "files"):
        import mcap.reader
    return mcap.reader


def source(path: Path) -> Source:
    """Return the messages of an MCAP file.

    Raises
    ------
    ProblemError
        If it is cut or spoilt, or none of its messages can be read.
    MissingExtra
        If a package is missing.
    """
    reader = import_mcap()
    check_size(path.stat().st_size, path)
    messages, decoders = Messages(), {}
    with path.open("rb") as file:
        opened = reader.make_reader(file, validate_crcs=True)
        own = {m.name: m.metadata for m in opened.iter_metadata()}.get(OWN_METADATA)
        topics = None if own is None else [OWN_TOPIC]
        for schema, channel, message in opened.iter_messages(topics=topics, log_time_order=False):
            if channel.id not in decoders:
                decoders[channel.id] = _decoder(schema, channel)
            decode = decoders[channel.id]
            if decode is None:
                messages.unread.add(f"{channel.topic} is {channel.message_encoding}: not read")
                continue
            try:
                decoded = decode(message.data)
            except Exception as error:
                raise ProblemError(
                    f"{path}: a message of {channel.topic} cannot be decoded: {error}"
                ) from error
            kind = schema.name if schema is not None else ""
            messages.add(channel.topic, kind, message.log_time, decoded)
    if not decoders:
        raise ProblemError(f"{path} holds no messages")
    found = messages.source()
    found.mapping = "" if own is None else own["mapping"]
    return found


def _decoder(schema: Any, channel: Any) -> Decode | None:
    """Return what decodes a channel's messages; None for an encoding that is not known."""
    encoding = channel.message_encoding
    if encoding == "json":
        return json.loads
    if encoding not in _DECODERS:
        return None
    module = _DECODERS[encoding]
    with needs(f"{module.replace('_', '-')}-support", "files"):
        factory = import_module(f"{module}.decoder").DecoderFactory()
    decode: Decode | None = factory.decoder_for(encoding, schema)
    if decode is None:
        raise ProblemError(f"messages with a schema in {getattr(schema, 'encoding', None)!r} cannot be read")
    return decode


def write(log: LogContents, path: Path) -> None:
    """Write a log into an empty file.

    Raises
    ------
    MissingExtra
        If mcap is not installed.
    """
    import_mcap()
    from mcap.writer import Writer

    time = np.nan_to_num(np.asarray(log.arrays["time"], dtype=np.float64))
    stamps = np.rint(1e9 * (time - (time.min() if len(time) else 0.0))).astype(np.int64)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(library="surefoot")
        writer.add_metadata(OWN_METADATA, {"mapping": _own_mapping(log).as_yaml()})
        schema = json.dumps({"title": "surefoot.Log", "type": "object"}).encode()
        kind = writer.register_schema(name="surefoot.Log", encoding="jsonschema", data=schema)
        rows = writer.register_channel(topic=OWN_TOPIC, message_encoding="json", schema_id=kind)
        for k, stamp in enumerate(stamps.tolist()):
            row = {name: np.atleast_1d(array[k]).tolist() for name, array in log.arrays.items()}
            writer.add_message(rows, log_time=stamp, publish_time=stamp, data=_as_text(row).encode())
        writer.finish()


def _own_mapping(log: LogContents) -> LogMapping:
    """Return the mapping by which the file's own topic is the log again."""
    takes = {name: Take((f"{OWN_TOPIC}.{name}",)) for name in log.arrays}
    facts = {name: np.asarray(value).tolist() for name, value in log.facts.items()}
    own = {name: c for name, c in log.channels.items() if CHANNELS.get(name) != c}
    return LogMapping(takes, facts=facts, define=own)


def _as_text(row: dict[str, Any]) -> str:
    """Return JSON, which knows neither NaN (null here) nor infinity (a number too large for a double)."""
    text = json.dumps(row, separators=(",", ":"))
    return text.replace("NaN", "null").replace("Infinity", "1e999")
