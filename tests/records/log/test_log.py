"""The typed log: what it refuses, what it keeps, and that kept logs sum up to the same."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.cli.output import to_json
from surefoot.base.errors import ProblemError
from surefoot.records.audit import RunSummary, summarise_stand, summarise_walk
from surefoot.records.log import CHANNELS, Channel, Log
from surefoot.records.log.channels import SCHEMA, check_shapes
from surefoot.records.log.reading import read_log

DATA = Path(__file__).parent / "data"
"""Short runs of a Go2 in MuJoCo, logged and summarised by an early version."""


def small(T: int = 5, p: int = 4) -> dict[str, Any]:
    rng = np.random.default_rng(T)
    return {
        "time": 1e-3 * np.arange(T),
        "forces": rng.normal(size=(T, p, 3)),
        "gaps": rng.normal(size=(T, p)),
        "active": rng.random((T, p)) < 0.5,
    }


@pytest.mark.parametrize(("name", "summarise"), [("stand", summarise_stand), ("walk", summarise_walk)])
def test_a_log_that_was_kept_sums_up_to_the_same(name: str, summarise: Any, tmp_path: Path) -> None:
    log = read_log(DATA / f"{name}.npz")
    summary: RunSummary = summarise(log)
    told = json.loads(to_json(summary.as_dict()))
    before = json.loads((DATA / f"{name}.json").read_text())
    assert set(told) == set(before)
    for key, value in before.items():
        assert told[key] == approx(value), key
    again = read_log(log.save(tmp_path / "new.npz"))
    with np.load(tmp_path / "new.npz") as file:
        assert int(file["schema"]) == SCHEMA
    assert again.channels == log.channels
    for channel in log.arrays:
        np.testing.assert_array_equal(again[channel], log[channel])
    assert again.facts == log.facts


def approx(value: Any) -> Any:
    """Return a value of JSON that is met to rounding, all the way down."""
    if isinstance(value, dict):
        return {key: approx(one) for key, one in value.items()}
    if isinstance(value, list):
        return [approx(one) for one in value]
    return pytest.approx(value, rel=1e-9, abs=1e-12) if isinstance(value, float) else value


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": None}, "no channel 'time'; it has: forces, gaps, active"),
        ({"forces": np.zeros((5, 4))}, r"forces must have shape \(T, p, 3\) with T = 5, got \(5, 4\)"),
        ({"forces": np.zeros((4, 4, 3))}, r"forces must have shape .* T = 5, got \(4, 4, 3\)"),
        ({"gaps": np.zeros((5, 3))}, r"gaps must have shape \(T, p\), p = 4, got \(5, 3\)"),
        ({"forces": np.zeros((5, 4, 2))}, r"forces must have shape \(T, p, 3\), got \(5, 4, 2\)"),
        ({"grasp_map": np.zeros((5, 6, 9))}, r"grasp_map must have shape \(T, 6, 3p\), p = 4, got"),
        ({"grasp_map": np.zeros((5, 6, 13))}, r"grasp_map must have shape \(T, 6, 3p\), p = 4, got"),
        ({"gaps": np.zeros((5, 4), dtype=complex)}, "gaps must hold real numbers, got complex128"),
        ({"gaps": np.full((5, 4), "x")}, "gaps must hold real numbers"),
        ({"gaps": np.float64(1.0)}, r"gaps must have shape .* got \(\)"),
        ({"battery": np.zeros(5)}, "'battery' is no channel of a log"),
    ],
)
def test_what_does_not_fit_is_named(change: dict[str, Any], message: str) -> None:
    arrays = {name: array for name, array in (small() | change).items() if array is not None}
    with pytest.raises(ProblemError, match=message):
        Log(arrays)


def test_a_channel_of_ones_own_goes_with_the_log(tmp_path: Path) -> None:
    battery = Channel("battery", (2, "cells"), "V", meaning="of each cell")
    log = Log(small() | {"battery": np.arange(30.0).reshape(5, 2, 3)}, channels={"battery": battery})
    assert check_shapes(log.arrays, log.channels) == {"p": 4, "cells": 3}
    again = read_log(log.save(tmp_path / "log.npz"))
    assert again.channels["battery"] == battery
    np.testing.assert_array_equal(again["battery"], log["battery"])
    late = again.rows(slice(3, None))
    assert (len(late), late.channels["battery"]) == (2, battery)


def test_what_is_not_there_is_told(tmp_path: Path) -> None:
    log = Log(small())
    with pytest.raises(ProblemError, match="unknown channel 'q'; valid names: active, forces, gaps, time"):
        log["q"]
    with pytest.raises(ProblemError, match=r"does not tell 'mass' \(of all that moves: .* \[kg\]\)"):
        log.fact("mass")
    with pytest.raises(ProblemError, match="does not tell 'outcome'"):
        summarise_stand(log)
    assert "gaps" in log
    assert "q" not in log
    with pytest.raises(ProblemError, match="can be read, not written"):
        log.save(tmp_path / "log.parts")
    assert log.save(tmp_path / "plain").name == "plain.npz"
    assert list(tmp_path.iterdir()) == [tmp_path / "plain.npz"]


def test_a_cut_or_spoilt_file_is_no_log(tmp_path: Path) -> None:
    whole = (DATA / "stand.npz").read_bytes()
    path = tmp_path / "cut.npz"
    rng = np.random.default_rng(3)
    for size in (0, 1, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:size])
        with pytest.raises(ProblemError, match="not a Surefoot log"):
            read_log(path)
    for _ in range(200):
        spoilt = bytearray(whole)
        for at in rng.integers(0, len(whole), 4):
            spoilt[at] = rng.integers(0, 256)
        path.write_bytes(spoilt)
        try:
            log = read_log(path)
        except ProblemError:
            continue
        assert len(log) == 40


def test_sizes_are_numbers_names_or_both() -> None:
    assert Channel("x", ("3p", 2, "n")).sized(p=4, n=2).row_shape == (12, 2, 2)
    with pytest.raises(ProblemError, match="the size p of channel x is not given"):
        Channel("x", ("p",)).sized(n=2)
    with pytest.raises(ProblemError, match="a size is a number, a name or both"):
        Channel("x", ("p3",)).sized(p3=1, p=2) and Channel("x", ("p+1",)).sized(p=2)


def test_every_channel_says_what_it_is() -> None:
    for name, channel in CHANNELS.items():
        assert name == channel.name
        assert channel.meaning
        assert channel.flag or channel.unit, name
    assert not CHANNELS["time"].optional
    assert sf.Log is Log
    assert sf.read_log is read_log
