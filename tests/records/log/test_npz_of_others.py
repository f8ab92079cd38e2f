"""Archives of arrays that somebody's own loop wrote are tables, as CSV files are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.cli.main import main
from surefoot.base.errors import ProblemError

ROWS = 50
FORCES = np.tile([2.0, 0.0, 30.0], (ROWS, 4, 1))
TIME = 0.01 * np.arange(ROWS)
LEVEL = np.tile([0.0, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0, *np.zeros(12)], (ROWS, 1))


def saved(folder: Path, **arrays: Any) -> Path:
    np.savez(folder / "own.npz", **arrays)
    return folder / "own.npz"


def test_names_are_guessed_and_doubted(tmp_path: Path) -> None:
    path = saved(tmp_path, t=TIME, grf=FORCES, mu=np.full(ROWS, 0.6), mass=12.0, names=np.array(["a", "b"]))
    log = sf.read_log(path)
    np.testing.assert_array_equal(log["forces"], FORCES)
    assert {*log} == {"time", "forces", "mu"}
    assert log.fact("mass") == 12.0
    assert "names holds no numbers: left out" in log.doubts
    assert log.doubts[0].startswith("the mapping was guessed (time, mu, forces)")
    assert "both hold: pull, friction" in sf.audit_log(log).sentence


def test_engines_names_a_step_and_friction_once(tmp_path: Path) -> None:
    log = sf.read_log(saved(tmp_path, dt=0.01, qpos=LEVEL, net_forces_w=FORCES, mu=0.5))
    np.testing.assert_allclose(log["time"], TIME)
    np.testing.assert_array_equal(log["q"][0, 3:7], [0.0, 0.0, 0.0, 1.0])  # MuJoCo's w comes first
    np.testing.assert_array_equal(log["mu"], 0.5)
    each = sf.read_log(saved(tmp_path, dt=0.01, forces=FORCES, mu=np.full((ROWS, 4), 0.4)))
    assert each["contact_friction"].shape == (ROWS, 4)


def test_an_array_a_foot(tmp_path: Path) -> None:
    feet = {f"{name}_force": FORCES[:, k] + k for k, name in enumerate(("FR", "FL", "RR", "RL"))}
    log = sf.read_log(saved(tmp_path, t=TIME, **feet))
    assert log.facts["feet"] == ["FR", "FL", "RR", "RL"]
    np.testing.assert_array_equal(log["forces"][0, :, 2], [30.0, 31.0, 32.0, 33.0])


def test_an_array_of_all_feet_leaves_their_own_aside(tmp_path: Path) -> None:
    log = sf.read_log(saved(tmp_path, t=TIME, forces=FORCES, FL_force=2.0 * FORCES[:, 0]))
    np.testing.assert_array_equal(log["forces"], FORCES)
    assert len(log.facts.get("feet", ())) in (0, 4)


def test_a_template_is_completed_and_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, mapping = saved(tmp_path, stamp_ms=1e3 * TIME, legs=FORCES, mu=0.6), tmp_path / "own.yaml"
    assert main(["audit", str(path), "--template", str(mapping)]) == 0
    text = mapping.read_text()
    assert "#   legs" in text
    assert "#   stamp_ms" in text
    mapping.write_text(
        "channels:\n  forces: {from: legs}\n  time: {from: stamp_ms, unit: ms}\nfacts: {mass: 12}\n"
    )
    assert main(["audit", str(path), "--mapping", str(mapping)]) == 3
    assert "2 laws judged, both hold: pull, friction" in " ".join(capsys.readouterr().out.split())
    log = sf.read_log(path, mapping)
    np.testing.assert_allclose(log["time"], TIME)
    assert log.doubts == ()


def test_friction_is_a_fact_of_a_mapping(tmp_path: Path) -> None:
    mapping = tmp_path / "own.yaml"
    mapping.write_text("channels: {time: {from: t}, forces: {from: f}}\nfacts: {mu: 0.7}\n")
    np.testing.assert_array_equal(sf.read_log(saved(tmp_path, t=TIME, f=FORCES), mapping)["mu"], 0.7)
    mapping.write_text("channels: {time: {from: t}, forces: {from: f}}\nfacts: {mu: [0.7]}\n")
    with pytest.raises(ProblemError, match="one for each of 4 contacts"):
        sf.read_log(tmp_path / "own.npz", mapping)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({}, "no array of numbers over time"),
        ({"mass": 3.0}, "no array of numbers over time"),
        ({"t": TIME, "legs": FORCES}, "no channel can be guessed from the fields t, legs"),
        ({"grf": FORCES}, "which column is the time"),
    ],
)
def test_what_is_no_table_says_why(arrays: dict[str, Any], words: str, tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=words):
        sf.read_log(saved(tmp_path, **arrays))


def test_rows_are_those_of_most_arrays(tmp_path: Path) -> None:
    log = sf.read_log(saved(tmp_path, t=TIME, grf=FORCES, gains=np.ones(12)))
    assert len(log) == ROWS
    assert any("gains (12,)" in doubt for doubt in log.doubts)
    assert len(sf.read_log(saved(tmp_path, t=TIME, grf=FORCES), rate=None)) == ROWS
    assert sf.read_log(saved(tmp_path, grf=FORCES), rate=200.0).duration == pytest.approx(49 / 200.0)


def test_objects_are_left_in_the_file(tmp_path: Path) -> None:
    log = sf.read_log(saved(tmp_path, t=TIME, grf=FORCES, note=np.array([{"a": 1}], dtype=object)))
    assert any("the array note holds pickled Python objects, which are not loaded" in d for d in log.doubts)


def test_our_own_logs_are_read_as_before(tmp_path: Path) -> None:
    log = sf.read_log(saved(tmp_path, t=TIME, grf=FORCES))
    kept = log.save(tmp_path / "log.npz")
    assert sf.read_log(kept) == log
    with pytest.raises(ProblemError, match="exists already"):
        log.save(tmp_path / "own.npz")
