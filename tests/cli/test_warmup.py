"""`surefoot warmup` runs every command that compiles, leaves nothing behind, and says what it lacks."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from surefoot.cli import commands, warmup
from surefoot.cli.main import main


def test_its_commands_are_commands_and_leave_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    quick = tuple(words for words in warmup.COMMANDS if words.split()[0] not in ("stand", "walk"))
    assert {"stand", "walk"} == {words.split()[0] for words in {*warmup.COMMANDS} - {*quick}}
    monkeypatch.setattr(warmup, "COMMANDS", quick)
    monkeypatch.chdir(tmp_path)
    assert main(["warmup", "--json"]) == 0
    facts = json.loads(capfd.readouterr().out)
    assert len(facts["tasks"]) == len(quick)
    assert facts["size"] > 0
    assert not any(row["skipped"] for row in facts["tasks"])
    assert Path.cwd() == tmp_path
    assert not list(tmp_path.iterdir())


def test_what_lacks_a_package_is_left_out_and_said(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from surefoot.errors import MissingExtra

    def lacking(*arguments: object, **options: object) -> None:
        raise MissingExtra("mujoco", "sim")

    monkeypatch.setattr(warmup, "COMMANDS", ("stand go2", "walk go2"))
    real = commands.tree()
    monkeypatch.setattr(
        commands, "tree", lambda: lambda args, **k: real(args=args, **k) if args == ["warmup"] else lacking()
    )
    assert main(["warmup"]) == 0
    assert capfd.readouterr().out.count("mujoco is not installed; run: pip install -e '.[sim]'") == 1
