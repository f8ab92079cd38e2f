"""`surefoot estimate`: from a file to a log that can be audited, with two commands."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf


def test_a_table_becomes_a_log_that_audits(
    tmp_path: Path, answer: Callable[..., Any], printed: Callable[..., str]
) -> None:
    robot, rows = sf.load_robot("go2"), 600
    names = [f"JointPos{name.removesuffix('_joint')}" for name in robot.joint_names]
    head = ["Time(s)", "BaseAx", "BaseAy", "BaseAz", "BaseWx", "BaseWy", "BaseWz", *names]
    still = np.concatenate([[0.0, 0.0, 9.81, 0.0, 0.0, 0.0], robot.nominal[7:]])
    table = np.column_stack([0.002 * np.arange(rows), np.tile(still, (rows, 1))])
    file = tmp_path / "go2.csv"
    np.savetxt(file, table, delimiter=",", header=",".join(head), comments="")
    told = answer("estimate", file, "--robot", "go2", "--out", tmp_path / "runs")
    assert told["trusted"] == 1.0
    np.testing.assert_allclose(told["end"][:3], [0.0, 0.0, robot.nominal[2]], atol=0.01)
    assert answer("audit", told["log"], code=3)["verdict"] == "cannot tell"  # no forces, no contacts
    assert "trusted in 100 % of the rows" in printed(
        "estimate", file, "--robot", "go2", "--out", tmp_path / "runs"
    )
    said = printed("estimate", file, "--robot", "g1", "--out", tmp_path / "runs", code=2)
    assert "has 29 joints, the log has 12" in said


def test_a_slope_is_told_and_doubted_until_terrain_says_so(
    tmp_path: Path, answer: Callable[..., Any]
) -> None:
    robot, rows, angle = sf.load_robot("go2"), 600, np.radians(8.0)
    still = np.tile([9.81 * np.sin(angle), 0.0, 9.81 * np.cos(angle)], (rows, 1))  # nose up, along the slope
    arrays = {
        "time": 0.002 * np.arange(rows), "imu_acceleration": still,
        "imu_angular_velocity": np.zeros((rows, 3)), "joint_positions": np.tile(robot.nominal[7:], (rows, 1)),
        "foot_sensors": np.tile(30.0 * (np.arange(rows) < 500)[:, None], (1, 4)),  # lifted in the end
    }  # fmt: skip
    file = sf.Log(arrays, {"joints": list(robot.joint_names)}).save(tmp_path / "slope.npz")
    level = answer("estimate", file, "--out", tmp_path / "runs")
    assert level["trusted"] == 0.0
    pattern = r"doubted throughout: feet stand on a slope of (.*)° that rises -?0° left of ahead"
    said = re.fullmatch(pattern, level["told"][-1])
    assert said
    assert abs(float(said[1]) - 8.0) < 0.3
    known = answer("estimate", file, "--terrain", "slope:8", "--out", tmp_path / "runs")
    assert known["trusted"] == 1.0
    assert not any("doubted" in line or "level" in line for line in known["told"])
