"""TSID: point and planar contacts of every phase.

TSID's own pyramids have four sides that touch the round cone from outside along its tangents; with friction
divided by sqrt(2) they are inside it. That is what an inner fit writes, whatever the number of facets.

Checked against the source of stack-of-tasks/tsid at commit 591f737: forces, corners and normals are in the
foot's own axes, but for a `ContactPoint` with useLocalFrame(False), which is what is written for points.
"""

from __future__ import annotations

from surefoot.app.export.sequence import ContactSequence
from surefoot.app.export.targets.target import script

BODY = '''
MOST = 1e6
"""What stands for no upper bound on a normal force [N]."""


def friction(contact):
    """Return the coefficient of TSID's four-sided pyramid."""
    return contact["mu"] / math.sqrt(2.0) if INNER else contact["mu"]


def contacts(robot, phase):
    """Return TSID's contacts of a phase, by frame; `robot` is a tsid.RobotWrapper.

    The frame of a sole is taken to lie in its middle with z out of the ground.
    """
    out = {}
    for contact in PHASES[phase]["contacts"]:
        frame, normal = contact["frame"], np.array(contact["rotation"])[:, 2]
        low, high = contact["normal_min"], min(contact["normal_max"], MOST)
        if contact["patch"] is None:
            made = tsid.ContactPoint(frame, robot, frame, normal, friction(contact), low, high)
            made.useLocalFrame(False)  # the normal is in world axes
        else:
            x, y = 0.5 * contact["patch"][0], 0.5 * contact["patch"][1]
            corners = np.array([[-x, -x, x, x], [-y, y, -y, y], [0.0] * 4])
            up = np.array([0.0, 0.0, 1.0])
            made = tsid.Contact6d(frame, robot, frame, corners, up, friction(contact), low, high)
        out[frame] = made
    return out


def schedule():
    """Return (time, frames to add, frames to remove) of every switch."""
    before, time, out = set(), 0.0, []
    for phase in PHASES:
        now = {contact["frame"] for contact in phase["contacts"]}
        out.append((time, sorted(now - before), sorted(before - now)))
        before, time = now, time + phase["duration"]
    return out
'''


def files(sequence: ContactSequence) -> dict[str, str]:
    """Return contacts_tsid.py, with `contacts(robot, phase)` and `schedule()`."""
    how = "contacts(robot, phase) are TSID's contacts, schedule() says when to add and remove them."
    setup = f"import math\n\nimport numpy as np\nimport tsid\n\nINNER = {sequence.fit == 'inner'}\n"
    text, sides = script(sequence, "TSID", how, setup, BODY), f"{sequence.facets} facets, {sequence.fit}"
    if sequence.facets != 4:
        text = text.replace(sides, f"{sides} (TSID itself has four)", 1)
    return {"contacts_tsid.py": text}
