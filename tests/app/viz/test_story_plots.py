"""Pictures of why a run went wrong: its moments, the robots at them, and the curves that show the cause."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.app.viz.story_plots import draw_panels_of_story, draw_story
from surefoot.app.viz.style import BAD, FORCE, INK, MUTED, blank_figure
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.records import Log
from surefoot.records.audit import AuditReport
from surefoot.records.audit.story.told import Cause, Event, Story
from tests.app.viz.drawn_axes import (
    arrows_of,
    assert_legible,
    ends_of,
    legend_of,
    legend_place,
    level_lines,
    lines_in,
    points_of,
    texts_of,
)
from tests.robots import go2

MASS = 10.0
WEIGHT = MASS * 9.81
SCALE = 1.0 / 1.1
"""Share of a place's width for a metre: the robot's centre of mass is 0.5 m up, 2.2 times that is a place."""
PLACES = np.array([[0.2, 0.1, 0.0], [-0.2, -0.1, 0.05]])
"""Of two feet [m]."""


def log_of(com: FloatArray | None = None, facts: dict[str, Any] | None = None, **channels: Any) -> Log:
    """Return a log of 11 rows in a second: a body goes 1 m along x, on two feet that share its weight."""
    time = np.linspace(0.0, 1.0, 11)
    forces = np.zeros((11, 2, 3))
    forces[..., 2] = 0.5 * WEIGHT
    walk = np.stack([time, 0.0 * time, 0.0 * time + 0.5], axis=1)
    arrays = {
        "time": time, "com": walk if com is None else com, "forces": forces, "mu": np.full(11, 0.5),
        "contact_positions": np.tile(PLACES, (11, 1, 1)),
    }  # fmt: skip
    known = {"mass": MASS, "feet": ["left", "right"], "contact_foot": [0, 1]}
    arrays = {name: array for name, array in {**arrays, **channels}.items() if array is not None}
    return Log(arrays, {**known, **(facts or {})})


def cause(time: float, name: str, where: str = "left") -> Cause:
    return Cause(name, time, where, "it was", "nothing", "rest")


def event(time: float, name: str) -> Event:
    return Event(name, time, "body", "it did")


def report_of(log: Log | None, story: Story | None = None, end: float = 1.0) -> AuditReport:
    told = Story() if story is None else story
    return AuditReport(
        "lawful", (), {}, (), {}, (), (), 11, 0.0, end, ("left", "right"), WEIGHT, story=told, log=log
    )


def picture(log: Log, story: Story | None = None, end: float = 1.0) -> Any:
    figure = blank_figure()
    draw_panels_of_story(report_of(log, story, end), figure)
    return figure


def panel(figure: Any, label: str) -> Any:
    (found,) = [axis for axis in figure.axes if axis.get_ylabel().startswith(label)]
    return found


def curve(axis: Any, name: str) -> list[float]:
    """Return the heights of the curve of a name."""
    (found,) = [line for line in axis.lines if line.get_label() == name]
    return [float(height) for height in found.get_ydata()]


def test_a_report_without_its_log_has_no_picture() -> None:
    with pytest.raises(ProblemError, match="the report has no log"):
        draw_panels_of_story(report_of(None), blank_figure())


def test_a_story_becomes_a_picture_six_inches_wide(tmp_path: Path) -> None:
    from matplotlib.image import imread

    path = draw_story(report_of(log_of(torques=np.ones((11, 1)))), tmp_path / "story.png")
    assert path == tmp_path / "story.png"
    assert imread(path).shape[:2] == (round(130 * (2.6 + 2 * 1.3)), 6 * 130)


def test_robots_stand_at_causes_failure_events_and_the_end_in_the_order_of_time() -> None:
    story = Story(
        (event(0.3, "trips"), event(0.9, "rolls")),
        (cause(0.5, "ice patch"), cause(0.2, "late"), cause(0.1, "no third cause")),
        event(0.7, "fell"),
    )
    words = texts_of(picture(log_of(), story).axes[0])
    assert words[0::2] == ["0.20 s", "0.30 s", "0.50 s", "0.70 s", "0.90 s", "1.00 s"]
    assert words[1::2] == ["late\nleft", "trips", "ice\npatch\nleft", "fell", "rolls", "end"]


def test_of_many_events_the_first_five_and_the_end_are_drawn() -> None:
    story = Story(tuple(event(0.1 * k, f"event{k}") for k in range(9)))
    words = texts_of(picture(log_of(), story).axes[0])
    assert words[1::2] == ["event0", "event1", "event2", "event3", "event4", "end"]


def test_an_event_is_not_drawn_within_a_twentieth_of_a_second_of_another() -> None:
    """The distance is from times in whole milliseconds."""
    events = (event(0.05, "a"), event(0.09, "b"), event(0.5502, "c"), event(0.7004, "d"), event(0.7502, "e"))
    story = Story(events, (cause(0.5004, "ice"),), event(0.0, "fell"))
    words = texts_of(picture(log_of(), story).axes[0])
    assert words[1::2] == ["fell", "a", "ice\nleft", "c", "d", "end"]
    near = Story((event(0.4, "a"), event(0.44, "b"), event(0.7004, "d"), event(0.7502, "e")))
    assert texts_of(picture(log_of(), near).axes[0])[1::2] == ["a", "d", "e", "end"]


def test_causes_are_red_in_words_and_as_strong_lines_through_every_panel() -> None:
    story = Story((event(0.3, "trips"),), (cause(0.5, "ice"),))
    figure = picture(log_of(torques=np.ones((11, 1))), story)
    assert [text.get_color() for text in figure.axes[0].texts if text.get_text()] == [
        INK, INK, BAD, BAD, INK, INK,
    ]  # fmt: skip
    assert len(figure.axes) == 3
    for axis in figure.axes[1:]:
        marks = [line for line in axis.lines if list(line.get_ydata()) == [0, 1]]
        assert [line.get_xdata()[0] for line in marks] == [0.3, 0.5, 1.0]
        assert [line.get_color() for line in marks] == [MUTED, BAD, MUTED]
        widths = [line.get_linewidth() for line in marks]
        assert 0.5 <= widths[0] == widths[2] < 1.0 < widths[1] <= 1.5


def test_each_robot_has_a_place_with_its_words_above() -> None:
    axis = picture(log_of(), Story((event(0.3, "trips"),))).axes[0]
    assert axis.get_xlim() == (0.0, 2.0)
    low, high = axis.get_ylim()
    assert (low, high) == (-0.8, 1.1)
    words = [text for text in axis.texts if text.get_text()]
    assert [text.get_position()[0] for text in words] == [0.5, 0.5, 1.5, 1.5]
    heights = [text.get_position()[1] for text in words]
    assert 0.5 < heights[0] < heights[1] < high - 0.2
    assert words[1].get_va() == "bottom"
    assert {text.get_ha() for text in words} == {"center"}
    assert not axis.axison


def test_feet_and_forces_stand_about_the_centre_of_mass_of_their_row() -> None:
    """At 0.3 s the body is at x = 0.3; half its weight is an arrow of half its height."""
    axis = picture(log_of(), Story((event(0.3, "trips"),))).axes[0]
    dots = lines_in(axis, INK)
    np.testing.assert_allclose([points_of(dot)[0] for dot in dots], [[0.5, 0.0], [1.5, 0.0]], atol=1e-9)
    assert all(dot.get_marker() == "o" and 2.0 <= dot.get_markersize() < 4.0 for dot in dots)
    ends = np.array([ends_of(arrow) for arrow in arrows_of(axis)])
    feet = np.array([[-0.1, -0.5], [-0.5, -0.45], [-0.8, -0.5], [-1.2, -0.45]])
    starts = SCALE * feet + [[0.5, 0.0], [0.5, 0.0], [1.5, 0.0], [1.5, 0.0]]
    np.testing.assert_allclose(ends[:, 0], starts, atol=1e-9)
    np.testing.assert_allclose(ends[:, 1] - ends[:, 0], np.tile([0.0, 0.25 * SCALE], (4, 1)), atol=1e-9)
    assert all(arrow.arrow_patch.get_edgecolor()[:3] == _rgb(FORCE) for arrow in arrows_of(axis))


def _rgb(colour: str) -> tuple[float, ...]:
    from matplotlib.colors import to_rgb

    return to_rgb(colour)


def test_moments_outside_the_log_are_drawn_at_its_first_and_last_rows() -> None:
    axis = picture(log_of(), Story((event(-1.0, "before"), event(2.0, "after")))).axes[0]
    feet = [ends_of(arrow)[0, 0] for arrow in arrows_of(axis)][::2]
    np.testing.assert_allclose(feet, [0.5 + 0.2 * SCALE, 1.5 - 0.8 * SCALE, 2.5 - 0.8 * SCALE], atol=1e-9)


def test_feet_without_a_load_have_no_arrow() -> None:
    forces = np.zeros((11, 2, 3))
    forces[:, 0, 2], forces[:, 1, 2] = WEIGHT, 0.01 * WEIGHT
    assert len(arrows_of(picture(log_of(forces=forces)).axes[0])) == 1


def patch(log: Log) -> FloatArray:
    """Return the corners of the ground at the end [m], from the centre of mass along heading and up."""
    (ground,) = picture(log).axes[0].patches
    return np.asarray((ground.get_xy()[:4] - np.array([0.5, 0.0])) / SCALE, dtype=np.float64)


def test_the_ground_is_a_slab_of_ten_centimetres_under_the_lowest_foot() -> None:
    """Of 0.45 m to each side of it: nine tenths of the height of the centre of mass."""
    np.testing.assert_allclose(
        patch(log_of()), [[-1.25, -0.5], [-0.35, -0.5], [-0.35, -0.6], [-1.25, -0.6]], atol=1e-9
    )


def test_the_ground_is_not_under_what_moves_nor_under_a_raised_foot() -> None:
    crate = log_of(facts={"contact_other_moves": [1, 0]})
    np.testing.assert_allclose(patch(crate)[:2], [[-1.65, -0.45], [-0.75, -0.45]], atol=1e-9)
    raised = np.zeros((11, 2, 3))
    raised[0, :, 2] = WEIGHT
    raised[1:, 1, 2] = WEIGHT
    np.testing.assert_allclose(patch(log_of(forces=raised))[:2, 1], [-0.45, -0.45], atol=1e-9)


def test_in_the_air_the_ground_is_under_the_lowest_foot() -> None:
    forces = np.zeros((11, 2, 3))
    forces[0, :, 2] = 0.5 * WEIGHT
    np.testing.assert_allclose(patch(log_of(forces=forces))[:2], [[-1.25, -0.5], [-0.35, -0.5]], atol=1e-9)


def test_a_slope_is_drawn_as_steep_as_it_is() -> None:
    """A slope of 30 degrees that rises along x, under the first foot."""
    normals = np.tile([-0.5, 0.0, np.sqrt(0.75)], (11, 2, 1))
    corners = patch(log_of(normals=normals))
    way = 0.45 * np.array([np.sqrt(0.75), 0.5])
    np.testing.assert_allclose(corners[:2], np.array([-0.8, -0.5]) + np.stack([-way, way]), atol=1e-9)
    np.testing.assert_allclose(corners[2:] - corners[1::-1], [[0.0, -0.1]] * 2, atol=1e-9)


def test_a_log_without_contacts_stands_on_nothing_and_has_no_curves() -> None:
    log = log_of(forces=None, contact_positions=None, mu=None)
    log.facts = {"mass": MASS}
    figure = picture(log, Story((event(0.3, "trips"),)))
    (axis,) = figure.axes
    assert texts_of(axis)[1::2] == ["trips", "end"]
    assert axis.get_xlabel() == ""
    np.testing.assert_allclose(figure.get_size_inches(), [6.0, 2.6])
    # without a height, 0.22 m are a place; the ground is at the centre of mass, 0.09 m to each side
    corners = (axis.patches[0].get_xy()[:4] - np.array([0.5, 0.0])) * 0.22
    np.testing.assert_allclose(corners, [[-0.09, 0.0], [0.09, 0.0], [0.09, -0.1], [-0.09, -0.1]], atol=1e-9)


def test_the_robot_is_drawn_from_the_side_of_its_farthest_way_on_the_level() -> None:
    """It rises by 5 m, sways in the second row, and is 0.6 m along x and 0.8 m against y at last."""
    com = np.array([3.0, 2.0, 0.5]) + np.linspace(0.0, 1.0, 11)[:, None] * np.array([0.6, -0.8, 0.0])
    com[5, 2] += 5.0
    com[1] += [0.4, 0.1, 0.0]
    axis = picture(log_of(com, contact_positions=np.tile([[3.0, 1.2, 0.0]], (11, 2, 1)))).axes[0]
    foot = ends_of(arrows_of(axis)[0])[0]
    np.testing.assert_allclose(foot, [0.5 - 0.36 * SCALE, -0.5 * SCALE], atol=1e-9)


def test_a_robot_that_stays_is_drawn_from_a_side() -> None:
    """Across x, so that its left is at the right."""
    com = np.tile([0.0, 0.0, 0.5], (11, 1))
    axis = picture(log_of(com)).axes[0]
    places = np.array([ends_of(arrow)[0] for arrow in arrows_of(axis)])
    np.testing.assert_allclose(places[:, 0], [0.5 + 0.1 * SCALE, 0.5 - 0.1 * SCALE], atol=1e-9)


def test_friction_is_a_share_of_what_there_is_and_a_gap_in_the_air() -> None:
    forces = np.zeros((11, 2, 3))
    forces[:, :, 2] = 0.5 * WEIGHT
    forces[:, 0, 0], forces[:, 1, 1] = 0.125 * WEIGHT, WEIGHT
    forces[5:, 0, 2] = 0.0
    axis = panel(picture(log_of(forces=forces)), "friction")
    np.testing.assert_allclose(curve(axis, "left"), [0.5] * 5 + [np.nan] * 6)
    np.testing.assert_allclose(curve(axis, "right"), [1.5] * 11)  # four times what there is, drawn at 1.5
    assert level_lines(axis) == [1.0]
    assert lines_in(axis, BAD)[0].get_linestyle() == ":"
    assert legend_of(axis) == ["right", "left"]  # the busier foot first
    np.testing.assert_allclose(legend_place(axis), [1.0, 0.5], atol=1e-9)
    assert 0.5 <= axis.get_legend().handlelength < 1.5


def test_the_six_busiest_feet_are_drawn_and_none_where_friction_is_unknown() -> None:
    forces = np.zeros((11, 7, 3))
    forces[..., 2] = 10.0 + np.array([3.0, 5.0, 1.0, 6.0, 2.0, 0.0, 4.0])
    feet: dict[str, Any] = {"feet": list("abcdefg"), "contact_foot": [*range(7)]}
    log = log_of(forces=forces, contact_positions=np.zeros((11, 7, 3)), facts=feet)
    assert legend_of(panel(picture(log), "friction")) == ["d", "b", "g", "a", "e", "c"]
    assert len(picture(log_of(mu=None)).axes) == 1
    assert len(picture(log_of(forces=np.zeros((11, 2, 3)))).axes) == 1


def test_torques_are_shares_of_their_limits() -> None:
    torques = np.tile([0.25, -0.2, 1.0], (11, 1))
    facts: dict[str, Any] = {"joints": ["hip", "knee", "toe"], "effort_limits": [0.5, 0.4, 2.0]}
    axis = panel(picture(log_of(torques=torques, facts=facts)), "torque")
    np.testing.assert_allclose(curve(axis, "hip"), [0.5] * 11)
    np.testing.assert_allclose(curve(axis, "knee"), [-0.5] * 11)
    np.testing.assert_allclose(curve(axis, "toe"), [0.5] * 11)
    assert level_lines(axis) == [1.0]
    assert axis.get_ylabel() == "torque\n/ largest"


def test_torques_without_limits_are_shares_of_the_largest_torque() -> None:
    torques = np.tile([0.25, -0.05], (11, 1))
    torques[3] = [-0.5, 0.0]
    axis = panel(picture(log_of(torques=torques)), "torque")
    np.testing.assert_allclose(curve(axis, "joint 0"), [0.5] * 3 + [-1.0] + [0.5] * 7)
    np.testing.assert_allclose(curve(axis, "joint 1"), [-0.1] * 3 + [0.0] + [-0.1] * 7)
    assert curve(panel(picture(log_of(torques=np.zeros((11, 1)))), "torque"), "joint 0") == [0.0] * 11
    locked = log_of(torques=np.zeros((11, 1)), facts={"effort_limits": [0.0], "joints": ["hip"]})
    assert curve(panel(picture(locked), "torque"), "hip") == [0.0] * 11


def test_joints_of_causes_come_first_then_the_hardest_worked() -> None:
    torques = np.tile([1.0, -7.0, 3.0, 6.0, -2.0, 5.0, 4.0], (11, 1))
    facts: dict[str, Any] = {"joints": list("ABCDEFG")}
    story = Story((), (cause(0.1, "weak", "E"), cause(0.2, "weak", "A"), cause(0.3, "weak", "C")))
    assert legend_of(panel(picture(log_of(torques=torques, facts=facts), story), "torque")) == [
        "A", "E", "B", "D", "F",
    ]  # fmt: skip


def test_panels_share_the_time_of_the_report_and_the_last_one_names_it() -> None:
    figure = picture(log_of(torques=np.ones((11, 1))), end=0.8)
    robots, friction, torque = figure.axes
    assert friction.get_shared_x_axes().joined(friction, torque)
    assert not friction.get_shared_x_axes().joined(friction, robots)
    assert friction.get_xlim() == torque.get_xlim() == (0.0, 0.8)
    assert [a.xaxis.get_tick_params()["labelbottom"] for a in (friction, torque)] == [False, True]
    assert [a.get_xlabel() for a in figure.axes] == ["", "", "time [s]"]
    np.testing.assert_allclose(points_of(friction.lines[0])[:, 0], np.linspace(0.0, 1.0, 11))
    grid = robots.get_subplotspec().get_gridspec()
    np.testing.assert_allclose(np.divide(grid.get_height_ratios(), 1.3), [2.0 / 1.3, 1.0, 1.0])
    assert 0.1 < grid.left < 0.2
    assert 0.7 < grid.right < 0.8
    assert 0.2 < grid.hspace < 0.3
    assert_legible(figure)
    assert 0.0 < np.diff(picture(log_of(), end=0.0).axes[1].get_xlim())[0] < 1e-3


def test_the_title_is_the_failure_and_its_first_cause_in_four_lines_at_most() -> None:
    failure, first = event(0.7, "fell"), cause(0.5, "ice")
    assert picture(log_of()).get_suptitle() == "Nothing went wrong that the log can tell."
    assert picture(log_of(), Story((), (), failure)).get_suptitle() == "0.70 s: fell, it did."
    assert picture(log_of(), Story((), (first,))).get_suptitle() == "First cause: ice at left, it was."
    both = picture(log_of(), Story((), (first,), failure))
    assert both.get_suptitle() == "0.70 s: fell, it did. First cause: ice at left, it was."
    long = picture(log_of(), Story((), (), Event("fell", 0.7, "body", "abc " * 200))).get_suptitle()
    lines = long.split("\n")
    assert len(lines) == 4
    assert [len(line) for line in lines[1:]] == [67, 67, 67]  # of 70 letters at most: 17 words of 4
    assert 9.0 <= both._suptitle.get_fontsize() <= 10.5
    assert both._suptitle.get_wrap()


def walker(tilt: float = 0.0, aside: float = 0.0, facts: dict[str, Any] | None = None) -> Log:
    """Return a log of a go2 that stands, tilted about y at the end [rad], its centre of mass aside [m]."""
    import pinocchio

    robot, q = go2(), np.tile(go2().nominal, (11, 1))
    q[10, 3:7] = 0.0, np.sin(0.5 * tilt), 0.0, np.cos(0.5 * tilt)
    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, q[0])
    points = robot.contact_points
    places = [data.oMi[int(j)].act(p) for j, p in zip(points.joints, points.places, strict=True)]
    forces = np.zeros((11, 4, 3))
    forces[..., 2] = 0.25 * WEIGHT
    edge = max(place[1] for place in places)
    return log_of(
        np.tile([0.0, edge + aside, 0.5], (11, 1)), q=q, v=np.zeros((11, 18)), forces=forces,
        contact_positions=np.tile(places, (11, 1, 1)), normals=np.tile([0.0, 0.0, 1.0], (11, 4, 1)),
        facts={"robot": "go2", "feet": list(robot.foot_names), "contact_foot": [0, 1, 2, 3], **(facts or {})},
    )  # fmt: skip


def test_balance_is_the_capture_point_in_centimetres_and_the_lean_in_degrees() -> None:
    axis = panel(picture(walker(tilt=np.radians(20.0), aside=0.1)), "balance")
    np.testing.assert_allclose(curve(axis, "capture point\noutside feet [cm]"), [10.0] * 11, atol=0.05)
    np.testing.assert_allclose(curve(axis, "lean [deg]"), [0.0] * 10 + [20.0], atol=1e-6)
    assert level_lines(axis) == [0.0]
    assert len(picture(log_of(torques=np.ones((11, 1)))).axes) == 3  # a base that is not known has none


def test_links_are_drawn_from_joint_to_joint_and_on_to_the_feet() -> None:
    """Eight links of four legs behind their hips, four hips at the base, and four shanks."""
    import pinocchio

    log, robot = walker(), go2()
    q = np.asarray(log["q"][10])
    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, q)
    com = np.asarray(log["com"][10])
    scale = 1.0 / (2.2 * float((com - log["contact_positions"][10])[:, 2].max()))

    def place(at: Any) -> FloatArray:  # a robot that stays is drawn across x
        return np.array([0.5 + scale * (at[1] - com[1]), scale * (at[2] - com[2])])

    bones = [points_of(line) for line in picture(log).axes[0].lines if line.get_marker() == "None"]
    assert len(bones) == 16
    names = ("hip", "thigh", "calf")
    for k, foot in enumerate(("FL", "FR", "RL", "RR")):
        joints = [data.oMi[robot.model.getJointId(f"{foot}_{name}_joint")].translation for name in names]
        chain = [data.oMi[1].translation, *joints, log["contact_positions"][10, k]]
        for pair in pairwise(chain):
            drawn = np.array([place(at) for at in pair])
            assert min(float(np.abs(bone - drawn).max()) for bone in bones) < 1e-9
    only = picture(walker(facts={"contact_is_foot": [1, 0, 0, 1]}))
    assert len([line for line in only.axes[0].lines if line.get_marker() == "None"]) == 14
    widths = {line.get_linewidth() for line in picture(log).axes[0].lines if line.get_marker() == "None"}
    assert all(1.0 < width < 2.0 for width in widths)
