"""Tables without a column of time, and of one foot's raw Fz: what people have who log at a fixed rate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.cli.main import main
from surefoot.base.errors import ProblemError
from surefoot.records.log.mapping import LogMapping, Take, mapping_from_yaml

ROWS = 250


def table(path: Path, header: str, columns: int = 1) -> Path:
    rows = [",".join(f"{300.0 + 5.0 * ((k + c) % 7):g}" for c in range(columns)) for k in range(ROWS)]
    path.write_text("\n".join([*([header] if header else []), *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("name", ["FL_force", "FL_fz", "FL_F_z"])
def test_a_rate_tells_the_time_of_rows(name: str, tmp_path: Path) -> None:
    log = sf.read_log(table(tmp_path / "a.csv", f"{name},FR{name[2:]}", 2), rate=500)
    np.testing.assert_allclose(log["time"], np.arange(ROWS) / 500.0)
    assert log.fact("dt") == pytest.approx(0.002)
    assert log.facts["feet"] == ["FL", "FR"]
    assert log["foot_sensors"].shape == (ROWS, 2)
    mapping = mapping_from_yaml(log.facts["mapping"])
    assert mapping.rate == 500.0
    again = sf.read_log(tmp_path / "a.csv", mapping)
    np.testing.assert_array_equal(again["time"], log["time"])


@pytest.mark.parametrize("name", ["F_z", "fz", "Fz", "force_z", "grf_z", "Fz (N)"])
def test_one_foot_s_raw_force_is_guessed(name: str, tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", f"{name},temperature", 2)
    log = sf.read_log(path, rate=1000)
    assert log["foot_sensors"].shape == (ROWS, 1)
    assert log["foot_sensors"][0, 0] == 300.0
    path = table(tmp_path / "b.csv", f"t,{name}", 2)
    assert "foot_sensors" in sf.read_log(path)


def test_three_axes_of_one_foot_are_forces(tmp_path: Path) -> None:
    log = sf.read_log(table(tmp_path / "a.csv", "Fx,Fy,Fz", 3), rate=500)
    assert log["forces"].shape == (ROWS, 1, 3)


def test_no_header_and_no_time(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", "")
    with pytest.raises(ProblemError, match=r"columns=\[\.\.\.\] or --columns|the first line must name"):
        sf.read_log(path, rate=500)
    log = sf.read_log(path, columns=["fz"], rate=500)
    assert log["foot_sensors"].shape == (ROWS, 1)


def test_a_mapping_says_the_rate(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", "left", 1)
    mapping = tmp_path / "m.yaml"
    mapping.write_text("time: {rate: 250}\nfeet: [L]\nchannels: {foot_sensors: left}\n", encoding="utf-8")
    assert sf.read_log(path, mapping)["time"][-1] == pytest.approx((ROWS - 1) / 250.0)
    assert len(sf.read_log(path, mapping, rate=250.0)) == ROWS
    with pytest.raises(ProblemError, match="the mapping says 250 Hz, not 500"):
        sf.read_log(path, mapping, rate=500.0)


@pytest.mark.parametrize("rate", [0.0, -5.0, float("nan"), float("inf")])
def test_what_is_no_rate(rate: float, tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", "fz")
    with pytest.raises(ProblemError, match="rate"):
        sf.read_log(path, rate=rate)
    mapping = tmp_path / "m.yaml"
    mapping.write_text(f"time: {{rate: {rate}}}\nchannels: {{foot_sensors: fz}}\n", encoding="utf-8")
    with pytest.raises(ProblemError):
        sf.read_log(path, mapping)


def test_a_rate_beside_stamps_is_refused(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", "t,fz", 2)
    with pytest.raises(ProblemError, match="told twice, by 't' and by a rate of 500 Hz"):
        sf.read_log(path, rate=500)
    with pytest.raises(ProblemError, match="must be the field of the stamps, or the rate"):
        mapping_from_yaml("time: {rate: 500, from: t}\nchannels: {foot_sensors: fz}")
    with pytest.raises(ProblemError, match="told twice"):
        LogMapping({"time": Take(("t",))}, rate=500.0)
    sf.log_from_arrays({"forces": np.ones((9, 1, 3))}, dt=0.01).save(tmp_path / "own.npz")
    with pytest.raises(ProblemError, match="take no mapping, columns or rate"):
        sf.read_log(tmp_path / "own.npz", rate=500)


def test_a_table_without_either_says_how(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=r"time: NAME; or the rate of the rows where none is.*--rate 500"):
        sf.read_log(table(tmp_path / "a.csv", "fz"))


def test_the_command_takes_a_rate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(table(tmp_path / "a.csv", "fz"))
    assert main(["audit", path, "--rate", "500"]) == 3
    assert main(["audit", path, "--rate", "-1"]) == 2
    assert "--rate" in capsys.readouterr().err
