"""The table of rules: names once, severities known, each on the docs page, each found by some test."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import surefoot
from surefoot.app.cli.lint import lint_of
from surefoot.mechanics.robot.lint.finding import SEVERITIES
from surefoot.mechanics.robot.lint.rules import RULES
from tests.mechanics.robot.lint import models
from tests.mechanics.robot.lint.test_seeded_faults import SEEDS

PAGE = Path(surefoot.__file__).parents[2] / "docs" / "lint.md"
KNEE = (
    '<origin xyz="0 0 -0.2"/><axis xyz="0 1 0"/><limit lower="-2.7" upper="-0.3" effort="30" velocity="20"/>'
)
FIRST = '<joint name="FL_roll"'
BARE_FOOT = (
    '<link name="FL_foot"><inertial><origin xyz="0 0 -0.01"/><mass value="0.05"/><inertia ixx="1e-05" '
    'ixy="0" ixz="0" iyy="1e-05" iyz="0" izz="1e-05"/></inertial>'
)
BOX = '<box size="0.02 0.02 0.1"/>'

MORE = {  # rule: format, what of the file becomes what, place, severity
    "file-unreadable": ("urdf", "<robot", "<robots", "file dog.urdf", "error"),
    "load-refused": ("urdf", 'child link="FL_calf"', 'child link="shin"', "file dog.urdf", "error"),
    "base-twice": (
        "urdf", "</robot>",
        '<link name="floor"/><joint name="free" type="floating"><parent link="floor"/><child link="trunk"/>'
        "</joint></robot>",
        "joint free", "error",
    ),
    "name-twice": ("urdf", "</robot>", '<link name="trunk"/></robot>', "link trunk", "error"),
    "mimic-unknown": ("urdf", KNEE, f'{KNEE}<mimic joint="tail"/>', "joint FL_knee", "error"),
    "mass-missing": (
        "urdf", "</robot>",
        '<link name="tip"/><joint name="tail" type="continuous"><parent link="trunk"/><child link="tip"/>'
        '<limit effort="1" velocity="1"/></joint></robot>',
        "link tip", "warning",
    ),
    "limits-shut": (
        "urdf", KNEE, KNEE.replace('"-2.7" upper="-0.3"', '"0" upper="0"'), "joint FL_knee", "warning"
    ),
    "speed-missing": (
        "urdf", KNEE, KNEE.replace('velocity="20"', 'velocity="0"'), "joint FL_knee", "note"
    ),
    "speed-negative": (
        "urdf", KNEE, KNEE.replace('velocity="20"', 'velocity="-9"'), "joint FL_knee", "error"
    ),
    "pose-outside-limits": (
        "mjcf", '331 1 0 0 0 0 0.7 -1.4', '331 1 0 0 0 0 0.7 0.4', "joint FL_knee", "warning"
    ),
    "sides-differ": ("urdf", KNEE, KNEE.replace('"30"', '"20"'), "joint FL_knee", "warning"),
    "feet-differ": ("urdf", KNEE, KNEE.replace("0 0 -0.2", "0 0 -0.15"), "foot FL_foot", "warning"),
    "foot-without-shape": (
        "urdf",
        f"<collision><geometry>{BOX}</geometry></collision></link>\n{BARE_FOOT}"
        '<collision><geometry><sphere radius="0.02"/></geometry></collision></link>',
        f"</link>\n{BARE_FOOT}</link>",
        "foot FL_foot", "warning",
    ),
    "body-in-ground": (
        "urdf", f"{BOX}</geometry></collision>",
        f'{BOX}</geometry></collision><collision><origin xyz="0.06 0 -0.25"/><geometry>{BOX}'
        "</geometry></collision>",
        "link FL_calf", "error",
    ),
    "shape-empty": ("urdf", BOX, '<box size="0 0.02 0.1"/>', "link FL_calf", "error"),
    "shape-unlike-robot": ("urdf", BOX, '<box size="20 20 100"/>', "link FL_calf", "error"),
    "self-collision": ("urdf", BOX, '<box size="0.6 0.7 0.05"/>', "links of FL_knee", "warning"),
    "actuators-share-joint": (
        "mjcf", "</actuator>", '<motor name="more" joint="FL_knee"/></actuator>', "joint FL_knee", "note"
    ),
    "actuator-useless": ("mjcf", 'joint="FL_knee" ', 'joint="FL_knee" gear="0" ', "FL_knee_motor", "error"),
    "armature-absurd": (
        "mjcf", '"FL_knee" axis', '"FL_knee" armature="1e4" axis', "joint FL_knee", "warning"
    ),
    "joint-moves-nothing": (
        "urdf", "</robot>",
        '<link name="tip"><inertial><mass value="1e-9"/><inertia ixx="1e-14" iyy="1e-14" izz="1e-14" ixy="0" '
        'ixz="0" iyz="0"/></inertial></link><joint name="tail" type="continuous"><parent link="trunk"/>'
        '<child link="tip"/><limit effort="1" velocity="1"/></joint></robot>',
        "joint tail", "warning",
    ),
    "world-unusual": ("mjcf", 'timestep="0.002"', 'timestep="0.05"', "option timestep", "warning"),
}  # fmt: skip


def test_names_stand_once_with_a_known_severity_and_a_remedy() -> None:
    assert len({rule.name for rule in RULES}) == len(RULES)
    assert all(rule.severity in SEVERITIES and rule.remedy.endswith(".") for rule in RULES)


def test_the_page_has_the_table_of_rules() -> None:
    rows = re.findall(r"^\| `([\w-]+)` \| (\w+) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert rows == [(rule.name, rule.severity) for rule in RULES]


def test_every_rule_has_a_fault_in_the_tests() -> None:
    found = {seed.rule for seed in SEEDS} | set(MORE) | {"feet-unknown"}
    assert {rule.name for rule in RULES} == found


@pytest.mark.parametrize("rule", MORE)
def test_its_fault_is_named(rule: str, tmp_path: Path) -> None:
    kind, old, new, place, severity = MORE[rule]
    text = models.urdf() if kind == "urdf" else models.mjcf()
    assert old in text
    path = tmp_path / ("dog.urdf" if kind == "urdf" else "dog.xml")
    path.write_text(text.replace(old, new, 1))
    found = lint_of(str(path), models.FEET)
    named = [one for one in found.findings if one.rule == rule and place in one.place]
    assert named, str(found)
    assert named[0].severity == severity
