"""Pictures of a certified motion: where robots and missing forces stand, which limits are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from surefoot.app.viz.motion_plots import draw_motion, draw_panels_of_motion, write_motion_page
from surefoot.app.viz.style import BAD, FORCE, GOOD, GROUND, INK, MUTED, WARN, blank_figure
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.records.certificates.frame_table import FrameTable
from surefoot.records.certificates.segments import Segment
from tests.app.viz.drawn_axes import (
    arrows_of,
    assert_legible,
    ends_of,
    legend_of,
    level_lines,
    lines_in,
    points_of,
    texts_of,
)
from tests.robots import go2

MASS = 20.0
WEIGHT = MASS * 9.81


class Certificate(SimpleNamespace):
    """What is drawn of a certified motion."""

    def __str__(self) -> str:
        return "still: cannot tell."


def frames_of(count: int, rate: float = 10.0, **columns: Any) -> FrameTable:
    zero, none = np.zeros(count), np.zeros(count, dtype=np.int64)
    words = np.full(count, "", dtype="<U24")
    table: dict[str, Any] = {
        "time": np.arange(count) / rate,
        "verdict": np.full(count, "possible", dtype="<U24"),
        **dict.fromkeys(("force", "moment"), np.zeros((count, 3))),
        **dict.fromkeys(("share", "bound", "detour", "slide_speed", "penetration", "gap", "range"), zero),
        "noise": zero, "cause": words, "joint": words, "contacts": none, "sliding": none,
    }  # fmt: skip
    return FrameTable(**{**table, **columns})


def standing(yaws: Sequence[float] | FloatArray, way: FloatArray | None = None) -> FloatArray:
    """Return configurations of a standing robot, turned about the vertical and moved on the level."""
    q = np.tile(go2().nominal, (len(yaws), 1))
    q[:, 3:5] = 0.0
    q[:, 5], q[:, 6] = np.sin(0.5 * np.asarray(yaws)), np.cos(0.5 * np.asarray(yaws))
    q[:, :2] = 0.0 if way is None else way
    return q


def certificate(q: FloatArray, tall: float = 0.5, com: FloatArray | None = None, **more: Any) -> Certificate:
    """Return what is drawn of a motion; `tall` is how high its highest joint is above its lowest [m]."""
    count = len(q)
    origins = np.zeros((count, 2, 3))
    origins[:, 1, 2] = tall
    com = np.zeros((count, 3)) if com is None else com
    model = SimpleNamespace(
        motion=SimpleNamespace(origins=origins, com=com), rules=SimpleNamespace(mass=MASS)
    )
    about = {
        "motion": SimpleNamespace(robot=go2(), q=q, name="still"), "data": SimpleNamespace(model=model),
        "frames": frames_of(count), "possible": 0.02, "impossible": 0.1, "verdict": "possible",
        "segments": (), "notes": ("no noise",), "good": tuple,
    }  # fmt: skip
    return Certificate(**{**about, **more})


def panels(report: Any) -> Any:
    figure = blank_figure((9.0, 6.0))
    draw_panels_of_motion(report, figure)
    return figure


def bones_of(axes: Any) -> list[Any]:
    """Return the lines of robots: those of two points that are not across the axes."""
    return [line for line in axes.lines if line.get_color() in (GOOD, WARN, BAD, MUTED)]


def test_ten_robots_stand_in_a_row_from_the_first_frame_to_the_last() -> None:
    strip = panels(certificate(standing(np.zeros(25)))).axes[0]
    times = ["0.0", "0.2", "0.5", "0.8", "1.0", "1.3", "1.6", "1.8", "2.1", "2.4"]
    assert texts_of(strip) == [f"{time} s" for time in times]


def test_a_short_motion_has_each_frame_once() -> None:
    assert texts_of(panels(certificate(standing(np.zeros(3)))).axes[0]) == ["0.0 s", "0.1 s", "0.2 s"]


def test_a_robot_is_drawn_from_its_left_wherever_it_heads_and_stands() -> None:
    """Turned and moved robots look as the first one does, each further right by one place."""
    yaws = np.array([0.0, 0.5 * np.pi, -2.0])
    strip = panels(certificate(standing(yaws, np.array([[0.0, 0.0], [3.0, -1.0], [0.0, 7.0]])))).axes[0]
    lines = np.array([points_of(line) for line in bones_of(strip)]).reshape(3, -1, 2, 2)
    apart = lines[1] - lines[0]
    np.testing.assert_allclose(apart[..., 1], 0.0, atol=1e-9)
    np.testing.assert_allclose(apart[..., 0], apart[0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(lines[2] - lines[0], 2.0 * apart, atol=1e-9)


def test_bones_are_where_pinocchio_has_the_joints() -> None:
    import pinocchio

    robot, q = go2(), standing([0.0])
    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, q[0])
    lines = np.array([points_of(line) for line in bones_of(panels(certificate(q)).axes[0])])
    for name in ("FL_thigh_joint", "RR_calf_joint"):
        at = data.oMi[robot.model.getJointId(name)].translation
        ends = np.abs(lines - np.array([at[0], at[2]])).max(axis=-1)
        assert ends.min() < 1e-9


def test_robots_are_as_far_apart_as_the_larger_of_their_length_and_height() -> None:
    """A go2 is longer than 0.5 m high; one whose joints were 3 m apart in height would need 0.9 of that."""
    q = standing(np.zeros(2))
    short, high = (panels(certificate(q, tall)).axes[0] for tall in (0.5, 3.0))
    drawn = np.array([points_of(line) for line in bones_of(short)])
    length = float(np.ptp(drawn[: len(drawn) // 2, :, 0]))
    places = [[text.get_position() for text in axes.texts] for axes in (short, high)]
    np.testing.assert_allclose(places[0], [[0.0, -0.1], [1.15 * length, -0.1]], atol=1e-9)
    np.testing.assert_allclose(places[1], [[0.0, -0.6], [2.7, -0.6]], atol=1e-9)


def test_a_robot_that_lies_flat_leaves_room_for_its_time() -> None:
    strip = panels(certificate(standing(np.zeros(2)), 0.1)).axes[0]
    assert strip.texts[0].get_position()[1] == pytest.approx(-0.06)


def test_robots_have_the_colours_of_their_verdicts() -> None:
    names = np.array(["no window", "possible", "cannot tell", "impossible"])
    report = certificate(standing(np.zeros(4)), frames=frames_of(4, verdict=names))
    bones = bones_of(panels(report).axes[0])
    assert [line.get_color() for line in bones[:: len(bones) // 4]] == [MUTED, GOOD, WARN, BAD]


def missing(share: float, force: Sequence[float], yaw: float = 0.0) -> list[NDArray[np.float64]]:
    """Return the ends of the arrows at a single robot that lacks a force, its centre of mass 0.3 m up."""
    table = frames_of(1, share=np.array([share]), force=np.array([force]))
    way, com = np.array([[2.0, 1.0]]), np.array([[2.0 + 0.1 * np.cos(yaw), 1.0 + 0.1 * np.sin(yaw), 0.3]])
    strip = panels(certificate(standing([yaw], way), com=com, frames=table)).axes[0]
    return [ends_of(arrow) for arrow in arrows_of(strip)]


def test_the_missing_force_starts_at_the_centre_of_mass() -> None:
    """Half the robot's height is drawn for its weight: 0.25 m."""
    (up,) = missing(0.5, [0.0, 0.0, WEIGHT])
    np.testing.assert_allclose(up, [[0.1, 0.3], [0.1, 0.55]], atol=1e-9)
    (ahead,) = missing(0.5, [0.0, 2.0 * WEIGHT, 0.0], yaw=0.5 * np.pi)
    np.testing.assert_allclose(ahead, [[0.1, 0.3], [0.6, 0.3]], atol=1e-9)


def test_only_what_is_more_than_the_noise_is_missing() -> None:
    assert missing(0.02, [0.0, 0.0, WEIGHT]) == []
    assert len(missing(0.021, [0.0, 0.0, WEIGHT])) == 1
    assert missing(0.5, [np.nan, 0.0, WEIGHT]) == []


def test_the_arrow_of_a_later_robot_stands_at_that_robot() -> None:
    table = frames_of(2, share=np.array([0.0, 0.5]), force=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, WEIGHT]]))
    com = np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.3]])
    strip = panels(certificate(standing(np.zeros(2)), com=com, frames=table)).axes[0]
    (arrow,) = arrows_of(strip)
    place = strip.texts[-1].get_position()[0]
    np.testing.assert_allclose(ends_of(arrow), [[place, 0.3], [place, 0.55]], atol=1e-9)
    np.testing.assert_allclose(arrow.arrow_patch.get_edgecolor()[:3], rgb(FORCE))
    assert 0.5 <= arrow.arrow_patch.get_linewidth() <= 2.0


def rgb(colour: str) -> tuple[float, ...]:
    from matplotlib.colors import to_rgb

    return to_rgb(colour)


def test_the_row_stands_on_a_ground_that_hides_nothing_and_has_no_scales() -> None:
    strip = panels(certificate(standing([0.0]))).axes[0]
    (ground,) = lines_in(strip, GROUND)
    assert set(np.asarray(ground.get_ydata()).tolist()) == {0.0}
    assert 2.0 < ground.get_linewidth() < 3.5
    assert ground.get_zorder() < min(line.get_zorder() for line in strip.lines if line is not ground)
    assert not strip.axison
    assert strip.get_aspect() == 1.0
    time = strip.texts[0]
    assert (time.get_ha(), time.get_va()) == ("center", "top")


def test_shares_are_points_in_the_colour_of_their_verdict_between_two_limits() -> None:
    names = np.array(["possible", "impossible", "cannot tell", "impossible"])
    table = frames_of(4, verdict=names, share=np.array([0.01, 0.4, 0.05, 0.2]))
    share = panels(certificate(standing(np.zeros(4)), frames=table)).axes[1]
    points = {line.get_label(): points_of(line).tolist() for line in share.lines[:4]}
    assert points == {
        "possible": [[0.0, 0.01]], "cannot tell": [[0.2, 0.05]], "impossible": [[0.1, 0.4], [0.3, 0.2]],
        "no window": [],
    }  # fmt: skip
    assert [line.get_color() for line in share.lines[:4]] == [GOOD, WARN, BAD, MUTED]
    assert all(2.0 <= line.get_markersize() <= 3.5 for line in share.lines[:4])
    assert sorted(level_lines(share)) == [0.02, 0.1]
    assert [lines_in(share, colour)[-1].get_ydata()[0] for colour in (GOOD, BAD)] == [0.02, 0.1]
    assert legend_of(share) == ["possible", "cannot tell", "impossible", "no window"]
    assert share.get_legend()._ncols == 4  # one row
    assert share.get_ylabel() == "left over [m g]"


def test_the_lowest_point_is_drawn_in_centimetres_below_the_ground_where_it_is_in_it() -> None:
    table = frames_of(3, gap=np.array([0.02, 0.0, 0.0]), penetration=np.array([0.0, 0.0, 0.03]))
    ground = panels(certificate(standing(np.zeros(3)), frames=table)).axes[2]
    (curve,) = lines_in(ground, INK)
    np.testing.assert_allclose(points_of(curve), [[0.0, 2.0], [0.1, 0.0], [0.2, -3.0]], atol=1e-9)
    assert level_lines(ground) == [0.0]
    assert (ground.get_xlabel(), ground.get_ylabel()) == ("time [s]", "lowest [cm]")


def test_the_robots_have_more_room_than_the_curves_below() -> None:
    figure = panels(certificate(standing([0.0])))
    grid = figure.axes[0].get_subplotspec().get_gridspec()
    ratios = np.array(grid.get_height_ratios())
    assert (np.diff(ratios) < 0.0).all()
    assert (ratios > 0.0).all()
    assert ratios[0] < 0.5 * ratios.sum()
    assert 0.0 <= grid.hspace <= 0.5
    assert figure.get_suptitle() == "still: cannot tell."
    assert figure._suptitle.get_fontsize() == 9.0
    assert figure._suptitle.get_wrap()
    assert_legible(figure)


def test_a_certificate_becomes_a_picture_of_nine_by_six_inches(tmp_path: Path) -> None:
    from matplotlib.image import imread

    path = draw_motion(certificate(standing([0.0])), tmp_path / "motion.png")  # type: ignore[arg-type]
    assert path == tmp_path / "motion.png"
    assert imread(path).shape[:2] == (6 * 130, 9 * 130)


def test_the_page_has_stretches_and_what_to_train_on(tmp_path: Path) -> None:
    part = Segment(0.5, 1.25, 5, 12, "friction", 0.3, 0.1, "FL_foot", "slow to 0.8")
    report: Any = certificate(
        standing([0.0]), segments=(part,), good=lambda: ((0.0, 0.4), (1.3, 4.0)), verdict="impossible"
    )
    page = write_motion_page(report, tmp_path / "page.html")
    text = page.read_text(encoding="utf-8")
    cells = ["0.50", "1.25", "friction", "FL_foot", "0.30", "slow to 0.8"]
    assert "".join(f"<td>{cell}</td>" for cell in cells) in text
    head = ["from [s]", "to [s]", "cause", "where", "worst [m g]", "cure"]
    assert "".join(f"<th>{cell}</th>" for cell in head) in text
    assert "<p>0.00 to 0.40 s, 1.30 to 4.00 s</p>" in text
    assert "<p>no noise</p>" in text
    assert "<h1>Is it possible? still</h1>" in text
    assert '<span class="verdict">still: cannot tell.</span>' in text
    assert 'alt="motion" src="data:image/png;base64,' in text
    with pytest.raises(ProblemError, match="exists already"):
        write_motion_page(report, page)


def test_the_page_of_a_possible_motion_is_good_and_has_no_stretches(tmp_path: Path) -> None:
    report: Any = certificate(standing([0.0]))
    text = write_motion_page(report, tmp_path / "page.html").read_text(encoding="utf-8")
    assert '<span class="verdict good">' in text
    assert "<h2>Impossible stretches</h2>\n<p>none</p>" in text
    assert "<p>none of a second</p>" in text
