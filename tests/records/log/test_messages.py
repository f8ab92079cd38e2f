"""MCAP files and ROS bags: written with the libraries themselves, read back; and files that are broken."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError, SurefootError
from surefoot.records.log.mapping import LogMapping, Take
from surefoot.records.log.reading import read_log, read_source

mcap_writer = pytest.importorskip("mcap.writer")
pytest.importorskip("rosbags")
pytest.importorskip("mcap_ros2")
pytest.importorskip("mcap_protobuf")
DATA = Path(__file__).parent / "data"
NAMES = ["hip", "thigh", "calf"]
START = 1_700_000_000_000_000_000
N = 50


def joints(k: int) -> np.ndarray:
    return np.array([0.1, 0.2, 0.3]) * np.sin(0.05 * k + np.arange(3))


def rates(k: int) -> np.ndarray:
    return np.array([0.1, 0.2, 0.3]) * 5.0 * np.cos(0.05 * k + np.arange(3))


def joint_state(k: int) -> dict[str, Any]:
    return {"name": NAMES, "position": joints(k).tolist(), "velocity": rates(k).tolist(), "effort": []}


def imu_reading(k: int) -> dict[str, Any]:
    return {"linear_acceleration": {"x": k // 2, "y": 0, "z": 9.8}}


def check(log: sf.Log, first: int = 0) -> None:
    """Joints at 100 Hz and an IMU at 50 Hz, held."""
    count = len(log)
    assert count in (N, N - 1)
    np.testing.assert_allclose(np.diff(log["time"]), 0.01, atol=1e-9)
    at = np.arange(N)[N - count :]
    np.testing.assert_allclose(log["joint_positions"], [joints(k) for k in at], atol=1e-15)
    np.testing.assert_allclose(log["joint_velocities"], [rates(k) for k in at], atol=1e-15)
    np.testing.assert_allclose(log["imu_acceleration"][:, 0], at // 2)
    assert log.facts["joints"] == NAMES
    assert log.facts["start"] == pytest.approx(1e-9 * START)
    assert any("every 20 ms and is held for rows every 10 ms" in d for d in log.doubts)


def write_json(path: Path) -> Path:
    with path.open("wb") as file:
        writer = mcap_writer.Writer(file)
        writer.start()
        number = {}
        for topic, kind in (("/joints", "sensor_msgs/JointState"), ("/imu", "sensor_msgs/Imu")):
            schema = writer.register_schema(name=kind, encoding="jsonschema", data=b"{}")
            number[topic] = writer.register_channel(topic=topic, message_encoding="json", schema_id=schema)
        other = writer.register_channel(topic="/camera", message_encoding="jpeg", schema_id=0)
        writer.add_message(other, log_time=START, publish_time=START, data=b"\xff")
        for k in range(N):
            stamp = START + k * 10_000_000
            writer.add_message(number["/joints"], stamp, json.dumps(joint_state(k)).encode(), stamp)
            if k % 2 == 0:
                writer.add_message(number["/imu"], stamp, json.dumps(imu_reading(k)).encode(), stamp)
        writer.finish()
    return path


def test_mcap_with_json(tmp_path: Path) -> None:
    log = read_log(write_json(tmp_path / "a.mcap"))
    check(log)
    assert "/camera is jpeg: not read" in log.doubts


def test_joints_are_picked_by_name(tmp_path: Path) -> None:
    path = write_json(tmp_path / "a.mcap")
    takes = {
        "joint_positions": Take(("/joints.position",)),
        "imu_acceleration": Take(("/imu.linear_acceleration",)),
    }
    log = read_log(path, LogMapping(takes, joints=("calf", "hip")))
    np.testing.assert_allclose(log["joint_positions"][3], joints(3)[[2, 0]])
    with pytest.raises(ProblemError, match="/joints has no joint 'knee'; it has: hip, thigh, calf"):
        read_log(path, LogMapping(takes, joints=("knee",)))
    with pytest.raises(
        ProblemError, match=r"no field '/joints.speed'; it has: /joints.position, /joints.vel"
    ):
        read_log(path, LogMapping({"joint_velocities": Take(("/joints.speed",))}))
    assert read_source(path).topics["/joints"].kind == "sensor_msgs/JointState"


def test_efforts_and_names_of_another_length_are_left_out(tmp_path: Path) -> None:
    """A driver that names one joint too few, and gives efforts of some: angles are read, the rest is told."""
    path = tmp_path / "odd.mcap"
    with path.open("wb") as file:
        writer = mcap_writer.Writer(file)
        writer.start()
        schema = writer.register_schema("sensor_msgs/JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/joints", "json", schema)
        for k in range(N):
            row = joint_state(k) | {"name": NAMES[:2], "effort": [1.0, 2.0]}
            stamp = START + k * 10_000_000
            writer.add_message(channel, stamp, json.dumps(row).encode(), stamp)
        writer.finish()
    log = sf.read_log(path)
    np.testing.assert_allclose(log["joint_positions"], [joints(k) for k in range(N)], atol=1e-15)
    assert "torques" not in log
    assert "torques: 2 numbers for 3 joints, left out" in log.doubts
    assert "/joints names 2 joints for 3 numbers: its names are not used" in log.doubts


def test_mcap_with_protobuf(tmp_path: Path) -> None:
    from google.protobuf.struct_pb2 import Struct
    from google.protobuf.wrappers_pb2 import DoubleValue
    from mcap_protobuf.writer import Writer

    with (tmp_path / "a.mcap").open("wb") as file, Writer(file) as writer:
        for k in range(N):
            stamp = START + k * 10_000_000
            writer.write_message("/mu", DoubleValue(value=0.5 + 0.01 * k), stamp, stamp)
        writer.write_message("/struct", Struct(), START, START)
    log = read_log(tmp_path / "a.mcap", LogMapping({"mu": Take(("/mu.value",))}))
    np.testing.assert_array_equal(log["mu"], 0.5 + 0.01 * np.arange(N))
    np.testing.assert_allclose(log["time"], 0.01 * np.arange(N), atol=1e-9)


def ros_messages(store: Any) -> list[tuple[str, str, int, Any]]:
    kinds = store.types
    stamp_of, header_of = kinds["builtin_interfaces/msg/Time"], kinds["std_msgs/msg/Header"]
    vector, quaternion = kinds["geometry_msgs/msg/Vector3"], kinds["geometry_msgs/msg/Quaternion"]
    out = []
    for k in range(N):
        at = START + k * 10_000_000
        seconds = stamp_of(sec=at // 10**9, nanosec=at % 10**9)
        more = {"seq": k} if "seq" in header_of.__dataclass_fields__ else {}
        header = header_of(stamp=seconds, frame_id="imu", **more)
        state = kinds["sensor_msgs/msg/JointState"](
            header=header, name=NAMES, position=joints(k), velocity=rates(k), effort=np.zeros(0)
        )
        late = at + 3_000_000  # the recorder is late, the stamps are right
        out.append(("/joint_states", "sensor_msgs/msg/JointState", late, state))
        if k % 2 == 0:
            imu = kinds["sensor_msgs/msg/Imu"](
                header=header,
                orientation=quaternion(x=0.0, y=0.0, z=0.0, w=1.0),
                orientation_covariance=np.zeros(9),
                angular_velocity=vector(x=0.0, y=0.0, z=0.0),
                angular_velocity_covariance=np.zeros(9),
                linear_acceleration=vector(x=float(k // 2), y=0.0, z=9.8),
                linear_acceleration_covariance=np.zeros(9),
            )
            out.append(("/imu", "sensor_msgs/msg/Imu", late, imu))
    return out


def write_all(writer: Any, store: Any, serialize: Callable[[Any, str], Any]) -> None:
    known = {}
    for topic, kind, at, message in ros_messages(store):
        if topic not in known:
            known[topic] = writer.add_connection(topic, kind, typestore=store)
        writer.write(known[topic], at, serialize(message, kind))


def test_a_bag_of_ros_2(tmp_path: Path) -> None:
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(tmp_path / "walk", version=9) as writer:
        write_all(writer, store, store.serialize_cdr)
    check(read_log(tmp_path / "walk"))
    check(read_log(next((tmp_path / "walk").glob("*.db3"))))
    (tmp_path / "walk" / "metadata.yaml").unlink()
    with pytest.raises(ProblemError, match=r"a \.db3 is read with the metadata\.yaml of its bag"):
        read_log(next((tmp_path / "walk").glob("*.db3")))


def write_ros1(path: Path) -> Path:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer(path) as writer:
        write_all(writer, store, store.serialize_ros1)
    return path


def test_a_bag_of_ros_1(tmp_path: Path) -> None:
    check(read_log(write_ros1(tmp_path / "walk.bag")))


def test_mcap_with_ros_2_messages(tmp_path: Path) -> None:
    from mcap_ros2.writer import Writer

    text = "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    imu = "V linear_acceleration\n" + "=" * 40 + "\nMSG: test/V\nfloat64 x\nfloat64 y\nfloat64 z"
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file)
        kinds = {
            "/j": writer.register_msgdef("sensor_msgs/msg/JointState", text),
            "/i": writer.register_msgdef("test/Imu", imu),
        }
        for k in range(N):
            at = START + k * 10_000_000
            writer.write_message("/j", kinds["/j"], joint_state(k), at, at)
            if k % 2 == 0:
                writer.write_message("/i", kinds["/i"], imu_reading(k), at, at)
        writer.finish()
    check(read_log(tmp_path / "a.mcap"))


@pytest.mark.parametrize("name", ["stand", "walk"])
def test_a_log_comes_back_from_mcap_to_the_last_bit(name: str, tmp_path: Path) -> None:
    log = read_log(DATA / f"{name}.npz")
    log.arrays["mu"] = np.where(np.arange(len(log)) == 3, np.nan, log["mu"])
    log.arrays["gaps"] = np.where(np.arange(len(log))[:, None] == 4, np.inf, log["gaps"])
    path = log.save(tmp_path / "log.mcap")
    again = read_log(path)
    assert set(again.arrays) == set(log.arrays)
    for channel, array in log.arrays.items():
        np.testing.assert_array_equal(again[channel], array)
        assert again[channel].dtype == array.dtype
    assert again.facts == log.facts
    with path.open("rb") as file:
        from mcap.reader import make_reader

        for _, _, message in make_reader(file).iter_messages():
            json.loads(message.data, parse_constant=lambda c: pytest.fail(f"{c} is no JSON"))


def one_line(path: Path) -> str:
    """Return how reading fails; empty if it does not."""
    try:
        read_log(path)
    except SurefootError as error:
        told = str(error)
    else:
        told = ""
    assert "\n" not in told
    return told


def test_broken_files_are_one_line(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    sound = {
        "a.mcap": write_json(tmp_path / "sound.mcap").read_bytes(),
        "a.bag": write_ros1(tmp_path / "sound.bag").read_bytes(),
        "a.csv": b"time,FL_force,FR_force\n" + b"".join(b"%d,1,2\n" % k for k in range(200)),
    }
    for name, whole in sound.items():
        path = tmp_path / name
        for size in (0, 1, 7, 20, len(whole) // 3, len(whole) // 2, len(whole) - 3):
            path.write_bytes(whole[:size])
            told = one_line(path)
            assert told or name.endswith(".csv"), (name, size)  # a table cut after a row is a table
        for _ in range(60):
            spoilt = bytearray(whole)
            for at in rng.integers(0, len(whole), 6):
                spoilt[at] = rng.integers(0, 256)
            path.write_bytes(spoilt)
            one_line(path)
        path.write_bytes(rng.bytes(4000))
        assert one_line(path)
    (tmp_path / "x.bag").mkdir()
    assert one_line(tmp_path / "x.bag")
    assert "missing.mcap" in one_line(tmp_path / "missing.mcap")
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "metadata.yaml").write_text("{")
    assert one_line(tmp_path / "bag")


def test_names_that_change_their_order_are_refused(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = mcap_writer.Writer(file)
        writer.start()
        channel = writer.register_channel(topic="/j", message_encoding="json", schema_id=0)
        for k, names in enumerate((["a", "b"], ["b", "a"])):
            told = json.dumps({"name": names, "position": [0.0, 1.0]}).encode()
            writer.add_message(channel, k * 10**7, told, k * 10**7)
        writer.finish()
    with pytest.raises(ProblemError, match=r"/j\.name changes at message 2: the order must stay the same"):
        read_log(tmp_path / "a.mcap")
