"""States that a log keeps: they come back to the last bit, and a file that was changed is refused."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import WriteError
from surefoot.records.log import kept_states
from surefoot.records.log.kept_states import KeptState

ARRAYS = {"q": np.arange(3.0), "deep/flags": np.array([[True], [False]]), "empty": np.zeros((0, 2))}


def state(step: int = 7) -> KeptState:
    return KeptState(step, step * 0.002, ARRAYS, {"gait": "trot", "n": [1, None]}, {"robot": "go2"})


def repacked(contents: bytes, **changes: Any) -> bytes:
    """Return the contents of a file with some of its entries changed, None for left out."""
    with np.load(io.BytesIO(contents)) as file:
        entries = {name: file[name] for name in file.files} | changes
    out = io.BytesIO()
    np.savez(out, allow_pickle=False, **{k: v for k, v in entries.items() if v is not None})
    return out.getvalue()


def head(**changes: Any) -> Any:
    with np.load(io.BytesIO(state().pack())) as file:
        return np.array(json.dumps(json.loads(str(file["text"])) | changes))


def test_a_state_comes_back_as_it_was_kept() -> None:
    back = KeptState.unpack(state().pack(), "here")
    assert (back.step, back.time, back.facts, back.about) == (7, 0.014, state().facts, state().about)
    assert isinstance(back.step, int)
    assert list(back.arrays) == list(ARRAYS)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(back.arrays[name], array)
        assert back.arrays[name].dtype == array.dtype
        assert back.arrays[name].shape == array.shape


def test_facts_that_are_no_json_are_not_kept() -> None:
    with pytest.raises(ValueError, match="JSON"):
        state()._replace(facts={"x": float("nan")}).pack()
    with pytest.raises(ValueError, match="allow_pickle"):
        state()._replace(arrays={"x": np.array([None])}).pack()


@pytest.mark.parametrize(
    "change",
    [
        {"a0": np.array([0.0, 1.0, 3.0])},
        {"a0": np.arange(3.0, dtype=np.float32)},
        {"a0": np.arange(3.0).view(np.int64)},
        {"a0": np.arange(3.0).reshape(3, 1)},
        {"a1": np.array([[False], [False]])},
        {"text": head(time=0.016)},
        {"digest": np.array("0" * 64)},
    ],
)
def test_what_was_changed_is_told(change: dict[str, Any]) -> None:
    with pytest.raises(sf.ProblemError) as caught:
        KeptState.unpack(repacked(state().pack(), **change), "the state")
    assert str(caught.value) == "the state was changed since it was kept: its digest is another"


def test_another_form_is_told() -> None:
    with pytest.raises(sf.ProblemError) as caught:
        KeptState.unpack(repacked(state().pack(), text=head(form=2)), "it")
    assert str(caught.value) == "it has form 2, this version reads 1"
    assert json.loads(str(head()))["form"] == 1


@pytest.mark.parametrize(
    "contents",
    [b"", b"no archive", state().pack()[:-40], repacked(state().pack(), text=None),
     repacked(state().pack(), digest=None), repacked(state().pack(), text=np.array("{"))],
)  # fmt: skip
def test_what_is_broken_is_no_state(contents: bytes) -> None:
    with pytest.raises(sf.ProblemError) as caught:
        KeptState.unpack(contents, "it")
    begin, _, reason = str(caught.value).partition(" is no state that a run has kept: ")
    assert begin == "it"
    assert 0 < len(reason) <= 200
    assert "\n" not in reason


def test_objects_in_a_file_are_not_unpickled() -> None:
    out = io.BytesIO()
    np.savez(out, allow_pickle=True, a0=np.array([{}]), text=head(), digest=np.array("0"))
    with pytest.raises(sf.ProblemError, match=r"it is no state that a run has kept: .*allow_pickle=False"):
        KeptState.unpack(out.getvalue(), "it")


def kept(folder: Path, *steps: int) -> Path:
    folder.mkdir(exist_ok=True)
    for step in steps:
        kept_states.keep_state(folder, state(step))
    return folder


def test_states_lie_in_the_order_of_their_steps(tmp_path: Path) -> None:
    path = kept_states.keep_state(tmp_path, state(12))
    assert path == tmp_path / "states" / "000000012.npz"
    kept(tmp_path, 3, 500)
    assert [file.stem for file in kept_states.kept_files(tmp_path)] == ["000000003", "000000012", "000000500"]
    assert [file.name[0] for file in path.parent.iterdir()] == ["0"] * 3
    assert KeptState.unpack(path.read_bytes(), "it").step == 12


def test_a_state_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    with pytest.raises(WriteError, match=r"cannot write .*000000007\.npz: No such file"):
        kept_states.keep_state(tmp_path / "none", state())


def test_own_states_are_removed_and_nothing_else(tmp_path: Path) -> None:
    states = kept(tmp_path, 1, 2) / "states"
    (states / ".000000003.npz").write_bytes(b"half")
    others = [states / name for name in ("mine.npz", "1.txt", "1.npz.old", "x1.npz", "1x.npz")]
    for path in others:
        path.write_bytes(b"")
    kept_states.remove_states(tmp_path)
    assert sorted(states.iterdir()) == sorted(others)
    for path in others:
        path.unlink()
    kept_states.remove_states(tmp_path)
    assert not states.exists()
    kept_states.remove_states(tmp_path)


def archived(tmp_path: Path, folder: Path) -> Path:
    """Return an archive with another entry and the states of a folder."""
    path = tmp_path / "log.npz"
    np.savez(path, q=np.zeros(2))
    kept_states.add_states(path, folder)
    return path


@pytest.mark.parametrize("packed", [False, True])
def test_the_last_state_before_a_time_is_read(packed: bool, tmp_path: Path) -> None:
    path = folder = kept(tmp_path / "parts", 10, 20, 30)
    if packed:
        path = archived(tmp_path, folder)
    dt = 0.002
    for time, step in (
        (0.02, 10),
        (0.038, 10),
        (0.0395, 20),
        (0.04, 20),
        (0.0585, 20),
        (0.0591, 30),
        (9.0, 30),
    ):
        assert kept_states.read_kept_state(path, time, dt).step == step
    assert kept_states.read_kept_state(path, 0.0191, dt).step == 10
    with pytest.raises(sf.ProblemError) as caught:
        kept_states.read_kept_state(path, 0.0185, dt)
    assert str(caught.value) == f"{path} has kept states from 0.020 s on, none at 0.0185 s"


def test_states_beside_other_entries_of_an_archive_are_found(tmp_path: Path) -> None:
    path = archived(tmp_path, kept(tmp_path / "parts", 5))
    with zipfile.ZipFile(path, "a") as archive:
        assert archive.namelist() == ["q.npy", "states/000000005.npz"]
        assert archive.getinfo("states/000000005.npz").compress_type == zipfile.ZIP_STORED
        archive.writestr("states/note.txt", "x")
        archive.writestr("more/states/000000009.npz", "x")
    assert kept_states.read_kept_state(path, 1.0, 0.002).step == 5


def test_a_log_without_states_says_how_to_keep_them(tmp_path: Path) -> None:
    path = archived(tmp_path, tmp_path)
    for place in (path, tmp_path):
        with pytest.raises(sf.ProblemError) as caught:
            kept_states.read_kept_state(place, 1.0, 0.002)
        assert str(caught.value) == f"{place} has kept no states: walk with --keep-states SECONDS"


def test_what_is_no_log_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    with pytest.raises(sf.ProblemError) as caught:
        kept_states.read_kept_state(path, 1.0, 0.002)
    assert str(caught.value) == f"{path}: there is no such file"
    path.write_text("words")
    with pytest.raises(sf.ProblemError, match=r"a\.npz is not a Surefoot log \(npz\): "):
        kept_states.read_kept_state(path, 1.0, 0.002)


def test_a_state_under_another_name_is_refused(tmp_path: Path) -> None:
    kept(tmp_path, 4)
    (tmp_path / "states" / "000000004.npz").rename(tmp_path / "states" / "000000006.npz")
    with pytest.raises(sf.ProblemError) as caught:
        kept_states.read_kept_state(tmp_path, 1.0, 0.002)
    assert str(caught.value) == f"the state of 0.012 s in {tmp_path} is that of step 4, its name says 6"
