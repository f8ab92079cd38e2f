"""Where limits of an audit are from: how sources begin, with the range of values that do as well."""

from __future__ import annotations

from surefoot.base.settings import JUDGEMENT

VARIED = "`python -m benchmarks.limits`, 2026-11-25: as good from "
"""The command varies a limit over logs with faults and clean ones; values beyond the range do worse."""
ALIKE = f"{JUDGEMENT}: the faults of `benchmarks.limits` are found alike from "
"""No value that the command tried does worse: another value would be chosen as well."""
