"""MCAP files: messages as JSON, protobuf or ROS 2 (CDR) in, see `surefoot.log.foxglove` for the way out."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from surefoot.errors import MissingExtra, ProblemError
from surefoot.log.foxglove import OWN_METADATA, OWN_TOPIC
from surefoot.log.source import Messages, Source, check_size

Decode = Callable[[bytes], Any]


def import_mcap() -> Any:
    """Return the module `mcap.reader`, with its exceptions, or raise `MissingExtra`."""
    try:
        import mcap.reader
    except ModuleNotFoundError as error:
        raise MissingExtra("mcap", "files") from error
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
    messages, decoders, unread = Messages(), {}, set()
    with path.open("rb") as file:
        opened = reader.make_reader(file, validate_crcs=True)
        own = {m.name: m.metadata for m in opened.iter_metadata()}.get(OWN_METADATA)
        topics = None if own is None else [OWN_TOPIC]
        for schema, channel, message in opened.iter_messages(topics=topics, log_time_order=False):
            if channel.id not in decoders:
                decoders[channel.id] = _decoder(schema, channel)
            decode = decoders[channel.id]
            if decode is None:
                unread.add(f"{channel.topic} is {channel.message_encoding}: not read")
                continue
            try:
                told = decode(message.data)
            except Exception as error:
                raise ProblemError(
                    f"{path}: a message of {channel.topic} cannot be decoded: {error}"
                ) from error
            kind = schema.name if schema is not None else ""
            messages.add(channel.topic, kind, message.log_time, told)
    if not decoders:
        raise ProblemError(f"{path} holds no messages")
    found = messages.source()
    found.notes += sorted(unread)
    found.mapping = "" if own is None else own["mapping"]
    return found


def _decoder(schema: Any, channel: Any) -> Decode | None:
    """Return what decodes a channel's messages; None for an encoding that is not known."""
    known = {"json": _json, "protobuf": _protobuf, "cdr": _cdr}
    return known[channel.message_encoding](schema) if channel.message_encoding in known else None


def _json(schema: Any) -> Decode:
    return json.loads


def _protobuf(schema: Any) -> Decode:
    try:
        from mcap_protobuf.decoder import DecoderFactory
    except ModuleNotFoundError as error:
        raise MissingExtra("mcap-protobuf-support", "files") from error
    return _made(DecoderFactory().decoder_for("protobuf", schema), schema)


def _cdr(schema: Any) -> Decode:
    try:
        from mcap_ros2.decoder import DecoderFactory
    except ModuleNotFoundError as error:
        raise MissingExtra("mcap-ros2-support", "files") from error
    return _made(DecoderFactory().decoder_for("cdr", schema), schema)


def _made(decode: Decode | None, schema: Any) -> Decode:
    if decode is None:
        raise ProblemError(f"messages with a schema in {getattr(schema, 'encoding', None)!r} cannot be read")
    return decode
