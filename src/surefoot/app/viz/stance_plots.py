"""Pictures of robots and stances: contacts, cones, forces or the falling motion, and their regions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.app.viz.palette import OUTLINE_WIDTH
from surefoot.app.viz.shapes import bones, cone_rim, ring
from surefoot.app.viz.stance_scene import draw_bones, draw_labels, draw_surfaces
from surefoot.app.viz.style import (
    BAD,
    FOOT_COLOURS,
    FORCE,
    GOOD,
    INK,
    MUTED,
    blank_figure,
    friction_colour,
    house_style,
    save,
)
from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot, Verdict
from surefoot.mechanics.stance import Contact, Stance, StanceQuestion
from surefoot.mechanics.statics.com_region import com_region, support_polygon
from surefoot.mechanics.statics.region import Region, polygon_area
from surefoot.records.identification.force_estimate import ForceEstimate

COM, SUPPORT, ZMP = FOOT_COLOURS[0], FOOT_COLOURS[3], FOOT_COLOURS[4]


def draw_check(
    question: StanceQuestion, verdict: Verdict, headline: str, path: Path,
    robot: Robot | None = None, q: FloatArray | None = None,
) -> Path:  # fmt: skip
    """Draw a stance in space and from above, with its forces or the motion that proves that none will do.

    Parameters
    ----------
    question
        Stance, mass and centre of mass.
    verdict
        Whose forces or separating wrench are drawn.
    headline
        Written above.
    path
        New file.
    robot, q
        Who stands there and how (nq,), drawn as well; None for a stance alone.
    """
    figure = blank_figure((11.0, 5.4))
    with house_style():
        space = figure.add_subplot(1, 2, 1, projection="3d")
        above = figure.add_subplot(1, 2, 2)
        region = com_region(question.stance, question.mass, external_wrench=question.external_wrench)
        _ground(space, question.stance, region, question.com)
        _balance(space, verdict, robot, q)
        _above(above, question, region, verdict)
        colour = GOOD if headline.startswith("possible") else BAD
        figure.suptitle(f"{question.name}\n{headline}", color=colour, fontsize=10.5)
    return save(figure, path)


def _balance(axis: Any, verdict: Verdict, robot: Robot | None = None, q: FloatArray | None = None) -> None:
    """Draw contacts on their surfaces, cones, centre of mass, and the forces or the proof in space."""
    stance, com = verdict.stance, verdict.com
    size = _size(stance, com)
    draw_surfaces(axis, stance, size)
    if robot is not None:
        draw_bones(axis, robot, robot.nominal if q is None else finite_array("q", q, robot.nominal.shape))
    for contact in stance:
        _cone(axis, contact, 0.28 * size)
    if verdict.feasible:
        _forces(axis, stance, verdict.by_contact(), size)
    elif verdict.certificate is not None:
        _falling(axis, stance, com, verdict, size)
    axis.scatter(*com, s=55, color=INK, depthshade=False)
    _frame(axis, stance, com, size)


def draw_verdict(
    verdict: Verdict, axes: Any, robot: Robot | None = None, q: FloatArray | None = None
) -> None:
    """Draw what holds a stance, or the motion that proves that nothing does; on plane axes from above.

    Parameters
    ----------
    verdict, axes
        What is drawn where.
    robot, q
        Who stands there and how (nq,), drawn in space as well; None for nobody, and for its nominal pose.
    """
    colour = GOOD if verdict.feasible else BAD
    if axes.name == "3d":
        _balance(axes, verdict, robot, q)
    else:
        _fill(axes, support_polygon(verdict.stance), SUPPORT, "support polygon", filled=False)
        _feet(axes, verdict.stance)
        _pushes(axes, verdict)
        axes.plot(*verdict.com[:2], "o", color=INK, ms=8, label="centre of mass", zorder=5)
        _finish(axes, "")
        axes.legend(fontsize=8)
    margin = f", {verdict.margin:.3g} N to spare" if verdict.feasible else ""
    axes.set_title(f"{verdict.status}{margin}", color=colour)


def draw_stance(stance: Stance, axes: Any, forces: ArrayLike | None = None) -> None:
    """Draw the contacts with their cones, or from above on plane axes; with forces, these in place of names.

    Parameters
    ----------
    stance, axes
        What is drawn where.
    forces
        (n, 3) or (dim,) in contact frames [N, N m], as `surefoot.distribute` returns them.
    """
    carried = None if forces is None else _wrenches(stance, forces)
    if axes.name != "3d":
        _fill(axes, support_polygon(stance), SUPPORT, "support polygon", filled=False)
        _feet(axes, stance)
        if carried is not None:
            weight = max(float(sum(np.linalg.norm(force[:3]) for force in carried)), 1e-300)
            _push_arrows(axes, stance, carried, 0.25 * _size(stance, stance.positions.mean(axis=0)) / weight)
        _finish(axes, f"{len(stance)} contacts from above")
        return
    middle = stance.positions.mean(axis=0) if len(stance) else np.zeros(3)
    size = _size(stance, middle)
    draw_surfaces(axes, stance, size)
    for contact in stance:
        _cone(axes, contact, 0.28 * size)
    if carried is None:
        draw_labels(axes, stance, size, [(contact.name.removesuffix("_foot"), INK) for contact in stance])
    else:
        _forces(axes, stance, carried, size)
    _frame(axes, stance, middle, size)
    axes.set_title(f"{len(stance)} contacts")


def draw_estimate(estimate: ForceEstimate, axes: Any) -> None:
    """Draw the forces that explain a motion best, at the contacts that were taken to touch."""
    draw_stance(estimate.stance, axes, estimate.stacked)
    axes.set_title(f"lawful: {'yes' if estimate.lawful else 'no'}; explainable: {estimate.explainable}")


def _wrenches(stance: Stance, forces: ArrayLike) -> list[FloatArray]:
    """Return each contact's force or wrench, of forces a row a contact or stacked."""
    given = np.asarray(forces, dtype=np.float64)
    if given.shape == (len(stance), 3) and given.size != stance.dim:
        return list(finite_array("forces", given, given.shape))
    stacked = finite_array("forces", given.ravel(), (stance.dim,))
    return [stacked[part] for part in stance.slices]


def draw_region(region: Region, axes: Any) -> None:
    """Draw the region's inner polygon filled, and what it is known to be inside of dashed."""
    _fill(axes, region.inner, COM, f"inside: {1e4 * region.area:.0f} cm²", filled=True)
    _fill(axes, region.outer, MUTED, f"outside of this: none (gap {1e3 * region.gap:.2g} mm)", filled=False)
    _finish(axes, "empty" if region.empty else f"region at height {round(region.height, 2) + 0.0:.2f} m")
    if not region.empty:
        axes.legend(fontsize=8, loc="best")


def draw_robot(robot: Robot, axes: Any, q: FloatArray | None = None) -> None:
    """Draw a robot's links as lines and its feet as dots, at (nq,) q or its nominal configuration."""
    pose = robot.nominal if q is None else finite_array("q", q, robot.nominal.shape)
    lines = bones(robot, pose)
    points = lines.reshape(-1, 3)
    if not len(points):
        raise ProblemError(f"{robot.name} has no joints: there is nothing to draw")
    for line in lines:
        axes.plot(*(line.T if axes.name == "3d" else line[:, [0, 2]].T), color=INK, lw=2.0)
    for name, foot in zip(robot.foot_names, robot.foot_positions(pose), strict=True):
        place = foot if axes.name == "3d" else foot[[0, 2]]
        axes.plot(*(np.atleast_2d(place).T), "o", color=FORCE, ms=4)
        axes.text(*place, f" {name.removesuffix('_foot')}", fontsize=7, color=INK)
    axes.set_title(f"{robot.name}, {robot.mass:.4g} kg, {robot.joints} joints")
    if axes.name == "3d":
        _frame_around(axes, points)
    else:
        axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")


def _size(stance: Stance, com: FloatArray) -> float:
    """Return the extent of the scene [m]."""
    points = np.vstack([stance.points().positions.reshape(-1, 3), com])
    return max(0.1, float(np.ptp(points, axis=0).max()))


def _ground(axis: Any, stance: Stance, region: Region, com: FloatArray) -> None:
    """Draw the CoM region at the lowest contact's height, and the plumb line of the centre of mass."""
    if not len(stance):
        return
    floor = float(stance.points().positions[:, 2].min())
    if len(region.inner) >= 2:
        axis.plot(*ring(region.inner).T, floor, color=COM, lw=1.2)
    if len(region.inner) >= 3:
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        corners = np.column_stack([region.inner, np.full(len(region.inner), floor)])
        axis.add_collection3d(Poly3DCollection([corners], facecolor=COM, alpha=0.15, edgecolor="none"))
    axis.plot([com[0]] * 2, [com[1]] * 2, [floor, com[2]], color=MUTED, lw=1.0, ls=":")


def _cone(axis: Any, contact: Contact, height: float) -> None:
    """Draw a friction cone as a surface; a sole as its outline and one cone in the middle."""
    p = contact.position
    height = min(height, height / max(contact.mu, 1e-9) * 0.8)
    rim = p + cone_rim(contact.mu, height, contact.rotation_world_contact, 40)
    sheet = np.stack([np.broadcast_to(p, rim.shape), rim])
    axis.plot_surface(*np.moveaxis(sheet, -1, 0), color=MUTED, alpha=0.22, linewidth=0)
    axis.plot(*rim.T, color=MUTED, lw=0.7)
    if contact.dim == 6:
        axis.plot(*_sole(contact).T, color=INK, lw=1.4)
    else:
        axis.scatter(*p, s=14, color=INK, depthshade=False)


def _sole(contact: Contact) -> FloatArray:
    """Return the (k + 1, 3) outline of a sole, closed."""
    return ring(np.array([c.position for c in contact.corners()]))  # type: ignore[attr-defined]


def _forces(axis: Any, stance: Stance, forces: list[FloatArray], size: float) -> None:
    """Draw contact forces as arrows, at the centres of pressure of soles, with the friction that they use."""
    longest = max((float(np.linalg.norm(f[:3])) for f in forces), default=0.0)
    labels = []
    for contact, force in zip(stance, forces, strict=True):
        R = contact.rotation_world_contact
        foot = contact.position
        if len(force) == 6 and force[2] > 0.0:
            foot = foot + R @ np.array([-force[4] / force[2], force[3] / force[2], 0.0])
        arrow = R @ force[:3] * (0.5 * size / max(longest, 1e-300))
        used = _used(contact, force)
        colour = friction_colour(used)
        axis.quiver(*foot, *arrow, color=colour, lw=2.0, arrow_length_ratio=0.14)
        name = contact.name.removesuffix("_foot")
        words = f"{name}\n{np.linalg.norm(force[:3]):.0f} N, {100.0 * used:.0f} %".strip()
        labels.append((words, colour))
    draw_labels(axis, stance, size, labels)


def _used(contact: Contact, force: FloatArray) -> float:
    """Return the share of its friction that a force of a contact uses."""
    limit = contact.mu * float(force[2])
    return float(np.hypot(force[0], force[1])) / limit if limit > 0.0 else 0.0


def _falling(axis: Any, stance: Stance, com: FloatArray, verdict: Verdict, size: float) -> None:
    """Draw the separating wrench as a motion: a proof's direction, not how the robot will fall."""
    assert verdict.certificate is not None
    linear, angular = verdict.certificate[:3], verdict.certificate[3:]
    arms = stance.points().positions.reshape(-1, 3) - com
    if len(verdict.multipliers):  # the legs give way, not the contacts: these do not move with the body
        arms = arms[:0]
    moves = linear + np.cross(angular, arms) if len(arms) else np.zeros((0, 3))
    longest = float(np.linalg.norm(np.vstack([linear, moves]), axis=1).max(initial=1e-300))
    scale = 0.45 * size / longest
    axis.quiver(*com, *(scale * linear), color=BAD, lw=2.2, arrow_length_ratio=0.15)
    axis.text(
        *(com + 1.15 * scale * linear + [0.0, 0.0, 0.06 * size]),
        "proof",
        fontsize=8.5,
        color=BAD,
        ha="center",
    )
    for arm, move in zip(arms, moves, strict=True):
        if np.linalg.norm(scale * move) > 0.02 * size:
            axis.quiver(*(com + arm), *(scale * move), color=BAD, lw=1.1, alpha=0.7, arrow_length_ratio=0.2)


def _frame(axis: Any, stance: Stance, com: FloatArray, size: float) -> None:
    """Set equal axes around contacts and centre of mass."""
    _frame_around(axis, np.vstack([stance.points().positions.reshape(-1, 3), com]), size)


def _frame_around(axis: Any, points: FloatArray, size: float | None = None) -> None:
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    reach = 0.72 * (max(0.1, float(np.ptp(points, axis=0).max())) if size is None else size)
    for k, name in enumerate("xyz"):
        getattr(axis, f"set_{name}lim")(middle[k] - reach, middle[k] + reach)
        getattr(axis, f"set_{name}label")(f"{name} [m]", labelpad=-2)
        axis.locator_params(axis=name, nbins=4)
        axis.tick_params(axis=name, pad=-1, labelsize=7)
    axis.set_box_aspect((1, 1, 1), zoom=1.1)
    axis.view_init(elev=20, azim=-62)


def _above(axis: Any, question: StanceQuestion, region: Region, verdict: Verdict) -> None:
    """Draw the stance from above: support polygon, CoM region, centre of mass."""
    stance, com = question.stance, question.com
    shifted = region.inner if region.empty else region.at_height(float(com[2]))
    _fill(axis, shifted, COM, "CoM region", filled=True)
    _fill(axis, support_polygon(stance), SUPPORT, "support polygon", filled=False)
    _feet(axis, stance)
    _pushes(axis, verdict)
    axis.plot(*com[:2], "o", color=INK, ms=8, label="centre of mass", zorder=5)
    _finish(axis, "from above" + (": the CoM region is empty" if region.empty else ""))
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3, fontsize=8)


def _pushes(axis: Any, verdict: Verdict) -> None:
    """Draw the horizontal parts of the forces as arrows; none where there are no forces."""
    share = 0.25 * _size(verdict.stance, verdict.com) / max(float(np.linalg.norm(verdict.load)), 1e-300)
    _push_arrows(axis, verdict.stance, verdict.by_contact(), share)


def _push_arrows(axis: Any, stance: Stance, forces: list[FloatArray], share: float) -> None:
    """Draw horizontal parts of forces, so much of a metre a newton; of no forces none."""
    for contact, force in zip(stance, forces, strict=bool(forces)):
        world = contact.rotation_world_contact @ force[:3]
        if np.linalg.norm(world[:2]) * share > 1e-4:
            colour = friction_colour(_used(contact, force))
            start, arrow = contact.position[:2], {"arrowstyle": "->", "color": colour, "lw": OUTLINE_WIDTH}
            axis.annotate("", start + 2.0 * share * world[:2], start, arrowprops=arrow)


def _fill(axis: Any, polygon: FloatArray, colour: str, label: str, filled: bool) -> None:
    """Draw a polygon, a segment or a point."""
    if not len(polygon):
        return
    if len(polygon) == 1:
        axis.plot(*polygon[0], "s", color=colour, label=label, ms=5)
        return
    style = {"lw": 1.6} if filled else {"lw": 1.3, "ls": (0, (4, 3))}
    axis.plot(*ring(polygon).T, color=colour, label=label, **style)
    if filled and len(polygon) >= 3:
        axis.fill(*polygon.T, color=colour, alpha=0.18, lw=0)


def _feet(axis: Any, stance: Stance) -> None:
    """Draw contacts from above, with their names."""
    for contact in stance:
        if contact.dim == 6:
            axis.plot(*_sole(contact)[:, :2].T, color=MUTED, lw=0.9)
        else:
            axis.plot(*contact.position[:2], "o", color=MUTED, ms=4)
        label = {"xytext": (4, 4), "textcoords": "offset points", "fontsize": 7, "color": INK}
        axis.annotate(contact.name.removesuffix("_foot"), contact.position[:2], **label)


def _finish(axis: Any, title: str) -> None:
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.12)
    axis.set(xlabel="x [m]", ylabel="y [m]", title=title)


def draw_regions(
    question: StanceQuestion, com: Region, zmp: Region | None, support: FloatArray, path: Path
) -> Path:
    """Draw CoM region, support polygon and ZMP region side by side on the same axes.

    Parameters
    ----------
    question
        Stance and centre of mass.
    com, zmp, support
        Regions of the centre of mass and of the zero-moment point, None for none; corners (k, 2) of the
        support polygon [m].
    path
        New file.
    """
    panels = [
        ("CoM region", com.inner, COM),
        ("support polygon", support, SUPPORT),
        ("ZMP region", np.zeros((0, 2)) if zmp is None else zmp.inner, ZMP),
    ]
    figure = blank_figure((11.5, 4.3))
    with house_style():
        axes = figure.subplots(1, 3, sharex=True, sharey=True)
        for axis, (name, polygon, colour) in zip(axes, panels, strict=True):
            for other, shape, tint in panels:
                if other != name:
                    _fill(axis, shape, tint, other, filled=False)
            for line in axis.lines:
                line.set(alpha=0.5, linewidth=1.0)
            _fill(axis, polygon, colour, name, filled=True)
            _feet(axis, question.stance)
            axis.plot(*question.com[:2], "+", color=INK, ms=9, mew=1.6, zorder=5)
            area = 1e4 * polygon_area(polygon)
            _finish(axis, f"{name}, {area:.0f} cm²" if area > 0.0 else f"{name}: {_flat(polygon)}")
            axis.set_aspect("equal", adjustable="box")
        for axis in axes[1:]:
            axis.set_ylabel("")
        figure.suptitle(question.name, color=INK, fontsize=10.5)
    return save(figure, path)


def _flat(polygon: FloatArray) -> str:
    return ("empty", "a point", "a line")[min(len(polygon), 2)]
