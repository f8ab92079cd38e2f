"""Thirty faults put into a robot without one, each by itself: the lint names rule, place and value."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from surefoot.app.cli.lint import lint_of
from surefoot.mechanics.robot.lint import Lint
from tests.mechanics.robot.lint import models


class Seed(NamedTuple):
    """A fault: what of the file becomes what, and how the lint should name it."""

    format: str
    old: str
    new: str
    rule: str
    place: str
    value: str
    severity: str


CALF = 'name="FL_calf"><inertial><origin xyz="0 0 -0.01"/><mass value="0.2"/><inertia ixx="0.001"'
TRUNK = '<mass value="8.0"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'
THIGH = 'mass value="0.8"/><inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.004"/>'
ROLL = '<origin xyz="0.2 0.1 0"/><axis xyz="1 0 0"/>'
KNEE = (
    '<joint name="FL_knee" type="revolute"><parent link="FL_thigh"/><child link="FL_calf"/>'
    '<origin xyz="0 0 -0.2"/><axis xyz="0 1 0"/><limit lower="-2.7" upper="-0.3" effort="30" velocity="20"/>'
)
HIP = (
    'name="FL_hip" pos="0.2 0.1 0"><inertial pos="0 0 -0.01" mass="0.5" diaginertia="0.0005 0.0005 0.0005"/>'
)
FOOT = 'name="FL_foot" type="sphere" size="0.02" pos="0 0 -0.2" solref="0.004 1" solimp="0.99 0.999 0.001"'
MOTOR = '<motor name="FL_knee_motor" joint="FL_knee" ctrlrange="-30 30"/>'

SEEDS = (
    Seed("urdf", CALF, CALF.replace("0.2", "-0.2"), "mass-negative", "link FL_calf", "-0.2 kg", "error"),
    Seed("urdf", CALF, CALF.replace("0.2", "200"), "mass-unlike-kin", "link FL_calf", "200 kg", "error"),
    Seed("urdf", CALF, CALF.replace("0.2", "2e-10"), "mass-unlike-kin", "link FL_calf", "2e-10 kg", "error"),
    Seed("urdf", TRUNK, TRUNK.replace("8.0", "8000"), "mass-unlike-kin", "link trunk", "8000 kg", "error"),
    Seed(
        "urdf",
        THIGH,
        THIGH.replace("0.004", "4"),
        "inertia-unlike-kin",
        "link FL_thigh",
        "(4, 4, 4)",
        "error",
    ),
    Seed(
        "urdf", TRUNK, TRUNK.replace('"0.1"', '"1e-10"'), "inertia-unlike-kin", "link trunk", "1e-10", "error"
    ),
    Seed(
        "urdf",
        TRUNK,
        TRUNK.replace('izz="0.1"', 'izz="0.5"'),
        "inertia-triangle",
        "link trunk",
        "0.5",
        "warning",
    ),
    Seed(
        "urdf",
        TRUNK,
        TRUNK.replace('izz="0.1"', 'izz="-0.1"'),
        "inertia-negative",
        "link trunk",
        "-0.1",
        "error",
    ),
    Seed("urdf", CALF, CALF.replace("0 0 -0.01", "0 0 -100"), "com-far", "link FL_calf", "-100", "error"),
    Seed(
        "urdf", CALF, CALF.replace("0.2", "nan"), "not-a-number", "link FL_calf, mass value", "nan", "error"
    ),
    Seed("urdf", KNEE, KNEE.replace('"-2.7"', '"0.7"'), "limits-crossed", "joint FL_knee", "0.7", "error"),
    Seed(
        "urdf", KNEE, KNEE.replace('"-2.7"', '"-1e10"'), "limits-absurd", "joint FL_knee", "-1e+10", "warning"
    ),
    Seed(
        "urdf",
        KNEE,
        KNEE.replace('"-2.7" upper="-0.3"', '"-155" upper="-17"'),
        "limits-in-degrees",
        "joint FL_knee",
        "-155 to -17",
        "error",
    ),
    Seed("urdf", KNEE, KNEE.split("<limit")[0], "limits-missing", "joint FL_knee", "no <limit>", "error"),
    Seed(
        "urdf",
        KNEE,
        KNEE.replace('effort="30"', 'effort="0"'),
        "effort-missing",
        "joint FL_knee",
        "0",
        "warning",
    ),
    Seed("urdf", KNEE, KNEE.replace('"30"', '"3e7"'), "effort-absurd", "joint FL_knee", "3e+07", "warning"),
    Seed("urdf", KNEE, KNEE.replace("0 1 0", "0 0 0"), "axis-zero", "joint FL_knee", "(0, 0, 0)", "error"),
    Seed(
        "urdf",
        ROLL,
        ROLL.replace("0.2 0.1 0", "200 100 0"),
        "offset-unlike-kin",
        "joint FL_roll",
        "200",
        "error",
    ),
    Seed(
        "urdf",
        "</robot>",
        '<transmission name="spare"><joint name="tail"/></transmission></robot>',
        "actuator-without-joint",
        "actuator spare",
        "tail",
        "warning",
    ),
    Seed(
        "urdf", 'child link="FL_calf"', 'child link="shin"', "tree-broken", "joint FL_knee", "shin", "error"
    ),
    Seed(
        "urdf",
        '<box size="0.4 0.2 0.1"/>',
        '<mesh filename="trunk.stl"/>',
        "mesh-missing",
        "link trunk",
        "trunk.stl",
        "warning",
    ),
    Seed(
        "urdf",
        '<collision><geometry><sphere radius="0.02"/></geometry></collision></link>\n<joint name="FL_roll"',
        '</link>\n<joint name="FL_roll"',
        "load-refused",
        "file dog.urdf",
        "does not load",
        "error",
    ),
    Seed("mjcf", HIP, HIP.replace("0.5", "500"), "mass-unlike-kin", "link FL_hip", "500 kg", "error"),
    Seed(
        "mjcf",
        HIP,
        HIP.replace("0.0005 0.0005 0.0005", "0.0005 0.0005 0.005"),
        "inertia-triangle",
        "link FL_hip",
        "0.005",
        "error",
    ),
    Seed(
        "mjcf", 'joint="FL_knee"', 'joint="knee"', "actuator-without-joint", "FL_knee_motor", "knee", "error"
    ),
    Seed("mjcf", MOTOR, "", "joint-without-actuator", "joint FL_knee", "no actuator", "error"),
    Seed(
        "mjcf",
        FOOT,
        FOOT.replace("0.004 1", "0.3 1").replace("0.99 0.999", "0.9 0.95"),
        "contact-sinks",
        "foot body FL_calf",
        "sinks",
        "error",
    ),
    Seed(
        "mjcf",
        '"FL_knee" axis="0 1 0" range="-2.7 -0.3"',
        '"FL_knee" axis="0 1 0" range="-2.7 -0.3" damping="500"',
        "step-unstable",
        "joint FL_knee",
        "500",
        "warning",
    ),
    Seed(
        "mjcf",
        'qpos="0 0 0.331',
        'qpos="0 0 0.25',
        "start-in-ground",
        "keyframe home",
        "mm in the floor",
        "warning",
    ),
    Seed("mjcf", '<compiler angle="radian"/>', "", "limits-in-degrees", "joint FL_roll", "-0.014", "error"),
)


def lint_with(seed: Seed, folder: Path) -> Lint:
    """Return the lint of the robot with a fault."""
    text = models.urdf() if seed.format == "urdf" else models.mjcf()
    assert seed.old in text
    text = text.replace(seed.old, seed.new, 1)
    path = folder / ("dog.urdf" if seed.format == "urdf" else "dog.xml")
    path.write_text(text)
    found: Lint = lint_of(str(path), models.FEET)
    return found


@pytest.mark.parametrize("seed", SEEDS, ids=lambda seed: f"{seed.format}-{seed.rule}-{seed.value}")
def test_a_seeded_fault_is_named(seed: Seed, tmp_path: Path) -> None:
    found = lint_with(seed, tmp_path)
    named = [
        f for f in found.findings if f.rule == seed.rule and seed.place in f.place and seed.value in f.value
    ]
    assert named, f"{seed}\n{found}"
    assert named[0].severity == seed.severity, str(named[0])
    assert named[0].remedy
    assert named[0].detail
    assert found.ok is (seed.severity != "error" and not found.errors)


def test_there_are_thirty() -> None:
    assert len(SEEDS) == 30


@pytest.mark.parametrize("name", ["dog.urdf", "dog.xml"])
def test_the_clean_twin_has_nothing(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(models.urdf() if name.endswith("urdf") else models.mjcf())
    assert not lint_of(str(tmp_path / name), models.FEET).findings
