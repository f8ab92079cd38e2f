"""Recorded tosses of a body: the value, and its file.

A file is an .npz without pickles: `states` (N, 13 + 2j), tosses one after the other, each row position of
the first link [m], quaternion (x, y, z, w) from it to the world, j joints [rad, m], velocity [m/s] in world
axes, angular velocity [rad/s] in body axes and joints' rates; `starts` (B + 1,), the first row of each toss,
and the end; `dt`, the time between rows [s]. `ids` (B,), and a cube's `half_side` [m], `mass` [kg]
and `inertia` [kg m²] may be there too. Where `states` is (B, T, 13 + 2j), each row is quaternion
(w, x, y, z), position, joints, then angular velocity, velocity and rates, as in the files of dair_pll.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray, IntArray, finite_array, real_number
from surefoot.base.errors import ProblemError, shown
from surefoot.base.npz_files import check_archive
from surefoot.base.text_files import path_of

UNIT = 1e-3
"""How far a quaternion's length may be from one."""
ROUNDED = 1e-14
"""And how far it is by rounding alone."""
NAMES = ("states", "starts", "dt")
"""Arrays that a file of tosses has; of equally long ones the second is not needed."""
SHORTEST = 4
"""Frames of the shortest toss that says anything."""


@dataclass(frozen=True)
class Cube:
    """A homogeneous-looking cube: its inertia is the same about every axis.

    Attributes
    ----------
    half_side
        [m].
    mass
        [kg].
    inertia
        About every axis through the centre [kg m²].
    """

    half_side: float = 0.0524
    mass: float = 0.37
    inertia: float = 0.00081

    def __post_init__(self) -> None:
        for name in ("half_side", "mass", "inertia"):
            real_number(name, getattr(self, name), low=1e-9, high=1e9)

    @property
    def width(self) -> float:
        """Length of a side [m]."""
        return 2.0 * self.half_side


@dataclass(frozen=True)
class Tosses:
    """Tosses of one body, all recorded at the same rate.

    Attributes
    ----------
    states
        (N, 13 + 2j) positions and velocities [m, -, rad, m/s, rad/s], see the module.
    starts
        (B + 1,) first row of each toss, and the end.
    dt
        Time between rows [s].
    ids
        (B,) what the tosses are called.
    cube
        What was thrown, if it is one.

    Raises
    ------
    ProblemError
        If the arrays do not fit together, or hold what no toss does; the message names toss and row.
    """

    states: FloatArray
    starts: IntArray
    dt: float
    ids: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    cube: Cube = field(default_factory=Cube)

    def __post_init__(self) -> None:
        states = finite_array("states", self.states, (None, None))
        if states.shape[1] < 13 or states.shape[1] % 2 == 0:
            raise ProblemError(
                f"a row of states has 13 numbers and two for each joint, got {states.shape[1]}"
            )
        starts = _indices("starts", self.starts)
        ids = _indices("ids", self.ids) if np.size(self.ids) else np.arange(starts.size - 1)
        set_ = object.__setattr__
        set_(self, "dt", real_number("dt", self.dt, low=1e-6, high=1.0))
        if starts.size < 2 or starts[0] != 0 or starts[-1] != len(states):
            raise ProblemError(
                f"starts must run from 0 to the number of rows, {len(states)}, got {starts[:1].tolist()} ... "
                f"{starts[-1:].tolist()}"
            )
        lengths = np.diff(starts)
        if lengths.min() < SHORTEST:
            k = int(np.argmin(lengths))
            raise ProblemError(f"toss {k} has {lengths[k]} rows, {SHORTEST} are the least")
        if ids.shape != lengths.shape:
            raise ProblemError(f"ids must have shape {lengths.shape}, got {ids.shape}")
        size = np.linalg.norm(states[:, 3:7], axis=1)
        off = np.abs(size - 1.0) > UNIT
        if off.any():
            row = int(np.argmax(off))
            toss = int(np.searchsorted(starts, row, side="right")) - 1
            raise ProblemError(
                f"the quaternion of toss {toss}, row {row - starts[toss]}, must have length 1, "
                f"got {size[row]:g}"
            )
        # what has been made of length one before stays as it is, to the last bit
        states[:, 3:7] /= np.where(np.abs(size - 1.0) < ROUNDED, 1.0, size)[:, None]
        set_(self, "states", states)
        set_(self, "starts", starts)
        set_(self, "ids", ids)

    def __len__(self) -> int:
        return int(self.starts.size - 1)

    @property
    def joints(self) -> int:
        """How many joints the body has."""
        return int(self.states.shape[1] - 13) // 2

    @property
    def poses(self) -> FloatArray:
        """(N, 7 + joints) position [m], quaternion and joints [rad, m]."""
        # in rows without gaps, as kernels are compiled for
        return np.ascontiguousarray(self.states[:, : 7 + self.joints])

    @property
    def frames(self) -> IntArray:
        """(B,) rows of each toss."""
        return np.diff(self.starts)

    def subset(self, which: ArrayLike) -> Tosses:
        """Return the tosses with these (k,) indices, in their order.

        Raises
        ------
        ProblemError
            If there is no such toss, or none is wanted.
        """
        chosen = _indices("which", which)
        if chosen.size == 0 or chosen.min() < 0 or chosen.max() >= len(self):
            raise ProblemError(f"tosses are chosen from 0 to {len(self) - 1}, got {shown(chosen.tolist())}")
        return self._part(chosen, self.frames[chosen])

    def until(self, ends: IntArray) -> Tosses:
        """Return the tosses cut before these (B,) frames."""
        return self._part(np.arange(len(self)), np.minimum(np.maximum(ends, SHORTEST), self.frames))

    def _part(self, which: IntArray, frames: IntArray) -> Tosses:
        """Return the first (k,) frames of (k,) tosses."""
        rows = np.concatenate([a + np.arange(n) for a, n in zip(self.starts[which], frames, strict=True)])
        ends = np.concatenate([[0], np.cumsum(frames)])
        return Tosses(self.states[rows], ends, self.dt, self.ids[which], self.cube)


def pose_differences(poses: FloatArray, recorded: FloatArray) -> FloatArray:
    """Return (N, 6 + joints) how far poses (N, 7 + joints) are from others: ways [m], turns, joints [rad]."""
    turn = Rotation.from_quat(poses[:, 3:7]) * Rotation.from_quat(recorded[:, 3:7]).inv()
    return np.hstack([poses[:, :3] - recorded[:, :3], turn.as_rotvec(), poses[:, 7:] - recorded[:, 7:]])


def _indices(name: str, value: Any) -> IntArray:
    array = np.asarray(value)
    if array.ndim != 1 or not (array.size == 0 or np.issubdtype(array.dtype, np.integer)):
        raise ProblemError(
            f"{name} must be a list of whole numbers, got {array.dtype} of shape {array.shape}"
        )
    return array.astype(np.int64)


def read_tosses(path: str | Path) -> Tosses:
    """Read a file of tosses, see the module.

    Parameters
    ----------
    path
        The .npz file.

    Raises
    ------
    ProblemError
        If it is no such file; one line that names the file and what is wrong.
    """
    try:
        check_archive(path_of(path), path)
        with path_of(path).open("rb") as file:
            archive = np.load(file, allow_pickle=False)
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise ProblemError("it is a single array, not an .npz archive")
            needed = NAMES if "starts" in archive.files or "ids" not in archive.files else ("states", "dt")
            missing = [name for name in needed if name not in archive.files]
            if missing:
                raise ProblemError(f"it has no {', '.join(missing)}; it holds: {', '.join(archive.files)}")
            held = {name: archive[name] for name in archive.files}
        given = {name: float(held[name]) for name in ("half_side", "mass", "inertia") if name in held}
        ids = held.get("ids", np.empty(0, dtype=np.int64))
        if held["states"].ndim == 3:
            held["states"], held["starts"] = _in_rows(finite_array("states", held["states"], (None,) * 3))
        elif "starts" not in held:
            raise ProblemError("it has no starts, and its states are not (tosses, frames, numbers)")
        return Tosses(held["states"], held["starts"], float(held["dt"]), ids, Cube(**given))
    except (ProblemError, TypeError) as error:
        raise ProblemError(f"{path} holds no tosses: {error}") from error
    except OSError as error:
        raise ProblemError(f"cannot read {path}: {error.strerror}") from error
    except (ValueError, EOFError, zipfile.BadZipFile, KeyError, NotImplementedError) as error:
        raise ProblemError(
            f"{path} is no .npz file of tosses, which `identify` takes: plain arrays "
            f"{', '.join(NAMES)}, see docs/identify.md"
        ) from error


def _in_rows(states: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return rows (B T, 13 + 2j) and starts (B + 1,) of (B, T, 13 + 2j) states of dair_pll; angles go on."""
    count, frames, numbers = states.shape
    j = (numbers - 13) // 2
    nq = 7 + j
    angles = np.unwrap(states[:, :, 7:nq], axis=1)
    order = [4, 5, 6, 1, 2, 3, 0, *range(7, nq), *range(nq + 3, nq + 6), *range(nq, nq + 3)]
    order += range(nq + 6, numbers)
    states = np.concatenate([states[:, :, :7], angles, states[:, :, nq:]], axis=2)[:, :, order]
    return states.reshape(count * frames, numbers), np.arange(count + 1) * frames
