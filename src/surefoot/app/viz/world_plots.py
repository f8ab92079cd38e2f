"""What engines at their defaults make of a few scenes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from surefoot.app.viz.style import FOOT_COLOURS, new_figure, save

OURS = ("rigid", "mujoco-exact")
"""Worlds whose contact step is of this package."""


def draw_defaults(found: Mapping[str, Mapping[str, tuple[float, float]]], path: Path) -> Path:
    """Draw engines' errors over their cost, CPU seconds per simulated second, a panel for each scene.

    `found` is engine to scene to both. Hollow marks are engines at their defaults, filled ones tuned, stars
    ours; infinite errors stand at the top.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    from surefoot.worlds.experiments.engines.defaults import CASES, ENGINES

    cases = list(next(iter(found.values())))
    worlds = list(dict.fromkeys(ENGINES[engine].world for engine in found))
    marks = "os^DvP"
    figure, axes = new_figure(1, len(cases), size=(3.0 * len(cases) + 0.6, 4.8))
    for axis, case in zip(axes[0], cases, strict=True):
        for engine, by in found.items():
            world = ENGINES[engine].world
            own = [e for e in found if ENGINES[e].world == world]
            error, cost = by[case]
            colour, ours = FOOT_COLOURS[worlds.index(world) % len(FOOT_COLOURS)], world in OURS
            axis.loglog(
                cost, min(max(error, 1e-9), 10.0), "*" if ours else marks[own.index(engine) % 6],
                mfc=colour if ENGINES[engine].tuned or ours else "none", mec=colour, ms=8,
                label=engine, ls="",
            )  # fmt: skip
        unit = CASES[case].unit
        axis.set_title(f"{case} [{unit}]" if unit else case, fontsize=9, loc="left")
        axis.set_ylim(5e-10, 20.0)
    figure.supxlabel("CPU seconds per simulated second", fontsize=9)
    axes[0, 0].set_ylabel("distance from the closed form", fontsize=9)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), ncol=6, fontsize=7, loc="outside upper center")
    return save(figure, path)
