"""`surefoot lint`: exit codes, JSON, words, and the line of `surefoot check`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.mechanics.robot.lint import models

CALF = 'name="FL_calf"><inertial><origin xyz="0 0 -0.01"/><mass value="'


@pytest.fixture
def heavy(tmp_path: Path) -> Path:
    """Return a file whose left front calf weighs 200 kg."""
    path = tmp_path / "dog.urdf"
    path.write_text(models.urdf().replace(f"{CALF}0.2", f"{CALF}200"))
    return path


def test_a_clean_robot_exits_0(answer: Callable[..., Any], printed: Callable[..., str]) -> None:
    found = answer("lint", "go2")
    assert found["ok"] is True
    assert (found["errors"], found["warnings"], found["notes"], found["findings"]) == (0, 0, 0, [])
    assert "Surefoot's worlds" in found["world"]
    assert printed("lint", "go2").startswith("go2: 0 errors, 0 warnings, 0 notes; walks in Surefoot's worlds")


def test_an_error_exits_1_and_is_named(
    heavy: Path, answer: Callable[..., Any], printed: Callable[..., str]
) -> None:
    found = answer("lint", heavy, "--feet", models.FEET, code=1)
    assert found["errors"] == 1
    (first,) = found["findings"]
    assert set(first) == {"rule", "severity", "place", "value", "detail", "remedy"}
    assert (first["rule"], first["place"], first["value"]) == (
        "mass-unlike-kin",
        "link FL_calf",
        "mass 200 kg",
    )
    assert "error mass-unlike-kin: link FL_calf: mass 200 kg" in printed("lint", heavy, code=1)


def test_a_file_that_does_not_load_has_a_lint(tmp_path: Path, answer: Callable[..., Any]) -> None:
    path = tmp_path / "dog.urdf"
    path.write_text(models.urdf().replace('lower="-2.7" upper="-0.3"', 'lower="2.7" upper="-0.3"', 1))
    rules = [finding["rule"] for finding in answer("lint", path, code=1)["findings"]]
    assert rules == ["load-refused", "limits-crossed"]


def test_wrong_input_exits_2_in_one_line(heavy: Path, printed: Callable[..., str]) -> None:
    for words in (("cat",), ("cat.urdf",), (heavy, "--feet", "paw")):
        said = printed("lint", *words, code=2)
        assert len(said.splitlines()) == 1


def test_check_says_that_the_lint_has_errors(
    heavy: Path, answer: Callable[..., Any], printed: Callable[..., str]
) -> None:
    words = ("check", heavy, "--feet", models.FEET, "--no-picture")
    said = printed(*words, code=1)
    assert "lint: 1 error in its model, as mass-unlike-kin at link FL_calf (mass 200 kg)" in said
    assert answer("check", "go2", "--no-picture")["lint"] is None
