"""Forces of a stance as the page shows them: where they press, and how much of a sole's cone they use."""

from __future__ import annotations

import numpy as np

from surefoot.app.lab.html_text import paragraph
from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Verdict
from surefoot.mechanics.stance import SoleContact, Stance


def pressures(stance: Stance, found: FloatArray | None) -> tuple[FloatArray | None, FloatArray]:
    """Return the forces (k, 3) in contact frames [N] and where they press (k, 3) [m]; None without forces."""
    places = np.array([contact.position for contact in stance.contacts]).reshape(-1, 3)
    if found is None:
        return None, places
    forces, at = np.zeros((len(places), 3)), 0
    for k, contact in enumerate(stance.contacts):
        wrench = found[at : at + contact.dim]
        at += contact.dim
        forces[k] = wrench[:3]
        if contact.dim == 6 and wrench[2] > 0.0:
            arm = np.array([-wrench[4], wrench[3], 0.0]) / wrench[2]
            places[k] += contact.rotation_world_contact @ arm
    return forces, places


def sole_lines(verdict: Verdict) -> list[str]:
    """Return for each sole the share of its cone that its wrench uses, and what binds, as HTML."""
    lines, at, forces = [], 0, np.asarray(verdict.stacked)
    for contact in verdict.stance.contacts:
        wrench = forces[at : at + contact.dim]
        at += contact.dim
        if isinstance(contact, SoleContact) and wrench[2] > 0.0:
            use = contact.sole.use(wrench)
            share = f"{100.0 * float(use.total):.0f} %"
            lines.append(
                paragraph(f"{contact.name}: {share} of its sole's cone, most of it {use.binds.item()}.")
            )
    return lines
