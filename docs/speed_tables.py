"""Rows of the tables of `bench forces` and `bench walk`, from the commands' JSON."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from docs.measured import Rows

CLASSES = ("easy", "near-boundary", "infeasible-wrench")
TRAJECTORIES = {
    "sliding": "sliding: slope of 20°, mu 0.5, pushed hard",
    "slope": "slope of 20°, mu 0.5, pushed",
    "ice": "ice, mu 0.15, pushed",
    "flat": "flat ground, mu 0.6, pushed",
    "made": "made: a smooth sway, 500 Hz",
}
OURS = "surefoot, exact cones"


def both(timing: dict[str, float], digits: int = 0) -> str:
    """Return median and 99th percentile in µs."""
    return " / ".join(f"{1e6 * timing[key]:.{digits}f}" for key in ("median", "p99"))


def allocation(data: Any) -> Rows:
    """Return a row per solver, exact and on 8 inner facets, and two of what facets get wrong."""
    cells: dict[str, dict[str, Any]] = defaultdict(dict)
    for row in data["rows"]:
        if not row["warm"]:
            cells[f"{row['solver']}, {row['cone']}"][row["instances"]] = row
    out = []
    for name, by in cells.items():
        if name.endswith((", exact", ", 8 inner")):
            fast = min(row["timing"]["median"] for row in by.values()) < 20e-6
            times = [both(by[one]["timing"], 1 if fast else 0) for one in CLASSES]
            short = min(row["solved"] for row in by.values())
            label = name.replace("8 inner", "8 facets") + (
                "" if short == 1.0 else f" ({100 * short:.0f} % solved)"
            )
            out.append([label, *times])
    inner, outer = cells["DAQP, 8 inner"], cells["DAQP, 8 outer"]
    wrong = [f"{inner[one]['distance_worst']:.2g} N" for one in CLASSES]
    beyond = [f"{outer[one]['cone_violation']:.2g} N" for one in CLASSES]
    return [
        *out,
        ["worst force error of 8 inner facets", *wrong],
        ["worst cone violation of 8 outer facets", *beyond],
    ]


def warm_starts(data: Any) -> Rows:
    """Return a row per trajectory: cold and warm, through Python and in a compiled loop."""
    rows = []
    for row in sorted(data["warm"], key=lambda row: -row["iterations_cold"]):
        times = [row[key]["median"] for key in ("cold", "warm", "loop_cold", "loop_warm")]
        rows.append(
            [
                TRAJECTORIES.get(row["trajectory"], row["trajectory"]), f"{100.0 * row['active']:.0f} %",
                f"{row['iterations_cold']:.1f} → {row['iterations_warm']:.1f}",
                both(row["cold"], 2), both(row["warm"], 2), f"{times[1] / times[0]:.2f}",
                both(row["loop_cold"], 2), both(row["loop_warm"], 2), f"{times[3] / times[2]:.2f}",
            ]
        )  # fmt: skip
    return rows


def horizons(data: Any) -> Rows:
    """Return a row per scene: our plan, the fastest accurate QP on 4 or 8 facets, and Clarabel."""
    by: dict[str, dict[str, Any]] = defaultdict(dict)
    for row in data["rows"]:
        if row["accurate"]:
            by[row["scene"]][row["method"]] = row
    rows = []
    for scene, methods in by.items():
        name = min(
            (one for one in methods if "facets" in one), key=lambda one: methods[one]["timing"]["median"]
        )
        cells = [
            both(methods[one]["timing"]) if one in methods else "-"
            for one in (OURS, name, "Clarabel, exact cones")
        ]
        cells[1] += f" ({name.removesuffix(' facets')})"
        rows.append([scene, *cells])
    return rows


def steps(data: Any) -> Rows:
    """Return a row per robot and call of a walking controller: median and 99th percentile."""
    return [[row["robot"], row["call"], both(row["timing"])] for row in data["steps"]]
