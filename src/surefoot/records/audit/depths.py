"""How deep contacts are: beyond what their world declares, and so deep that they are soft in any case."""

from __future__ import annotations

import numpy as np

from surefoot.records.audit.laws import stated
from surefoot.records.audit.rows import Measured, Rows, over
from surefoot.records.audit.within_row import way_to_touch


def penetration(rows: Rows) -> Measured:
    """Return the depth (T, p) beyond what is declared [m].

    On a body that tumbles soft contacts drive each other deeper, and so do motors and loads.
    """
    limits, sinking = rows.setting.limits.laws, rows.setting.sinking
    moved = rows.has("torques") or bool(np.any(rows.log.facts.get("contact_other_moves", 0.0)))
    pressed = moved and rows.log.facts.get("kind") == "recording"
    limit = max(limits.penetration, limits.swing_depth * sinking if pressed else sinking)
    limit = max(limit, rows.setting.step_depth)
    driven = min(stated(rows.log, "sinking_at_most"), rows.setting.limits.softness.sinking)
    deep = np.where(rows.swinging, max(limit, limits.swing_depth * sinking, driven), limit)
    # a soft corner goes on for a row while another one lands
    late = rows.once(way_to_touch) if sinking > 0.0 or rows.setting.step_depth > 0.0 else 0.0
    return over(-rows.gaps, deep + late)


def depth(rows: Rows) -> Measured:
    """Return the depth (T, p) that is soft, whatever the world declares [m]."""
    return over(-rows.gaps, rows.setting.limits.records.deep)
