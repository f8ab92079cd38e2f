"""Folders of CSV files: a file a sensor, the columns of one table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.records.log.reading import read_source

ROWS = 20
LEGS = ("FL", "FR", "RL", "RR")


def write_sensors(folder: Path) -> Path:
    """Write a file for each sensor of a walking robot, as a motion-capture laboratory stores them."""
    time = 0.005 * np.arange(ROWS)
    joints = [f"{leg}{k}" for leg in LEGS for k in range(3)]
    parts: dict[str, tuple[list[str], np.ndarray]] = {
        "Accel_body_IMU": (["ACC_X", "ACC_Y", "ACC_Z"], np.tile([0.1, 0.2, 9.8], (ROWS, 1))),
        "Gyro_body_IMU": (["Gyro_X", "Gyro_Y", "Gyro_Z"], np.zeros((ROWS, 3))),
        "Contact_mode": ([f"{leg}_foot" for leg in LEGS], np.ones((ROWS, 4))),
        "Joint_ang": ([f"{j}_ang" for j in joints], np.arange(12.0 * ROWS).reshape(ROWS, 12)),
        "Joint_vel": ([f"{j}_vel" for j in joints], np.full((ROWS, 12), 0.5)),
        "Pos_mocap": (["Pos_mocap_X", "Pos_mocap_Y", "Pos_mocap_Z"], np.full((ROWS, 3), 0.25)),
    }
    folder.mkdir()
    for name, (columns, numbers) in parts.items():
        header = ",".join(["Time", *columns])
        np.savetxt(
            folder / f"{name}.csv", np.column_stack([time, numbers]), "%.6g", ",", header=header, comments=""
        )
    return folder


def test_files_of_sensors_are_one_log(tmp_path: Path) -> None:
    log = sf.read_log(write_sensors(tmp_path / "run"))
    np.testing.assert_allclose(log["time"], 0.005 * np.arange(ROWS))
    np.testing.assert_allclose(log["imu_acceleration"][3], [0.1, 0.2, 9.8])
    np.testing.assert_allclose(log["joint_positions"], np.arange(12.0 * ROWS).reshape(ROWS, 12))
    np.testing.assert_allclose(log["joint_velocities"], 0.5)
    np.testing.assert_allclose(log["base_position"], 0.25)  # not three more joints
    assert log["foot_sensors"].shape == (ROWS, 4)
    assert log.facts["feet"] == list(LEGS)
    assert log.facts["joints"][:3] == ["FL0", "FL1", "FL2"]


def test_names_that_two_files_share_stay_apart(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,x\n0,1\n1,2\n")
    (tmp_path / "b.csv").write_text("t,x\n0,3\n1,4\n")
    fields = read_source(tmp_path).topics[""].fields
    assert list(fields) == ["t", "x", "b.x"]
    np.testing.assert_array_equal(fields["b.x"], [3.0, 4.0])


def test_files_of_other_rows_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,x\n0,1\n1,2\n")
    (tmp_path / "b.csv").write_text("t,y\n0,3\n")
    with pytest.raises(ProblemError, match=r"no columns of one table, their rows are a\.csv 2, b\.csv 1"):
        sf.read_log(tmp_path)
