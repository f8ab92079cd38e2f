"""`surefoot bench softening` finds the ball and says so."""

from __future__ import annotations

import pytest

pytest.importorskip("casadi")


@pytest.mark.long
def test_command_prints_json_only(answer):
    words = ["--problem", "ball", "--table", "race", "--table", "recommended", "--quick"]
    found = answer("bench", "softening", *words)
    assert all(row["solved"] == row["starts"] == 1 for row in found["race"])
    assert found["recommended"][0]["complementarity"] < 1e-12
