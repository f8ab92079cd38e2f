"""Plots of a walk: velocity beside its command, footfalls beside the plan, the path above its ground."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from surefoot.app.viz import plots, walk_plots
from surefoot.app.viz.style import BAD, FOOT_COLOURS, GROUND, INK, MUTED
from surefoot.app.viz.walk_plots import draw_footfalls, draw_path, draw_velocity, draw_walk
from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.records import Log
from tests.app.viz.drawn_axes import assert_legible, legend_of, lines_in, points_of, texts_of

MASS = 10.0
ROWS = 1001
TIME = np.linspace(0.0, 5.0, ROWS)


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return the figures that are saved from now on, by the names of their files; none is written."""
    kept: dict[str, Any] = {}

    def keep(figure: Any, path: Path) -> Path:
        kept[path.name] = figure
        return path

    for module in (walk_plots, plots):
        monkeypatch.setattr(module, "save", keep)
    return kept


def walk(facts: dict[str, Any] | None = None, **channels: Any) -> Log:
    """Return a log of five seconds: a base goes along x at 1 m/s, on a left foot, then on a right one."""
    q, forces = np.zeros((ROWS, 7)), np.zeros((ROWS, 3, 3))
    q[:, 0], q[:, 1], q[:, 2], q[:, 6] = TIME, 0.1 * TIME, 0.3, 1.0
    left = (TIME % 1.0) < 0.5
    forces[left, 0, 2] = forces[~left, 2, 2] = MASS * 9.81
    places = np.zeros((ROWS, 3, 3))
    places[:, :, 0], places[:, :, 1] = TIME[:, None], [0.1, 9.0, -0.1]
    arrays = {
        "time": TIME, "q": q, "v": np.zeros((ROWS, 6)), "command": np.zeros((ROWS, 3)), "forces": forces,
        "contact_positions": places, "push": np.zeros((ROWS, 3)), "mu": np.full(ROWS, 0.6),
        "active": np.ones((ROWS, 3), dtype=bool), "planned": np.column_stack([left, ~left]),
        "torques": np.ones((ROWS, 2)),
    }  # fmt: skip
    arrays = {name: array for name, array in {**arrays, **channels}.items() if array is not None}
    known = {
        "mass": MASS, "feet": ["left", "right"], "contact_foot": [0, 0, 1], "joints": ["hip", "knee"],
        "effort_limits": [10.0, 10.0],
    }  # fmt: skip
    return Log(arrays, {**known, **(facts or {})})


def velocity(measured: Any, command: float) -> Log:
    """Return a walk whose base has a velocity along x, beside a command of the same for all time."""
    v, commands = np.zeros((ROWS, 6)), np.zeros((ROWS, 3))
    v[:, 0], commands[:, 0] = measured, command
    return walk(v=v, command=commands)


def test_velocity_is_drawn_in_the_heading_frame_beside_its_command(
    figures: dict[str, Any], tmp_path: Path
) -> None:
    """A base that looks along y and goes forward at 1 and left at 0.5 m/s, turning at 0.2 rad/s."""
    log = walk()
    log["q"][:, 5:7] = np.sqrt(0.5)
    log["v"][:] = [1.0, 0.5, 0.0, 0.0, 0.0, 0.2]
    log["command"][:] = [0.9, 0.4, 0.1]
    assert draw_velocity(log, tmp_path / "v.png") == tmp_path / "v.png"
    axes = figures["v.png"].axes
    assert [axis.get_ylabel() for axis in axes] == ["forward [m/s]", "left [m/s]", "yaw rate [rad/s]"]
    for k, (axis, measured, command) in enumerate(zip(axes, (1.0, 0.5, 0.2), (0.9, 0.4, 0.1), strict=True)):
        own, reference = axis.lines
        np.testing.assert_allclose(points_of(own)[[0, -1]], [[0.0, measured], [5.0, measured]])
        np.testing.assert_allclose(points_of(reference)[[0, -1]], [[0.0, command], [5.0, command]])
        assert (own.get_color(), reference.get_color()) == (FOOT_COLOURS[k], INK)
        assert (own.get_linestyle(), reference.get_linestyle()) == ("-", "--")
    assert legend_of(axes[0]) == ["measured", "commanded"]
    assert axes[0].get_legend()._ncols == 2
    assert axes[0].get_title() == "Velocity of the base in its heading frame"
    np.testing.assert_allclose(figures["v.png"].get_size_inches(), [8.0, 5.6])
    assert_legible(figures["v.png"])


@pytest.mark.parametrize(
    ("measured", "command", "limits"),
    [
        (0.4, 0.5, (0.25, 0.65)),  # 0.3 of the command beyond both
        (0.6, 0.5, (0.35, 0.75)),
        (0.4, -0.5, (-0.65, 0.55)),
        (0.0, 0.05, (-0.03, 0.08)),  # 0.03 of a small one
    ],
)
def test_velocities_have_room_by_the_command(
    measured: float, command: float, limits: tuple[float, float], figures: dict[str, Any]
) -> None:
    draw_velocity(velocity(measured, command), Path("v.png"))
    np.testing.assert_allclose(figures["v.png"].axes[0].get_ylim(), limits, atol=1e-9)


def test_a_jolt_of_two_rows_is_marked_and_does_not_squash_the_velocity(figures: dict[str, Any]) -> None:
    jolt = np.full(ROWS, 0.5)
    jolt[[300, 301]], jolt[[600, 601]] = 20.0, -30.0
    draw_velocity(velocity(jolt, 0.5), Path("v.png"))
    axis = figures["v.png"].axes[0]
    np.testing.assert_allclose(axis.get_ylim(), [0.35, 0.65], atol=1e-9)
    assert texts_of(axis) == ["20", "-30"]
    assert [points_of(mark)[0, 0] for mark in lines_in(axis, BAD)] == [1.5, 3.0]
    jolt[600:606] = -30.0  # no jolt
    draw_velocity(velocity(jolt, 0.5), Path("v.png"))
    assert figures["v.png"].axes[0].get_ylim()[0] == pytest.approx(-30.15)


def test_pushes_are_marked_in_velocity(figures: dict[str, Any]) -> None:
    push = np.zeros((ROWS, 3))
    push[100:200, 1] = 5.0
    draw_velocity(walk(push=push), Path("v.png"))
    assert [len(axis.patches) for axis in figures["v.png"].axes] == [1, 1, 1]


def test_footfalls_of_the_last_three_seconds_are_bars_above_planned_lines(figures: dict[str, Any]) -> None:
    draw_footfalls(walk(), Path("f.png"))
    axis = figures["f.png"].axes[0]
    left, right = axis.collections
    assert (left.get_label(), right.get_label()) == ("left", "right")
    for bars, row, begins in ((left, 1, [2.0, 3.0, 4.0]), (right, 0, [2.5, 3.5, 4.5])):
        boxes = [path.vertices for path in bars.get_paths()][:3]
        np.testing.assert_allclose([box[:, 0].min() for box in boxes], begins)
        np.testing.assert_allclose([np.ptp(box[:, 0]) for box in boxes], 0.5)
        assert {float(box[:, 1].mean().round()) for box in boxes} == {float(row)}
    plan = [points_of(line) for line in lines_in(axis, INK)][:3]
    np.testing.assert_allclose(plan, [[[begin, 0.58], [begin + 0.5, 0.58]] for begin in (2.0, 3.0, 4.0)])
    other = points_of(lines_in(axis, INK)[-1])
    np.testing.assert_allclose(other, [[4.5, -0.42], [5.0, -0.42]])
    assert all(line.get_solid_capstyle() == "butt" and line.get_linewidth() < 2.0 for line in axis.lines)
    np.testing.assert_allclose(axis.get_xlim(), [2.0, 5.0])
    assert axis.get_title() == "Footfalls: bars measured, dark lines planned"
    assert axis.get_xlabel() == "time [s]"
    np.testing.assert_allclose(figures["f.png"].get_size_inches(), [8.0, 2.1])
    assert_legible(figures["f.png"])


def test_footfalls_without_a_plan_have_no_lines(figures: dict[str, Any]) -> None:
    draw_footfalls(walk(planned=None), Path("f.png"))
    axis = figures["f.png"].axes[0]
    assert not axis.lines
    assert axis.get_title() == "Footfalls: bars measured"


def test_the_path_is_drawn_from_above_and_from_the_side_with_every_touchdown(figures: dict[str, Any]) -> None:
    """The left foot begins on the ground; later touchdowns are at its first point's place."""
    draw_path(walk(), Path("p.png"))
    axes = figures["p.png"].axes
    assert [axis.get_ylabel() for axis in axes] == ["y [m]", "z [m]"]
    for axis, height in zip(axes, (0.5, 0.3), strict=True):
        (line,) = axis.lines
        assert (line.get_color(), axis.get_aspect(), axis.get_adjustable()) == (INK, 1.0, "datalim")
        np.testing.assert_allclose(points_of(line)[-1], [5.0, height])
    above, beside = ([dots.get_offsets() for dots in axis.collections] for axis in axes)
    np.testing.assert_allclose(above[0], [[k, 0.1] for k in (1.0, 2.0, 3.0, 4.0, 5.0)], atol=1e-9)
    np.testing.assert_allclose(above[1], [[k, -0.1] for k in (0.5, 1.5, 2.5, 3.5, 4.5)], atol=1e-9)
    np.testing.assert_allclose(beside[0], [[k, 0.0] for k in (1.0, 2.0, 3.0, 4.0, 5.0)], atol=1e-9)
    for axis in axes:
        assert [tuple(dots.get_facecolor()[0][:3]) for dots in axis.collections] == [
            to_rgb(colour) for colour in FOOT_COLOURS[:2]
        ]
        assert all(
            4.0 < dots.get_sizes()[0] < 7.0 and dots.get_linewidth()[0] == 0.0 for dots in axis.collections
        )
    assert axes[0].get_title() == "Path of the base and footfalls, from above and from the side"
    assert axes[1].get_xlabel() == "x [m]"
    assert not axes[0].get_shared_x_axes().joined(*axes)
    np.testing.assert_allclose(figures["p.png"].get_size_inches(), [8.0, 4.6])
    assert_legible(figures["p.png"])


def ground(figures: dict[str, Any], q: FloatArray | None = None, terrain: str = "slope:45") -> Any:
    """Return the side view of a walk whose log names its ground."""
    draw_path(walk({"terrain": terrain}, **({} if q is None else {"q": q})), Path("p.png"))
    return figures["p.png"].axes[1]


def test_the_ground_is_drawn_below_the_way_as_far_as_feet_and_base_went(figures: dict[str, Any]) -> None:
    log = walk()
    q = log["q"].copy()
    q[:, 0] += 0.25  # the feet were at 0 to 5 m
    q[:, 1] *= -1.0
    axis = ground(figures, q)
    (line,) = lines_in(axis, MUTED)
    x, z = points_of(line).T
    np.testing.assert_allclose(z, x, atol=1e-9)  # of 45 degrees
    np.testing.assert_allclose([x.min(), x.max()], [0.0, 5.25])
    assert len(x) == 600
    area = next(one for one in axis.collections if len(one.get_paths()[0].vertices) > 600)
    corners = area.get_paths()[0].vertices
    np.testing.assert_allclose([corners[:, 1].min(), corners[:, 1].max()], [-0.05, 5.25])
    assert tuple(area.get_facecolor()[0][:3]) == to_rgb(GROUND)
    assert area.get_linewidth()[0] == 0.0
    assert area.get_zorder() < line.get_zorder() < axis.lines[0].get_zorder()
    assert not lines_in(figures["p.png"].axes[0], MUTED)


def test_no_ground_is_drawn_where_none_is_known(figures: dict[str, Any]) -> None:
    assert not lines_in(ground(figures, terrain=""), MUTED)


def turning(turns: BoolArray) -> FloatArray:
    """Return configurations whose way along x turns back at some of the rows."""
    q = walk()["q"].copy()
    steps = np.where(np.cumsum(turns) % 2 == 0, 0.01, -0.01)
    q[1:, 0] = np.cumsum(steps)
    return np.asarray(q, dtype=np.float64)


@pytest.mark.parametrize(("every", "drawn"), [(1, False), (3, False), (5, True), (0, True)])
def test_a_robot_that_marks_time_has_no_side_view_of_a_way(
    every: int, drawn: bool, figures: dict[str, Any]
) -> None:
    """It turns back in every row, or in every few of them; a quarter of the rows is the border."""
    rows = np.arange(1, ROWS)
    turns = (rows % every == 0) if every else np.zeros(len(rows), dtype=bool)
    assert bool(lines_in(ground(figures, turning(turns)), MUTED)) is drawn


def test_the_ground_beside_the_x_axis_is_that_below_the_path(figures: dict[str, Any]) -> None:
    """Its way back is sorted along x, and z is the height below it."""
    q = walk()["q"][::-1].copy()
    x, z = points_of(lines_in(ground(figures, q), MUTED)[0]).T
    np.testing.assert_allclose(z, x, atol=1e-9)
    assert (np.diff(x) > 0.0).all()


def test_a_walk_has_six_pictures_of_which_the_normal_forces_are_of_its_end(
    figures: dict[str, Any], tmp_path: Path
) -> None:
    names = ["velocity", "footfalls", "cone_use", "normal_forces", "path", "torques"]
    assert draw_walk(walk(), tmp_path) == [tmp_path / f"{name}.png" for name in names]
    assert [*figures] == [f"{name}.png" for name in names]
    time = np.asarray(figures["normal_forces.png"].axes[0].lines[0].get_xdata())
    np.testing.assert_allclose([time[0], time[-1]], [2.0, 5.0])
    assert np.asarray(figures["torques.png"].axes[0].lines[0].get_xdata())[0] == 0.0
