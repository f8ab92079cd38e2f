"""Motions in the formats of others are read as what they were written from, and what is guessed is told."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.records.motions.joint_orders import breadth_first
from tests.records.motions.made_motions import FRAMES, RATE, g1, in_order, same, spoilt, waved, wxyz

WITHOUT_WRISTS = [name for name in g1().joint_names if "wrist" not in name]


@pytest.fixture(scope="module")
def q() -> Any:
    return waved(g1(), 3)


def phc(q: Any) -> dict[str, Any]:
    return {
        "root_trans_offset": q[:, :3].astype(np.float32), "root_rot": q[:, 3:7], "fps": 50,
        "dof": in_order(g1(), q, WITHOUT_WRISTS), "pose_aa": np.zeros((FRAMES, 27, 3)),
    }  # fmt: skip


def bodies(q: Any) -> tuple[Any, Any]:
    """Return places and quaternions, w first, of all links."""
    robot, data = g1(), g1().model.createData()
    links = [f.name for f in robot.model.frames if f.type.name == "BODY"]
    places, turns = np.empty((FRAMES, len(links), 3)), np.empty((FRAMES, len(links), 4))
    for k, row in enumerate(q):
        pinocchio.framesForwardKinematics(robot.model, data, row)
        for at, link in enumerate(links):
            pose = pinocchio.SE3ToXYZQUAT(data.oMf[robot.model.getFrameId(link)])
            places[k, at], turns[k, at] = pose[:3], pose[[6, 3, 4, 5]]
    return places, turns


def test_a_table_without_names(tmp_path: Path, q: Any) -> None:
    """LAFAN1 has x, y, z, w, Kimodo w, x, y, z, both without a word; the rate must be given."""
    for name, table, turn in (("lafan", q, "xyzw"), ("kimodo", wxyz(q), "wxyz")):
        path = tmp_path / f"{name}.csv"
        np.savetxt(path, table, delimiter=",")
        motion = sf.read_motion(path, g1(), fps=50)
        assert same(motion, q)
        assert (motion.rate, motion.name, motion.source, motion.doubts) == (50.0, name, path, ())
        assert any(f"quaternion: guessed as {turn}" in note for note in motion.notes)
        assert any("joint order: guessed as depth first" in note for note in motion.notes)
    with pytest.raises(sf.SurefootError, match="give fps="):
        sf.read_motion(path, g1())


def test_a_table_whose_first_line_names_its_columns(tmp_path: Path, q: Any) -> None:
    mixed = list(np.random.default_rng(0).permutation(g1().joint_names))
    names = ["time", "root_x", "root_y", "root_z", "root_qw", "root_qx", "root_qy", "root_qz", *mixed]
    table = np.hstack([np.arange(FRAMES)[:, None] / RATE, wxyz(q)[:, :7], in_order(g1(), q, mixed)])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header=",".join(names), comments="")
    motion = sf.read_motion(tmp_path / "a.csv", "g1")
    assert same(motion, q)
    assert motion.rate == pytest.approx(RATE)
    assert motion.notes == ()


def test_a_table_that_counts_its_frames_or_has_its_root_last(tmp_path: Path, q: Any) -> None:
    counted = np.hstack([np.arange(FRAMES)[:, None], wxyz(q)])
    motion = sf.read_motion(counted, g1(), fps=50)
    assert same(motion, q)
    assert "its first column counts frames" in motion.notes
    timed = sf.read_motion(np.hstack([np.arange(FRAMES)[:, None] / RATE, q]), g1())
    assert same(timed, q)
    assert timed.rate == pytest.approx(RATE)
    last = sf.read_motion(np.hstack([q[:, 7:], q[:, :7]]), g1(), fps=50)
    assert same(last, q)
    assert any(doubt.startswith("columns") for doubt in last.doubts)


def test_bodies_that_are_few_tell_no_order(q: Any) -> None:
    places, turns = bodies(q)
    joints = in_order(g1(), q, breadth_first(g1()))
    for count in (1, 14, len(places[0])):
        contents = {
            "fps": 50,
            "joint_pos": joints,
            "body_pos_w": places[:, :count],
            "body_quat_w": turns[:, :count],
        }
        assert same(sf.read_motion(contents, g1()), q)


def test_pickles_of_gmr_and_twist2(tmp_path: Path, q: Any) -> None:
    contents = {"fps": np.float64(50.0), "root_pos": q[:, :3], "root_rot": q[:, 3:7], "dof_pos": q[:, 7:],
                "local_body_pos": np.zeros((FRAMES, 2, 3)), "link_body_list": ["a", "b"]}  # fmt: skip
    for protocol in range(6):
        (tmp_path / "gmr.pkl").write_bytes(pickle.dumps(contents, protocol))
        motion = sf.read_motion(tmp_path / "gmr.pkl", g1())
        assert same(motion, q)
        assert motion.rate == 50.0
        assert motion.extra["local_body_pos"].shape == (FRAMES, 2, 3)
        assert motion.doubts == ()


@pytest.mark.parametrize("compress", [0, 3, ("gzip", 3), ("bz2", 3), ("xz", 3), ("lzma", 3)])
def test_pickles_of_phc_asap_and_pbhc(tmp_path: Path, q: Any, compress: Any) -> None:
    """A dict of one dict, by joblib, 23 joints: those that are missing stand at the nominal angle."""
    joblib.dump({"0-walk": phc(q)}, tmp_path / "walk.pkl", compress=compress)
    motion = sf.read_motion(tmp_path / "walk.pkl", g1())
    expected = q.copy()
    absent = [k for k, name in enumerate(g1().joint_names) if "wrist" in name]
    expected[:, [7 + k for k in absent]] = g1().nominal[[7 + k for k in absent]]
    assert same(motion, expected, 1e-6)
    assert motion.absent == tuple(g1().joint_names[k] for k in absent)
    assert any("6 joints are not in the file" in note for note in motion.notes)
    assert motion.name == "walk"
    contents = {**phc(q), "dof": phc(q)["dof"][:, :, None]}
    assert same(sf.read_motion(contents, g1()), expected, 1e-6)


def test_several_motions_in_a_file(tmp_path: Path, q: Any) -> None:
    joblib.dump({"walk": phc(q), "back": phc(q[::-1])}, tmp_path / "two.pkl")
    assert [motion.name for motion in sf.read_motions(tmp_path / "two.pkl", g1())] == ["walk", "back"]
    assert sf.read_motion(tmp_path / "two.pkl", g1(), name="back").q[0, 0] == pytest.approx(q[-1, 0])
    with pytest.raises(sf.SurefootError, match=r"holds 2 motions, say which by name=.*walk, back"):
        sf.read_motion(tmp_path / "two.pkl", g1())
    with pytest.raises(sf.SurefootError, match="unknown motion 'run'; valid names: back, walk"):
        sf.read_motion(tmp_path / "two.pkl", g1(), name="run")


def test_archives_of_whole_body_tracking(tmp_path: Path, q: Any) -> None:
    """No names, breadth first; the places of links tell the order exactly, names or not."""
    places, turns = bodies(q)
    for names in ({}, {"body_names": np.array([f.name for f in g1().model.frames if f.type.name == "BODY"])}):
        np.savez(
            tmp_path / "a.npz", fps=np.array([50]), joint_pos=in_order(g1(), q, breadth_first(g1())),
            joint_vel=np.zeros((FRAMES, 29)), body_pos_w=places, body_quat_w=turns, **names,
        )  # fmt: skip
        motion = sf.read_motion(tmp_path / "a.npz", g1())
        assert same(motion, q)
        assert any("joint order" in note and "breadth first" in note for note in motion.notes)


def test_archives_of_holosoma(tmp_path: Path, q: Any) -> None:
    names = np.array(g1().joint_names)
    np.savez(tmp_path / "a.npz", fps=np.array([50]), joint_pos=wxyz(q).astype(np.float32), joint_names=names)
    motion = sf.read_motion(tmp_path / "a.npz", g1())
    assert same(motion, q, 1e-6)
    assert motion.doubts == ()
    objects = np.array(g1().joint_names, dtype=object)  # pickled within the archive
    np.savez(tmp_path / "b.npz", fps=50, joint_pos=wxyz(q), joint_names=objects)
    assert same(sf.read_motion(tmp_path / "b.npz", g1()), q)


def test_rollouts_and_executed_motions(tmp_path: Path, q: Any) -> None:
    times = np.arange(FRAMES) / RATE
    np.savez(
        tmp_path / "a.npz", qpos=wxyz(q), qvel=np.zeros((FRAMES, 35)), times=times, ctrl=np.zeros((9, 29))
    )
    motion = sf.read_motion(tmp_path / "a.npz", g1())
    assert same(motion, q)
    assert motion.rate == pytest.approx(RATE)
    backwards = g1().joint_names[::-1]
    torques = np.arange(29.0) * np.ones((FRAMES, 1))
    np.savez(
        tmp_path / "b.npz", fps=50, root_pos=q[:, :3], root_quat_xyzw=q[:, 3:7],
        joint_pos=in_order(g1(), q, backwards), joint_names=np.array(backwards), torques=torques,
    )  # fmt: skip
    motion = sf.read_motion(tmp_path / "b.npz", g1())
    assert same(motion, q)
    assert motion.torques is not None
    assert motion.torques[0].tolist() == list(range(28, -1, -1))


def test_plain_arrays(tmp_path: Path, q: Any) -> None:
    np.save(tmp_path / "q.npy", q)
    np.savez(tmp_path / "q.npz", q)
    for source in (tmp_path / "q.npy", tmp_path / "q.npz", q, q.tolist(), {"q": q}):
        assert same(sf.read_motion(source, g1(), fps=50), q)


def test_a_log(tmp_path: Path, q: Any) -> None:
    torques = np.ones((FRAMES, 29))
    log = sf.Log({"time": np.arange(FRAMES) / RATE, "q": q, "v": np.zeros((FRAMES, 35)), "torques": torques})
    folder = tmp_path / "walk-g1"
    folder.mkdir()
    log.save(folder / "log.npz")
    for source in (log, log.save(tmp_path / "run.npz"), folder):
        motion = sf.read_motion(source, g1())
        assert same(motion, q)
        assert motion.rate == pytest.approx(RATE)
        assert motion.torques is not None
        assert motion.notes == ()
    with pytest.raises(sf.SurefootError, match="must have 19 columns, as go2 has them, got 36"):
        sf.read_motion(log, "go2")


def test_a_robot_that_is_bolted_down() -> None:
    robot = sf.load_robot("panda")
    rows = robot.nominal + 0.1 * np.sin(np.arange(40) / 9.0)[:, None]
    motion = sf.read_motion(rows, robot, fps=100, order="depth")
    assert np.array_equal(motion.q, rows)


def test_options_win_and_contradictions_are_told(q: Any) -> None:
    right = sf.read_motion(q, g1(), fps=50, quaternion="xyzw", order="depth")
    assert right.notes == ()
    wrong = sf.read_motion(q, g1(), fps=50, quaternion="wxyz")
    assert any("quaternion: given as wxyz; xyzw is more plausible" in doubt for doubt in wrong.doubts)
    wrong = sf.read_motion(q, g1(), fps=50, order="breadth")
    assert any(
        "joint order: breadth first, but another one is more plausible" in doubt for doubt in wrong.doubts
    )
    contents = {"fps": 30, "root_pos": q[:, :3], "root_rot": q[:, 3:7], "dof_pos": q[:, 7:]}
    wrong = sf.read_motion(contents, g1(), fps=50)
    assert wrong.rate == 50.0
    assert wrong.doubts == ("rate: fps=50 was given, the file says 30 Hz",)
    names = list(breadth_first(g1()))
    assert same(sf.read_motion(np.hstack([q[:, :7], in_order(g1(), q, names)]), g1(), fps=50, order=names), q)


def test_units_are_put_right_and_told(q: Any) -> None:
    place, turn, joints = spoilt(g1(), q, "degrees")
    motion = sf.read_motion(np.hstack([1000.0 * place, turn, joints]), g1(), fps=50)
    assert same(motion, q)
    assert [doubt.split(":")[0] for doubt in motion.doubts] == ["units", "units"]


def test_uneven_times_are_made_even(q: Any) -> None:
    times = np.arange(FRAMES) / RATE
    times[70:] += 0.5
    motion = sf.read_motion({"qpos": wxyz(q), "times": times}, g1())
    assert any("not evenly spaced" in doubt for doubt in motion.doubts)
    assert motion.duration == pytest.approx(times[-1])


KINDS = (
    "wxyz",
    "breadth",
    "sides",
    "shuffled",
    "wxyz breadth",
    "degrees wxyz",
    "sides wxyz",
    "breadth sides",
)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", KINDS)
def test_other_conventions_are_read_rightly_or_named(kind: str, seed: int) -> None:
    """Thirty-two motions whose names say xyzw and depth first, written otherwise."""
    q = waved(g1(), 100 + seed, heading=float(seed))
    place, turn, joints = spoilt(g1(), q, kind)
    contents = {"fps": 50, "root_pos": place, "root_rot": turn, "dof_pos": joints}
    motion = sf.read_motion(contents, g1())
    assert same(sf.read_motion({**contents, "root_rot": q[:, 3:7], "dof_pos": q[:, 7:]}, g1()), q)
    if "shuffled" not in kind and kind != "breadth sides":
        assert same(motion, q)
    for word, about in (("wxyz", "quaternion"), ("breadth", "joint order"), ("sides", "joint order"),
                        ("shuffled", "joint order"), ("degrees", "units")):  # fmt: skip
        if word in kind:
            assert any(doubt.startswith(about) for doubt in motion.doubts), motion.notes


@pytest.mark.parametrize("kind", KINDS[:4])
def test_names_that_are_not_those_of_the_columns_are_doubted(kind: str, q: Any) -> None:
    place, turn, joints = spoilt(g1(), q, kind)
    contents = {"fps": 50, "root_pos": place, "root_quat_xyzw": turn, "joint_pos": joints,
                "joint_names": list(g1().joint_names)}  # fmt: skip
    about = "quaternion" if kind == "wxyz" else "joint order"
    assert any(doubt.startswith(about) for doubt in sf.read_motion(contents, g1()).doubts)


def test_falls_tell_the_rate_or_doubt_it() -> None:
    """Three jumps of a stiff robot, 0.4 s each: at another rate they do not fall as gravity has it."""
    robot = g1()
    height = np.zeros(200)
    for start in (20, 80, 140):
        times = np.arange(21) / 50.0
        height[start : start + 21] = 0.5 * 9.81 * times * (0.4 - times)
    q = np.tile(robot.nominal, (200, 1))
    q[:, 2] += height
    q[:, 0] += 0.01 * np.arange(200)
    guessed = sf.read_motion(q, robot, quaternion="xyzw", order="depth")
    assert guessed.rate == 50.0
    assert any("guessed as 50 Hz" in doubt for doubt in guessed.doubts)
    assert not any(d.startswith("rate") for d in sf.read_motion(q, robot, fps=50).doubts)
    slow = sf.read_motion(q, robot, fps=30)
    assert any("3 airborne phases fall at 3.5 m/s²" in doubt for doubt in slow.doubts)


def test_a_quadruped_in_unitrees_order() -> None:
    """A Go2 whose right legs come first, as in Unitree's own messages, and quaternions w first."""
    robot = sf.load_robot("go2")
    q = waved_quadruped(robot)
    place, turn, joints = spoilt(robot, q, "sides wxyz")
    motion = sf.read_motion(np.hstack([place, turn, joints]), robot, fps=50)
    assert same(motion, q)
    assert any("sides exchanged" in doubt for doubt in motion.doubts)


def waved_quadruped(robot: sf.Robot) -> Any:
    """Return configurations of a robot on point feet that leans over its front left foot."""
    times = np.arange(FRAMES) / RATE
    joints = robot.nominal[7:] + 0.2 * np.sin(2.0 * times[:, None] + np.arange(robot.joints))
    joints[:, [k for k, name in enumerate(robot.joint_names) if "hip" in name]] += [0.15, -0.15, 0.15, -0.15]
    q = np.hstack([np.tile(robot.nominal[:7], (FRAMES, 1)), joints])
    q[:, 3:7] = pinocchio.Quaternion(pinocchio.rpy.rpyToMatrix(0.1, 0.15, 1.0)).coeffs()
    for row in q:
        row[:3] -= robot.foot_positions(row)[0]
    return q
