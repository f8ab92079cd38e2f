"""Bags of ROS 1 (.bag) and ROS 2 (a folder with metadata.yaml, or its .db3), without ROS."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from surefoot.base.errors import ProblemError, needs
from surefoot.records.log.source import Messages, Source, check_size

MARKER = "metadata.yaml"
"""The file by which a ROS 2 bag's folder is known."""


def source(path: Path) -> Source:
    """Return the messages of a bag.

    Messages whose types the bag does not define are taken for those of ROS 2 Humble.

    Raises
    ------
    ProblemError
        If it is cut or spoilt, or none of its messages can be read.
    MissingExtra
        If rosbags is not installed.
    """
    with needs("rosbags", "files"):
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    if path.suffix == ".db3":
        if not (path.parent / MARKER).exists():
            raise ProblemError(f"{path}: a .db3 is read with the {MARKER} of its bag, which is not beside it")
        path = path.parent
    files = [path] if path.is_file() else [f for f in path.rglob("*") if f.is_file()]
    check_size(sum(file.stat().st_size for file in files), path)
    messages = Messages()
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, stamp, raw in reader.messages():
            topic, kind = connection.topic, connection.msgtype
            try:
                decoded: Any = reader.deserialize(raw, kind)
            except KeyError:
                messages.unread.add(f"{topic} is of the unknown type {kind}: not read")
                continue
            messages.add(topic, kind, stamp, decoded)
    return messages.source()
