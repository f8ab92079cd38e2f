"""`surefoot bench softening` finds the ball and says so."""

from __future__ import annotations

import json

import pytest

from surefoot.cli.main import main

pytest.importorskip("casadi")


@pytest.mark.long
def test_command_prints_json_only(capsys):
    words = ["--problem", "ball", "--table", "race", "--table", "recommended", "--quick", "--json"]
    assert main(["bench", "softening", *words]) == 0
    found = json.loads(capsys.readouterr().out)
    assert all(row["solved"] == row["starts"] == 1 for row in found["race"])
    assert found["recommended"][0]["complementarity"] < 1e-12
