"""Picture of an audit of many environments: which laws they break, in how many rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.app.viz.style import BAD, MUTED

if TYPE_CHECKING:
    from surefoot.records.audit.batch.batch_report import BatchReport


def draw_broken_laws(report: BatchReport, axes: Any) -> None:
    """Draw a bar a law: environments that break it, and above it the share of all rows.

    Parameters
    ----------
    report
        What was found.
    axes
        Plane axes.
    """
    found = [law for law in report.laws.values() if law.law and not np.isnan(law.worst).all()]
    places = np.arange(len(found))[::-1]
    broken = np.array([100.0 * (law.share > 0.0).mean() for law in found])
    rows = np.array([100.0 * law.share.mean() for law in found])
    most = max(1.0, float(broken.max(initial=0.0)))
    axes.grid(False)
    axes.barh(places, broken, height=0.62, color=BAD, linewidth=0.0)
    axes.barh(places - 0.4, rows, height=0.1, color=MUTED, linewidth=0.0)
    for place, share, part in zip(places.tolist(), broken.tolist(), rows.tolist(), strict=True):
        told = f" {share:.3g} % of them, {part:.2g} % of rows" if share else " holds"
        axes.text(share, place, told, va="center", fontsize=8)
    axes.set_yticks(places, [law.name for law in found])
    axes.set(xlim=(0.0, 1.6 * most), ylim=(-1.0, max(len(found), 4) - 0.4))  # room for the words
    axes.set_xticks([tick for tick in axes.get_xticks() if tick <= 100.0])
    axes.set_xlabel("share of environments that break it [%]")
    axes.set_title(f"{len(report):,} environments, {len(report.unlawful):,} broken", fontsize=9, loc="left")
