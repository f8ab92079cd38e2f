from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest


def test_cone_prints_half_spaces_rays_and_errors(tmp_path: Path, printed: Any) -> None:
    said = printed("cone", "--mu", "0.6", "--facets", "4", "--fit", "outer", "--out", tmp_path)
    assert "41.421 %" in said
    assert "-0.600000" in said
    assert "more, see --json" in printed("cone", "--facets", "64", "--no-picture")
    assert len(list(tmp_path.glob("cone-*/pyramid.png"))) == 1


def test_cone_json(tmp_path: Path, answer: Callable[..., Any]) -> None:
    facts = answer("cone", "--mu", "0.5", "--facets", "6", "--no-picture", "--out", tmp_path)
    assert np.all(np.array(facts["halfspaces"]) @ np.array(facts["rays"]).T <= 1e-12)
    assert facts["fit_error"]["radial"] == pytest.approx(1 - np.cos(np.pi / 6))
    assert not list(tmp_path.iterdir())


def test_the_picture_is_of_what_was_asked(
    tmp_path: Path, answer: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of eight sides around the cone there is one pyramid, of eight sides and around it."""
    pytest.importorskip("matplotlib")
    drawn = []
    monkeypatch.setattr(
        "surefoot.app.viz.cone_plots.draw_friction_pyramid",
        lambda pyramid, axes: drawn.append((pyramid.mu, pyramid.facets, pyramid.fit, axes.name)),
    )
    answer("cone", "--mu", "0.4", "--facets", "8", "--fit", "outer", "--out", tmp_path)
    assert drawn == [(0.4, 8, "outer", "rectilinear"), (0.4, 8, "outer", "3d")]
