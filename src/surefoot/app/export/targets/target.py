"""What targets that are Python scripts have in common: a sequence as data, and a body that uses it."""

from __future__ import annotations

from surefoot.app.export.sequence import ContactSequence, rectangle_of
from surefoot.mechanics.stance import SoleContact


def python_data(sequence: ContactSequence) -> str:
    """Return the assignments FRAMES and PHASES as Python text: all that a script needs, and no import.

    Every phase has its duration [s], its contacts (frame, mu, normal_min, normal_max, patch, position and
    rotation row by row in world axes, dim), and A, b with A @ forces <= b for the stacked forces in contact
    frames.
    """
    lines = [f"FRAMES = {list(sequence.frames)!r}", "PHASES = ["]
    for k, phase in enumerate(sequence.phases):
        lines += ["    {", f'        "duration": {phase.duration!r},', '        "contacts": [']
        for contact in phase.stance:
            size = rectangle_of(contact) if isinstance(contact, SoleContact) else None
            entry = {
                "frame": contact.name, "dim": contact.dim, "mu": contact.mu, "normal_min": contact.normal_min,
                "normal_max": contact.normal_max, "patch": size, "position": contact.position.tolist(),
                "rotation": contact.rotation_world_contact.tolist(),
            }  # fmt: skip
            lines += ["            {"]
            lines += [f"                {key!r}: {_number(value)}," for key, value in entry.items()]
            lines += ["            },"]
        rows = sequence.halfspaces(k)
        A, b = rows.A, rows.b
        lines += ["        ],", '        "A": [']
        lines += [f"            {row!r}," for row in A.tolist()]
        lines += ["        ],", f'        "b": {b.tolist()!r},', "    },"]
    return "\n".join([*lines, "]"]) + "\n"


def _number(value: object) -> str:
    """Return Python text of a value; infinity has no literal of its own."""
    return repr(value).replace("inf", 'float("inf")') if isinstance(value, float) else repr(value)


def script(sequence: ContactSequence, tool: str, how: str, setup: str, body: str) -> str:
    """Return a script that holds a sequence.

    Parameters
    ----------
    sequence
        See `python_data`.
    tool, how
        Whom it is for, and what to call in it, in a sentence.
    setup, body
        What stands before the data (imports, with a blank line behind them) and after it.
    """
    return header(sequence, tool, how) + setup + python_data(sequence) + body


def header(sequence: ContactSequence, tool: str, how: str) -> str:
    """Return the docstring of a script."""
    robot = f" of {sequence.robot}" if sequence.robot else ""
    cones = f"{sequence.facets} facets, {sequence.fit}"
    return (
        f'"""Contacts{robot} for {tool}, written by Surefoot.\n\n{how}\n'
        f"Forces act on the robot, in contact frames (x, y tangential, z out of the ground); {cones}.\n"
        '"""\n\n'
    )
