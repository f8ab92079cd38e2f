"""The wrapper's price is measured beside the plain environment, whose results it leaves as they are."""

from __future__ import annotations

import json

import pytest
import typer
from typer.testing import CliRunner

pytest.importorskip("gymnasium")
pytest.importorskip("mujoco")
pytestmark = pytest.mark.filterwarnings("ignore:.*:DeprecationWarning", "ignore::UserWarning")


def test_short_blocks_price_every_environment() -> None:
    """Every episode is audited, every substep judged, and nothing else changes; times are not asserted."""
    from benchmarks.wrapper_price import ENVIRONMENTS, main

    app = typer.Typer()
    app.command()(main)
    result = CliRunner().invoke(app, ["--quick", "--json"])
    assert result.exit_code == 0, result.output
    rows = json.loads(result.stdout)["environments"]
    assert [row["name"] for row in rows] == list(ENVIRONMENTS)
    for row in rows:
        assert row["same"], row
        assert row["steps"] == 200
        assert row["plain"] > 0.0
        assert row["wrapped"] > 0.0
        if row["episodes"]:
            assert row["rate"] == pytest.approx(1.0)
