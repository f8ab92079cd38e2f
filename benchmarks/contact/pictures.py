"""Pictures of the contact benchmark: performance profiles and speed-ups."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.viz.style import FOOT_COLOURS, MUTED, new_figure, save


def draw_profile(
    ratios: FloatArray, profiles: dict[str, FloatArray], title: str, path: Path, ours: tuple[str, ...] = ()
) -> Path:
    """Draw a performance profile: the share of problems solved within a factor of the best time.

    Solvers of ours are drawn in full lines, "auto" thickest; rivals are dashed.
    """
    figure, axes = new_figure(size=(8.0, 4.6))
    axis = axes[0, 0]
    order = sorted(profiles, key=lambda n: -float(np.trapezoid(profiles[n], np.log(ratios))))
    mine = [n for n in order if n in ours]
    for name in order:
        full = name in ours
        colour = FOOT_COLOURS[(mine.index(name) if full else 4 + order.index(name)) % len(FOOT_COLOURS)]
        axis.step(
            ratios,
            profiles[name],
            where="post",
            label=name,
            color=colour,
            linestyle="-" if full else (0, (4, 2)),
            linewidth=2.6 if name == "auto" else 1.3,
        )
    axis.set_xscale("log")
    axis.set_xlim(1.0, float(ratios[-1]))
    axis.set_ylim(0.0, 1.02)
    axis.set_xlabel("time over the best time of all solvers on that problem")
    axis.set_ylabel("share of problems solved")
    axis.set_title(title, loc="left")
    figure.legend(loc="outside right center", fontsize=8, frameon=False)
    return save(figure, path)


def draw_speed_up(ratios: dict[str, float], title: str, path: Path) -> Path:
    """Draw the speed-up over the best rival by family, as bars on a logarithmic axis."""
    names = [n for n in ratios if n not in ("all", "least", "lost", "no rival")]
    figure, axes = new_figure(size=(8.0, 0.8 + 0.26 * len(names)))
    axis = axes[0, 0]
    values = [ratios[n] for n in names]
    axis.barh(names, values, color=[FOOT_COLOURS[0] if v >= 1.0 else FOOT_COLOURS[1] for v in values])
    axis.axvline(1.0, color=MUTED, linewidth=1.0)
    axis.axvline(ratios["all"], color=FOOT_COLOURS[2], linewidth=1.3, linestyle="--")
    axis.text(
        ratios["all"],
        len(names) - 0.3,
        f" geometric mean {ratios['all']:.1f}x",
        color=FOOT_COLOURS[2],
        va="bottom",
    )
    axis.set_xscale("log")
    axis.set_ylim(-0.6, len(names) + 0.6)
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("time of the best rival over ours")
    axis.set_title(title, loc="left")
    return save(figure, path)
