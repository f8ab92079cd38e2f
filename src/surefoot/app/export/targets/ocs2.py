"""OCS2: gait and mode schedule in INFO notation, and the friction settings of its legged robot example.

Checked against the source of leggedrobotics/ocs2 at commit 2638675: `loadModeSequenceTemplate` wants
`switchingTimes` and throws without them, `loadModeSchedule` wants `eventTimes`; a mode names LF, RF, LH, RH.
`loadFrictionConeSettings` reads three keys: the friction coefficient, and mu and delta of a relaxed barrier.
Its cone is mu F_z - sqrt(F_x^2 + F_y^2 + 25 N^2) >= 0 for all feet and times, **in world axes** whatever the
ground (`t_R_w` is the identity, `setSurfaceNormalInWorld` throws), without bounds on normal forces.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from surefoot.app.export.sequence import ContactSequence
from surefoot.base.errors import ProblemError
from surefoot.mechanics.stance import Contact, PointContact

FEET = ("LF", "RF", "LH", "RH")
FRICTION = """; Of task.info: replaces the block of this name.
; The largest cone about the world's z axis that is inside the cones of all contacts{lean}.
frictionConeSoftConstraint
{{
  frictionCoefficient  {mu:.17g}

  ; relaxed log barrier parameters: those of OCS2's example
  mu                   0.1
  delta                5.0
}}
"""


def files(sequence: ContactSequence) -> dict[str, str]:
    """Return gait.info and friction.info, of four point feet in the order of the frames (LF, RF, LH, RH).

    Raises
    ------
    ProblemError
        For other feet, and a cone that no upright one is inside of.
    """
    if len(sequence.frames) != len(FEET):
        raise ProblemError(f"OCS2's modes name 4 feet, the sequence has {len(sequence.frames)} frames")
    contacts = [contact for phase in sequence.phases for contact in phase.stance]
    for contact in contacts:
        if not isinstance(contact, PointContact):
            raise ProblemError(f"OCS2's legged robot has point feet, {contact.name} is a sole")
    modes = [_mode([name in p.names for name in sequence.frames]) for p in sequence.phases]
    times = [f"{time:.12g}" for time in sequence.switching]
    gait = [
        *(f"; {label} is {name}" for name, label in zip(sequence.frames, FEET, strict=True)),
        *_list_lines("list", ["sequence"]),
        *_block("sequence", _list_lines("modeSequence", modes) + _list_lines("switchingTimes", times)),
        # a schedule goes on for ever on both sides: there its first and last modes hold
        *_block(
            "initialModeSchedule", _list_lines("modeSequence", modes) + _list_lines("eventTimes", times[1:-1])
        ),
    ]
    mu = min((_upright_friction(contact) for contact in contacts), default=0.0)
    lean = max((_lean(contact) for contact in contacts), default=0.0)
    said = f", which lean by up to {math.degrees(lean):.3g} deg" if lean > 1e-9 else ""
    return {"gait.info": "\n".join(gait) + "\n", "friction.info": FRICTION.format(mu=mu, lean=said)}


def _mode(stands: Sequence[bool]) -> str:
    """Return the name of the mode in which the feet stand that are said to."""
    if all(stands):
        return "STANCE"
    return "_".join(foot for foot, on in zip(FEET, stands, strict=True) if on) or "FLY"


def _list_lines(name: str, entries: Sequence[str]) -> list[str]:
    """Return the lines of a list in INFO notation: ``[0] a``, ``[1] b`` and so on."""
    return _block(name, [f"[{k}] {entry}" for k, entry in enumerate(entries)])


def _block(name: str, lines: Sequence[str]) -> list[str]:
    """Return the lines of a block in INFO notation."""
    return [name, "{", *("  " + line for line in lines), "}"]


def _lean(contact: Contact) -> float:
    """Return the angle between a contact's normal and the world's z axis [rad]."""
    x, y, z = contact.rotation_world_contact[:, 2]
    return math.atan2(math.hypot(x, y), z)


def _upright_friction(contact: Contact) -> float:
    """Return the friction of the largest upright cone inside a contact's own: tan(atan(mu) - lean)."""
    spare = math.atan(contact.mu) - _lean(contact)
    if spare <= 0.0:
        raise ProblemError(
            f"OCS2's friction cones stand upright in the world: none is inside that of {contact.name}, which "
            f"leans by {math.degrees(_lean(contact)):.3g} deg at mu {contact.mu:g}"
        )
    return math.tan(spare)
