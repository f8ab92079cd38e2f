"""A model in MuJoCo's own binary file (MJB), beside a recording of its loop.

`mj_saveLastXML` writes the model that was read last, whichever that was; the binary file is the model that
was run, hulls, textures and all. MuJoCo reads it without much care for what is in it, and only those of its
own version: it is opened where it is asked for by name, and its header is looked at first.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError, WriteError
from surefoot.base.text_files import path_of
from surefoot.worlds.mujoco.spec import import_mujoco

SUFFIX = ".mjb"
MAGIC = 54321
"""First number of the header, before the size of a number, how many sizes there are, and the version."""
HEADER = struct.Struct("<4i")


def model_path(log: Path) -> Path:
    """Return where the model of a log's file is."""
    return log.with_suffix(SUFFIX)


def model_bytes(mujoco: Any, model: Any) -> bytes:
    """Return a model as MuJoCo's binary file."""
    room = np.zeros((mujoco.mj_sizeModel(model), 1), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, room)
    return room.tobytes()


def check_model_file(path: Path, content: bytes) -> None:
    """Raise `ProblemError` where another model is in a file already."""
    if path.exists() and (path.stat().st_size != len(content) or path.read_bytes() != content):
        raise ProblemError(f"{path} exists already, and holds another model (model=False writes none)")


def write_model_file(path: Path, content: bytes) -> None:
    """Write a model into a new file; one that has it already stays."""
    if path.exists():
        return
    try:
        path.open("xb").close()  # ours from here on
        try:
            path.write_bytes(content)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise WriteError(path, error) from error


def read_model_file(path: Path | str) -> Any:
    """Return the MjModel of a binary file that somebody trusts.

    Raises
    ------
    ProblemError
        In one line, for a file that is not there, is none, is cut, or is another version's.
    """
    mujoco, path = import_mujoco(), path_of(path)
    try:
        with path.open("rb") as file:
            start = file.read(HEADER.size)
    except OSError as error:
        raise ProblemError(f"{path} cannot be read: {error.strerror}") from error
    numbers = HEADER.unpack(start) if len(start) == HEADER.size else (0, 0, 0, 0)
    if numbers[0] != MAGIC:
        raise ProblemError(f"{path} is no binary model of MuJoCo")
    known = int(mujoco.mjVERSION_HEADER)
    if numbers[3] != known:
        raise ProblemError(
            f"{path} is of another version of MuJoCo (number {numbers[3]}), and {mujoco.__version__} "
            f"({known}) reads its own only"
        )
    try:
        return mujoco.MjModel.from_binary_path(str(path))
    except ValueError as error:
        raise ProblemError(f"{path} is damaged: {error}") from error
