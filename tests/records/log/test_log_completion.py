"""Logs of others completed by a robot, a ground and what their user knows; the truth is a simulator's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.problems.logged_runs import CleanRun
from surefoot.app.cli.main import main
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import SlopeTerrain
from surefoot.records.log import Log
from surefoot.records.log.log_completion import complete
from surefoot.records.log.reading import read_log
from tests.records.audit.logs import SLOPE, TROT, log_of

JOINTS = tuple(np.random.default_rng(1).permutation(12).tolist())
FEET = (3, 1, 0, 2)
MAPPING = """
time: {from: ms, unit: ms}
feet: [RR, FR, FL, RL]
joints: [JOINTS]
channels:
  base_position: ["base_{axis}"]
  base_orientation: {from: [qw, qx, qy, qz], quaternion: wxyz}
  base_velocity: ["velocity_{axis}"]
  base_angular_velocity: ["rate_{axis}"]
  joint_positions: {from: "{joint}_angle", unit: deg}
  joint_velocities: "{joint}_speed"
  torques: "{joint}_torque"
  forces: {from: "{foot}_{axis}", frame: world}
"""


def write(run: CleanRun, folder: Path) -> Log:
    """Write a run as a table in other units, orders and axes with its mapping; return its log."""
    log, robot = log_of(run), load_robot("go2")
    q, v = np.asarray(log["q"]), np.asarray(log["v"])
    world = np.einsum("tij,tj->ti", rotation_from_quaternion(q[:, 3:7]), v[:, :3])
    frame = SlopeTerrain(10.0).frame([0.0, 0.0]) if run is SLOPE else np.eye(3)
    joints, feet = [robot.joint_names[k] for k in JOINTS], [log.facts["feet"][k] for k in FEET]
    forces = np.einsum("ij,tpj->tpi", frame, np.asarray(log["forces"]))[:, FEET]
    blocks = {
        ("ms",): 1e3 * np.asarray(log["time"])[:, None],
        ("base_x", "base_y", "base_z", "qx", "qy", "qz", "qw"): q[:, :7],
        tuple(f"{j}_angle" for j in joints): np.degrees(q[:, 7:][:, JOINTS]),
        ("velocity_x", "velocity_y", "velocity_z"): world,
        ("rate_x", "rate_y", "rate_z"): v[:, 3:6],
        tuple(f"{j}_speed" for j in joints): v[:, 6:][:, JOINTS],
        tuple(f"{j}_torque" for j in joints): np.asarray(log["torques"])[:, JOINTS],
        tuple(f"{f[:2]}_{a}" for f in feet for a in "xyz"): forces.reshape(len(q), -1),
    }
    head = ",".join(name for names in blocks for name in names)
    np.savetxt(folder / "run.csv", np.hstack([*blocks.values()]), "%.17g", ",", header=head, comments="")
    (folder / "run.yaml").write_text(MAPPING.replace("JOINTS", ", ".join(joints)))
    return log


@pytest.mark.parametrize("run", [TROT, SLOPE])
@pytest.mark.long
def test_positions_gaps_and_velocities_are_the_simulators(run: CleanRun, tmp_path: Path) -> None:
    """And the audit of the table says what that of the run says, in law after law."""
    log = write(run, tmp_path)
    terrain = SlopeTerrain(10.0 if run is SLOPE else 0.0)
    full = complete(read_log(tmp_path / "run.csv", tmp_path / "run.yaml"), load_robot("go2"), terrain)
    near = np.asarray(log["gaps"]) < 0.02
    assert near.mean() > 0.3
    names = ["contact_positions", "normals", "forces", "q", "torques"]
    for name in names + ["gaps", "contact_velocities"] * (run is TROT):
        ours, theirs = np.asarray(full[name]), np.asarray(log[name])
        if log.channels[name].shape[:1] == ("p",):
            ours, theirs = ours[near], theirs[near]
        step = 1e-3 if run is SLOPE and name == "contact_positions" else 2e-6
        np.testing.assert_allclose(ours, theirs, atol=step, rtol=1e-9, err_msg=name)
    loaded = np.asarray(log["forces"])[..., 2] > 1.0  # rigid steps log contacts as they end
    held = loaded[:-2] & loaded[1:-1] & loaded[2:]
    assert np.abs(full["gaps"][1:-1][held]).max() < (3e-3 if run is TROT else 1e-4)
    mu, mass, ground = float(log["mu"][0]), log.facts["mass"], "slope:10" if run is SLOPE else "flat"
    words = ["audit", str(tmp_path / "run.csv"), "--mapping", str(tmp_path / "run.yaml"), "--robot", "go2"]
    assert main([*words, "--terrain", ground, "--mu", str(mu), "--mass", str(mass)]) == 0
    assert main([*words, "--terrain", ground, "--mu", str(0.3 * mu), "--mass", str(mass)]) == 1
    assert main([*words, "--mass", str(mass)]) == 3


def test_what_a_log_tells_is_not_told_again(tmp_path: Path) -> None:
    log = log_of(TROT)
    for given, word in (
        ({"mu": 0.3}, "friction"),
        ({"mass": 3.0}, "mass"),
        ({"terrain": SlopeTerrain(1.0)}, "gaps"),
    ):
        with pytest.raises(ProblemError, match=word):
            complete(log, **given)
    write(TROT, tmp_path)
    other = read_log(tmp_path / "run.csv", tmp_path / "run.yaml")
    with pytest.raises(ProblemError, match="12 joints"):
        complete(other, load_robot("g1"))


def test_the_template_is_a_mapping_and_says_what_is_missing(tmp_path: Path, printed: Any) -> None:
    head = "time_ms,FL_force_x,FL_force_y,FL_force_z,battery\n"
    (tmp_path / "a.csv").write_text(head + "".join(f"{k},0,0,{30 + k % 2},9\n" for k in range(50)))
    words, mapping = ("audit", tmp_path / "a.csv"), tmp_path / "m.yaml"
    printed(*words, "--template", mapping)
    text = mapping.read_text()
    assert "#   battery" in text
    assert "#   mu: friction of the ground [1]: friction, sole, work, dissipation; or --mu" in text
    printed(*words, "--template", mapping, code=2)
    for more in ((), ("--mapping", mapping)):
        printed(*words, *more, "--mu", "0.5", code=3)
    (tmp_path / "b.csv").write_text("a,b\n1,2\n")
    said = printed("audit", tmp_path / "b.csv", "--template", "-")
    assert "It does not suffice: no channel can be guessed" in said
