"""Files that are no motions end in one line that names what is wrong; a pickle is never run."""

from __future__ import annotations

import contextlib
import gzip
import io
import os
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pytest

import surefoot as sf
from surefoot.records.motions.pickle_reader import PickleReader
from surefoot.records.motions.pickled_parts import Refused
from tests.records.motions.made_motions import g1

ROWS = np.tile(g1().nominal, (20, 1))


def table(rows: Any, name: str = "a.csv") -> Callable[[Path], Path]:
    """Return what writes rows of numbers as a table."""

    def write(folder: Path) -> Path:
        path = folder / name
        path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
        return path

    return write


def raw(data: bytes, name: str = "a.bin") -> Callable[[Path], Path]:
    """Return what writes bytes."""

    def write(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return write


def archive(**arrays: Any) -> Callable[[Path], Path]:
    """Return what writes arrays as an archive."""

    def write(folder: Path) -> Path:
        np.savez_compressed(folder / "a.npz", **arrays)
        return folder / "a.npz"

    return write


def changed(column: int, value: float) -> Any:
    rows = ROWS.copy()
    rows[7, column] = value
    return rows


GMR = {"fps": 30, "root_pos": ROWS[:, :3], "root_rot": ROWS[:, 3:7], "dof_pos": ROWS[:, 7:]}
GO2 = np.array(sf.load_robot("go2").joint_names)

FILES: dict[str, tuple[Callable[[Path], Path], str]] = {
    "NaN": (table(changed(12, np.nan)), r"its table\[7, 12\] is NaN"),
    "infinite": (table(changed(12, np.inf)), r"its table\[7, 12\] is infinite"),
    "ragged": (table([*ROWS.tolist(), [0.0] * 35]), "line 21: 35 cells, 36 columns"),
    "a column less": (table(ROWS[:, :-1]), "28 joint angles a frame, g1 has 29.* 29, 27, 25, 23, 15, 12"),
    "empty": (raw(b""), "has 0 bytes"),
    "cut pickle": (raw(pickle.dumps(GMR)[:2000]), "cut or broken"),
    "cut archive": (lambda folder: cut(archive(q=ROWS)(folder)), "broken archive"),
    "bomb": (archive(joint_pos=np.zeros((600_000, 120))), "would unpack to 576 MB"),
    "quaternion of another length": (table(changed(6, 1.4)), r"length of 1, that of frame 7 has 1\.4"),
    "another robot": (
        archive(fps=30, root_pos=ROWS[:, :3], root_rot=ROWS[:, 3:7], joint_pos=ROWS[:, :12], joint_names=GO2),
        "its joints are not those of g1: unknown joint 'FL_hip_joint'; valid names: left_ankle",
    ),
    "text": (raw(b"Once upon a time, there was\na robot.\n"), "of no format of motions .* 'Once upon"),
    "picture": (raw(b"\xff\xd8\xff\xe0" + bytes(range(256)), "a.csv"), "of no format of motions"),
    "folder": (lambda folder: folder, "is a folder"),
    "no file": (lambda folder: folder / "none.csv", "cannot read .*No such file"),
    "one frame": (table(ROWS[:1]), "has 1 frame; a motion has two or more"),
    "fps below zero": (archive(**{**GMR, "fps": -30}), "fps must be a number >= 0, got -30"),
    "times that stand": (archive(qpos=ROWS, times=np.zeros(20)), "times do not rise"),
    "angles beyond degrees": (table(np.hstack([ROWS[:, :7], ROWS[:, 7:] + 5e3])), "neither radians nor"),
    "frames that differ": (archive(**{**GMR, "root_pos": ROWS[1:, :3]}), "'root_pos' has 19 frames"),
    "no root": (archive(fps=30, dof_pos=ROWS[:, 7:]), "no place of the root under any of root_pos"),
    "nothing known": (archive(a=ROWS[:, :3]), "no joint angles under any of dof.*it holds a"),
    "a tensor": (
        raw(b"\x80\x04\x8c\x0ctorch._utils\x8c\x12_rebuild_tensor_v2\x93)R."),
        "torch._utils._rebuild_tensor_v2.*tensor.numpy()",
    ),
}  # fmt: skip


def cut(path: Path) -> Path:
    path.write_bytes(path.read_bytes()[:-200])
    return path


@pytest.mark.parametrize("name", FILES)
def test_a_malformed_file_ends_in_one_line(name: str, tmp_path: Path) -> None:
    write, expected = FILES[name]
    path = write(tmp_path)
    with pytest.raises(sf.SurefootError, match=expected) as caught:
        sf.read_motion(path, g1(), fps=None if name == "fps below zero" else 30)
    message = str(caught.value)
    assert "\n" not in message
    assert message.count(str(path)) == 1


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"fps": 0}, "fps must be positive"),
        ({"fps": "fast"}, "fps must be a number, got 'fast'"),
        ({"order": "width"}, "unknown order 'width'; valid names: breadth, depth, isaaclab"),
        ({"order": ["knee"]}, "unknown joint of g1 in order 'knee'; valid names: left_ankle"),
        ({"order": list(g1().joint_names[:5])}, "order names 5 joints, the file has 29"),
        ({"order": 7}, "order must be one of"),
        ({"quaternion": "zyx"}, "unknown quaternion order 'zyx'; valid names: wxyz, xyzw"),
        ({"name": "x"}, "unknown motion 'x'; valid names: motion"),
    ],
)
def test_a_wrong_option_ends_in_one_line(options: dict[str, Any], expected: str) -> None:
    with pytest.raises(sf.SurefootError, match=expected):
        sf.read_motion(GMR, g1(), **options)


@pytest.mark.parametrize(
    "source", [None, 5, b"abc", "a\0b", np.zeros(5), np.array([["a"]]), {}, [], {"a": 1}]
)
def test_a_source_that_is_none_is_refused(source: Any) -> None:
    with pytest.raises(sf.SurefootError):
        sf.read_motion(source, g1())


class Malice:
    """What runs a command where it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return os.system, (f"touch {self.path}",)


def test_a_pickle_is_not_run(tmp_path: Path) -> None:
    mark = tmp_path / "ran"
    for protocol in range(6):
        (tmp_path / "a.pkl").write_bytes(pickle.dumps({"dof": ROWS, "x": Malice(mark)}, protocol))
        with pytest.raises(sf.SurefootError, match="system"):
            sf.read_motion(tmp_path / "a.pkl", g1())
    joblib.dump({"dof": ROWS, "x": Malice(mark)}, tmp_path / "b.pkl", compress=3)
    np.savez(tmp_path / "c.npz", joint_pos=ROWS, joint_names=np.array([Malice(mark)], dtype=object))
    np.save(tmp_path / "d.npy", np.array([Malice(mark)], dtype=object))
    for name in ("b.pkl", "c.npz", "d.npy"):
        with pytest.raises(sf.SurefootError, match="nothing of it was run"):
            sf.read_motion(tmp_path / name, g1())
    assert not mark.exists()


def test_a_compressed_pickle_is_not_unpacked_without_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("surefoot.records.motions.array_files.LARGEST", 1 << 20)
    with gzip.open(tmp_path / "a.pkl", "wb") as file:
        file.write(bytes(1 << 21))
    with pytest.raises(sf.SurefootError, match="would unpack to more than 1 MB"):
        sf.read_motion(tmp_path / "a.pkl", g1())


ODD = {
    "a key that is hashed for ever": b"\x80\x04}))\x86\x86K\x01s.",
    "a class of its own": b"\x80\x04\x8c\x08builtins\x8c\x04eval\x93.",
    "a set": b"\x80\x04\x8f.",
    "an object by number": b"\x80\x04K\x05Q.",
    "no mark": b"\x80\x04t.",
    "nothing on the stack": b"\x80\x04.",
    "a memo that was never kept": b"\x80\x04h\x09.",
    "a shape of all memory": pickle.dumps(np.zeros(3)).replace(
        b"K\x03\x85", b"\x8a\x06\xff\xff\xff\xff\xff\x00\x85"
    ),
    "no end": b"\x80\x04K\x01",
    "the state of a list": b"\x80\x04]Nb.",
    "a call of a number": b"\x80\x04K\x01)R.",
}


@pytest.mark.parametrize("name", ODD)
def test_an_odd_pickle_is_refused(name: str) -> None:
    with pytest.raises(Refused):
        PickleReader(io.BytesIO(ODD[name])).read()


def test_spoilt_bytes_of_pickles_never_end_otherwise() -> None:
    """Two thousand pickles of motions with bytes changed are read or refused, by one kind of error."""
    rng = np.random.default_rng(5)
    small = {
        "fps": 30.0,
        "root_pos": ROWS[:3, :3],
        "names": ["a", "b"],
        "objects": np.array(["a"], dtype=object),
    }
    whole = [np.frombuffer(pickle.dumps(small, protocol), np.uint8) for protocol in (0, 2, 4, 5)]
    for k in range(2000):
        data = whole[k % 4].copy()
        at = rng.integers(0, len(data), 1 + k % 3)
        data[at] = rng.integers(0, 256, len(at))
        with contextlib.suppress(Refused):
            PickleReader(io.BytesIO(data.tobytes())).read()
