"""The picture of any log: what it has of height, speed, normal forces, friction and torques, over time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from surefoot.app.viz.plots import stride_of
from surefoot.app.viz.style import BAD, INK, draw_columns, most_of
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.records import Log

_LEAST_LOAD = 0.02
"""Share of the largest normal force below which no friction is drawn: of small forces it is noise."""
_MOST_USE = 1.5
"""Shares of the friction beyond this are drawn at it."""
_MOST_CURVES = 8
"""Contacts that are drawn, those with the largest mean normal forces."""


class _Panel(NamedTuple):
    label: str
    curves: FloatArray
    names: list[str]
    mark: float | None = None


def draw_log(log: Log, figure: Any) -> None:
    """Draw a log's panels into an empty figure.

    Raises
    ------
    ProblemError
        If the log has nothing of what is drawn.
    """
    found = (panel(log) for panel in _PANELS)
    panels = [panel for panel in found if panel is not None]
    if not panels:
        known = "q, com, v, forces, torques"
        raise ProblemError(f"the log has none of {known}: there is nothing to draw in {', '.join(log)}")
    time, thin = log["time"], stride_of(len(log))
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axis, panel in zip(axes, panels, strict=True):
        draw_columns(axis, time[thin], panel.curves[thin], panel.names)
        axis.set_ylabel(panel.label)
        if panel.label.startswith("normal"):
            _limit_range(axis, time, panel.curves)
        if panel.mark is not None:
            axis.axhline(panel.mark, color=BAD, lw=0.8, ls="--")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7)
    axes[-1].set_xlabel("time [s]")
    figure.suptitle(str(log).partition(". Channels")[0], fontsize=9, color=INK)


def _limit_range(axis: Any, time: FloatArray, forces: FloatArray) -> None:
    """Keep an impact of a millisecond from squashing all other forces."""
    usual = 1.3 * float(np.percentile(np.nan_to_num(forces), 99.8))
    if usual > 0.0 and usual < 0.7 * float(np.nanmax(forces)):
        most_of(axis, time, forces, min(0.0, float(np.nanmin(forces))), usual, "N")


def _height(log: Log) -> _Panel | None:
    if "q" in log and log["q"].shape[1] >= 7:
        return _Panel("height of the\nbase [m]", log["q"][:, 2:3], ["base"])
    return _Panel("height of the\nCoM [m]", log["com"][:, 2:3], ["com"]) if "com" in log else None


def _speed(log: Log) -> _Panel | None:
    floating = "v" in log and "q" in log and log["q"].shape[1] >= 7
    return _Panel("base velocity\n[m/s]", log["v"][:, :3], ["x", "y", "z"]) if floating else None


def _normal_forces(log: Log) -> _Panel | None:
    if "forces" not in log:
        return None
    forces, names = _by_foot(log)
    return _Panel("normal force\n[N]", forces[..., 2], names)


def _friction(log: Log) -> _Panel | None:
    """Return each foot's friction as a share of the law's; a gap where it bears nothing."""
    mu = log["contact_friction"] if "contact_friction" in log else log.arrays.get("mu")
    if "forces" not in log or mu is None:
        return None
    forces, names = _by_foot(log)
    if mu.ndim == 2 and mu.shape[1] != forces.shape[1]:
        mu = np.min(mu, axis=1)
    normal = forces[..., 2]
    limit = (mu[:, None] if mu.ndim == 1 else mu) * normal
    carries = (normal > _LEAST_LOAD * float(np.nanmax(normal, initial=0.0))) & (limit > 0.0)
    used = np.linalg.norm(forces[..., :2], axis=-1) / np.where(carries, limit, 1.0)
    return _Panel("friction used\n[1]", np.where(carries, np.minimum(used, _MOST_USE), np.nan), names, 1.0)


def _torques(log: Log) -> _Panel | None:
    if "torques" not in log or not log["torques"].shape[1]:
        return None
    torques = log["torques"]
    hardest = np.argsort(-np.nanmax(np.abs(torques), axis=0))[:4]
    names = log.facts.get("joints", [f"joint {k}" for k in range(torques.shape[1])])
    return _Panel("torque\n[N m]", torques[:, hardest], [str(names[k]) for k in hardest])


def _by_foot(log: Log) -> tuple[FloatArray, list[str]]:
    """Return the forces (T, k, 3) on the busiest feet, contacts added up by foot where told."""
    forces = np.asarray(log["forces"], dtype=np.float64)
    names = [str(name) for name in log.facts.get("feet", ())]
    owner = np.asarray(log.facts.get("contact_foot", ()))
    if len(owner) == forces.shape[1] and len(names) > int(owner.max(initial=-1)):
        forces = np.stack([forces[:, owner == k].sum(axis=1) for k in range(len(names))], axis=1)
    elif len(names) != forces.shape[1]:
        names = [f"contact {k}" for k in range(forces.shape[1])]
    load = np.nan_to_num(forces[..., 2]).mean(axis=0)
    busy = sorted(np.argsort(-load)[:_MOST_CURVES].tolist())
    return forces[:, busy], [names[k] for k in busy]


_PANELS: tuple[Callable[[Log], _Panel | None], ...] = (_height, _speed, _normal_forces, _friction, _torques)
