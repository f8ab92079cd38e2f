"""Runs in MJX, where it is installed, are as lawful as MuJoCo's."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

import surefoot as sf
from benchmarks.problems.logged_runs import CleanRun

pytest.importorskip("jax")
pytest.importorskip("mujoco")


@pytest.mark.skipif(find_spec("mujoco.mjx") is None, reason="MJX is not here")
@pytest.mark.filterwarnings("ignore")
def test_a_stand_in_it_is_lawful() -> None:
    log = CleanRun(world="mjx", duration=0.1).make()
    report = sf.audit_log(log)
    assert (report.verdict, report.symptoms) == ("lawful", ())
    assert log.fact("sinking") > 0.0  # it declares itself as soft as MuJoCo
    log["forces"][40:80, 0, 2] *= -1.0
    assert sf.audit_log(log).verdict == "broken"
