"""The logs of this tree are those of the revisions in `BASE`, and what compares them finds a single bit."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.same_logs import comparing
from tests.same_logs.__main__ import main, record_revision
from tests.same_logs.comparing import differences, first_difference
from tests.same_logs.recording import ROOT, RecordError, record
from tests.same_logs.revisions import BASE, commit, export, read_base
from tests.same_logs.scenarios import GROUPS, SCENARIOS, chosen

Arrays = dict[str, Any]


def written(folder: Path, name: str = "log", **changed: Any) -> Path:
    """Write a log of forty rows as `Log.save` does, some arrays of it changed or left out (None)."""
    rng, form = np.random.default_rng(0), {"shape": [3], "unit": "N m", "meaning": "of the joints"}
    arrays: Arrays = {
        "channels": np.array(json.dumps([{"name": "torques"} | form, {"name": "controller_time"} | form])),
        "time": 1e-3 * np.arange(40.0), "torques": rng.normal(size=(40, 3)), "active": np.ones((40, 2), bool),
        "forces": rng.normal(size=(40, 2, 3)), "controller_time": rng.random(40),
        "mode": np.array(["up"] * 40), "fact_behaviours": np.array(["cruise", "seen stairs"]),
        "fact_mass": np.float64(12.0), "fact_wall_time": np.float64(1.0),
    }  # fmt: skip
    arrays = {key: value for key, value in (arrays | changed).items() if value is not None}
    np.savez(folder / f"{name}.npz", **arrays)
    return folder / f"{name}.npz"


def bit(array: np.ndarray[Any, Any], *at: int) -> np.ndarray[Any, Any]:
    """Return an array with the last bit of one entry changed."""
    out = array.copy()
    out.view(f"u{out.dtype.itemsize}")[at] ^= 1
    return out


CHANGES: dict[str, tuple[Callable[[Arrays], Arrays], tuple[str, int, int]]] = {
    "a torque's last bit": (lambda a: {"torques": bit(a["torques"], 7, 2)}, ("torques", 7, 2)),
    "a force's, in three axes": (lambda a: {"forces": bit(a["forces"], 9, 1, 0)}, ("forces", 9, 3)),
    "a flag": (lambda a: {"active": bit(a["active"], 39, 1)}, ("active", 39, 1)),
    "a channel without columns": (lambda a: {"time": bit(a["time"], 5)}, ("time", 5, -1)),
    "text of another width": (lambda a: {"mode": np.array(["up"] * 39 + ["lower"])}, ("mode", 39, -1)),
    "the earlier of two": (
        lambda a: {"torques": bit(a["torques"], 30, 0), "forces": bit(a["forces"], 29, 0, 0)},
        ("forces", 29, 0),
    ),
    "a channel before a fact": (
        lambda a: {"torques": bit(a["torques"], 30, 0), "fact_mass": np.float64(13.0)},
        ("torques", 30, 0),
    ),
    "a row less": (lambda a: {"forces": a["forces"][:-1]}, ("forces", 39, -1)),
    "a fact": (lambda _: {"fact_mass": np.nextafter(12.0, 13.0)}, ("fact_mass", -1, 0)),
    "a name": (lambda _: {"fact_behaviours": np.array(["cruise", "stairs"])}, ("fact_behaviours", -1, 1)),
    "a channel less": (lambda _: {"active": None}, ("active", -1, -1)),
    "a channel more": (lambda _: {"state": np.zeros(40)}, ("state", -1, -1)),
    "single precision": (lambda a: {"forces": a["forces"].astype(np.float32)}, ("forces", -1, -1)),
    "a unit": (
        lambda a: {"channels": np.array(str(a["channels"]).replace("N m", "mN m"))},
        ("definition of torques", -1, 0),
    ),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_difference_is_found_where_it_is(tmp_path: Path, change: str) -> None:
    made, (channel, row, column) = CHANGES[change]
    first = written(tmp_path)
    with np.load(first) as arrays:
        second = written(tmp_path, "second", **made({name: arrays[name] for name in arrays}))
    found = first_difference("trot", first, second)
    assert found is not None
    assert found[:4] == ("trot", channel, row, column)
    assert found.first != found.second
    assert str(found).startswith(f"trot: {channel}")


def test_zero_and_minus_zero_differ_and_nan_does_not(tmp_path: Path) -> None:
    zero, nan = np.zeros(40), np.full(40, np.nan)
    first, second = written(tmp_path, a=zero, b=nan), written(tmp_path, "second", a=-zero, b=nan)
    found = first_difference("trot", first, second)
    assert found is not None
    assert (found.channel, found.row) == ("a", 0)


def test_clocks_and_prose_are_not_compared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = written(tmp_path)
    said = str(np.load(first)["channels"]).replace("of the joints", "at the joints")
    changed: Arrays = {
        "controller_time": np.zeros(40), "fact_wall_time": np.float64(2.0), "channels": np.array(said),
        "fact_source": np.array("elsewhere"),
    }  # fmt: skip
    assert first_difference("trot", first, written(tmp_path, "second", **changed)) is None
    monkeypatch.setattr(comparing, "RENAMED", {"seen stairs": "stairs"})
    monkeypatch.setattr(comparing, "ADDED", frozenset({"state"}))
    changed |= {"fact_behaviours": np.array(["cruise", "stairs"]), "state": np.zeros(40)}
    assert first_difference("trot", first, written(tmp_path, "second", **changed)) is None


def test_records_are_compared_by_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    for folder in (first, second):
        folder.mkdir()
        written(folder, "pace")
    assert main(["compare", str(first), str(second), "--only", "pace"]) == 0
    assert main(["compare", str(first), str(second), "--only", "pace,icub"]) == 1
    assert "icub: log: none and none" in capsys.readouterr().out
    written(second, "pace", time=np.arange(40.0))
    assert main(["compare", str(first), str(second), "--only", "pace"]) == 1
    assert "pace: time row 1: 0x1.0624dd2f1a9fcp-10 (0.001) and 0x1.0" in capsys.readouterr().out
    assert main(["compare", str(first), str(second), "--only", "jog"]) == 2
    assert main(["record", str(first), "--tree", str(tmp_path), "--only", "pace"]) == 2


def test_the_base_names_a_commit_for_every_group() -> None:
    assert set(read_base(BASE.read_text(encoding="utf-8"))) == set(GROUPS)
    said = "".join(f"{group} 1234567\n" for group in GROUPS)
    assert read_base(f"# comment\n\n{said}")["loop"] == "1234567"
    for text, wrong in (
        ("walks 1234567", "line 1 is no group"), ("loop 12x4567", "line 1 is no"), ("loop", "line 1 is no"),
        (f"{said}loop 1234567", "names loop again"), ("loop 1234567", "no commit for quadrupeds, slow-gait"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=wrong):
            read_base(text)


def test_scenarios_are_chosen_by_name_and_group() -> None:
    assert chosen([]) == list(SCENARIOS)
    assert chosen(["loop", "pace"]) == ["pace", "loop"]
    assert {SCENARIOS[name].group for name in chosen(["bipeds"])} == {"bipeds"}
    assert {one.group for one in SCENARIOS.values()} == set(GROUPS)
    with pytest.raises(ValueError, match="unknown scenario or group 'jog'; there are quadrupeds"):
        chosen(["jog"])


def test_a_revision_is_copied_whole_or_not_at_all(tmp_path: Path) -> None:
    assert commit("no-such-revision") is None
    number = commit("HEAD")
    if number is None:
        pytest.skip("this checkout has no history")
    export(number, tmp_path / "tree")
    assert (tmp_path / "tree" / "src" / "surefoot" / "__init__.pyi").is_file()
    with pytest.raises(ValueError, match="git archive"):
        export("0" * 40, tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_a_tree_without_its_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="no checkout"):
        record(tmp_path, tmp_path / "logs", ["pace"])


@pytest.mark.long
@pytest.mark.parametrize("group", GROUPS)
def test_the_logs_are_those_of_the_base(group: str, tmp_path: Path, pytestconfig: pytest.Config) -> None:
    """To the last digit; the base's compiled kernels are kept in pytest's cache folder."""
    for needed in ("mujoco", "pinocchio"):
        pytest.importorskip(needed)
    named = read_base(BASE.read_text(encoding="utf-8"))[group]
    number = commit(named)
    if number is None:
        pytest.skip(f"the history has no commit {named}, the base of {group}")
    names, cache = chosen([group]), pytestconfig.cache.mkdir("same_logs")
    base = record_revision(number, cache, names, tell=False)
    record(ROOT, tmp_path, names, tell=False)
    assert "\n".join(map(str, differences(base, tmp_path, names))) == ""
    known, asking = set[str](), set[str]()
    for name in names:  # a robot that has fallen proves little
        with np.load(tmp_path / f"{name}.npz") as log:
            assert log["fact_reached"] if name == "loop" else str(log["fact_outcome"]) == "done", name
            if group == "quadrupeds":
                behaviours = log["fact_behaviours"].tolist()
                known |= set(behaviours)
                asking |= {behaviours[int(rank)] for rank in np.unique(log["asked_by"]) if rank >= 0}
    assert asking == known  # nor does a behaviour that never asks for anything
