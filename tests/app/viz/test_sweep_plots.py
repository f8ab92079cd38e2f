"""Pictures of a sweep: shares with their intervals over each parameter, and maps over pairs."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from surefoot.app.viz import sweep_plots
from surefoot.app.viz.style import BAD, GROUND, INK, MUTED, blank_figure
from surefoot.app.viz.sweep_plots import SURVIVED, draw_survival, draw_sweep
from surefoot.base.errors import ProblemError
from surefoot.worlds.sweep import SweepConfig, sweep_from_dict
from tests.app.viz.drawn_axes import points_of

pa = pytest.importorskip("pyarrow", reason="a sweep's table is Arrow's")

DEEP = {"body": "box", "size": 0.1, "height": 0.1}


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return the figures that are saved from now on, by the names of their files; none is written."""
    kept: dict[str, Any] = {}

    def keep(figure: Any, path: Path) -> Path:
        kept[path.name] = figure
        return path

    monkeypatch.setattr(sweep_plots, "save", keep)
    return kept


def config_of(ranges: dict[str, Any], maps: list[list[str]] | None = None) -> SweepConfig:
    given = {"experiment": "drop", "samples": 4, "seed": 0, "settings": DEEP, "ranges": ranges}
    return sweep_from_dict({**given, "maps": maps or []})


def table_of(rested: list[bool], **columns: Any) -> Any:
    """Return the table of samples that are done, all other results zero."""
    zero = [0.0] * len(rested)
    results = dict.fromkeys(("rest_time", "distance", "bounce", "force_max", "depth_max"), zero)
    return pa.table({"status": ["done"] * len(rested), "rested": rested, **results, **columns})


def survival(config: SweepConfig, table: Any) -> Any:
    figure = blank_figure()
    draw_survival(SimpleNamespace(config=config, table=table), figure)  # type: ignore[arg-type]
    return figure


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval."""
    z, p = 1.959963984540054, hits / count
    middle = (p + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * math.sqrt(p * (1 - p) / count + z * z / (4 * count * count))
    return middle - half, middle + half


def test_shares_stand_in_the_middle_of_their_bins_with_wilson_s_intervals() -> None:
    """Of 8 bins from 0 to 0.8, three samples in the first, two survive; one in the last, which does not."""
    config = config_of({"mu": [0.0, 0.8]})
    figure = survival(config, table_of([True, True, False, False], mu=[0.01, 0.02, 0.03, 0.79]))
    (axis,) = figure.axes
    (shares,) = axis.containers
    dots, _, (bars,) = shares
    np.testing.assert_allclose(points_of(dots)[:, 0], np.arange(8) / 10.0 + 0.05)
    np.testing.assert_allclose(points_of(dots)[:, 1], [2.0 / 3.0, *[np.nan] * 6, 0.0])
    segments = bars.get_segments()
    np.testing.assert_allclose(segments[0][:, 1], wilson(2, 3), rtol=1e-6)
    np.testing.assert_allclose(segments[-1][:, 1], wilson(0, 1), rtol=1e-6, atol=1e-9)
    assert (dots.get_color(), dots.get_marker(), dots.get_linestyle()) == (SURVIVED, "o", "None")
    assert tuple(bars.get_color()[0][:3]) == to_rgb(MUTED)
    assert 3.0 <= dots.get_markersize() <= 5.0
    np.testing.assert_allclose(axis.get_ylim(), [-0.03, 1.03])
    assert (axis.get_xlabel(), axis.get_xscale()) == (config.label("mu"), "linear")
    assert figure.get_suptitle() == "drop: share that rested, with 95 % intervals"
    assert figure._suptitle.get_color() == INK
    np.testing.assert_allclose(figure.get_size_inches(), [4.0, 3.2])


def test_a_range_in_its_logarithm_has_the_geometric_middles() -> None:
    config = config_of({"height": {"low": 0.01, "high": 2.56, "scale": "log"}})
    (axis,) = survival(config, table_of([True], height=[0.5])).axes
    np.testing.assert_allclose(points_of(axis.containers[0][0])[:, 0], 0.01 * 2.0 ** (np.arange(8) + 0.5))
    assert axis.get_xscale() == "log"


def test_texts_are_named_at_their_places() -> None:
    (axis,) = survival(config_of({"body": ["box", "ball"]}), table_of([True], body=["ball"])).axes
    np.testing.assert_allclose(axis.get_xticks(), [0.5, 1.5])
    assert [text.get_text() for text in axis.get_xticklabels()] == ["box", "ball"]
    assert {text.get_rotation() for text in axis.get_xticklabels()} == {20.0}
    np.testing.assert_allclose(points_of(axis.containers[0][0])[:, 1], [np.nan, 1.0])


def test_a_sweep_of_nothing_drawn_has_no_picture() -> None:
    with pytest.raises(ProblemError, match="nothing of this sweep was drawn from a range"):
        survival(config_of({"mu": 0.5}), table_of([True], mu=[0.5]))


NUMBERS = ("mu", "restitution", "mass", "inertia", "com_x", "com_y", "com_z", "slope", "size", "height")
"""Numbers of a drop between 0.1 and 0.9, in the order of its settings."""


def many(numbers: tuple[str, ...]) -> tuple[SweepConfig, Any]:
    """Return a sweep over numbers of which each later one decides more about survival."""
    rested = [True] * 20 + [False] * 20
    config, columns = config_of({name: [0.1, 0.9] for name in numbers}), {}
    for k, name in enumerate(numbers):
        right = np.array(rested)
        right[: 10 - k] = False
        right[20 : 30 - k] = True
        columns[name] = np.where(right, 0.8, 0.2).tolist()
    return config, table_of(rested, **columns)


def test_the_nine_parameters_that_matter_most_are_drawn_three_in_a_row() -> None:
    figure = survival(*many(NUMBERS))
    labels = [axis.get_xlabel().partition(" [")[0] for axis in figure.axes if axis.axison]
    assert labels == [*NUMBERS[:0:-1]]
    np.testing.assert_allclose(figure.get_size_inches(), [3 * 3.4 + 0.6, 3 * 2.7 + 0.5])


def test_pairs_of_the_three_numbers_that_matter_most_are_mapped(figures: dict[str, Any]) -> None:
    drawn = draw_sweep(*many(NUMBERS[:4]), Path("folder"))
    assert drawn == [Path("folder/survival.png"), Path("folder/survival-map.png")]
    assert [*figures] == ["survival.png", "survival-map.png"]
    maps = [axis for axis in figures["survival-map.png"].axes if axis.collections and axis.axison][:3]
    pairs = [tuple(text.partition(" [")[0] for text in (a.get_xlabel(), a.get_ylabel())) for a in maps]
    assert pairs == [("restitution", "mass"), ("restitution", "inertia"), ("mass", "inertia")]


def test_one_number_has_no_map_and_none_no_picture(figures: dict[str, Any]) -> None:
    config = config_of({"mu": [0.0, 0.8], "body": ["box", "ball"]})
    table = table_of([True], mu=[0.5], body=["box"])
    assert draw_sweep(config, table, Path()) == [Path("survival.png")]
    assert draw_sweep(config_of({"mu": 0.5}), table, Path()) == []


def test_at_most_four_maps_that_a_sweep_names_are_drawn(figures: dict[str, Any]) -> None:
    pairs = [["mu", "slope"], ["slope", "mu"], ["mu", "height"], ["height", "mu"], ["slope", "height"]]
    config = config_of({name: [0.1, 0.9] for name in ("mu", "slope", "height")}, pairs)
    draw_sweep(config, table_of([True], mu=[0.5], slope=[0.5], height=[0.5]), Path())
    figure = figures["survival-map.png"]
    maps = [axis for axis in figure.axes if axis.get_xlabel()]
    labels = [(axis.get_xlabel(), axis.get_ylabel()) for axis in maps]
    assert labels == [(config.label(x), config.label(y)) for x, y in pairs[:4]]
    np.testing.assert_allclose(figure.get_size_inches(), [3 * 4.1 + 0.9, 2 * 3.4 + 0.5])


def test_a_map_shows_the_share_where_its_samples_are(figures: dict[str, Any]) -> None:
    """Two samples in one cell, of which one survives; one in another; a third that ended with an error."""
    config = config_of({"mu": [0.0, 0.8], "height": {"low": 0.01, "high": 2.56, "scale": "log"}})
    table = table_of(
        [True, False, True, True], mu=[0.05, 0.05, 0.75, 0.45], height=[0.015, 0.015, 0.03, 0.1],
        status=["done", "done", "done", "error"],
    )  # fmt: skip
    draw_sweep(config, table, Path())
    figure = figures["survival-map.png"]
    axis, bar = figure.axes
    (mesh,) = axis.collections
    shares = np.ma.filled(mesh.get_array().astype(float), np.nan)
    where = np.full((8, 8), np.nan)
    where[0, 0], where[1, 7] = 0.5, 1.0  # heights upwards, friction to the right
    np.testing.assert_allclose(shares, where)
    assert mesh.get_clim() == (0.0, 1.0)
    colours = [mesh.cmap(share)[:3] for share in (0.0, 0.5, 1.0)]
    np.testing.assert_allclose(colours, [to_rgb(c) for c in (BAD, GROUND, SURVIVED)], atol=0.01)
    corners = mesh.get_coordinates()
    np.testing.assert_allclose(corners[0, :, 0], np.linspace(0.0, 0.8, 9), atol=1e-12)
    np.testing.assert_allclose(corners[:, 0, 1], 0.01 * 2.0 ** np.arange(9))
    assert (axis.get_xscale(), axis.get_yscale()) == ("linear", "log")
    assert not any(line.get_visible() for line in axis.get_xgridlines() + axis.get_ygridlines())
    assert bar.get_ylabel() == "share that rested"
    assert figure.get_suptitle() == "drop: 4 samples; white: none"
    np.testing.assert_allclose(figure.get_size_inches(), [5.0, 3.9])


def test_the_grid_is_drawn_over_margins_in_the_package_s_style(figures: dict[str, Any]) -> None:
    draw_sweep(config_of({"mu": [0.0, 0.8]}), table_of([True], mu=[0.5]), Path())
    (axis,) = figures["survival.png"].axes
    assert not axis.spines["top"].get_visible()
