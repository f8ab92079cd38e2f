from __future__ import annotations

import json

import numpy as np
import pytest

from surefoot.cli.main import main
from surefoot.log.formats import read_log


def summary(capsys, tmp_path, *arguments):
    code = main(["stand", "go2", *arguments, "--no-video", "--json", "--out", str(tmp_path)])
    return code, json.loads(capsys.readouterr().out)


def test_stands_in_the_rigid_world_and_breaks_no_law(capsys, tmp_path):
    code, found = summary(capsys, tmp_path, "--world", "rigid", "--duration", "1", "--push", "0.2:40,0,0:0.1")
    assert code == 0
    assert found["stood"]
    assert found["laws_broken"] == []
    assert found["normal_force_total_mean"] == pytest.approx(16.085 * 9.81, rel=0.01)
    log = read_log(next(tmp_path.glob("*/log.npz")))
    assert log["gaps"].min() > -1e-5


def test_both_worlds_put_the_same_load_on_each_foot(capsys, tmp_path):
    loads = []
    for world in ("rigid", "mujoco"):
        _, found = summary(capsys, tmp_path / world, "--world", world, "--duration", "1", "--slope", "5")
        loads.append([foot["normal_force_mean"] for foot in found["feet"]])
    assert np.allclose(loads[0], loads[1], rtol=0.02)


def test_unknown_world_is_one_line(capsys):
    assert main(["stand", "go2", "--world", "moon"]) == 2
    assert "unknown world 'moon'; valid names: drake, mjx, mujoco, rigid" in capsys.readouterr().err
