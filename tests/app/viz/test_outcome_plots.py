"""Pictures of what became of runs: bars, intervals and margins stand where the outcomes have them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import surefoot as sf
from surefoot.app.export.sequence import ContactSequence, SequencePhase
from surefoot.app.viz.outcome_plots import (
    draw_contact_times,
    draw_repair,
    draw_replay,
    draw_sequence,
    draw_transfer,
    draw_verdicts,
)
from surefoot.app.viz.style import BAD, FOOT_COLOURS, GOOD, INK, MUTED, WARN
from surefoot.base.errors import ProblemError
from surefoot.records.audit.contact_times import ContactTimes, FootTimes
from surefoot.worlds.replay.windows import ReplayReport, WindowReplay
from surefoot.worlds.transfer.transfer import TransferReport, WorldTransfer
from tests.app.viz.drawn_axes import (
    assert_legible,
    legend_of,
    level_lines,
    lines_in,
    new_axes,
    points_of,
    texts_of,
)


def bars_of(axes: Any) -> dict[str, list[list[float]]]:
    """Return the begins and ends of each foot's bars by its name, and its row."""
    out = {}
    for bars in axes.collections:
        spans = [path.vertices for path in bars.get_paths()]
        out[bars.get_label()] = [
            [float(s[:, 0].min()), float(s[:, 0].max()), float(s[:, 1].mean().round())] for s in spans
        ]
    return out


def world(name: str, successes: int, share: tuple[float, float], verdict: Any) -> WorldTransfer:
    return WorldTransfer(name, successes, 8, share, (0.0, 0.0), verdict, np.nan, "", 0)


def test_worlds_stand_below_the_reference_with_their_intervals_in_per_cent() -> None:
    rows = (
        world("here", 8, (0.5, 1.0), "reference"), world("ice", 2, (0.1, 0.6), "lost"),
        world("rug", 6, (0.4, 0.9), "gained"), world("mud", 4, (0.2, 0.8), "not told apart"),
    )  # fmt: skip
    axes = new_axes()
    draw_transfer(TransferReport(rows), axes)
    spans, dots = axes.lines[0::2], axes.lines[1::2]
    ends = [[[50, 3], [100, 3]], [[10, 2], [60, 2]], [[40, 1], [90, 1]], [[20, 0], [80, 0]]]
    np.testing.assert_allclose([points_of(line) for line in spans], ends)
    np.testing.assert_allclose([points_of(dot)[0] for dot in dots], [[100, 3], [25, 2], [75, 1], [50, 0]])
    for lines in (spans, dots):
        assert [line.get_color() for line in lines] == [INK, BAD, GOOD, MUTED]
    assert all(line.get_solid_capstyle() == "butt" and 2.0 < line.get_linewidth() < 3.0 for line in spans)
    assert all(dot.get_marker() == "o" and 5.0 < dot.get_markersize() < 7.0 for dot in dots)
    words = ["8 of 8, reference", "2 of 8, lost", "6 of 8, gained", "4 of 8, not told apart"]
    assert texts_of(axes) == words
    assert [text.get_position() for text in axes.texts] == [(104.0, 3), (104.0, 2), (104.0, 1), (104.0, 0)]
    labels = {
        float(y): text.get_text() for y, text in zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)
    }
    assert labels == {3.0: "here", 2.0: "ice", 1.0: "rug", 0.0: "mud"}
    np.testing.assert_allclose(axes.get_ylim(), [-0.6, 3.6])
    np.testing.assert_allclose(axes.get_xlim(), [-2.0, 102.0])
    assert axes.get_xlabel() == "runs that succeed [%], 95 % interval"
    assert not axes.yaxis.get_gridlines()[0].get_visible()
    assert_legible(axes.figure)


def window(start: float, end: float, drift: float, lost: str = "") -> WindowReplay:
    return WindowReplay(start, end, "done", 1.0, 1.0, 0.1, drift, (), lost)


def replay(*windows: WindowReplay) -> ReplayReport:
    return ReplayReport("rigid", "a contact", "lost", "it fell", windows, ())


def test_windows_are_bars_of_the_drift_in_centimetres_green_where_they_hold() -> None:
    axes = new_axes()
    draw_replay(replay(window(0.5, 1.5, 0.01), window(2.0, 4.0, 0.2, "it fell"), window(5.0, 5.0, 0.1)), axes)
    boxes = [(*bar.get_xy(), bar.get_width(), bar.get_height()) for bar in axes.patches]
    np.testing.assert_allclose(boxes, [[0.5, 0, 1, 1], [2.0, 0, 2.0, 20.0], [5.0, 0.0, 1e-3, 10.0]])
    assert [bar.get_facecolor()[:3] for bar in axes.patches] == [to_rgb(c) for c in (GOOD, BAD, GOOD)]
    assert all(bar.get_edgecolor()[:3] == (1.0, 1.0, 1.0) for bar in axes.patches)
    assert all(0.5 < bar.get_linewidth() < 1.5 for bar in axes.patches)
    assert texts_of(axes) == ["5.7°"] * 3  # a lean of 0.1 rad
    places = [text.get_position() for text in axes.texts]
    np.testing.assert_allclose(places, [[1.0, 1.0], [3.0, 20.0], [5.0005, 10.0]])
    assert {(text.get_ha(), text.get_va()) for text in axes.texts} == {("center", "bottom")}
    assert axes.margins()[1] == 0.15
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "time of the log [s]", "base from the log's\nat the end [cm]",
    )  # fmt: skip
    assert axes.get_title() == "in the world rigid: lost (numbers: lean beside the log's)"
    assert_legible(axes.figure)


def test_a_replay_without_a_window_says_why() -> None:
    with pytest.raises(ProblemError, match="no window was replayed: it fell"):
        draw_replay(replay(), new_axes())


def report(share: list[float], bad: float) -> Any:
    frames = SimpleNamespace(time=np.arange(len(share)), share=np.array(share))
    return SimpleNamespace(frames=frames, impossible_share=bad, impossible=0.1)


def test_a_repair_shows_what_was_left_over_before_and_after() -> None:
    repair: Any = SimpleNamespace(
        before=report([0.1, 0.5], 0.25), report=report([0.05, 0.02], 0.0), motion=SimpleNamespace(name="jump")
    )
    axes = new_axes()
    draw_repair(repair, axes)
    assert legend_of(axes) == ["before: 25.0 % impossible", "after: 0.0 % impossible", "no force gives more"]
    np.testing.assert_allclose(points_of(axes.lines[0]), [[0, 0.1], [1, 0.5]])
    np.testing.assert_allclose(points_of(axes.lines[1]), [[0, 0.05], [1, 0.02]])
    assert [line.get_color() for line in axes.lines] == [MUTED, FOOT_COLOURS[0], BAD]
    assert level_lines(axes) == [0.1]
    assert axes.lines[2].get_linestyle() == "--"
    assert axes.get_ylim()[0] == 0.0
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) == ("time [s]", "left over [m g]", "jump")
    assert_legible(axes.figure)


def times_of(*feet: FootTimes) -> ContactTimes:
    return ContactTimes("forces", feet, np.zeros((0, len(feet)), dtype=np.bool_))


def foot(name: str, downs: list[float], ups: list[float], duty: float = np.nan) -> FootTimes:
    return FootTimes(name, np.array(downs), np.array(ups), duty_factor=duty)


def test_feet_are_on_the_ground_from_each_touchdown_to_the_next_lift_off() -> None:
    axes = new_axes()
    draw_contact_times(times_of(foot("A", [1.0, 3.0], [2.0, 4.5], 0.6), foot("B", [1.5, 4.0], [3.5])), axes)
    assert bars_of(axes) == {
        "A, 60 %": [[1.0, 2.0, 1.0], [3.0, 4.5, 1.0]],
        "B": [[1.5, 3.5, 0.0], [4.0, 4.5, 0.0]],  # down at the end of all that is known
    }
    assert axes.get_title() == "on the ground, from forces"
    assert axes.get_xlabel() == "time [s]"


def test_a_foot_that_lifts_off_first_was_on_the_ground_from_the_first_event_on() -> None:
    axes = new_axes()
    draw_contact_times(
        times_of(foot("A", [0.5], [2.0]), foot("B", [3.0], [1.0, 4.0]), foot("C", [], [1.5])), axes
    )
    assert bars_of(axes) == {
        "A": [[0.5, 2.0, 2.0]], "B": [[0.5, 1.0, 1.0], [3.0, 4.0, 1.0]], "C": [[0.5, 1.5, 0.0]],
    }  # fmt: skip


def test_a_foot_whose_lift_off_is_the_first_event_is_in_the_air_after_it() -> None:
    axes = new_axes()
    draw_contact_times(times_of(foot("A", [1.5], [0.5, 2.5]), foot("B", [1.0], [2.0])), axes)
    length = {name: sum(end - begin for begin, end, _ in bars) for name, bars in bars_of(axes).items()}
    assert length == {"A": 1.0, "B": 1.0}


def test_feet_that_never_touch_have_no_picture() -> None:
    with pytest.raises(ProblemError, match="no foot touched down or lifted off"):
        draw_contact_times(times_of(foot("A", [], [])), new_axes())


def test_a_sequence_is_bars_of_its_phases_between_marks() -> None:
    both = [sf.PointContact((x, 0.0, 0.0), name=name) for x, name in ((0.1, "L"), (-0.1, "R"))]
    phases = [
        SequencePhase(0.3, sf.Stance(both)), SequencePhase(0.2, sf.Stance(both[:1])),
        SequencePhase(0.4, sf.Stance(both[1:])),
    ]  # fmt: skip
    axes = new_axes()
    draw_sequence(ContactSequence(phases, ("L", "R"), robot="biped"), axes)
    bars = bars_of(axes)
    np.testing.assert_allclose(bars["L"], [[0.0, 0.3, 1.0], [0.3, 0.5, 1.0]])
    np.testing.assert_allclose(bars["R"], [[0.0, 0.3, 0.0], [0.5, 0.9, 0.0]])
    marks = lines_in(axes, INK)
    np.testing.assert_allclose([line.get_xdata() for line in marks], [[0.3, 0.3], [0.5, 0.5]])
    assert {line.get_linestyle() for line in marks} == {":"}
    np.testing.assert_allclose(axes.get_xlim(), [0.0, 0.9])
    assert (axes.get_xlabel(), axes.get_title()) == ("time [s]", "biped: 3 phases")
    unnamed = new_axes()
    draw_sequence(ContactSequence(phases, ("L", "R")), unnamed)
    assert unnamed.get_title() == "contact sequence: 3 phases"
    assert_legible(axes.figure)


def test_margins_of_stances_rise_in_the_colours_of_their_verdicts() -> None:
    """What has no margin stands first and is counted, not drawn."""
    verdicts: Any = SimpleNamespace(
        margin=np.array([2.0, np.nan, -1.0, 0.5, np.nan]),
        status=np.array(["possible", "impossible", "impossible", "possible", "undecided"]),
    )
    axes = new_axes()
    draw_verdicts(verdicts, axes)
    drawn = {line.get_label(): points_of(line).tolist() for line in axes.lines[:-1]}
    assert drawn == {
        "possible: 2": [[3.0, 0.5], [4.0, 2.0]], "undecided: 1": [], "impossible: 2": [[2.0, -1.0]],
    }  # fmt: skip
    assert [line.get_color() for line in axes.lines] == [GOOD, WARN, BAD, MUTED]
    assert level_lines(axes) == [0.0]
    assert all(2.0 < line.get_markersize() < 4.0 for line in axes.lines[:-1])
    assert axes.get_title() == "5 stances"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("stances, by margin", "margin [N]")
    assert len(legend_of(axes)) == 3
    assert_legible(axes.figure)


def test_verdicts_that_no_stance_has_are_not_named() -> None:
    axes = new_axes()
    draw_verdicts(SimpleNamespace(margin=np.ones(2), status=np.array(["possible"] * 2)), axes)  # type: ignore[arg-type]
    assert legend_of(axes) == ["possible: 2"]
