"""The mapping that is guessed for somebody's log, as a file to complete: what is missing, and what for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from surefoot.base.errors import ProblemError
from surefoot.records import CHANNELS
from surefoot.records.audit.checks import CHECKS
from surefoot.records.log.from_source import log_from_source
from surefoot.records.log.mapping import LogMapping, with_rate
from surefoot.records.log.mapping_guess import guess_mapping
from surefoot.records.log.reading import read_source

INSTEAD = {
    "mu": "or --mu",
    "gaps": "or --terrain, where there are contact_positions, or q with --robot",
    "contact_velocities": "or --terrain, where there are q and v, with --robot",
    "contact_positions": "or --terrain, where there is q, with --robot",
    "normals": "or --terrain, where there are contact_positions, or q with --robot",
    "q": "or base_position, base_orientation and joint_positions",
    "v": "or base_velocity, base_angular_velocity and joint_velocities, with base_orientation",
}
"""Channel to what else gives it."""


def template(path: Path, columns: Sequence[str] | None, rate: float | None = None) -> str:
    """Return a mapping file for a log of somebody's: what is guessed, and comments on what is not.

    Raises
    ------
    ProblemError
        If the file cannot be read, or needs no mapping.
    """
    source = read_source(path, columns)
    mapping, failed, there = LogMapping({}), "", {"time"}
    try:
        mapping = with_rate(guess_mapping(source), rate)
        there = {*log_from_source(source, mapping)}
    except ProblemError as error:
        failed = f"# It does not suffice: {error}\n"
        there |= set(mapping.channels)
    used = {field for take in mapping.channels.values() for field in take.fields}
    lines = [f"# A mapping for {path.name}; docs/logs.md has the keys. Check units, axes and orders."]
    text = mapping.as_yaml()
    if "mass" not in mapping.facts:
        lines.append(
            "# facts: {mass: 15.0}   # of all that moves [kg], or --mass; without, verdicts cannot tell"
        )
    unused = [name for name in source.names() if name not in used]
    more = [f"#   {name}" for name in unused]
    missing = [_line(name) for name in _list_needed() if name not in there]
    if missing:
        more = [*more, "# Missing, and what each would allow to judge:", *missing]
    if unused:
        more = ["# Fields that are not used:", *more]
    return "\n".join([*lines, failed + text + "\n".join(more), ""])


def _list_needed() -> list[str]:
    """Return the channels that laws need."""
    return [*dict.fromkeys(name for check in CHECKS if check.law for name in check.needs)]


def _line(name: str) -> str:
    """Return what a missing channel is, which laws need it, and what else gives it."""
    channel = CHANNELS[name]
    laws = ", ".join(check.name for check in CHECKS if check.law and name in check.needs)
    unit = f" [{channel.unit}]" if channel.unit else ""
    axes = f", {channel.frame} axes" if channel.frame else ""
    also = f"; {INSTEAD[name]}" if name in INSTEAD else ""
    return f"#   {name}: {channel.meaning}{unit}{axes}: {laws}{also}"
