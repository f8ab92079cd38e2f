from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "02_pushed_on_a_slope.py"


def test_the_animation_has_the_pictures_of_the_walk(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "pushed.webp"
    log = runpy.run_path(str(EXAMPLE))["main"](path, 0.8)
    assert log.facts["outcome"] == "done"
    if not path.exists():
        pytest.skip(capsys.readouterr().out)
    from PIL import Image

    with Image.open(path) as animation:
        assert animation.size == (720, 405)
        assert animation.n_frames in (11, 12)  # rounding decides on the last


def test_an_animation_that_exists_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "mine.webp"
    path.write_text("mine")
    runpy.run_path(str(EXAMPLE))["main"](path, 0.5)
    assert path.read_text() == "mine"
