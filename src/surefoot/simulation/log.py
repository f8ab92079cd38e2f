"""The log of a run: arrays over time, written as one .npz that needs no pickle to read."""

from __future__ import annotations

import json
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.errors import ProblemError, WriteError

SCHEMA = 1
MEMORY = 64 << 20
"""Largest log that is held in memory; a longer one is mapped from files [bytes]."""

FIELDS: dict[str, str] = {
    "time": "(T,) time at the start of each step [s]",
    "q": "(T, nq) configuration, Pinocchio's order",
    "v": "(T, nv) velocity, Pinocchio's order",
    "torques": "(T, joints) applied joint torques [N m]",
    "forces": "(T, p, 3) ground force on each contact point as the world reports it, contact frames [N]",
    "forces_commanded": "(T, p, 3) the forces that the controller asked for [N]",
    "gaps": "(T, p) distance of each contact point to the ground, negative in penetration [m]",
    "contact_velocities": "(T, p, 3) velocity of the foot's material there, contact frames [m/s]",
    "contact_positions": "(T, p, 3) contact points, world axes [m]",
    "wrench_desired": "(T, 6) wanted wrench about the centre of mass [N, N m]",
    "wrench_error": "(T, 6) commanded forces' wrench less the wanted one",
    "grasp_map": "(T, 6, 3 p) from commanded forces to the wrench",
    "active": "(T, p) whether the controller lets a point push",
    "attained": "(T,) whether the wanted wrench was possible within the cones",
    "saturated": "(T,) whether a torque met its limit",
    "push": "(T, 3) external force on the base, world axes [N]",
    "mu": "(T,) friction of the ground",
    "planned": "(T, n) whether the gait wants a foot on the ground",
    "command": "(T, 3) wanted velocity of the body: forward, left [m/s], yaw rate [rad/s]",
    "controller_time": "(T,) wall time of the controller's step [s]",
}
"""What a log holds; every array has one row per step, T rows in all and p contact points."""


@dataclass
class Log:
    """Arrays of `FIELDS` and facts about the run; also what an interrupted run leaves.

    Attributes
    ----------
    arrays
        Name to array, cut to the steps that were made; of a long run mapped from files, read-only.
    facts
        Scalars and lists of strings: robot, mass, dt, feet, contact_foot, effort_limits, outcome, ...;
        ``error`` if something ended the run or its recording.
    parts
        Folder that the rows were written to during the run, until `save` has them in one file.
    """

    arrays: dict[str, Any]
    facts: dict[str, Any] = field(default_factory=dict)
    parts: Path | None = None

    def __getitem__(self, name: str) -> Any:
        return self.arrays[name]

    def __len__(self) -> int:
        return len(self.arrays["time"])

    def chunks(self, rows: int = 1 << 16) -> Iterator[Log]:
        """Yield the log in pieces of consecutive rows; a log of at most `rows` rows as it is."""
        if len(self) <= rows:
            yield self
            return
        for start in range(0, len(self), rows):
            yield Log({name: array[start : start + rows] for name, array in self.arrays.items()}, self.facts)
            for array in self.arrays.values():
                _let_go(array)

    def save(self, path: Path) -> Path:
        """Write to a new .npz file: the arrays, and each fact as ``fact_NAME``.

        The parts that the run left are removed when all is in the file, and kept if it cannot be written.

        Raises
        ------
        ProblemError
            If the file exists already; nothing is overwritten.
        WriteError
            If the disk has no room for it; no half file stays.
        """
        path = path if path.name.endswith(".npz") else path.with_name(path.name + ".npz")
        facts = {f"fact_{k}": np.asarray(v) for k, v in self.facts.items()}
        contents: dict[str, Any] = {"schema": np.int64(SCHEMA), **self.arrays, **facts}
        try:
            with path.open("xb") as file:
                try:
                    np.savez_compressed(file, **contents)
                except BaseException:
                    path.unlink(missing_ok=True)
                    raise
        except FileExistsError as error:
            raise ProblemError(f"{path} exists already") from error
        except OSError as error:
            path.unlink(missing_ok=True)
            kept = "" if self.parts is None else f"; its rows are in {self.parts}"
            raise WriteError(path, error, kept) from error
        if self.parts is not None:
            from surefoot.simulation.log_stream import remove_parts

            remove_parts(self.parts, self.arrays)
            self.parts = None
        return path


def _let_go(array: Any) -> None:
    """Tell the system that the pages of a mapped array are not needed for now."""
    mapped = array
    while isinstance(mapped, np.ndarray):
        mapped = mapped.base
    if hasattr(mapped, "madvise"):
        import mmap

        mapped.madvise(mmap.MADV_DONTNEED)


def read_log(path: Path | str) -> Log:
    """Read a log that `Log.save` wrote, or the folder of parts that a killed run left.

    A log of more than `MEMORY` bytes is unpacked into a temporary folder and mapped from there.

    Raises
    ------
    ProblemError
        If the file is missing, not a log, or of a schema that this version does not know.
    """
    path = Path(path)
    try:
        if path.is_dir():
            return Log(*read_parts(path))
        with np.load(path, allow_pickle=False) as file:
            if int(file["schema"]) != SCHEMA:
                raise ProblemError(f"{path} has log schema {int(file['schema'])}, expected {SCHEMA}")
            names = [k for k in file.files if k in FIELDS]
            facts = {k[5:]: file[k].tolist() for k in file.files if k.startswith("fact_")}
            large = sum(item.file_size for item in file.zip.infolist()) > MEMORY
            arrays = _unpack(file.zip, names) if large else {k: file[k] for k in names}
    except ProblemError:
        raise
    except (OSError, ValueError, KeyError, TypeError, EOFError, zlib.error, zipfile.BadZipFile) as error:
        raise ProblemError(f"{path} is not a Surefoot log: {error}") from error
    return Log(arrays, facts)


def _unpack(archive: zipfile.ZipFile, names: list[str]) -> dict[str, Any]:
    """Return arrays that are mapped from temporary files."""
    with tempfile.TemporaryDirectory(prefix="surefoot-log-") as folder:
        paths = {name: archive.extract(f"{name}.npy", folder) for name in names}
        return {name: np.load(at, mmap_mode="r") for name, at in paths.items()}


def read_parts(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the arrays, mapped, and the facts of a folder that a run wrote its rows to.

    Only rows that are in every file count.

    Raises
    ------
    ValueError
        If the folder holds no log.
    """
    facts = json.loads((folder / "facts.json").read_text(encoding="utf-8"))
    arrays = {p.stem: np.load(p, mmap_mode="r") for p in sorted(folder.glob("*.npy")) if p.stem in FIELDS}
    if "time" not in arrays:
        raise ValueError("no time.npy")
    rows = min(map(len, arrays.values()))
    return {name: array[:rows] for name, array in arrays.items()}, facts
