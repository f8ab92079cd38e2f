"""Logs as .npz files, which need no pickle: one array per channel, each fact as ``fact_NAME``.

Schema 2 adds ``channels``: the definitions, as JSON. A log of more than `MEMORY` bytes is unpacked into a
temporary folder and mapped from there.
"""

from __future__ import annotations

import json
import tempfile
import zipfile
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.base.npz_files import check_archive
from surefoot.records.log.channels import SCHEMA, channels_from
from surefoot.records.log.contents import MEMORY, LogContents, StoredLog


def read(path: Path) -> StoredLog:
    """Return the contents of an .npz file."""
    check_archive(path, path)
    # opened here: where the file is cut, NumPy leaves open what it opened
    with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
        check_schema(path, int(file["schema"]))
        channels = channels_from(json.loads(str(file["channels"])))
        facts = {k[5:]: file[k].tolist() for k in file.files if k.startswith("fact_")}
        large = sum(item.file_size for item in file.zip.infolist()) > MEMORY
        arrays = _unpack(file.zip, channels) if large else {k: file[k] for k in channels}
    return StoredLog(arrays, facts, channels)


def write(log: LogContents, path: Path) -> None:
    """Write a log into an empty file."""
    contents: dict[str, Any] = {f"fact_{k}": np.asarray(v) for k, v in log.facts.items()}
    definitions = np.array(json.dumps([asdict(channel) for channel in log.channels.values()]))
    with path.open("wb") as file:
        np.savez_compressed(file, schema=np.int64(SCHEMA), channels=definitions, **log.arrays, **contents)


def check_schema(path: Path, schema: int) -> None:
    """Raise `ProblemError` for a schema that this version does not know."""
    if schema != SCHEMA:
        raise ProblemError(f"{path} has log schema {schema}, expected {SCHEMA}")


def _unpack(archive: zipfile.ZipFile, names: Iterable[str]) -> dict[str, Any]:
    """Return arrays that are mapped from temporary files."""
    with tempfile.TemporaryDirectory(prefix="surefoot-log-") as folder:
        paths = {name: archive.extract(f"{name}.npy", folder) for name in names}
        return {name: np.load(at, mmap_mode="r") for name, at in paths.items()}
