"""Measured table of which robots walk, stand, or are refused, and how their feet are read."""

from __future__ import annotations

from typing import Any

from docs.measured import Rows, Table


def _catalogue(data: Any) -> Rows:
    return [[f"`{t['name']}`", t["feet"], _what_happens(t)] for t in data["trials"]]


def _what_happens(trial: dict[str, Any]) -> str:
    """Return "walks", or what a stand comes to and why it does not walk."""
    if trial["walk"] == "walks":
        return "**walks**"
    stand, walk = trial["stand"], trial["walk"]
    if stand == walk:  # refused for one reason
        return str(stand)
    return f"{'**stands**' if stand == 'stands' else stand}; to walk: {walk}"


TABLES = {
    "robots": Table(
        "surefoot bench robots", "standing.md", ("robot", "feet, and how the first is read", "what happens"),
        _catalogue, long=True,
    ),
}  # fmt: skip
