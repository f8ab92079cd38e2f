"""Where `surefoot bench` finds the benchmarks, and what an installed package says without them."""

from __future__ import annotations

from pathlib import Path

import pytest
import typer

from surefoot.app.cli import bench, commands, main


@pytest.mark.parametrize(
    "words", [[], ["walk"], ["walk", "--quick", "--out", "x"], ["--quick"], ["nonsense"]]
)
def test_an_installed_package_says_where_they_are(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    app = typer.Typer()
    app.callback()(commands.surefoot)
    app.add_typer(bench.commands(tmp_path / "benchmarks"), name="bench")
    monkeypatch.setattr(commands, "tree", lambda: typer.main.get_command(app))
    assert main.main(["bench", *words]) == 2
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "benchmarks come with the repository" in said.err
    assert main.main(["bench", "--help"]) == 0
    assert "not installed here" in " ".join(capfd.readouterr().out.split())
