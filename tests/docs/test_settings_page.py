"""The page of settings: current, complete, and each setting with unit, meaning and source."""

from __future__ import annotations

import re

from docs import settings as printer
from surefoot.base.settings import JUDGEMENT, MEASURED


def test_the_page_is_what_the_sources_say() -> None:
    assert printer.PAGE.read_text(encoding="utf-8") == printer.page(), "python -m docs.settings writes it"


def test_every_setting_of_the_package_is_on_the_page_with_unit_meaning_and_source() -> None:
    text = printer.PAGE.read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| `")]
    calls = 0
    for path in printer.SOURCE.rglob("*.py"):
        source = path.read_text(encoding="utf-8")
        if path.name != "settings.py" or path.parent.name != "base":
            calls += len(re.findall(r"(?<![\w.])setting\($|(?<![\w.])setting\((?=[^)\n])", source, re.M))
    assert len(rows) == calls > 0
    for row in rows:
        _, name, value, unit, _, meaning, source, _ = re.split(r"(?<!\\)\|", row)
        assert all(cell.strip() for cell in (name, value, unit, meaning)), row
        assert MEASURED.match(source.strip()) or source.strip().startswith(JUDGEMENT), row


def test_the_count_of_both_kinds_is_that_of_the_rows() -> None:
    text = printer.PAGE.read_text(encoding="utf-8")
    found = re.search(r"(\d+) settings: (\d+) chosen by a command, (\d+) by judgement", text)
    assert found is not None
    total, measured, judged = map(int, found.groups())
    rows = [line for line in text.splitlines() if line.startswith("| `")]
    assert total == measured + judged == len(rows)
    assert judged == sum(f"| {JUDGEMENT}" in row for row in rows)
