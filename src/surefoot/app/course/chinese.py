"""Chinese for what a check of an exercise says: its properties, and what is wrong where one fails."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path


@cache
def sentences() -> dict[str, str]:
    """Return the table `chinese.toml`: English sentences, with `{}` for each value, to Chinese ones."""
    table: dict[str, str] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    return table


@cache
def _patterns() -> list[tuple[re.Pattern[str], str]]:
    """Return the sentences with values, those with the most words of their own first."""
    held = sorted((key for key in sentences() if "{}" in key), key=lambda key: -len(key.replace("{}", "")))
    return [(re.compile("(.+?)".join(map(re.escape, key.split("{}")))), sentences()[key]) for key in held]


def chinese(sentence: str) -> str:
    """Return the Chinese of a check's sentence, or the sentence as it is where the table has none.

    A value is taken over as it is, or translated, too, where it is a sentence of the table itself.
    """
    if (whole := sentences().get(sentence)) is not None:
        return whole
    for pattern, translated in _patterns():
        if found := pattern.fullmatch(sentence):
            return translated.format(*map(chinese, found.groups()))
    return sentence
