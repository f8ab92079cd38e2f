"""Tables, mappings and arrays: what is read, guessed, converted, doubted and refused."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.records.log.log import Log
from surefoot.records.log.mapping import LogMapping, Take
from surefoot.records.log.plausibility import find_doubts
from surefoot.records.log.reading import read_log

GO1 = Path(__file__).resolve().parents[4] / "shared" / "data" / "go1_log" / "go1.csv"
T = 60
FEET = ("FL", "FR", "RL", "RR")


def table(path: Path, columns: dict[str, Any]) -> Path:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(np.asarray(c).tolist() for c in columns.values()), strict=True))
    return path


def moving(seed: int = 0) -> dict[str, Any]:
    """Return a body that moves: its quaternion (x, y, z, w), world velocity and joints."""
    rng = np.random.default_rng(seed)
    time = 0.01 * np.arange(T)
    angle = 0.3 * np.sin(time)
    quaternion = np.column_stack([0 * time, 0 * time, np.sin(angle / 2), np.cos(angle / 2)])
    position = np.column_stack([0.8 * time, 0.1 * np.sin(3 * time), 0.3 + 0 * time])
    velocity = np.column_stack([0.8 + 0 * time, 0.3 * np.cos(3 * time), 0 * time])
    phase = rng.uniform(0, 6, 4)
    joints = 0.4 * np.sin(5 * time[:, None] * (1 + 0.3 * np.arange(4)) + phase)
    rates = 2.0 * (1 + 0.3 * np.arange(4)) * np.cos(5 * time[:, None] * (1 + 0.3 * np.arange(4)) + phase)
    forces = rng.normal([0, 0, 30.0], 1.0, (T, 4, 3))
    return {
        "time": time, "base_orientation": quaternion, "base_position": position, "base_velocity": velocity,
        "base_angular_velocity": np.zeros((T, 3)), "joint_positions": joints, "joint_velocities": rates,
        "forces": forces,
    }  # fmt: skip


def columns(run: dict[str, Any]) -> dict[str, Any]:
    return {
        "t_ms": 1e3 * run["time"],
        **{f"base_pos_{a}": run["base_position"][:, k] for k, a in enumerate("xyz")},
        **{f"quat_{a}": run["base_orientation"][:, k] for k, a in enumerate("xyzw")},
        **{f"q_j{k}_deg": np.degrees(run["joint_positions"][:, k]) for k in range(4)},
        **{f"dq_j{k}": run["joint_velocities"][:, k] for k in range(4)},
        **{f"{f}_f{a}": run["forces"][:, i, k] for i, f in enumerate(FEET) for k, a in enumerate("xyz")},
    }


def test_columns_are_guessed_with_their_units(tmp_path: Path) -> None:
    run = moving()
    log = read_log(table(tmp_path / "run.csv", columns(run)))
    for name in (
        "time",
        "base_position",
        "base_orientation",
        "joint_positions",
        "joint_velocities",
        "forces",
    ):
        np.testing.assert_allclose(log[name], run[name], rtol=1e-12, atol=1e-14, err_msg=name)
    np.testing.assert_allclose(log["q"][:, :3], run["base_position"], rtol=1e-12, atol=1e-14)
    assert log.facts["feet"] == list(FEET)
    assert log.facts["joints"] == [f"j{k}" for k in range(4)]
    assert log.facts["dt"] == pytest.approx(0.01)
    assert len(log.doubts) == 1
    assert log.doubts[0].startswith("the mapping was guessed (time, base_orientation, base_position")
    shown = tmp_path / "shown.yaml"
    shown.write_text(log.facts["mapping"])
    again = read_log(tmp_path / "run.csv", shown)  # what is shown is a mapping
    assert again.doubts == ()
    for name in log.arrays:
        np.testing.assert_array_equal(again[name], log[name])
    kept = read_log(again.save(tmp_path / "kept.npz"))
    assert kept.facts["mapping"] == again.facts["mapping"]
    assert read_log(log.save(tmp_path / "doubted.npz")).doubts == log.doubts


def test_a_mapping_gives_units_frames_orders_and_signs(tmp_path: Path) -> None:
    run = moving()
    R = rotation_from_quaternion(run["base_orientation"])
    raw = {"stamp": 1e9 * run["time"]}
    raw |= {f"o{k}": run["base_orientation"][:, [3, 0, 1, 2]][:, k] for k in range(4)}
    local = np.einsum("tji,tj->ti", R, run["base_velocity"])
    raw |= {f"v{a}": local[:, k] for k, a in enumerate("XYZ")}
    ground = -np.einsum("tji,tpj->tpi", R, run["forces"]) / 1e3
    raw |= {f"{f}/{a}": ground[:, i, k] for i, f in enumerate(FEET) for k, a in enumerate("xyz")}
    path, how = table(tmp_path / "run.csv", raw), tmp_path / "how.yaml"
    how.write_text(
        """
        time: {from: stamp, unit: ns}
        feet: [FL, FR, RL, RR]
        facts: {mass: 12.2}
        channels:
          base_orientation: {from: [o0, o1, o2, o3], quaternion: wxyz}
          base_velocity: {from: "v{AXIS}", frame: base}
          forces: {from: "{foot}/{axis}", unit: kN, frame: base, scale: -1}
        """
    )
    log = read_log(path, how)
    np.testing.assert_allclose(log["time"], run["time"], atol=1e-12)
    for name in ("base_orientation", "base_velocity", "forces"):
        np.testing.assert_allclose(log[name], run[name], rtol=1e-12, atol=1e-12, err_msg=name)
    assert log.fact("mass") == 12.2
    assert log.doubts == ("forces: contact axes are taken to be the world's, as on level ground",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("channels: {forces: {from: [a, b]}}", "forces has the row shape"),
        ("channels: {forces: {from: nowhere}}", "the file has no field 'nowhere'; it has: time, a, b"),
        ("channels: {mu: {from: a, unit: lb}}", "unknown unit 'lb'; valid names: 1, N"),
        ("channels: {mu: {from: a, unit: deg}}", "channel mu is in 1, 'deg' is none of that"),
        ("channels: {nu: a}", "unknown channel 'nu'; valid names: active"),
        ("channels: {mu: {form: a}}", "unknown key 'form'; valid names: frame, from"),
        ("channels: {mu: {from: a, scale: much}}", "scale must be a number, got 'much'"),
        ("channels: {foot_sensors: '{foot}_F'}", "stands for every foot, and the mapping names no foot"),
        ("channels: {push: {from: [a, b, b], frame: camera}}", "unknown frame 'camera'"),
        ("channels: {push: {from: [a, b, b], frame: base}}", "needs the channel base_orientation"),
        ("channels: {active: [a, b]}", "channel active must hold true and false"),
        (
            "channels: {base_orientation: {from: [a, b, a, b], quaternion: zyx}}",
            "order of a quaternion 'zyx'",
        ),
        ("channels: {}", "the mapping takes no channel"),
        ("feet: 3\nchannels: {mu: a}", "feet must be a name or a list of names, got 3"),
        ("[1, 2]", "must be a mapping of the keys time, feet"),
        ("{", "is not YAML"),
        ("define: [3]\nchannels: {mu: a}", "define must list channels"),
    ],
)
def test_what_does_not_map_is_one_line(text: str, message: str, tmp_path: Path) -> None:
    path = table(tmp_path / "run.csv", {"time": [0, 1, 2], "a": [1, 2, 3], "b": [4, 5, 6]})
    (tmp_path / "how.yaml").write_text(text if "time" in text or text in "[1, 2]{" else f"time: time\n{text}")
    with pytest.raises(ProblemError, match=message) as told:
        read_log(path, tmp_path / "how.yaml")
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("time,mu\n", "has no rows"),
        ("time,mu\n0,1\n1\n", "line 3: 1 cells, 2 columns are named"),
        ("time,mu\n0,1\n1,two\n", "line 3, column mu: 'two' is no number"),
        ("time,mu\n0,1\n1,1_0\n", "line 3, column mu: '1_0' is no number"),
        ("time,mu\n0,1\nnan,2\n", "the time stamp of row 1 is no finite number"),
        ("0,1\n1,2\n", "the first line must name the columns, got numbers"),
        ("word\n", "has no rows"),
        ("time,a,a\n0,1,2\n", "two columns are called 'a'"),
        ("time,a\n0,1\n", "no channel can be guessed from the fields time, a: give a mapping"),
        ("mu,x\n0,1\n", "the mapping must say which column is the time"),
        ("\0\1\2", "must name the columns|is no text"),
        ('time,mu\n0,"1\n' + "1,2\n" * 50_000, "is no table, a quote may be open"),
    ],
    ids=lambda text: text[:20],
)
def test_a_table_that_is_none_is_one_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ProblemError, match=message) as told:
        read_log(path)
    assert "\n" not in str(told.value)


def test_empty_cells_and_words_are_numbers(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    how = LogMapping({"time": Take(("time",)), "mu": Take(("mu",))})
    for end in ("\n", "\r\n", "\r"):
        path.write_text("time;mu;FL_contact\n0;0.5;true\n0.1;;false\n0.2;0.7;true\n", newline=end)
        log = read_log(path, how)
        np.testing.assert_array_equal(log["mu"], [0.5, np.nan, 0.7])
        assert log.doubts == ("mu is not finite in 1 rows, first in row 1",)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: {"joint_positions": np.degrees(r["joint_positions"])}, "are they in degrees"),
        (
            lambda r: {"base_orientation": r["base_orientation"][:, [3, 0, 1, 2]]},
            "leans 17. deg as x, y, z, w",
        ),
        (lambda r: {"base_orientation": 2 * r["base_orientation"]}, "norms up to 2, not 1"),
        (lambda r: {"time": r["time"][::-1].copy()}, "goes backward in 59 rows"),
        (lambda r: {"time": np.repeat(r["time"][::2], 2)}, "stands still in 30 rows, first in row 1"),
        (lambda r: {"time": 1e3 * r["time"]}, "rows are 10 s apart: is the time in seconds"),
        (
            lambda r: {"time": r["time"] + (r["time"] > 0.3)},
            "missing in 1 places, at most 1.01 s after 0.3 s",
        ),
        (lambda r: {"forces": -r["forces"]}, "are they those on the ground"),
        (lambda r: {"forces": r["forces"][..., ::-1]}, "is the normal the first"),
        (
            lambda r: {"forces": np.where(np.arange(T) == 7, np.nan, r["forces"].T).T},
            "forces is not finite in 1",
        ),
        (lambda r: {"imu_acceleration": np.tile([0, 0, 1.0], (T, 1))}, "is it in g"),
        (lambda r: {"imu_acceleration": np.tile([0, 0, 1e200], (T, 1))}, "acceleration is 1e.200 m/s"),
        (lambda r: {"imu_acceleration": np.tile([0, 0, -9.8], (T, 1))}, "upside down"),
        (lambda r: {"imu_acceleration": np.tile([0, 0, 0.1], (T, 1))}, "is gravity taken out"),
        (lambda r: {"imu_acceleration": np.tile([9.8, 0, 0.1], (T, 1))}, "is z its upward axis"),
    ],
)
def test_what_is_not_plausible_is_told(change: Any, message: str) -> None:
    run = moving()
    told = find_doubts(sf.Log({**run, **change(run)}))
    assert re.search(message, "; ".join(told)), told


def test_a_wrong_weight_is_told() -> None:
    log = sf.Log(moving(), {"mass": 120.0 / 9.81})
    assert find_doubts(log) == []
    log.facts["mass"] *= 9.81
    assert find_doubts(log) == [
        "normal forces are 0.102 m g on average: unit, mass, or feet that are missing?"
    ]


def test_arrays_of_mujoco_and_isaac_lab() -> None:
    run = moving()
    R = rotation_from_quaternion(run["base_orientation"])
    wxyz = run["base_orientation"][:, [3, 0, 1, 2]]
    qpos = np.hstack([run["base_position"], wxyz, run["joint_positions"]])
    qvel = np.hstack([run["base_velocity"], run["base_angular_velocity"], run["joint_velocities"]])
    tau = np.hstack([np.zeros((T, 6)), run["joint_positions"]])
    log = sf.log_from_arrays({"qpos": qpos, "qvel": qvel, "qfrc_actuator": tau}, dt=0.01, quaternion="wxyz")
    np.testing.assert_allclose(log["q"][:, 3:7], run["base_orientation"], atol=1e-15)
    np.testing.assert_allclose(np.einsum("tij,tj->ti", R, log["v"][:, :3]), run["base_velocity"], atol=1e-14)
    np.testing.assert_array_equal(log["torques"], run["joint_positions"])
    isaac = {
        "net_forces_w": run["forces"],
        "root_pos_w": run["base_position"],
        "root_quat_w": wxyz,
        "root_lin_vel_b": np.einsum("tji,tj->ti", R, run["base_velocity"]),
        "root_ang_vel_b": np.zeros((T, 3)),
        "joint_pos": run["joint_positions"],
        "joint_vel": run["joint_velocities"],
    }
    lab = sf.log_from_arrays(isaac, dt=0.01, quaternion="wxyz", feet=FEET)
    np.testing.assert_array_equal(lab["forces"], run["forces"])
    np.testing.assert_allclose(lab["base_velocity"], run["base_velocity"], atol=1e-14)
    np.testing.assert_allclose(lab["q"], log["q"], atol=1e-15)
    np.testing.assert_allclose(lab["v"], log["v"], atol=1e-13)
    many = {name: np.stack([array] * 2, axis=1) for name, array in isaac.items()}
    with pytest.raises(ProblemError, match="pick one environment"):
        sf.log_from_arrays(many, dt=0.01, quaternion="wxyz")
    with pytest.raises(
        ProblemError, match="base_orientation holds a quaternion: say quaternion='xyzw' or 'wxyz'"
    ):
        sf.log_from_arrays(isaac, dt=0.01)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"forces": np.zeros((5, 3))}, r"forces must have shape \(T, p, 3\), got \(5, 3\)"),
        ({"forces": np.zeros((5, 4, 2))}, "three numbers last"),
        ({"forces": np.zeros((5, 4, 3)), "gaps": np.zeros((6, 4))}, "the same number of rows"),
        ({"speed": np.zeros(5)}, "unknown array 'speed'; valid names: active, applied_torque"),
        ({"mu": ["a"] * 5}, "array mu must hold real numbers"),
        ({"joint_pos": np.zeros((5, 2)), "joint_positions": np.zeros((5, 2))}, "two arrays are the channel"),
        ({}, "the same number of rows, got {}"),
    ],
)
def test_arrays_that_do_not_fit(arrays: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        sf.log_from_arrays(arrays, dt=0.01)
    with pytest.raises(ProblemError, match="give the array time, or dt > 0"):
        sf.log_from_arrays({"mu": np.zeros(5)})
    with pytest.raises(ProblemError, match="feet must be a name or a list of names, got 3"):
        sf.log_from_arrays({"mu": np.zeros(5)}, dt=0.1, feet=3)  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="4 contact points, feet names 2"):
        sf.log_from_arrays({"forces": np.zeros((5, 4, 3))}, dt=0.1, feet=["a", "b"])


@pytest.mark.shared
@pytest.mark.skipif(not GO1.exists(), reason=f"no data file {GO1}")
def test_the_walking_go1_is_read() -> None:
    log = read_log(GO1)
    assert log["foot_sensors"].shape == (10148, 4)
    assert log.facts["feet"] == ["FR", "FL", "RR", "RL"]
    assert log.facts["joints"][:3] == ["FR_hip", "FR_thigh", "FR_calf"]
    assert log["joint_positions"].shape == (10148, 12)
    assert log["imu_acceleration"][:, 2].mean() == pytest.approx(9.673, abs=0.01)
    assert len(log.doubts) == 1


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_a_table_without_names_is_given_them(separator: str, tmp_path: Path) -> None:
    rows = [[0.0, 0.5, 40.0], [0.01, 0.6, 41.0]]
    text = "\n".join(separator.join(map(str, row)) for row in rows)
    bare, named = tmp_path / "bare.csv", tmp_path / "named.csv"
    bare.write_text(text)
    named.write_text(separator.join(("time", "mu", "load")) + "\n" + text)
    mapping = LogMapping({"time": Take(("time",)), "mu": Take(("mu",))})
    log = read_log(bare, mapping, columns=["time", "mu", "load"])
    np.testing.assert_array_equal(log["mu"], [0.5, 0.6])
    for name in log:
        np.testing.assert_array_equal(log[name], read_log(named, mapping)[name])
    with pytest.raises(ProblemError, match=r"got numbers.*give their 3 names, columns="):
        read_log(bare, mapping)


def test_names_that_do_not_fit_a_table_are_refused(tmp_path: Path) -> None:
    (tmp_path / "bare.csv").write_text("0,1\n1,2\n")
    for columns, told in ((["time"], "line 1: 2 cells, 1 columns are named"), (["a", "a"], "called 'a'")):
        with pytest.raises(ProblemError, match=told):
            read_log(tmp_path / "bare.csv", columns=columns)
    saved = Log({"time": np.arange(3.0)}).save(tmp_path / "log.npz")
    for given in ({"columns": ["time"]}, {"mapping": tmp_path / "none.yaml"}):
        with pytest.raises(ProblemError, match="format npz take no mapping, columns or rate"):
            read_log(saved, **given)
