"""The recorder's price is measured beside `mj_step` on models that are always there."""

from __future__ import annotations

import json

import pytest

from benchmarks.record_price import models, price

pytest.importorskip("mujoco")


@pytest.mark.long
def test_every_model_has_a_price() -> None:
    names = []
    for name, model, data in models():
        found = price(name, model, data, 20)
        names.append(found.name.removesuffix("-like"))
        assert found.step > 0.0
        assert found.recorded > 0.0
        assert found.ratio == pytest.approx(found.recorded / found.step)
    assert names == ["ant", "humanoid", "go2", "g1"]


@pytest.mark.long
def test_the_command_prints_it(capsys: pytest.CaptureFixture[str]) -> None:
    from surefoot.app.cli.main import main

    assert main(["bench", "audit", "--price", "--quick", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert {"name", "step", "recorded", "read", "ratio"} <= set(record["models"][0])
