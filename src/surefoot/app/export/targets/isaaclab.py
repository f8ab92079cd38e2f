"""Isaac Lab: rigid-body materials of the ground, one for each friction coefficient of the sequence.

PhysX multiplies, averages or takes the smaller or larger of two materials' friction; "min" with a robot of
high friction leaves the ground's own.
"""

from __future__ import annotations

from surefoot.app.export.sequence import ContactSequence
from surefoot.app.export.targets.target import header

BODY = '''

def ground_material(frame, time=0.0):
    """Return the material of the ground below a frame at a time [s]."""
    for start, end, frames in SPANS:
        if start <= time < end and frame in frames:
            return MATERIALS[frames[frame]]
    raise KeyError(f"{frame} does not touch the ground at {time} s")
'''


def files(sequence: ContactSequence) -> dict[str, str]:
    """Return contacts_isaaclab.py, with MATERIALS and `ground_material(frame, time)`."""
    values = sorted({c.mu for phase in sequence.phases for c in phase.stance})
    lines = ["import isaaclab.sim as sim_utils\n", "MATERIALS = {"]
    for mu in values:
        lines += [
            f"    {mu!r}: sim_utils.RigidBodyMaterialCfg(",
            f"        static_friction={mu!r}, dynamic_friction={mu!r}, restitution=0.0,",
            '        friction_combine_mode="min", restitution_combine_mode="multiply",',
            "    ),",
        ]
    lines += ["}", "SPANS = ["]
    times = sequence.switching
    for k, phase in enumerate(sequence.phases):
        frames = {contact.name: contact.mu for contact in phase.stance}
        lines.append(f"    ({float(times[k])!r}, {float(times[k + 1])!r}, {frames!r}),")
    how = "ground_material(frame, time) is the ground's material below a foot."
    data = "\n".join([*lines, "]\n"])
    return {"contacts_isaaclab.py": header(sequence, "Isaac Lab", how) + data + BODY}
