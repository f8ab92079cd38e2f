"""Files of arrays by their content: archives, single arrays, pickles and tables."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError, located, one_line
from surefoot.base.npz_files import check_archive
from surefoot.base.text_files import path_of
from surefoot.records.log.csv_file import source as read_table
from surefoot.records.motions.pickle_reader import PickleReader
from surefoot.records.motions.pickled_parts import count_entries

LARGEST = 1 << 30
"""Bytes of a file, and of what a compressed one unpacks to, that are read at most: 1 GB."""
PICKLES = (b"\x80", b"}q", b"]q", b"(dp", b"(lp")
"""First bytes of pickles: of protocol 2 and later, of mappings and lists of protocols 1 and 0."""
KNOWN = ".csv, .npz, .npy, .pkl, .joblib"
"""Endings of the files that motions come in; their content decides."""


def read_arrays(path: Path | str) -> Any:
    """Return what a file holds: a mapping of arrays, numbers and texts, a list of such, or one array.

    Raises
    ------
    ProblemError
        In one line, for a file that cannot be read, is of none of the formats, or is broken.
    """
    path = path_of(path).expanduser()
    if path.is_dir():
        raise ProblemError(f"{path} is a folder; a motion is a file ({KNOWN})")
    try:
        size = path.stat().st_size
        if size == 0 or size > LARGEST:
            raise ProblemError(f"{path} has {size} bytes; a motion has between 1 and {LARGEST}")
        with path.open("rb") as file:
            head = file.read(8)
        with located(path):
            return _reader(head)(path)
    except OSError as error:
        raise ProblemError(f"cannot read {path}: {error.strerror or one_line(error)}") from error


def _reader(head: bytes) -> Callable[[Path], Any]:
    """Return what reads a file that begins so."""
    if head[:4] == b"PK\x03\x04":
        return _archive
    if head[:6] == b"\x93NUMPY":
        return lambda path: _npy(io.BytesIO(path.read_bytes()))
    if head.startswith(PICKLES):
        return lambda path: _pickle(path.read_bytes())
    for begin, unpack in COMPRESSED.items():
        if head.startswith(begin):
            return lambda path: _pickle(unpack(path))
    return _table


def _archive(path: Path) -> dict[str, Any]:
    """Return the arrays of an .npz file."""
    check_archive(path, "it")
    try:
        with zipfile.ZipFile(path) as archive:
            names = [name for name in archive.namelist() if name.endswith(".npy")]
            if not names:
                held = ", ".join(archive.namelist()[:3])
                torch = any(name.endswith("data.pkl") for name in archive.namelist())
                hint = "; it looks like torch.save: save arrays, np.savez" if torch else ""
                raise ProblemError(f"it is an archive without arrays, it holds {held or 'nothing'}{hint}")
            return {name.removesuffix(".npy"): _npy(io.BytesIO(archive.read(name))) for name in names}
    except (
        zipfile.BadZipFile,
        zlib.error,
        EOFError,
        NotImplementedError,
        RuntimeError,
        MemoryError,
    ) as error:
        raise ProblemError(f"it is a broken archive: {one_line(error)[:120]}") from error


def _npy(file: io.BytesIO) -> Any:
    """Return the array of an .npy file; objects, as lists of names are at times, by the reader of pickles."""
    try:
        version = np.lib.format.read_magic(file)
        header = {1: np.lib.format.read_array_header_1_0, 2: np.lib.format.read_array_header_2_0}
        shape, columns, dtype = header.get(version[0], np.lib.format.read_array_header_2_0)(file)
        if dtype.hasobject:
            return PickleReader(file).read()
        data = file.read()
        wanted = count_entries(shape) * dtype.itemsize
        if len(data) != wanted:
            raise ProblemError(f"an array of shape {shape} needs {wanted} bytes, the file has {len(data)}")
        return np.frombuffer(data, dtype).reshape(shape, order="F" if columns else "C")
    except ProblemError:
        raise
    except (ValueError, TypeError, SyntaxError, OverflowError, MemoryError) as error:
        raise ProblemError(f"it is a broken array: {one_line(error)[:120]}") from error


def _pickle(data: bytes) -> Any:
    """Return what a pickle holds."""
    return PickleReader(io.BytesIO(data)).read()


def _table(path: Path) -> dict[str, Any]:
    """Return a table's columns by name, and the table itself under an empty name where they have none."""
    with path.open("rb") as file:
        lines = [file.readline(1 << 20), file.readline(1 << 20)]
    try:
        first, second = lines[0].decode("utf-8-sig"), lines[1].decode("utf-8")
    except UnicodeDecodeError as error:
        raise ProblemError(f"it is of no format of motions ({KNOWN})") from error
    cells, bare = _cells(first), _is_numeric(first)
    if (
        len(cells) < 2
        or not (bare or _is_numeric(second))
        or not first.strip().replace("\t", " ").isprintable()
    ):
        raise ProblemError(
            f"it is of no format of motions ({KNOWN}): its first line is {first.strip()[:40]!r}"
        )
    try:
        topic = read_table(path, [f"column {k + 1}" for k in range(len(cells))] if bare else None).topics[""]
    except ProblemError as error:  # it begins with the path, which stands there already
        raise ProblemError(str(error).removeprefix(str(path)).lstrip(":, ")) from error
    fields = {name: np.asarray(column) for name, column in topic.fields.items()}
    return {"": np.column_stack(list(fields.values()))} if bare else fields


def _cells(line: str) -> list[str]:
    """Return the cells of a line, between commas, semicolons, tabs or blanks."""
    separator = max(",;\t", key=line.count)
    return line.strip().split(separator) if separator in line else line.split()


def _is_numeric(line: str) -> bool:
    """Tell whether more than half of a line's cells are numbers."""
    cells = _cells(line)
    return sum(map(_is_number, cells)) > len(cells) / 2


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return not text.strip()  # an empty cell
    return True


def _by_stream(opened: Callable[[Path], Any]) -> Callable[[Path], bytes]:
    """Return what unpacks a file by a stream of its format, no more than `LARGEST` bytes."""

    def unpack(path: Path) -> bytes:
        try:
            with opened(path) as file:
                data = file.read(LARGEST + 1)
        except (OSError, EOFError, zlib.error, lzma.LZMAError, ValueError) as error:
            raise ProblemError(f"its compression is broken: {one_line(error)[:120]}") from error
        return _check_unpacked(data)

    return unpack


def _check_unpacked(data: bytes) -> bytes:
    """Return unpacked bytes, or refuse more than `LARGEST`."""
    if len(data) > LARGEST:
        raise ProblemError(f"it would unpack to more than {LARGEST // 2**20} MB, so it is not read")
    return data


def _zlib(path: Path) -> bytes:
    try:
        return _check_unpacked(zlib.decompressobj().decompress(path.read_bytes(), LARGEST + 1))
    except zlib.error as error:
        raise ProblemError(f"its compression is broken: {one_line(error)[:120]}") from error


COMPRESSED: dict[bytes, Callable[[Path], bytes]] = {
    b"\x1f\x8b": _by_stream(gzip.open),
    b"BZh": _by_stream(bz2.open),
    b"\xfd7zXZ": _by_stream(lzma.open),
    b"\x5d\x00": _by_stream(lzma.open),
    b"\x78\x01": _zlib,
    b"\x78\x5e": _zlib,
    b"\x78\x9c": _zlib,
    b"\x78\xda": _zlib,
}
"""First bytes of a compressed pickle, as joblib writes them, to what unpacks it."""
