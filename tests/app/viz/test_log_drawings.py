"""The picture of any log: which panels it has, which feet and joints, in which shares and ranges."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from surefoot.app.viz.log_drawings import draw_log
from surefoot.app.viz.style import BAD, INK, blank_figure
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.records import Log
from tests.app.viz.drawn_axes import assert_legible, legend_of, legend_place, lines_in, points_of, texts_of


def picture(facts: dict[str, Any] | None = None, **channels: Any) -> Any:
    """Return the figure of a log with rows a tenth of a second apart."""
    count = len(next(iter(channels.values())))
    figure = blank_figure()
    draw_log(Log({"time": 0.1 * np.arange(count), **channels}, facts or {}), figure)
    return figure


def curves(figure: Any, label: str) -> dict[str, list[float]]:
    """Return name to heights of the curves in the panel of a label."""
    (axis,) = [one for one in figure.axes if one.get_ylabel().startswith(label)]
    return {
        line.get_label(): [float(y) for y in line.get_ydata()] for line in axis.lines[: len(legend_of(axis))]
    }


def pressing(normal: Any, along: Any = 0.0) -> FloatArray:
    """Return (T, p, 3) forces of (T, p) normal and tangential ones."""
    forces = np.zeros((*np.shape(normal), 3))
    forces[..., 2], forces[..., 0] = normal, along
    return forces


def test_a_log_of_nothing_that_is_drawn_is_refused_with_what_it_has() -> None:
    with pytest.raises(ProblemError, match=r"none of q, com, v, forces, torques: .* in time, mu"):
        picture(mu=np.ones(3))
    with pytest.raises(ProblemError, match="nothing to draw"):
        picture(torques=np.zeros((3, 0)), q=np.zeros((3, 6)))


def test_height_and_velocity_are_the_base_s() -> None:
    q, v = np.zeros((3, 7)), np.tile(np.arange(1.0, 7.0), (3, 1))
    q[:, 2], q[:, 6] = [0.3, 0.4, 0.5], 1.0
    figure = picture(q=q, v=v, com=np.ones((3, 3)))
    assert [axis.get_ylabel() for axis in figure.axes] == ["height of the\nbase [m]", "base velocity\n[m/s]"]
    assert curves(figure, "height") == {"base": [0.3, 0.4, 0.5]}
    assert curves(figure, "base velocity") == {"x": [1.0] * 3, "y": [2.0] * 3, "z": [3.0] * 3}
    np.testing.assert_allclose(points_of(figure.axes[0].lines[0])[:, 0], [0.0, 0.1, 0.2])
    assert figure.axes[0].get_shared_x_axes().joined(*figure.axes)
    assert [axis.get_xlabel() for axis in figure.axes] == ["", "time [s]"]
    assert figure.get_suptitle() == "Log: 0.2 s, 3 rows at 10 Hz"
    assert (figure._suptitle.get_fontsize(), figure._suptitle.get_color()) == (9.0, INK)
    np.testing.assert_allclose(legend_place(figure.axes[0]), [1.0, 0.5], atol=1e-9)
    assert_legible(figure)


def test_without_a_free_base_the_height_is_that_of_the_centre_of_mass() -> None:
    com = np.array([[0.0, 0.1, 0.2], [0.3, 0.4, 0.5]])
    for figure in (picture(com=com), picture(com=com, q=np.zeros((2, 6)), v=np.zeros((2, 6)))):
        assert [axis.get_ylabel() for axis in figure.axes] == ["height of the\nCoM [m]"]
        assert curves(figure, "height") == {"com": [0.2, 0.5]}
    assert len(picture(com=com, v=np.zeros((2, 6))).axes) == 1


def test_forces_of_a_foot_s_points_are_added_up() -> None:
    facts: dict[str, Any] = {"feet": ["left", "right"], "contact_foot": [1, 0, 1]}
    figure = picture(facts, forces=pressing([[1.0, 2.0, 4.0], [3.0, 5.0, 7.0]]))
    assert curves(figure, "normal") == {"left": [2.0, 5.0], "right": [5.0, 10.0]}


@pytest.mark.parametrize(
    ("facts", "names"),
    [
        ({}, ["contact 0", "contact 1"]),
        ({"feet": ["left", "right"]}, ["left", "right"]),
        ({"feet": ["left", "right"], "contact_foot": [0, 2]}, ["left", "right"]),
        ({"feet": ["left"], "contact_foot": [0, 1]}, ["contact 0", "contact 1"]),
        ({"feet": ["left", "right"], "contact_foot": [0]}, ["left", "right"]),
    ],
)
def test_contacts_have_the_names_of_feet_only_where_these_fit(
    facts: dict[str, Any], names: list[str]
) -> None:
    figure = picture(facts, forces=pressing([[1.0, 2.0], [3.0, 5.0]]))
    assert curves(figure, "normal") == {names[0]: [1.0, 3.0], names[1]: [2.0, 5.0]}


def test_the_eight_busiest_contacts_are_drawn_in_their_order() -> None:
    load = np.array([5.0, 1.0, 6.0, 2.0, 9.0, 3.0, 4.0, 8.0, 7.0])
    forces = pressing(np.tile(load, (4, 1)))
    forces[2, 1] = np.nan  # a gap is no load
    names = [f"contact {k}" for k in (0, 2, 3, 4, 5, 6, 7, 8)]
    assert [*curves(picture(forces=forces), "normal")] == names


def test_friction_is_a_share_of_the_law_s_with_gaps_where_little_bears() -> None:
    """A fiftieth of the largest normal force is little; shares beyond 1.5 are drawn at it."""
    normal = np.array([[100.0], [2.5], [2.0], [50.0]])
    figure = picture(forces=pressing(normal, [[25.0], [1.0], [0.5], [90.0]]), mu=np.full(4, 0.5))
    np.testing.assert_allclose(curves(figure, "friction")["contact 0"], [0.5, 0.8, np.nan, 1.5])
    axis = figure.axes[-1]
    (mark,) = lines_in(axis, BAD)
    assert (mark.get_ydata()[0], mark.get_linestyle()) == (1.0, "--")
    assert axis.get_ylabel() == "friction used\n[1]"
    assert_legible(figure)


def test_friction_counts_both_directions_along_the_ground() -> None:
    forces = pressing([[10.0], [10.0]], 3.0)
    forces[..., 1] = -4.0
    assert curves(picture(forces=forces, mu=np.ones(2)), "friction") == {"contact 0": [0.5, 0.5]}


def test_friction_of_a_contact_is_its_own_and_of_a_foot_its_slipperiest_point_s() -> None:
    forces, mu = pressing([[10.0, 10.0], [10.0, 10.0]], 2.0), np.array([[0.4, 0.8], [0.5, 0.0]])
    drawn = curves(picture(forces=forces, contact_friction=mu, mu=np.ones(2)), "friction")
    np.testing.assert_allclose(drawn["contact 0"], [0.5, 0.4])
    np.testing.assert_allclose(drawn["contact 1"], [0.25, np.nan])
    foot: dict[str, Any] = {"feet": ["left"], "contact_foot": [0, 0]}
    mu[1] = [0.8, 0.5]
    np.testing.assert_allclose(
        curves(picture(foot, forces=forces, contact_friction=mu), "friction")["left"], [0.5, 0.4]
    )


def test_friction_needs_forces_and_a_law() -> None:
    assert len(picture(forces=pressing([[1.0], [1.0]])).axes) == 1
    assert len(picture(com=np.zeros((2, 3)), mu=np.ones(2)).axes) == 1
    silent = picture(forces=pressing([[0.0], [0.0]]), mu=np.ones(2))
    np.testing.assert_array_equal(curves(silent, "friction")["contact 0"], [np.nan, np.nan])


def test_the_four_hardest_worked_joints_are_drawn() -> None:
    torques = np.tile([1.0, -6.0, 2.0, 3.0, 5.0], (3, 1))
    torques[1] = [0.0, 0.0, -9.0, np.nan, 0.0]
    figure = picture(torques=torques)
    assert [*curves(figure, "torque")] == ["joint 2", "joint 1", "joint 4", "joint 3"]
    assert curves(figure, "torque")["joint 2"] == [2.0, -9.0, 2.0]
    named = picture({"joints": list("abcde")}, torques=torques)
    assert [*curves(named, "torque")] == ["c", "b", "e", "d"]
    assert named.axes[0].get_ylabel() == "torque\n[N m]"


def spike(top: float, low: float = 100.0) -> Any:
    """Return the panel of a force of 100 N with one row of another, and one of the least."""
    normal = np.full((2000, 1), 100.0)
    normal[700], normal[50] = top, low
    return picture(forces=pressing(normal)).axes[0]


def test_an_impact_is_marked_and_does_not_squash_other_forces() -> None:
    axis = spike(1000.0)
    np.testing.assert_allclose(axis.get_ylim(), [0.0, 130.0])
    assert texts_of(axis) == ["1e+03 N"]
    np.testing.assert_allclose(points_of(axis.lines[-1])[0, 0], 70.0)
    np.testing.assert_allclose(spike(1000.0, -20.0).get_ylim(), [-20.0, 130.0])


def test_forces_of_a_usual_range_are_drawn_whole() -> None:
    """130 N, of which seven tenths of the largest have to be more."""
    assert spike(187.0).get_ylim()[1] == pytest.approx(130.0)
    assert spike(184.0).get_ylim()[1] > 184.0
    assert not texts_of(spike(184.0))
    gap = np.full((4, 1), 100.0)
    gap[2] = np.nan
    assert picture(forces=pressing(gap)).axes[0].get_ylim()[1] >= 100.0


def test_only_the_usual_range_of_normal_forces_is_cut() -> None:
    heights = np.full((2000, 3), 0.3)
    heights[50] = 9.0
    assert picture(com=heights).axes[0].get_ylim()[1] > 9.0


def test_long_logs_are_thinned() -> None:
    figure = picture(com=np.zeros((8001, 3)))
    line = points_of(figure.axes[0].lines[0])
    assert len(line) == 4001
    np.testing.assert_allclose(line[:2, 0], [0.0, 0.2])
