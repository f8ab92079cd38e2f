"""Where limits of an audit are from: how sources begin, with the range of values that do as well."""

from __future__ import annotations

VARIED = "`python -m benchmarks.limits`, 2026-11-25: as good from "
"""The command varies a limit over logs with faults and without, and made cases: values beyond do worse."""
RIVALS = "`python -m benchmarks.limits`, 2026-11-26: as good from "
"""The same with the cases in which two symptoms speak, or a fault and noise."""
STORIES = "`python -m benchmarks.story_limits`, 2026-11-26: as good from "
"""The command varies a limit over strangers' loops that fail of known causes, and over lawful ones."""
RULES = "`python -m benchmarks.story_limits`, 2026-11-27: as good from "
"""The same for limits within single rules."""
MADE = "`python -m pytest tests/records/audit`, 2026-11-27: its made cases hold from "
"""Where no run of those loops decides: the range in which the tests of that folder pass."""
