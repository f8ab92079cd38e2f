"""The ways without friction of a log's contacts, added up piece by piece, however slow the slides are."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.audit.checks import longest_unsure_way
from surefoot.records.audit.cones import grip
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.rows import Rows
from surefoot.records.audit.slides import WORST, slide_on, slide_rules, start_slides


class SlideCount:
    """The slides so far; what is lost is left out.

    Parameters
    ----------
    setting
        Of the log.
    """

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._state = start_slides(len(setting.names), setting.limits.laws)
        self._unsure = np.zeros(len(setting.names))

    @property
    def ways(self) -> FloatArray:
        """(p,) longest way without friction in a stance [m]."""
        return np.asarray(self._state[:, WORST])

    @property
    def limits(self) -> FloatArray:
        """(p,) ways that count as sticking [m]."""
        return np.asarray(self._setting.slide_limit + self._unsure)

    def add(self, rows: Rows) -> None:
        """Add the rows of a piece."""
        core, setting = rows.core, self._setting
        keep = ~rows.not_finite[core].any(axis=1)
        mu = np.ascontiguousarray(np.broadcast_to(rows.once(grip), rows.normal.shape)[core][keep])
        f, v = (np.ascontiguousarray(x[core][keep]) for x in (rows.forces, rows.slip))
        v = np.where(np.broadcast_to(rows.swinging, rows.normal.shape)[core][keep][..., None], 0.0, v)
        rules = slide_rules(setting.limits.laws)
        slide_on(self._state, f, v, mu, rows.dt[core][keep], setting.threshold, setting.weight, *rules)
        # of means a whole stance is open, else no more than a window of it
        if setting.means:
            self._unsure += rows.unsure_way[core].sum(axis=0)
        else:
            self._unsure = np.fmax(self._unsure, longest_unsure_way(rows))
