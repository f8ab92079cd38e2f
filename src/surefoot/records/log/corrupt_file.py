"""What is wrong with a file that should hold a log: what it is instead, or its first wrong byte."""

from __future__ import annotations

import json
import mmap
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import numpy as np

MAGIC = {".bag": b"#ROSBAG V2.0\n", ".mcap": b"\x89MCAP0\r\n", ".db3": b"SQLite format 3\0"}
"""How files of messages begin."""
Bytes: TypeAlias = "bytes | mmap.mmap"


def _archive(path: Path) -> str:
    """Tell what an .npz file holds that is no log."""
    with path.open("rb") as opened:
        try:
            file = np.load(opened, allow_pickle=False)
        except Exception:
            return "it is no .npz archive, or cut"
        if not isinstance(file, np.lib.npyio.NpzFile):
            return "it is a single array, not an .npz archive"
        for name in file.files:
            try:
                file[name]
            except ValueError:
                return (
                    f"the array {name} holds pickled Python objects, which are not loaded: save numbers, "
                    f"np.savez(path, {name}=np.asarray({name}, dtype=float))"
                )
            except Exception:
                return f"the array {name} is cut or spoilt"
        if "schema" in file.files:
            return "its channels are not those of a log"
        held = ", ".join(file.files[:8])
    return (
        f"it holds the arrays {held} and no schema: pass them to sf.log_from_arrays with their "
        "time step, quaternion and feet"
    )


def _folder(path: Path) -> str:
    """Tell what a folder lacks."""
    facts = path / "facts.json"
    if not facts.exists():
        held = sorted(entry.name for entry in path.iterdir())[:6]
        lacks = "facts.json, as what a killed run leaves has, nor metadata.yaml, as a ROS 2 bag has"
        return f"the folder has neither {lacks}; it holds {', '.join(held) or 'nothing'}"
    try:
        json.loads(facts.read_bytes())
    except (ValueError, UnicodeDecodeError) as error:
        at = getattr(error, "pos", getattr(error, "start", 0))
        return f"facts.json is no JSON from byte {at} on"
    return "its facts.json is not that of a log"


def _messages(path: Path) -> str:
    """Tell where a file of messages stops being one."""
    if path.is_dir():
        return "its metadata.yaml is not that of a ROS 2 bag, or does not fit its files"
    magic = MAGIC[path.suffix.lower()]
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        return _wrong_byte(data, magic, path.suffix.lower())


def _wrong_byte(data: Bytes, magic: bytes, suffix: str) -> str:
    """Tell the first wrong byte of a file that is not empty."""
    wrong = next((k for k, byte in enumerate(magic) if data[k : k + 1] != bytes([byte])), None)
    if wrong is not None:
        return f"byte {wrong} is wrong: such files begin with {magic!r}"
    at, step = len(magic), {".bag": _bag_record, ".mcap": _mcap_record}.get(suffix)
    while step is not None and at < len(data):
        if len(data) - at == len(magic) and data[at:] == magic:  # how MCAP ends
            break
        after = step(data, at)
        if after is None:
            return f"the record at byte {at} is spoilt, or the file is cut"
        at = after
    return "its records are whole, but not what such a file holds"


def _bag_record(data: Bytes, at: int) -> int | None:
    """Return where the next record begins: a header and data, each behind its length."""
    for part in range(2):
        size = int.from_bytes(data[at : at + 4], "little")
        at += 4 + size
        if at > len(data) or (part == 0 and size == 0):
            return None
    return at


def _mcap_record(data: Bytes, at: int) -> int | None:
    """Return where the next record begins: an opcode, a length, and so many bytes."""
    if at + 9 > len(data) or data[at] == 0:
        return None
    after = at + 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    return after if after <= len(data) else None


SPOILT: dict[str, Callable[[Path], str]] = {
    "npz": _archive, "parts": _folder, "mcap": _messages, "rosbag": _messages,
}  # fmt: skip
"""Format to what tells why a file is none of it."""
