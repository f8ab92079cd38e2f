"""Joints of limbs without a range in their URDF get half a turn either way; wheels go on turning."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

import surefoot as sf
from benchmarks.legged import write_legged
from surefoot.mechanics.robot.urdf_ranges import whole_turns


def without_ranges(tmp_path: Path, kind: str) -> tuple[Path, list[str]]:
    """Return a robot of four legs whose thighs say nothing of their range."""
    path, feet = write_legged(tmp_path, 4)
    text = path.read_text(encoding="utf-8")
    joint = r'(<joint name="\w+_thigh_joint" type=")revolute(".*?<limit )lower="[^"]*" upper="[^"]*" '
    text, count = re.subn(joint, rf"\g<1>{kind}\g<2>", text, flags=re.DOTALL)
    assert count == 4
    path.write_text(text, encoding="utf-8")
    return path, feet


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
def test_limbs_get_half_a_turn_and_say_so(tmp_path: Path, kind: str) -> None:
    path, feet = without_ranges(tmp_path, kind)
    robot = sf.load_robot(path, feet=feet)
    assert robot.model.nq == robot.model.nv + 1
    thighs = [k for k, name in enumerate(robot.joint_names) if "thigh" in name]
    assert len(thighs) == 4
    for k in range(robot.joints):
        whole = robot.model.upperPositionLimit[7 + k] == math.pi
        assert whole == (k in thighs)
    (note,) = [note for note in robot.notes if "without a range" in note]
    assert robot.joint_names[thighs[0]] in note
    verdict = sf.can_stand(robot.stance(sf.place(robot, sf.FlatTerrain()), mu=0.6), robot.com(), robot.mass)
    assert verdict


def test_a_file_with_ranges_and_wheels_is_left_alone(tmp_path: Path) -> None:
    path, _ = write_legged(tmp_path, 4)
    assert whole_turns(path) == ("", ())
    text = path.read_text(encoding="utf-8")
    wheel = '<link name="wheel"/><joint name="turning" type="continuous"><parent link="body"/>'
    wheel += '<child link="wheel"/><axis xyz="0 1 0"/></joint></robot>'
    path.write_text(text.replace("</robot>", wheel), encoding="utf-8")
    assert whole_turns(path) == ("", ())
    path.write_text("no XML", encoding="utf-8")
    assert whole_turns(path) == ("", ())
