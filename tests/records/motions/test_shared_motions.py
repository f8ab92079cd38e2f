"""The references and executed motions beside the project are read without an option but Kimodo's rate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from tests.records.motions.made_motions import g1, same, spoilt

FOLDER = Path(__file__).resolve().parents[4] / "shared" / "data" / "motions"
FILES = sorted(FOLDER.rglob("*.csv")) + sorted(FOLDER.rglob("*.pkl")) + sorted(FOLDER.rglob("*.npz"))
RATES = {"asap": 30.0, "gmr_": 29.85, "kimo": 30.0, "omni": 50.0}

pytestmark = pytest.mark.skipif(not FILES, reason="../shared is not there")


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}-{path.stem}")
@pytest.mark.sampled(3)
def test_a_shared_motion_is_read_and_its_spoilt_twins_too(path: Path) -> None:
    motion = sf.read_motion(path, g1(), fps=30 if path.suffix == ".csv" else None)
    assert motion.doubts == ()
    expected = 50.0 if path.parent.name == "executed" else RATES[path.name[:4]]
    assert motion.rate == pytest.approx(expected, abs=0.01)
    assert (len(motion.absent) == 6) == (path.suffix == ".pkl" and path.name.startswith("asap"))
    assert (motion.torques is not None) == (path.parent.name == "executed" and path.name.startswith("asap"))
    lowest = np.median([min(g1().sphere_bottoms(q)) for q in motion.q])
    assert -0.05 < lowest < 0.15
    for kind, about in (("wxyz", "quaternion"), ("breadth", "joint order"), ("sides", "joint order")):
        place, turn, joints = spoilt(g1(), motion.q, kind)
        twin = sf.read_motion({"fps": 30, "root_pos": place, "root_rot": turn, "dof_pos": joints}, g1())
        assert same(twin, motion.q)
        assert any(doubt.startswith(about) for doubt in twin.doubts)


def test_kimodos_rate_stands_nowhere() -> None:
    with pytest.raises(sf.SurefootError, match="nothing in it says the rate: give fps="):
        sf.read_motion(FOLDER / "kimodo_walk.csv", g1())
