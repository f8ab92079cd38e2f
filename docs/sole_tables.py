"""Measured tables of the exact cone of a sole."""

from __future__ import annotations

from typing import Any

from docs.measured import Rows, Table


def _answers(data: Any) -> Rows:
    rows = [
        [
            a["question"], str(a["wrenches"]), str(a["inside"]), f"**{a['differ']}**", str(a["settled"]),
            str(a["differ_near"]), f"{a['worst']:.1e}" if a["worst"] else "",
        ]
        for a in data["answers"]
    ]  # fmt: skip
    for fit, p in data["pyramids"].items():
        wrong = "promised and not held" if fit == "inner" else "held and denied"
        rows.append(
            [
                f'`polyhedral(8, "{fit}")`: {p["promised"]} of {p["held"]}; {wrong}:',
                "",
                "",
                f"**{p['wrongly']}**",
                "",
                "",
                "",
            ]
        )
    return rows


def _times(data: Any) -> Rows:
    return [
        [c["question"], c["who"], f"{1e6 * c['seconds']:.2f}", f"{c['ratio']:.2f}"] for c in data["speed"]
    ]


TABLES = {
    "soles": Table(
        "surefoot bench soles", "reports/cones.md",
        ("20 soles, 10,000 wrenches each", "asked", "held", "differ", "nearer than 1e-7", "of these differ",
         "farthest that differs"),
        _answers, long=True,
    ),
    "sole_times": Table(
        "surefoot bench soles", "reports/cones.md", ("question", "who", "processor time [µs]", "ratio"),
        _times,
        long=True,
    ),
}  # fmt: skip
