"""Pictures of identification from tosses: the errors of every toss, and one toss, recorded and simulated."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from surefoot.app.viz.shapes import along_path
from surefoot.app.viz.style import FOOT_COLOURS, GROUND, INK, MUTED, new_figure, save
from surefoot.base.arrays import FloatArray
from surefoot.records import ThrownBody
from surefoot.records.identification.thrown_body_tree import sphere_places
from surefoot.records.identification.toss_errors import TossErrors
from surefoot.records.identification.toss_fit import TossFit
from surefoot.records.identification.tosses import Tosses

SHOWN = 6
"""Moments of a toss that are drawn."""


def draw_tosses(train: Tosses, test: Tosses | None, fits: Mapping[str, TossFit], path: Path) -> Path:
    """Draw the errors of all tosses, of the test where there is one, and the toss of median error.

    Parameters
    ----------
    train, test
        What the fits saw, and what they did not.
    fits
        By name, the first of them being the one whose toss is drawn.
    path
        Of the new picture.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    figure, axes = new_figure(1, 3, size=(13.0, 4.0))
    errors = {name: _errors(fit) for name, fit in fits.items()}
    _draw_shares(axes[0, 0], {n: e.position for n, e in errors.items()}, "mean position error [width]")
    _draw_shares(axes[0, 1], {n: e.rotation for n, e in errors.items()}, "mean rotation error [deg]")
    first = next(iter(fits.values()))
    tosses = first.found.upright(train if test is None else test)
    poses = first.train_poses if test is None or first.test_poses is None else first.test_poses
    size = next(iter(errors.values())).position
    which = int(np.argsort(size)[size.size // 2])
    rows = slice(int(tosses.starts[which]), int(tosses.starts[which + 1]))
    height = first["ground"].value
    _draw_toss(axes[0, 2], first.found.body, tosses.poses[rows], poses[rows], height)
    share = "not seen by the fit" if test is not None else "fitted to"
    axes[0, 0].set_title(f"{len(tosses)} tosses {share}")
    axes[0, 2].set_title(f"Toss {tosses.ids[which]} (median): recorded grey")
    return save(figure, path)


def draw_fit(fit: TossFit, axes: Any) -> None:
    """Draw which share of the tosses has at most which position error, seen by the fit or not."""
    found = {"fitted to": fit.train} | ({} if fit.test is None else {"not seen": fit.test})
    errors = {name: one.position for name, one in found.items()}
    _draw_shares(axes, errors, "mean position error [width]")
    axes.set_title(f"{fit.model}: {', '.join(f'{name} {len(v)}' for name, v in errors.items())} tosses")


def _errors(fit: TossFit) -> TossErrors:
    return fit.train if fit.test is None else fit.test


def _draw_shares(axis: Any, errors: Mapping[str, FloatArray], label: str) -> None:
    """Draw which share of the tosses has at most which error."""
    for k, (name, values) in enumerate(errors.items()):
        x, share = np.sort(values), (np.arange(values.size) + 1.0) / values.size
        text = f"{name} (mean {values.mean():.3g})"
        axis.step(x, share, color=FOOT_COLOURS[k % 8], where="post", label=text)
    high = max(float(np.percentile(v, 99.0)) for v in errors.values())
    axis.set(xlabel=label, ylabel="share of tosses", xlim=(0.0, max(high, 1e-6)), ylim=(0.0, 1.0))
    axis.legend(fontsize=8, loc="lower right")


def _draw_toss(
    axis: Any, body: ThrownBody, recorded: FloatArray, simulated: FloatArray, ground: float
) -> None:
    """Draw the outlines of the links at a few moments, seen across the path."""
    moments = np.unique(np.linspace(0, len(recorded) - 1, SHOWN).round().astype(int))
    along, links = along_path(recorded[:, :2]), body.tree.links
    for poses, colour, width in ((recorded, MUTED, 1.6), (simulated, FOOT_COLOURS[0], 0.9)):
        for places in sphere_places(body.tree, np.ascontiguousarray(poses[moments])):
            flat = np.column_stack([(places[:, :2] - recorded[0, :2]) @ along, places[:, 2]])
            for link in np.unique(links):
                points = flat[links == link]
                order = ConvexHull(points).vertices if len(points) > 2 else np.arange(len(points))
                axis.plot(*points[[*order, order[0]]].T, color=colour, lw=width)
    axis.axhspan(ground - 0.02, ground, color=GROUND, lw=0)
    axis.axhline(ground, color=INK, lw=0.8)
    axis.set(xlabel="along the path [m]", ylabel="height [m]")
    axis.set_aspect("equal", adjustable="datalim")
