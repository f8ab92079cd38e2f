"""The page on logs is a program: it runs as shown, and what it says comes out."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.pages import DOCS, run_page

pytest.importorskip("mujoco")
PAGE = DOCS / "logs.md"


def test_the_page_runs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    told: list[str] = []
    for page in ("record.md", "logs.md", "contact-times.md"):
        run_page(page, after=lambda: told.append(capsys.readouterr().out))
    assert len(told) == 9
    assert "['shell'] ['floor', 'floor', 'floor', 'floor'] 5.0" in told[0]
    assert told[1].startswith("[300, 300]\n2 episodes, 2 lawful; ")
    assert told[2] == "[200, 200]\n"
    assert told[3] == "forces: contact axes are taken to be the world's, as on level ground\n"
    beyond = "beyond the sole: right, 0.400 to 0.450 s: presses 20 mm beyond its toe edge"
    assert told[4].splitlines() == [beyond]
    assert "[0.    0.002 0.004] [-1.65806279 -1.65806279" in told[5]
    assert "foot_sensors:" in told[6]
    assert told[7].startswith('(200, 4) ["contact_positions, gaps, normals: from')


def test_the_page_names_every_unit_and_alias_rightly() -> None:
    from surefoot.records.log.array_names import ALIASES
    from surefoot.records.log.mapping import UNITS

    page = PAGE.read_text()
    line = next(x for x in page.splitlines() if x.startswith("| `unit`"))
    assert all(unit in line for unit in UNITS)
    assert {
        n for n in re.findall(r"`(\w+)`", page) if n.startswith(("root_", "q")) and n != "quaternion"
    } <= {*ALIASES, "q"}
    assert np.isfinite([by for _, by in UNITS.values()]).all()
