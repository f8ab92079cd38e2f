"""Pictures of a log: what Rerun and Foxglove are given, and what is said without Rerun."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.errors import MissingExtra, ProblemError
from surefoot.log import scene
from surefoot.log.skeleton import skeleton_of
from surefoot.robot import load_robot
from tests.audit.logs import SLOPE, STAND, log_of

HERE = importlib.util.find_spec("rerun") is not None


@pytest.mark.skipif(HERE, reason="rerun-sdk is installed")
def test_without_rerun_a_line_says_what_to_install(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from surefoot.cli.main import main

    path = log_of(STAND).save(tmp_path / "log.npz")
    with pytest.raises(MissingExtra, match=r"surefoot\[rerun\]"):
        log_of(STAND).save(tmp_path / "log.rrd")
    assert not (tmp_path / "log.rrd").exists()
    assert main(["audit", str(path), "--rerun", str(tmp_path / "log.rrd")]) == 2
    assert "rerun-sdk is not installed" in capsys.readouterr().err


@pytest.mark.skipif(not HERE, reason="rerun-sdk is not installed (extra rerun)")
def test_a_recording_is_saved(tmp_path: Path) -> None:
    from surefoot.cli.main import main

    path = log_of(STAND).save(tmp_path / "log.npz")
    assert main(["audit", str(path), "--rerun", str(tmp_path / "log.rrd")]) == 0
    data = (tmp_path / "log.rrd").read_bytes()
    assert data[:4] == b"RRF2"
    assert len(data) > 20_000


class Stream:
    """Stands for Rerun's stream and module: keeps what it is given."""

    def __init__(self, *_: object) -> None:
        self.logged: dict[str, list[tuple[float, object]]] = {}
        self.curves: dict[str, object] = {}
        self.now = 0.0

    def set_time(self, name: str, duration: float) -> None:
        assert name == "time"
        self.now = duration

    def log(self, path: str, entity: object) -> None:
        self.logged.setdefault(path, []).append((self.now, entity))

    def send_columns(self, path: str, indexes: object, columns: object) -> None:
        self.curves[path] = columns


def test_what_rerun_is_given() -> None:
    from types import SimpleNamespace

    from surefoot.log import rerun_file

    def keep(*args: object, **named: object) -> dict[str, object]:
        return {**named, **({"lines": args[0]} if args else {})}

    columns = SimpleNamespace(columns=lambda scalars: scalars)
    rerun = SimpleNamespace(
        TimeColumn=keep, Scalars=columns, Quaternion=keep, Transform3D=keep, LineStrips3D=keep, Arrows3D=keep
    )
    log, stream = log_of(STAND), Stream()
    rerun_file._fill(rerun, stream, log)
    assert set(stream.logged) == {"robot/base", "robot/skeleton", "contacts/forces", "contacts/cones"}
    assert {len(rows) for rows in stream.logged.values()} == {30}  # 0.6 s, every 20 ms
    times = [now for now, _ in stream.logged["robot/base"]]
    np.testing.assert_allclose(np.diff(times), 0.02, atol=1e-9)
    (_, last) = stream.logged["contacts/forces"][-1]
    assert isinstance(last, dict)
    assert np.sum(last["vectors"], axis=0)[2] == pytest.approx(scene.ARROW, rel=0.05)
    np.testing.assert_array_equal(stream.curves["normal_force/FL_foot"], log["forces"][:, 0, 2])
    assert len(stream.curves) == 12


def test_other_targets_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from surefoot.cli.main import main

    path = log_of(STAND).save(tmp_path / "log.npz")
    assert main(["audit", str(path), "--rerun", "log.txt"]) == 2
    assert "--rerun takes a file that ends in .rrd, or show" in capsys.readouterr().err


def test_forces_and_cones_stand_on_the_slope() -> None:
    """Of the drawn arrows the sum is m g, straight up; each rim lies on its cone about the slope's normal."""
    log = log_of(SLOPE)
    weight = scene.weight_of(log)
    row = next(r for r in scene.pictures(np.asarray(log["time"])) if log["time"][r] > 0.1)
    drawn = list(scene.contacts(log, row, weight))
    assert drawn
    assert not any(c.broken for c in drawn)
    normal = log["normals"][row, 0]
    for c in drawn:
        axis = c.rim() - c.place
        height = axis @ normal
        np.testing.assert_allclose(height, scene.CONE, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(axis - height[:, None] * normal, axis=1), c.mu * scene.CONE)
        assert len(c.cone_lines()) == 1 + scene.SEGMENTS // 2
    mean = np.mean(
        [np.sum([c.arrow for c in scene.contacts(log, r, weight)], axis=0) for r in range(100, 1100)], axis=0
    )
    assert mean[2] == pytest.approx(scene.ARROW, rel=0.05)
    assert abs(mean[0]) < 0.1 * scene.ARROW


def test_the_skeleton_ends_at_the_contact_points() -> None:
    log = log_of(STAND)
    skeleton = skeleton_of(log)
    assert skeleton is not None
    lines = skeleton.segments(log["q"][0])
    ends = lines[-4:, 1]
    places = log["contact_positions"][0]
    radius = load_robot("go2").contact_points.radii
    np.testing.assert_allclose(np.linalg.norm(ends - places, axis=1), radius, atol=1e-4)
    poses = skeleton.poses(log["q"][0])
    np.testing.assert_allclose(poses[0], log["q"][0, :7], atol=1e-9)
    assert skeleton_of(sf.Log(log.arrays, {**log.facts, "robot": "nobody"}, channels=log.channels)) is None


def test_foxglove_draws_robot_forces_and_cones(tmp_path: Path) -> None:
    import json

    reader = pytest.importorskip("mcap.reader")
    log = log_of(STAND)
    path = log.save(tmp_path / "log.mcap")
    frames: set[str] = set()
    entities: dict[str, int] = {}
    with path.open("rb") as file:
        for schema, _, message in reader.make_reader(file).iter_messages():
            told = json.loads(message.data)
            if schema.name == "foxglove.FrameTransform":
                frames.add(told["child_frame_id"])
            if schema.name == "foxglove.SceneUpdate":
                for entity in told["entities"]:
                    entities[entity["id"]] = max(
                        entities.get(entity["id"], 0), len(entity["arrows"]) + len(entity["lines"])
                    )
    assert {"base", "FL_calf_joint"} <= frames
    assert len(frames) == 13
    assert entities == {"contacts": 8, "skeleton": 1}


def test_a_log_of_few_things_is_drawn_as_far_as_it_goes() -> None:
    bare = sf.Log({"time": np.arange(3.0)})
    assert scene.pose_of(bare) is None
    assert skeleton_of(bare) is None
    assert list(scene.contacts(bare, 0, scene.weight_of(bare))) == []
    assert scene.contact_names(bare) == []
    with pytest.raises(ProblemError, match=r"\.rrd"):
        bare.save("log.nothing")
