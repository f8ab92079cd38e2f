"""Files of one's own that are no logs: each is told what it is, in a line without a library's words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

BAG = b"#ROSBAG V2.0\n" + (4).to_bytes(4, "little") + b"op=\x03" + (2).to_bytes(4, "little") + b"xx"
MCAP = b"\x89MCAP0\r\n\x01" + (4).to_bytes(8, "little") + b"abcd"
FILES = {
    "bad.bag": (b"#ROSBAG V2.1\n", "byte 11 is wrong: such files begin with b'#ROSBAG V2.0"),
    "cut.bag": (BAG + BAG[13:-1], f"the record at byte {len(BAG)} is spoilt, or the file is cut"),
    "text.mcap": (b"hello", "byte 0 is wrong"),
    "cut.mcap": (MCAP + b"\x02\xff\xff\xff\xff\x00\x00\x00\x00", f"the record at byte {len(MCAP)}"),
    "text.npz": (b"no archive", "it is no .npz archive, or cut"),
}


@pytest.mark.parametrize("name", FILES)
def test_a_spoilt_file_is_told_its_first_wrong_byte(name: str, tmp_path: Path, printed: Any) -> None:
    content, words = FILES[name]
    (tmp_path / name).write_bytes(content)
    said = printed("audit", tmp_path / name, code=2)
    assert words in said
    assert said.count("\n") == 1


def test_arrays_folders_and_pushes_are_told_where_they_go(tmp_path: Path, printed: Any) -> None:
    np.savez(tmp_path / "plain.npz", qpos=np.zeros((5, 19)), forces=np.zeros((5, 4, 3)))
    np.savez(tmp_path / "pickled.npz", forces=np.array([{}], dtype=object))
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "notes.txt").write_text("")
    (tmp_path / "half").mkdir()
    (tmp_path / "half" / "facts.json").write_text('{"schema": 2, ')
    (tmp_path / "pushes.csv").write_text("time,force\n0,1\n")
    expected = {
        "audit plain.npz": "the mapping must say which column is the time: time: NAME; or the rate",
        "audit pickled.npz": "holds pickled Python objects, which are not loaded: save numbers, np.savez(",
        "audit folder": "neither facts.json, as what a killed run leaves has, nor metadata.yaml, as a ROS 2 "
        "bag has; it holds notes.txt",
        "audit half": "facts.json is no JSON from byte 14 on",
        "audit none.npz": "there is no such file",
        "identify pushes.csv": "is a leg's log: --model must name its URDF or MJCF file",
        "identify pickled.npz": "it has no states, starts, dt; it holds: forces",
    }
    for words, said in expected.items():
        command, name = words.split()
        assert said in printed(command, tmp_path / name, code=2)
