"""Archives of arrays (.npz) from outside: what they would unpack to, told before anything is unpacked."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import IO

from surefoot.base.errors import ProblemError

MOST_SHRUNK = 200
"""Bytes of an archive's arrays over its own bytes that arrays of numbers stay under, beside `SMALL` bytes.

Deflate reaches 1032 on zeros alone.
"""
SMALL = 1 << 29
"""Bytes that any archive may unpack to, sparse matrices written densely among them: 512 MB."""


def check_archive(file: Path | IO[bytes], name: object) -> None:
    """Refuse an archive that unpacks to far more than numbers can shrink by; nothing of it is unpacked.

    Parameters
    ----------
    file
        The archive; what is none is left to its reader.
    name
        Its name, for the message.

    Raises
    ------
    ProblemError
        With both sizes.
    """
    try:
        with zipfile.ZipFile(file) as archive:
            entries = archive.infolist()
    except (OSError, ValueError, zipfile.BadZipFile, NotImplementedError):
        return
    whole = sum(entry.file_size for entry in entries)
    packed = sum(entry.compress_size for entry in entries)
    if whole > SMALL and whole > MOST_SHRUNK * packed:
        raise ProblemError(
            f"{name} would unpack to {1e-6 * whole:.0f} MB from {1e-6 * packed:.1f} MB: arrays of numbers "
            f"shrink {MOST_SHRUNK} times at most, so it is not read"
        )
