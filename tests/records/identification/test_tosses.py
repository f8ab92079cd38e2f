"""Files of tosses: what is written is read, and what is no toss is refused in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.problems.tosses import write_tosses
from surefoot.base.errors import ProblemError
from surefoot.records.identification.tosses import Cube, Tosses, read_tosses


def arrays(tosses: int = 3, frames: int = 6) -> dict[str, Any]:
    states = np.zeros((tosses * frames, 13))
    states[:, 6] = 1.0
    return {"states": states, "starts": np.arange(tosses + 1) * frames, "dt": 0.01}


def test_a_file_comes_back(tmp_path: Path) -> None:
    tosses = Tosses(**arrays(), cube=Cube(0.03, 0.1, 1e-4))
    path = write_tosses(tosses, tmp_path / "t.npz")
    back = read_tosses(path)
    np.testing.assert_array_equal(back.states, tosses.states)
    assert (back.cube, back.dt, len(back)) == (tosses.cube, 0.01, 3)


def test_a_subset_is_its_tosses() -> None:
    given = arrays()
    given["states"][:, 0] = np.arange(18)
    part = Tosses(**given).subset([2, 0])
    np.testing.assert_array_equal(part.states[:, 0], [*range(12, 18), *range(6)])
    np.testing.assert_array_equal(part.ids, [2, 0])
    for wrong in ([3], [-1], [], [0.5]):
        with pytest.raises(ProblemError):
            Tosses(**given).subset(wrong)


def changed(**changes: Any) -> dict[str, Any]:
    return {**arrays(), **changes}


def broken(row: int, column: int, value: float) -> dict[str, Any]:
    given = arrays()
    given["states"][row, column] = value
    return given


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (broken(7, 2, np.nan), r"states\[7, 2\] is NaN"),
        (broken(7, 9, np.inf), r"states\[7, 9\] is infinite"),
        (broken(8, 6, 1.1), "quaternion of toss 1, row 2, must have length 1, got 1.1"),
        (changed(states=np.zeros((18, 12))), "a row of states has 13 numbers and two for each joint, got 12"),
        (changed(starts=np.array([0, 6, 12, 17])), "starts must run from 0 to the number of rows, 18"),
        (changed(starts=np.array([0, 10, 8, 18])), "toss 1 has -2 rows"),
        (changed(starts=np.array([0.0, 18.0])), "starts must be a list of whole numbers"),
        (changed(starts=np.array([0])), "starts must run"),
        (changed(dt=0.0), "dt must be"),
        (changed(dt=np.nan), "dt must be"),
        (changed(ids=np.array([1, 2])), r"ids must have shape \(3,\)"),
        (changed(mass=-1.0), "mass must be"),
        ({"states": arrays()["states"]}, "it has no starts, dt; it holds: states"),
    ],
)
def test_what_is_no_toss_is_named(given: dict[str, Any], message: str, tmp_path: Path) -> None:
    path = tmp_path / "t.npz"
    np.savez(path, **given)
    with pytest.raises(ProblemError, match=message) as caught:
        read_tosses(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_equally_long_tosses_of_a_jointed_body_are_read_in_the_order_of_dair_pll(tmp_path: Path) -> None:
    states = np.zeros((2, 5, 15), dtype=np.float32)
    states[:, :, 0] = 1.0  # w
    states[:, :, 4:7] = (1.0, 2.0, 3.0)
    states[:, :, 7] = [3.0, 3.1, -3.1, -3.0, -2.9]
    states[:, :, 8:11], states[:, :, 11:14], states[:, :, 14] = (4.0, 5.0, 6.0), (7.0, 8.0, 9.0), 10.0
    np.savez(tmp_path / "t.npz", states=states, ids=np.array([3, 5]), dt=0.01)
    read = read_tosses(tmp_path / "t.npz")
    assert (len(read), read.joints, read.ids.tolist()) == (2, 1, [3, 5])
    np.testing.assert_allclose(read.states[0, :7], [1, 2, 3, 0, 0, 0, 1])
    np.testing.assert_allclose(read.states[0, 8:], [7, 8, 9, 4, 5, 6, 10])
    assert (np.diff(read.states[:5, 7]) > 0.0).all()


def test_other_files_are_named(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("no tosses")
    (tmp_path / "empty.npz").write_bytes(b"")
    np.save(tmp_path / "one.npy", np.zeros(3))
    np.savez(tmp_path / "objects.npz", states=np.array([{}], dtype=object), starts=[0, 1], dt=0.1)
    whole = tmp_path / "whole.npz"
    np.savez(whole, **arrays())
    (tmp_path / "cut.npz").write_bytes(whole.read_bytes()[:-60])
    for name in ("text.npz", "empty.npz", "one.npy", "objects.npz", "cut.npz"):
        with pytest.raises(ProblemError, match=name):
            read_tosses(tmp_path / name)
    with pytest.raises(ProblemError, match="No such file"):
        read_tosses(tmp_path / "none.npz")
