from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from surefoot.cli.main import main


def test_cone_prints_half_spaces_rays_and_errors(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["cone", "--mu", "0.6", "--facets", "4", "--fit", "outer", "--out", str(tmp_path)]) == 0
    said = capfd.readouterr().out
    assert "41.421 %" in said
    assert "-0.600000" in said
    assert len(list(tmp_path.glob("cone-*/pyramids.png"))) == 1


def test_cone_json(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["cone", "--mu", "0.5", "--facets", "6", "--json", "--no-picture", "--out", str(tmp_path)]) == 0
    )
    facts = json.loads(capfd.readouterr().out)
    assert np.all(np.array(facts["halfspaces"]) @ np.array(facts["rays"]).T <= 1e-12)
    assert facts["fit_error"]["radial"] == pytest.approx(1 - np.cos(np.pi / 6))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "options", [["--mu", "-1"], ["--mu", "nan"], ["--facets", "2"], ["--fit", "x"], ["--facets", "a"]]
)
def test_wrong_input(options: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["cone", *options, "--out", str(tmp_path)]) == 2
    assert capfd.readouterr().err.count("\n") == 1


def test_help_and_unknown_command(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    assert "stand" in capfd.readouterr().out
    assert main(["stnd"]) == 2
    assert "No such command 'stnd'" in capfd.readouterr().err
