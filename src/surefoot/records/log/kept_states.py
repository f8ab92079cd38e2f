"""States of a run that a log keeps, one file each: plain arrays and JSON, with a digest of both.

During a run they lie in the folder ``states`` of the log's parts; `Log.save` puts them into the .npz file,
under ``states/``. What a state consists of is the matter of `surefoot.worlds.running.run_state`.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.base.errors import ProblemError, one_line, writing
from surefoot.base.npz_files import check_archive

FOLDER = "states"
"""Where states lie, in a folder of parts and in an .npz file."""
FORM = 1
"""Version of the files' form."""
_NAME = re.compile(rf"{FOLDER}/(\d+)\.npz")


class KeptState(NamedTuple):
    """A state as it is written down.

    Attributes
    ----------
    step, time
        Number of the step that comes next, and its time [s].
    arrays
        By the path to them.
    facts
        All else, as JSON holds it.
    about
        What the run was made with, as JSON holds it.
    """

    step: int
    time: float
    arrays: Mapping[str, NDArray[Any]]
    facts: Any
    about: Any

    def pack(self) -> bytes:
        """Return the contents of a file."""
        names = list(self.arrays)
        head = {"form": FORM, "step": self.step, "time": self.time, "names": names}
        text = json.dumps({**head, "facts": self.facts, "about": self.about}, allow_nan=False)
        arrays = {f"a{k}": self.arrays[name] for k, name in enumerate(names)}
        out = io.BytesIO()
        more = {"text": np.array(text), "digest": np.array(_digest(text, arrays))}
        np.savez_compressed(out, allow_pickle=False, **more, **arrays)
        return out.getvalue()

    @staticmethod
    def unpack(contents: bytes, where: str) -> KeptState:
        """Return the state in the contents of a file; `where` that lies is for errors.

        Raises
        ------
        ProblemError
            For what is no such file, is not whole, was changed, or has another form.
        """
        try:
            check_archive(io.BytesIO(contents), where)
            with np.load(io.BytesIO(contents), allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
                text, digest = str(arrays.pop("text")), str(arrays.pop("digest"))
            head = json.loads(text)
            if head["form"] != FORM:
                raise ProblemError(f"{where} has form {head['form']}, this version reads {FORM}")
            if digest != _digest(text, arrays):
                raise ProblemError(f"{where} was changed since it was kept: its digest is another")
            named = {name: arrays[f"a{k}"] for k, name in enumerate(head["names"])}
            return KeptState(int(head["step"]), float(head["time"]), named, head["facts"], head["about"])
        except ProblemError:
            raise
        except Exception as error:  # what is broken raises what it likes: zlib, zipfile, NumPy, JSON
            reason = one_line(error)[:200] or type(error).__name__
            raise ProblemError(f"{where} is no state that a run has kept: {reason}") from error


def _digest(text: str, arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return a digest of a state's facts and arrays, their types and shapes included."""
    out = hashlib.sha256(text.encode())
    for name, array in arrays.items():
        out.update(f"{name} {array.dtype.str} {array.shape}".encode())
        out.update(np.ascontiguousarray(array).tobytes())
    return out.hexdigest()


def keep_state(folder: Path, state: KeptState) -> Path:
    """Write a state into a log's folder of parts, and return its file.

    Raises
    ------
    WriteError
        If it cannot be written; no half file stays.
    """
    path = folder / FOLDER / f"{state.step:09d}.npz"
    with writing(path):
        path.parent.mkdir(exist_ok=True)
        new = path.with_name(f".{path.name}")
        new.write_bytes(state.pack())
        new.replace(path)
    return path


def kept_files(folder: Path) -> list[Path]:
    """Return the files of the states in a log's folder of parts, in their order."""
    return sorted((folder / FOLDER).glob("[0-9]*.npz"))


def add_states(path: Path, folder: Path) -> None:
    """Put the states in a folder of parts into the .npz file of the log."""
    files = kept_files(folder)
    if files:
        with zipfile.ZipFile(path, "a", zipfile.ZIP_STORED) as archive:
            for file in files:
                archive.write(file, f"{FOLDER}/{file.name}")


def remove_states(folder: Path) -> None:
    """Delete the states in a folder of parts, and their folder if nothing else lies in it."""
    for file in (folder / FOLDER).glob("*.npz"):
        if re.fullmatch(r"\.?\d+\.npz", file.name):
            file.unlink(missing_ok=True)
    if (folder / FOLDER).is_dir() and not any((folder / FOLDER).iterdir()):
        (folder / FOLDER).rmdir()


def read_kept_state(path: Path, time: float, dt: float) -> KeptState:
    """Return the last state that a log has kept at a time or before.

    Parameters
    ----------
    path
        Log of Surefoot's own: an .npz file, or the folder of parts of a killed run.
    time
        The time [s].
    dt
        Length of a step [s].

    Raises
    ------
    ProblemError
        For a log that has kept none, or none so early, and a file that is broken or was changed.
    """
    steps = _steps(path)
    if not steps:
        raise ProblemError(f"{path} has kept no states: walk with --keep-states SECONDS")
    early = [step for step in steps if step * dt <= time + 0.5 * dt]
    if not early:
        raise ProblemError(f"{path} has kept states from {min(steps) * dt:.3f} s on, none at {time:g} s")
    step = max(early)
    where = f"the state of {step * dt:.3f} s in {path}"
    if path.is_dir():
        contents = (path / FOLDER / f"{step:09d}.npz").read_bytes()
    else:
        try:
            with zipfile.ZipFile(path) as archive:
                contents = archive.read(f"{FOLDER}/{step:09d}.npz")
        except (OSError, zipfile.BadZipFile, EOFError, ValueError) as error:
            raise ProblemError(f"{where} cannot be read: {one_line(error)}") from error
    state = KeptState.unpack(contents, where)
    if state.step != step:
        raise ProblemError(f"{where} is that of step {state.step}, its name says {step}")
    return state


def _steps(path: Path) -> list[int]:
    """Return the steps of which a log has kept states."""
    if path.is_dir():
        return [int(file.stem) for file in kept_files(path)]
    try:
        with zipfile.ZipFile(path) as archive:
            found = (_NAME.fullmatch(name) for name in archive.namelist())
            return sorted(int(match[1]) for match in found if match)
    except FileNotFoundError:
        raise ProblemError(f"{path}: there is no such file") from None
    except (OSError, zipfile.BadZipFile) as error:
        raise ProblemError(f"{path} is not a Surefoot log (npz): {one_line(error)}") from error
