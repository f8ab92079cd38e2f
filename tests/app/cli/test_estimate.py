"""`surefoot estimate`: from a file to a log that can be audited, with two commands."""

from __future__ import annotations

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
