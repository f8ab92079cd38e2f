"""`surefoot examples` copies what the docs name, once, and overwrites nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli import examples as command
from surefoot.app.cli.main import main


def test_they_are_copied_where_nothing_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answer: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    facts = answer("examples")
    assert facts["folder"] == "examples"
    assert {"stances/chimney.yaml", "01_stand.py"} <= {*facts["files"]}
    assert not any("__pycache__" in name for name in facts["files"])
    (tmp_path / "examples" / "mine.txt").write_text("mine")
    assert main(["examples"]) == 2
    assert "examples exists already" in capfd.readouterr().err
    assert (tmp_path / "examples" / "mine.txt").read_text() == "mine"
    assert main(["examples", "--out", "more"]) == 0
    assert (tmp_path / "more" / "sweeps" / "drops.yaml").exists()


def test_an_installation_without_them_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "PLACES", (tmp_path,))
    assert main(["examples", "--out", str(tmp_path / "new")]) == 2
    assert "this installation has no examples" in capfd.readouterr().err
