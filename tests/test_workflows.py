"""What a public repository runs for every change: its files are read, and call what there is."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
FLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))


def flow(name: str) -> Any:
    """Return a workflow."""
    return yaml.safe_load((ROOT / ".github" / "workflows" / f"{name}.yml").read_text(encoding="utf-8"))


def test_there_is_one_for_each_task() -> None:
    assert {path.stem for path in FLOWS} == {"build", "docs", "lint", "nightly", "test"}


@pytest.mark.parametrize("path", FLOWS, ids=lambda path: path.stem)
def test_a_workflow_runs_targets_and_files_that_there_are(path: Path) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    steps = [step for job in flow(path.stem)["jobs"].values() for step in job["steps"]]
    assert steps[0]["uses"].startswith("actions/checkout@")
    for command in (step["run"] for step in steps if "run" in step):
        words = command.split()
        if words[0] == "make":
            assert set(words[1:]) <= targets, command
        for word in words:
            if re.match(r"(tests|examples|\.ci)/", word):
                assert (ROOT / word).exists(), command


def test_the_pythons_and_systems_that_are_tried() -> None:
    jobs = flow("test")["jobs"]
    pythons = ["3.11", "3.12", "3.13"]
    assert [jobs[name]["strategy"]["matrix"]["python"] for name in ("quick", "elsewhere")] == [pythons] * 2
    assert jobs["elsewhere"]["strategy"]["matrix"]["system"] == ["macos-latest", "windows-latest"]
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert all(f'"Programming Language :: Python :: {python}"' in project for python in pythons)


def test_a_night_takes_the_newest_of_what_we_depend_on_most() -> None:
    packages = flow("nightly")["jobs"]["newest"]["strategy"]["matrix"]["package"]
    assert {"numba", "mujoco", "pin"} <= set(packages)


@pytest.mark.parametrize("path", FORMS, ids=lambda path: path.stem)
def test_a_form_asks_for_something(path: Path) -> None:
    form = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert form["name"]
    assert form["description"]
    fields = [item for item in form["body"] if item["type"] == "textarea"]
    assert any(item.get("validations", {}).get("required") for item in fields)
    assert len({item["id"] for item in fields if "id" in item}) == len([i for i in fields if "id" in i])
