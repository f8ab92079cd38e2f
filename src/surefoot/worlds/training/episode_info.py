"""What an episode's ``info`` tells of its audit: plain values, which vector environments put side by side."""

from __future__ import annotations

from typing import Any

from surefoot.records import EXPLOITS, BatchReport

KEY = "audit"


def info_of(report: BatchReport, rate: float) -> dict[str, Any]:
    """Return the audit of one episode as plain values.

    ``verdict`` and ``reason`` (why one cannot tell); ``broken``, names of the laws, the one with most rows
    first, and of that ``exploit`` (what a policy gets of it), ``share`` of the episode's rows, ``worst``,
    ``limit``, ``instant`` [s] and ``contact``; ``paid``, the share of the return that came from those rows;
    ``rows``, and the ``rate``: which share of the simulation's steps was judged.
    """
    laws = [law for law in report.laws.values() if law.law and law.share[0] > 0.0]
    laws.sort(key=lambda law: -law.share[0])
    out: dict[str, Any] = {
        "verdict": report.verdicts[0], "reason": report.reasons[0],
        "broken": ", ".join(law.name for law in laws), "exploit": "", "share": 0.0, "worst": float("nan"),
        "limit": float("nan"), "instant": float("nan"), "contact": "", "paid": float("nan"),
        "rows": int(report.rows), "rate": float(rate),
    }  # fmt: skip
    if laws:
        first = laws[0]
        name = next((name for name, checks in EXPLOITS.items() if first.name in checks), "")
        facts, at = report.log(0).facts, int(first.contact[0])
        out |= {
            "exploit": name, "share": float(first.share[0]), "worst": float(first.worst[0]),
            "limit": float(first.limit[0]), "instant": float(first.instant[0]),
            "contact": str(facts["feet"][facts["contact_foot"][at]]),
            "paid": next((one.reward for one in report.exploits if one.name == name), float("nan")),
        }  # fmt: skip
    return out
