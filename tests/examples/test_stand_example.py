from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np

from surefoot.spatial import GRAVITY

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "01_stand.py"


def test_a_quarter_of_the_weight_on_every_foot(tmp_path: Path) -> None:
    picture = tmp_path / "stand.png"
    normal = runpy.run_path(str(EXAMPLE))["main"](picture)
    share = 16.085 * GRAVITY * np.cos(np.radians(20.0)) / 4
    np.testing.assert_allclose(normal, share, rtol=0.01)


def test_a_picture_that_exists_is_kept(tmp_path: Path) -> None:
    picture = tmp_path / "mine.png"
    picture.write_text("mine")
    runpy.run_path(str(EXAMPLE))["main"](picture)
    assert picture.read_text() == "mine"
