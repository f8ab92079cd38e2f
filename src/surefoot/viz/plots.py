"""Plots of a logged run: forces, cones, base, torques, time per step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.audit.laws import LOADED_SHARE
from surefoot.audit.motion import foot_forces, tilt_angles
from surefoot.log import Log
from surefoot.spatial import GRAVITY, rotation_from_quaternion
from surefoot.viz.style import BAD, FOOT_COLOURS, INK, MUTED, new_figure, save

MOST_POINTS = 4000
"""Longest series that is drawn; longer ones are thinned."""


def _thin(log: Log) -> slice:
    return slice(None, None, max(1, len(log) // MOST_POINTS))


def draw_normal_forces(log: Log, path: Path) -> Path:
    """Draw every foot's normal force over time, against an equal share of the weight."""
    figure, axes = new_figure(size=(8.0, 3.6))
    axis, thin, forces = axes[0, 0], _thin(log), foot_forces(log)
    for k, name in enumerate(log.facts["feet"]):
        axis.plot(log["time"][thin], forces[thin, k, 2], color=FOOT_COLOURS[k % 8], label=name)
    share = log.facts["mass"] * GRAVITY / len(log.facts["feet"])
    axis.axhline(share, color=INK, lw=0.9, ls="--", label=f"m g / {len(log.facts['feet'])} = {share:.1f} N")
    # the first millisecond's impact must not squash the rest
    top = max(1.3 * share, 1.1 * float(np.percentile(forces[..., 2], 99.8)))
    axis.set(xlabel="time [s]", ylabel="normal force [N]", ylim=(min(0.0, forces[..., 2].min()), top))
    mark_events(axis, log)
    axis.legend(ncols=3, fontsize=8, loc="best")
    axis.set_title("Normal forces as the world reports them")
    return save(figure, path)


def draw_cone_use(log: Log, path: Path) -> Path:
    """Draw every measured force in its cone's cross-section, scaled so that the cone is the unit circle."""
    names = log.facts["feet"]
    columns = min(4, len(names))
    rows = -(-len(names) // columns)
    figure, axes = new_figure(rows, columns, size=(2.4 * columns, 2.6 * rows + 0.3), sharex=True, sharey=True)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    threshold = LOADED_SHARE * log.facts["mass"] * GRAVITY
    forces = foot_forces(log)
    for k, axis in enumerate(axes.flat):
        if k >= len(names):
            axis.set_axis_off()
            continue
        f = forces[:, k]
        loaded = f[:, 2] > threshold
        scaled = f[loaded, :2] / np.maximum(log["mu"][loaded] * f[loaded, 2], 1e-12)[:, None]
        axis.fill(np.cos(angle), np.sin(angle), color=FOOT_COLOURS[k % 8], alpha=0.10, lw=0)
        axis.plot(np.cos(angle), np.sin(angle), color=INK, lw=0.9)
        step = max(1, len(scaled) // MOST_POINTS)
        axis.scatter(*scaled[::step].T, s=3, color=FOOT_COLOURS[k % 8], alpha=0.5, lw=0)
        use = float(np.linalg.norm(scaled, axis=1).max(initial=0.0))
        axis.set_title(
            f"{names[k]}: at most {100 * use:.0f} %", color=BAD if use > 1.001 else INK, fontsize=9
        )
        axis.set_aspect("equal")
        span = 1.15
        axis.set(xlim=(-span, span), ylim=(-span, span), xticks=[-1, 0, 1], yticks=[-1, 0, 1])
    figure.supxlabel(r"$f_x\,/\,\mu f_z$", fontsize=9)
    figure.supylabel(r"$f_y\,/\,\mu f_z$", fontsize=9)
    return save(figure, path)


def draw_base(log: Log, path: Path) -> Path:
    """Draw how far the base moved and turned from where it started."""
    figure, axes = new_figure(2, 1, size=(8.0, 4.6), sharex=True)
    thin, time = _thin(log), log["time"][_thin(log)]
    move = 1e3 * (log["q"][thin, :3] - log["q"][0, :3])
    for k, name in enumerate("xyz"):
        axes[0, 0].plot(time, move[:, k], color=FOOT_COLOURS[k], label=name)
    axes[0, 0].set_ylabel("base moved [mm]")
    axes[0, 0].legend(ncols=3, fontsize=8)
    R = rotation_from_quaternion(log["q"][thin, 3:7])
    turn = R @ R[0].T
    axial = 0.5 * np.stack(
        [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], axis=1
    )
    for k, name in enumerate(("roll", "pitch", "yaw")):
        axes[1, 0].plot(time, np.degrees(axial[:, k]), color=FOOT_COLOURS[k], label=name)
    axes[1, 0].plot(time, np.degrees(tilt_angles(log["q"])[thin]), color=MUTED, lw=0.8, ls=":", label="angle")
    axes[1, 0].set(xlabel="time [s]", ylabel="base turned [deg]")
    axes[1, 0].legend(ncols=4, fontsize=8)
    for axis in axes[:, 0]:
        mark_events(axis, log)
    axes[0, 0].set_title("Base, from where it started")
    return save(figure, path)


def draw_torques(log: Log, path: Path) -> Path:
    """Draw the joint torques as shares of their limits, one line per joint, a colour per limb."""
    limits = np.asarray(log.facts["effort_limits"], dtype=np.float64)
    figure, axes = new_figure(size=(8.0, 3.4))
    axis, thin = axes[0, 0], _thin(log)
    share = 100.0 * log["torques"][thin] / limits
    worst = int(np.abs(log["torques"] / limits).max(axis=0).argmax())
    for k in range(share.shape[1]):
        heavy = k == worst
        axis.plot(
            log["time"][thin], share[:, k], lw=1.6 if heavy else 0.7, alpha=1.0 if heavy else 0.6,
            color=FOOT_COLOURS[1] if heavy else MUTED, label=log.facts["joints"][k] if heavy else None,
            zorder=3 if heavy else 2,
        )  # fmt: skip
    top = max(25.0, 1.15 * float(np.abs(share).max(initial=0.0)))
    if top > 80.0:
        top = max(top, 110.0)
        for limit in (-100.0, 100.0):
            axis.axhline(limit, color=BAD, lw=0.9, ls="--")
    axis.set(xlabel="time [s]", ylabel="torque [% of limit]", ylim=(-top, top))
    mark_events(axis, log)
    axis.legend(fontsize=8, title="hardest worked joint", title_fontsize=8)
    axis.set_title("Joint torques against the effort limits")
    return save(figure, path)


def draw_step_times(log: Log, path: Path) -> Path:
    """Draw the histogram of the controller's time per step."""
    figure, axes = new_figure(size=(8.0, 2.8))
    axis, micro = axes[0, 0], 1e6 * np.asarray(log["controller_time"])
    median, p99 = float(np.median(micro)), float(np.percentile(micro, 99))
    axis.hist(np.clip(micro, 0.0, 2.0 * p99), bins=80, color=FOOT_COLOURS[0], alpha=0.75)
    for value, name in ((median, "median"), (p99, "99th percentile")):
        axis.axvline(
            value, color=INK, lw=1.0, ls="--" if name == "median" else ":", label=f"{name} {value:.0f} µs"
        )
    axis.set(xlabel="controller step [µs], longer ones in the last bar", ylabel="steps", yscale="log")
    axis.legend(fontsize=8)
    axis.set_title("Time of the controller's step")
    return save(figure, path)


def draw_run(log: Log, folder: Path) -> list[Path]:
    """Draw every plot of a run into a folder and return their paths."""
    from surefoot.viz.pressure_plots import draw_pressure

    pressure = draw_pressure(log, folder / "pressure.png")
    return [
        *([] if pressure is None else [pressure]),
        draw_normal_forces(log, folder / "normal_forces.png"),
        draw_cone_use(log, folder / "cone_use.png"),
        draw_base(log, folder / "base.png"),
        draw_torques(log, folder / "torques.png"),
        draw_step_times(log, folder / "step_times.png"),
    ]


def mark_events(axis: Any, log: Log) -> None:
    """Shade the pushes and mark changes of friction and, unless it walks, of the feet that push."""
    time, pushed = log["time"], np.any(log["push"] != 0.0, axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], pushed.astype(int), [0]])))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        axis.axvspan(time[begin], time[end - 1], color=FOOT_COLOURS[3], alpha=0.18, lw=0)
    changes = np.flatnonzero(np.diff(log["mu"]) != 0.0)
    lifted = np.flatnonzero(np.any(np.diff(log["active"].astype(int), axis=0) != 0, axis=1))
    if "planned" in log:
        lifted = lifted[:0]
    for at, colour in [(k, FOOT_COLOURS[5]) for k in changes] + [(k, MUTED) for k in lifted]:
        axis.axvline(time[at], color=colour, lw=0.8, ls=":")
