"""Files that are too large for a robot: refused before a parser sees them, in one line and little memory."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from surefoot.base.errors import ModelError
from surefoot.mechanics.robot.model_size import MOST_JOINTS, check_size

MEMORY = 1_500_000_000
"""Address space of the process that reads one [bytes]."""


def chain(count: int, kind: str = "revolute") -> str:
    """Return a URDF of so many joints one after the other."""
    links = "".join(f'<link name="l{k}"/>' for k in range(count + 1))
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    joints = "".join(
        f'<joint name="j{k}" type="{kind}"><parent link="l{k}"/><child link="l{k + 1}"/>{limit}</joint>'
        for k in range(count)
    )
    return f'<robot name="chain">{links}{joints}</robot>'


def nested(depth: int, count: int) -> str:
    """Return an MJCF file of replicates in replicates."""
    body = '<body><freejoint/><geom size="0.1"/></body>'
    for _ in range(depth):
        body = f'<replicate count="{count}" offset="0.1 0 0">{body}</replicate>'
    return f"<mujoco><worldbody>{body}</worldbody></mujoco>"


LARGE = {
    "five-thousand.urdf": (chain(5000), "links: 1001, at most 1000"),
    "thousand.urdf": (chain(999), f"joints that move: {MOST_JOINTS + 1}"),
    "fixed.urdf": (chain(5000, "fixed"), "links: 1001"),
    "nested.urdf": ("<robot>" + "<a>" * 2000 + "</a>" * 2000 + "</robot>", "nested tags: 1001"),
    "replicate.xml": (nested(5, 30), "tags: 837932"),
    "flex.xml": ('<mujoco><worldbody><flexcomp count="300 300 300"/></worldbody></mujoco>', "tags: 27000002"),
    "texture.xml": (
        '<mujoco><asset><texture builtin="flat" width="90000" height="90000"/></asset></mujoco>',
        "24300000000 in <texture>",
    ),
    "hfield.xml": ('<mujoco><asset><hfield nrow="90000" ncol="90000"/></asset></mujoco>', "in <hfield>"),
    "memory.xml": ('<mujoco><size memory="64G"/></mujoco>', "in <size>"),
    "itself.xml": ('<mujoco><include file="itself.xml"/></mujoco>', "files: 51"),
}


@pytest.mark.parametrize("name", LARGE)
def test_a_large_file_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(LARGE[name][0])
    with pytest.raises(ModelError, match="too large for a robot") as caught:
        check_size(path)
    assert LARGE[name][1] in str(caught.value)


@pytest.mark.long
@pytest.mark.parametrize("name", ["five-thousand.urdf", "thousand.urdf", "replicate.xml"])
@pytest.mark.parametrize("command", ["model", "lint"])
def test_commands_refuse_it_with_little_memory_and_time(name: str, command: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(LARGE[name][0])
    code = (
        f"import resource, sys; resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY})); "
        "resource.setrlimit(resource.RLIMIT_CPU, (30, 30)); "
        "from surefoot.app.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    done = subprocess.run([sys.executable, "-c", code, command, str(path)], capture_output=True, text=True)
    assert done.returncode == (2 if command == "model" else 1), done.stderr
    assert "too large for a robot" in done.stderr + done.stdout


def test_robots_pass(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    transmissions = "".join(f'<transmission><joint name="j{k}"/></transmission>' for k in range(MOST_JOINTS))
    path.write_text(chain(MOST_JOINTS).replace("</robot>", f"{transmissions}</robot>"))
    check_size(path)
    scene = tmp_path / "scene.xml"
    boxes = '<geom type="box" size="1 1 1"/>' * 5000
    scene.write_text(f'<mujoco><worldbody>{boxes}<body><joint name="a"/></body></worldbody></mujoco>')
    check_size(scene)
    (tmp_path / "no.xml").write_text("no xml")
    check_size(tmp_path / "no.xml")
