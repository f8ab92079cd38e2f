"""Chinese for the words that programs of the course print into their tables and texts."""

from __future__ import annotations

CHINESE = {
    "yes": "是",
    "no": "否",
    "done": "完成",
    "fell": "摔倒",
    "exact": "精确",
    "inner": "内接",
    "outer": "外切",
    "lawful": "合法",
    "broken": "违背定律",
    "cannot tell": "无法判定",
    "possible": "可能",
    "impossible": "不可能",
    "solved": "已求解",
    "infeasible": "不可行",
    "stalled": "停滞",
    "max_iterations": "达到迭代上限",
}
"""English word, as a program prints it, to the Chinese one."""


def translated(text: str, language: str) -> str:
    """Return a cell or value in a language; as it is where it is no word of the list."""
    return CHINESE.get(text, text) if language == "zh" else text
