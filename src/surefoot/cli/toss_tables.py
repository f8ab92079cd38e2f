"""What `surefoot audit` says of a file of tosses: which frames no lawful rigid contact explains."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from surefoot.cli.console import Table

if TYPE_CHECKING:
    from surefoot.estimation.toss_audit import TossAudit

MOST = 20
"""Rows of a table on the screen and on the page; the JSON has all."""


def noise(found: TossAudit) -> str:
    """Return what frames were judged against."""
    return (
        f"noise in free flight {1e3 * found.position_noise:.3f} mm and "
        f"{math.degrees(found.rotation_noise):.3f} deg, friction up to {found.mu:.3f}, corners rounded up to "
        f"{found.rounding:.3f} half sides"
    )


def tables(found: TossAudit) -> list[Table]:
    """Return the tables of laws, of the tosses with most frames beyond noise, and of the worst runs."""
    laws = [
        [name, str(t.judged), str(t.exact), str(t.beyond), str(t.jumps), str(t.tosses)]
        for name, t in found.laws.items()
    ]
    worst = sorted(found.tosses.items(), key=lambda one: -sum(one[1].values()))[:MOST]
    tosses = [[str(toss), *map(str, count.values())] for toss, count in worst]
    runs = sorted(found.violations, key=lambda v: -v.value / v.limit)[:MOST]
    broken = [
        [v.law, str(v.toss), v.contact, f"{v.start:.3f}", f"{v.end:.3f}", f"{v.value:.4g} {v.unit}",
         f"{v.limit:.4g}"] for v in runs
    ]  # fmt: skip
    heads = ("law", "frames judged", "not explained", "nor within noise", "one frame displaced", "tosses")
    listed = [
        Table("Laws", heads, laws),
        Table("Tosses with most frames beyond noise", ("toss", *found.laws), tosses),
        Table("Worst", ("law", "toss", "contact", "from [s]", "to [s]", "value", "noise"), broken),
    ]
    return [one for one in listed if one.rows]
