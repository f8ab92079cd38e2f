"""Formats of logs: a name or what lies in a folder tells them, and what was begun is taken back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import WriteError
from surefoot.records.log import formats, kept_states
from surefoot.records.log.formats import Format, format_of, new_file, register_format, write_log
from surefoot.records.log.kept_states import KeptState


@pytest.fixture(autouse=True)
def _own_formats(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formats, "FORMATS", dict(formats.FORMATS))


def a_log() -> sf.Log:
    return sf.Log({"time": np.arange(3.0)}, {})


@pytest.mark.parametrize(("name", "expected"), [
    ("a.npz", "npz"), ("A.NPZ", "npz"), ("a.parts", "parts"), ("a.csv", "csv"), ("a.tsv", "csv"),
    ("a.mcap", "mcap"), ("a.bag", "rosbag"), ("a.db3", "rosbag"),
])  # fmt: skip
def test_a_name_tells_the_format(name: str, expected: str, tmp_path: Path) -> None:
    assert format_of(tmp_path / name).name == expected


def test_arrays_of_others_are_a_table(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=np.arange(3.0))
    found = format_of(tmp_path / "a.npz")
    assert found.name == "arrays"
    assert found.source is not None
    np.testing.assert_array_equal(found.source(tmp_path / "a.npz").topics[""].fields["t"], [0.0, 1.0, 2.0])
    assert format_of(write_log(a_log(), tmp_path / "b.npz")).name == "npz"
    (tmp_path / "c.npz").mkdir()
    assert format_of(tmp_path / "c.npz").name == "npz"


def test_what_lies_in_a_folder_tells_its_format(tmp_path: Path) -> None:
    assert format_of(tmp_path).name == "parts"
    (tmp_path / "a.csv").touch()
    assert format_of(tmp_path).name == "csv folder"
    (tmp_path / "metadata.yaml").touch()
    assert format_of(tmp_path).name == "rosbag"
    (tmp_path / "facts.json").touch()
    assert format_of(tmp_path).name == "parts"


def test_a_name_of_no_format_is_told_the_valid_ones(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    with pytest.raises(sf.ProblemError) as caught:
        format_of(path)
    valid = ".bag, .csv, .db3, .mcap, .npz, .parts, .tsv"
    assert str(caught.value) == f"{path} is not a Surefoot log: its name should end in one of {valid}"


def test_a_new_file_has_a_suffix_and_is_not_there(tmp_path: Path) -> None:
    path, write = new_file(tmp_path / "walk")
    assert path == tmp_path / "walk.npz"
    assert write is formats.FORMATS["npz"].write
    assert new_file(tmp_path / "walk.mcap")[0] == tmp_path / "walk.mcap"
    for name in ("walk.npz", "walk.txt"):
        (tmp_path / name).touch()
        with pytest.raises(sf.ProblemError) as caught:
            new_file(tmp_path / name)
        assert str(caught.value) == f"{tmp_path / name} exists already"
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(sf.ProblemError, match=r"folder\.npz exists already"):
        new_file(tmp_path / "folder.npz")


def test_formats_that_are_only_read_are_not_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.csv"
    with pytest.raises(sf.ProblemError) as caught:
        new_file(path)
    assert str(caught.value) == f"{path}: logs of the format csv can be read, not written"
    monkeypatch.chdir(tmp_path)
    with pytest.raises(sf.ProblemError, match=r"^\.: logs of the format parts can be read, not written"):
        new_file(Path())


def test_a_format_of_ones_own_writes_an_empty_file(tmp_path: Path) -> None:
    def write(log: Any, path: Path) -> None:
        assert path.read_bytes() == b""
        path.write_text(f"{len(log.arrays['time'])} rows")

    register_format(Format("rows", (".rows",), write=write))
    path = write_log(a_log(), tmp_path / "a.rows")
    assert path == tmp_path / "a.rows"
    assert path.read_text() == "3 rows"


def parts(folder: Path, with_state: bool) -> Path:
    folder.mkdir()
    for name in ("time.npy", "facts.json", "note.txt"):
        (folder / name).touch()
    if with_state:
        kept_states.keep_state(folder, KeptState(5, 0.01, {}, {}, {}))
    return folder


def test_parts_are_removed_once_their_log_is_saved(tmp_path: Path) -> None:
    folder = parts(tmp_path / "parts", with_state=True)
    path = write_log(a_log(), tmp_path / "a.NPZ", folder)
    assert [file.name for file in folder.iterdir()] == ["note.txt"]
    assert kept_states.read_kept_state(path, 1.0, 0.002).step == 5


def test_a_log_with_states_is_saved_as_an_archive_only(tmp_path: Path) -> None:
    register_format(Format("rows", (".rows",), write=lambda log, path: None))
    path, folder = tmp_path / "a.rows", parts(tmp_path / "parts", with_state=True)
    with pytest.raises(sf.ProblemError) as caught:
        write_log(a_log(), path, folder)
    assert str(caught.value) == f"{path}: a log that has kept states is saved as .npz"
    assert not path.exists()
    assert len(list(folder.iterdir())) == 4
    write_log(a_log(), path, parts(tmp_path / "more", with_state=False))
    assert path.exists()
    assert [file.name for file in (tmp_path / "more").iterdir()] == ["note.txt"]


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_log_that_cannot_be_written_leaves_its_parts_and_no_file(
    error: BaseException, tmp_path: Path
) -> None:
    def write(log: Any, path: Path) -> None:
        raise error

    register_format(Format("rows", (".rows",), write=write))
    path, folder = tmp_path / "a.rows", parts(tmp_path / "parts", with_state=False)
    expected = WriteError if isinstance(error, OSError) else KeyboardInterrupt
    for where in (None, folder):
        with pytest.raises(expected) as caught:
            write_log(a_log(), path, where)
        assert not path.exists()
        if isinstance(error, OSError):
            kept = "" if where is None else f"; its rows are in {folder}"
            assert str(caught.value) == f"cannot write {path}: No space left on device{kept}"
    assert len(list(folder.iterdir())) == 3
