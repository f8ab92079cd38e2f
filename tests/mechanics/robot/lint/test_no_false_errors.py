"""Robots that are as they should be get no errors, whatever their size and kind; bad files get one."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import surefoot as sf
from surefoot.app.cli.lint import lint_of
from surefoot.base.errors import ModelError
from tests.mechanics.robot.lint import models


@pytest.mark.parametrize("name", sf.robot_names())
@pytest.mark.sampled(10)
def test_no_robot_of_the_catalogue_has_an_error(name: str) -> None:
    found = lint_of(name)
    assert found.ok, str(found)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_robot_of_other_masses_altogether_has_no_error(factor: float, tmp_path: Path) -> None:
    def scaled(match: re.Match[str]) -> str:
        return f'{match[1]}="{float(match[2]) * factor}"'

    path = tmp_path / "dog.urdf"
    path.write_text(re.sub(r"(mass value|i[xyz][xyz])=\"([^\"]+)\"", scaled, models.urdf()))
    assert lint_of(str(path), models.FEET).ok


@pytest.mark.parametrize("factor", [1e-2, 10.0])
def test_a_robot_of_another_size_altogether_has_no_error(factor: float, tmp_path: Path) -> None:
    def stretched(match: re.Match[str]) -> str:
        return f'{match[1]}="{" ".join(str(float(x) * factor) for x in match[2].split())}"'

    def turned(match: re.Match[str]) -> str:
        return f'{match[1]}="{float(match[2]) * factor**2}"'

    text = re.sub(r"(origin xyz|size|radius|length)=\"([^\"]+)\"", stretched, models.urdf())
    path = tmp_path / "dog.urdf"
    path.write_text(re.sub(r"(i[xyz][xyz])=\"([^\"]+)\"", turned, text))
    found = lint_of(str(path), models.FEET)
    assert found.ok, str(found)


def test_a_link_whose_shape_has_a_name_has_a_shape(tmp_path: Path) -> None:
    path = tmp_path / "dog.xml"
    path.write_text(models.mjcf())
    found = lint_of(str(path), models.FEET.replace("_foot", "_calf"))
    assert "foot-without-shape" not in {one.rule for one in found.findings}


def test_a_cart_without_feet_has_no_error(tmp_path: Path) -> None:
    wheels = re.sub(r'type="revolute"', 'type="continuous"', models.urdf())
    path = tmp_path / "cart.urdf"
    path.write_text(re.sub(r'lower="[^"]+" upper="[^"]+" ', "", wheels))
    found = lint_of(str(path))
    assert found.ok
    assert {f.rule for f in found.findings} == {"feet-unknown"}


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "not XML"), ("a robot", "not XML"), ("<robot", "not XML"), ("<sdf/>", "first tag is <sdf>")],
)
def test_what_is_no_robot_is_named(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "dog.urdf"
    path.write_text(text)
    (finding,) = lint_of(str(path)).errors
    assert finding.rule == "file-unreadable"
    assert words in finding.detail


def test_an_mjcf_that_cannot_be_parsed_is_named(tmp_path: Path) -> None:
    path = tmp_path / "dog.xml"
    path.write_text('<mujoco><worldbody><bodi name="a"/></worldbody></mujoco>')
    (finding,) = lint_of(str(path)).errors
    assert finding.rule == "file-unreadable"
    assert "bodi" in finding.detail


def test_wrong_input_is_no_finding(tmp_path: Path) -> None:
    (tmp_path / "dog.urdf").write_text(models.urdf())
    with pytest.raises(ModelError, match="unknown foot frame"):
        lint_of(str(tmp_path / "dog.urdf"), "paw")
    with pytest.raises(ModelError, match="no URDF file"):
        lint_of(str(tmp_path / "cat.urdf"))
    with pytest.raises(ModelError, match="unknown robot"):
        lint_of("cat")
