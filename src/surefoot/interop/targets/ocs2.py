"""OCS2: a mode schedule in INFO notation, and the friction settings of its legged robot example.

OCS2 has one friction coefficient and one least normal force for all feet and times; the smallest, and the
largest, of the sequence are written, so that what it allows is allowed here.
"""

from __future__ import annotations

import numpy as np

from surefoot.control.gait import ModeSchedule
from surefoot.control.gait_files import LABELS, format_gaits
from surefoot.errors import ProblemError
from surefoot.interop.sequence import ContactSequence


class Ocs2:
    """Mode schedules of two or four feet, in the order of the sequence's frames (OCS2: LF, RF, LH, RH)."""

    name = "ocs2"
    meaning = "mode schedule and friction settings in INFO notation"

    def files(self, sequence: ContactSequence) -> dict[str, str]:
        """Return gait.info and friction.info."""
        feet = len(sequence.frames)
        if feet not in LABELS:
            raise ProblemError(f"OCS2's modes name 2 or 4 feet, the sequence has {feet} frames")
        table = np.array([[name in phase.names for name in sequence.frames] for phase in sequence.phases])
        # a schedule goes on for ever on both sides: there its first and last modes hold
        schedule = ModeSchedule(sequence.switching[1:-1], table, max_flight=np.inf)
        contacts = [contact for phase in sequence.phases for contact in phase.stance]
        mu = min((c.mu for c in contacts), default=0.0)
        least = max((c.normal_min for c in contacts), default=0.0)
        labels = "".join(
            f"; {label} is {name}\n" for label, name in zip(LABELS[feet], sequence.frames, strict=True)
        )
        friction = (
            "; smallest friction and largest least force of the sequence\n"
            "frictionConeSoftConstraint\n"
            f"{{\n  frictionCoefficient  {mu:.17g}\n  minimumNormalForce  {least:.17g}\n}}\n"
        )
        return {"gait.info": labels + format_gaits({"sequence": schedule}), "friction.info": friction}


TARGET = Ocs2()
