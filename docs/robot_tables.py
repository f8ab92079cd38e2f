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


def _published(data: Any) -> Rows:
    return [[t["name"], t["true"], t["feet"], _what_happens(t), _errors(t["errors"])] for t in data["trials"]]


def _errors(errors: dict[str, int]) -> str:
    return ", ".join(f"{count} {rule}" for rule, count in errors.items()) or "none"


TABLES = {
    "robots": Table(
        "surefoot bench robots", "reports/standing.md",
        ("robot", "feet, and how the first is read", "what happens"), _catalogue, long=True,
    ),
    "published_robots": Table(
        "surefoot bench robots --published FOLDER", "reports/standing.md",
        ("robot (whose)", "what stands there", "feet, and how the first is read", "what happens",
         "errors of the lint"), _published, long=True,
    ),
}  # fmt: skip
