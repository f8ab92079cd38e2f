"""`surefoot doctor` tells what is there, and exits 1 only where the base install is broken."""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import sys
from typing import Any

import pytest

from surefoot.app.cli import doctor
from surefoot.base import compilation


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the process that draws import nothing."""
    monkeypatch.setattr(doctor, "TRY", "")


def test_it_tells_versions_blas_and_kernels(answer: Any) -> None:
    facts = answer("doctor")
    assert facts["sound"] is True
    versions = {p["name"]: p["version"] for p in facts["base"]}
    assert versions["numba"] == importlib.metadata.version("numba")
    assert {"numpy", "scipy", "typer"} <= set(versions)
    assert facts["blas"]["name"] != "unknown"
    assert facts["numba"]["works"] is True
    assert {"robot", "sim", "viz", "qp", "files"} <= set(facts["extras"])
    assert "all" not in facts["extras"]
    assert {p["name"] for p in facts["extras"]["robot"] if p["fits"]} == {"pin", "example-robot-data"}


@pytest.mark.parametrize(
    ("reason", "way", "said"),
    [
        ("", "whole trees", "compiled by whole trees"),
        ("Numba 0.70 is new", "plain", "plain numba.njit, slower"),
    ],
)
def test_it_tells_which_way_kernels_are_compiled(
    reason: str, way: str, said: str, printed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation, "PLAIN_BECAUSE", reason)
    assert doctor.examine()["numba"]["way"] == way
    text = " ".join(printed("doctor").split())
    assert said in text
    assert reason in text


def test_what_is_missing_is_said(printed: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> str:
        if name in ("mujoco", "matplotlib"):
            raise importlib.metadata.PackageNotFoundError(name)
        return importlib.metadata.version(name)

    monkeypatch.setattr(doctor, "version", absent)
    said = printed("doctor")
    assert "missing: mujoco" in said
    assert "pip install -e '.[viz]'" in said


def test_a_broken_base_is_exit_code_1(printed: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "version", lambda name: "0.0.1")
    said = printed("doctor", code=1)
    assert "too old" in said
    assert "base install is broken" in said


def test_drawing_is_tried_in_a_process_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco")
    monkeypatch.setattr(doctor, "TRY", "raise SystemExit('no GL here')")
    found = doctor.examine()["drawing"]
    assert found["works"] is False
    assert found["note"] == "no GL here"


def test_the_shell_completes_commands() -> None:
    asked = {"_SUREFOOT_COMPLETE": "complete_bash", "COMP_WORDS": "surefoot doc", "COMP_CWORD": "1"}
    done = subprocess.run(
        [sys.executable, "-c", "from surefoot.app.cli.main import run; run()"],
        capture_output=True, text=True, env={**os.environ, **asked}, check=False,
    )  # fmt: skip
    assert done.stdout.split() == ["doctor"]
