from __future__ import annotations

import json

import numpy as np

from benchmarks.momentum import WAYS, time_momentum
from benchmarks.rigid_world import drop
from surefoot.cli.main import main


def test_every_way_is_timed_and_checked():
    timing = time_momentum([5, 10, 20, 30], budget=0.02)
    assert timing.disagreement < 1e-12
    for way in WAYS:
        assert len(timing.seconds[way]) == 4
        assert min(timing.seconds[way]) > 0.0


def test_command_prints_json_only_and_draws(capsys, tmp_path):
    assert main(["bench", "momentum", "--longest", "20", "--json", "--out", str(tmp_path)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(list(tmp_path.glob("*/momentum-timing.png"))) == 1
    assert found["links"] == [10, 20]
    assert set(found["seconds"]) == set(WAYS)


def test_drop_is_measured_in_both_worlds():
    results = [drop(world, "go2", 0.05, 1.0) for world in ("rigid", "mujoco")]
    for result in results:
        assert 0.0 < result.wall < 60.0
        assert result.contacts == 4
        assert result.weight_error < 0.2
    assert results[0].energy_made <= 0.0
    assert results[0].penetration < 1e-5 < results[1].penetration
    assert np.isnan(results[1].energy_made)
