"""Plots of a logged run: forces, cones, base, torques."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.viz.style import (
    BAD,
    FOOT_COLOURS,
    INK,
    MUTED,
    at_least,
    draw_columns,
    draw_friction_circle,
    most_of,
    new_axis,
    new_grid,
    new_panels,
    save,
)
from surefoot.base.arrays import BoolArray
from surefoot.base.numerics.phases import runs_of
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.records import Log
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.motion import foot_forces, tilt_angles

MOST_POINTS = 4000
"""Longest series that is drawn; longer ones are thinned."""
LEAST_MOVE, LEAST_TURN = 1.0, 0.1
"""Least range of the base's motion in a plot [mm], [deg]: less is still standing."""


def stride_of(count: int) -> slice:
    """Return every how many of `count` rows are drawn."""
    return slice(None, None, max(1, count // MOST_POINTS))


def draw_normal_forces(log: Log, path: Path) -> Path:
    """Draw every foot's normal force over time, against an equal share of the weight."""
    title = "Normal forces of the ground"
    figure, axis = new_axis((8.0, 3.6), title, xlabel="time [s]", ylabel="normal force [N]")
    thin, forces = stride_of(len(log)), foot_forces(log)
    draw_columns(axis, log["time"][thin], forces[thin, :, 2], log.facts["feet"])
    share = log.facts["mass"] * GRAVITY / len(log.facts["feet"])
    axis.axhline(share, color=INK, lw=0.9, ls="--", label=f"m g / {len(log.facts['feet'])} = {share:.1f} N")
    # the first millisecond's impact must not squash the rest
    top = max(1.3 * share, 1.1 * float(np.percentile(forces[..., 2], 99.8)))
    most_of(axis, log["time"], forces[..., 2], min(0.0, float(forces[..., 2].min())), top, "N")
    mark_events(axis, log)
    axis.legend(ncols=3, fontsize=8, loc="best")
    return save(figure, path)


def draw_cone_use(log: Log, path: Path) -> Path:
    """Draw every force in its cone's cross-section, scaled so that the cone is the unit circle."""
    names = log.facts["feet"]
    figure, axes = new_grid(len(names), 4, (2.4, 2.6), (0.0, 0.3), sharex=True, sharey=True)
    threshold = LIMITS.laws.loaded * log.facts["mass"] * GRAVITY
    forces = foot_forces(log)
    for k, axis in enumerate(axes):
        f = forces[:, k]
        loaded = f[:, 2] > threshold
        scaled = f[loaded, :2] / np.maximum(log["mu"][loaded] * f[loaded, 2], 1e-12)[:, None]
        draw_friction_circle(axis, FOOT_COLOURS[k % 8])
        axis.scatter(*scaled[stride_of(len(scaled))].T, s=3, color=FOOT_COLOURS[k % 8], alpha=0.5, lw=0)
        use = float(np.linalg.norm(scaled, axis=1).max(initial=0.0))
        title = f"{names[k]}: at most {100 * use:.0f} %"
        axis.set_title(title, color=BAD if use > 1.001 else INK, fontsize=9)
        axis.set(xlim=(-1.15, 1.15), ylim=(-1.15, 1.15))
    figure.supxlabel(r"$f_x\,/\,\mu f_z$", fontsize=9)
    figure.supylabel(r"$f_y\,/\,\mu f_z$", fontsize=9)
    return save(figure, path)


def draw_base(log: Log, path: Path) -> Path:
    """Draw how far the base moved and turned from where it started."""
    labels = ("base moved [mm]", "base turned [deg]")
    figure, (place, turn) = new_panels(labels, (8.0, 4.6), "Base, from where it started")
    thin = stride_of(len(log))
    time = log["time"][thin]
    moved = 1e3 * (log["q"][thin, :3] - log["q"][0, :3])
    draw_columns(place, time, moved, "xyz")
    at_least(place, moved, LEAST_MOVE)
    place.legend(ncols=3, fontsize=8)
    R = rotation_from_quaternion(log["q"][thin, 3:7])
    turned = R @ R[0].T
    skew = 0.5 * (turned - np.swapaxes(turned, 1, 2))
    axial = np.degrees(skew[:, [2, 0, 1], [1, 2, 0]])  # sin(angle) times the axis of each turn
    draw_columns(turn, time, axial, ("roll", "pitch", "yaw"))
    tilt = np.degrees(tilt_angles(log["q"])[thin])
    turn.plot(time, tilt, color=MUTED, lw=0.8, ls=":", label="angle")
    at_least(turn, np.column_stack([axial, tilt]), LEAST_TURN)
    turn.legend(ncols=4, fontsize=8)
    for axis in (place, turn):
        mark_events(axis, log)
    return save(figure, path)


def draw_torques(log: Log, path: Path) -> Path:
    """Draw the joint torques as shares of their limits: the hardest worked joint in the range of all."""
    limits = np.asarray(log.facts["effort_limits"], dtype=np.float64)
    known = np.isfinite(limits).any()
    limits = limits if known else np.full(limits.shape, 100.0)  # per cent of 100 N m are newton metres
    title = "Joint torques against the effort limits" if known else "Joint torques, no limits known"
    unit = "% of limit" if known else "N m"
    figure, axis = new_axis((8.0, 3.4), title, xlabel="time [s]", ylabel=f"torque [{unit}]")
    thin = stride_of(len(log))
    share = 100.0 * log["torques"][thin] / limits
    worst = int(np.abs(log["torques"] / limits).max(axis=0).argmax())
    most = 100.0 * float(np.abs(log["torques"][:, worst] / limits[worst]).max())
    low, high = share.min(axis=1), share.max(axis=1)
    axis.fill_between(log["time"][thin], low, high, color=MUTED, alpha=0.25, lw=0, label="all joints")
    name = f"{log.facts['joints'][worst]}, at most {most:.0f} {unit}"
    axis.plot(log["time"][thin], share[:, worst], lw=1.6, color=FOOT_COLOURS[1], label=name, zorder=3)
    top = max(25.0, 1.15 * float(np.abs(share).max(initial=0.0)))
    if known and top > 80.0:
        top = max(top, 110.0)
        for limit in (-100.0, 100.0):
            axis.axhline(limit, color=BAD, lw=0.9, ls="--")
    axis.set_ylim(-top, top)
    mark_events(axis, log)
    axis.legend(fontsize=8, ncols=2, loc="upper left")
    return save(figure, path)


def draw_run(log: Log, folder: Path) -> list[Path]:
    """Draw every plot of a run into a folder and return their paths."""
    return [
        draw_normal_forces(log, folder / "normal_forces.png"),
        draw_cone_use(log, folder / "cone_use.png"),
        draw_base(log, folder / "base.png"),
        draw_torques(log, folder / "torques.png"),
    ]


def mark_events(axis: Any, log: Log) -> None:
    """Shade the pushes and mark changes of friction and, unless it walks, of the feet that push."""
    time, pushed = log["time"], np.any(log["push"] != 0.0, axis=1)
    for begin, end in runs_of(pushed):
        axis.axvspan(time[begin], time[end - 1], color=FOOT_COLOURS[3], alpha=0.18, lw=0)
    changes = np.flatnonzero(np.diff(log["mu"]) != 0.0)
    lifted = np.flatnonzero(np.any(np.diff(log["active"].astype(int), axis=0) != 0, axis=1))
    for rows, colour in ((changes, FOOT_COLOURS[5]), (lifted[:0] if "planned" in log else lifted, MUTED)):
        for at in rows:
            axis.axvline(time[at], color=colour, lw=0.8, ls=":")


def spans(time: Any, on: BoolArray) -> list[tuple[float, float]]:
    """Return (begin, length) of the runs where a flag is set."""
    last = len(time) - 1
    return [(float(time[a]), float(time[min(b, last)] - time[a])) for a, b in runs_of(on)]
