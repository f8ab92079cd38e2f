"""Chinese for the words that programs of the course print into their tables and texts."""

from __future__ import annotations

import re

CHINESE = {
    "yes": "是", "no": "否", "done": "完成", "fell": "摔倒", "lawful": "合法", "broken": "违背定律",
    "cannot tell": "无法判定", "possible": "可能", "impossible": "不可能", "solved": "已求解",
    "infeasible": "不可行", "stalled": "停滞", "exact": "精确", "inner": "内接", "outer": "外切",
    "facets": "面", "relaxation": "松弛", "equality": "等式", "continuation": "延拓", "at once": "一步到位",
    "level": "水平", "turned": "转动后", "world axes": "世界轴", "arms still": "手臂不动",
    "arms swung": "手臂摆动", "trot": "小跑", "pace": "溜步", "implicit": "隐式", "smoothed": "光滑化",
    "penalty": "惩罚", "randomised": "随机化", "samples": "样本", "rigid": "刚性", "soft": "软",
    "defaults": "默认", "schedule given": "给定时序", "all schedules tried": "试遍时序",
    "schedules": "种时序", "softened": "软化", "continued": "延拓", "contact-implicit": "接触隐式",
    "spring and damper": "弹簧与阻尼", "Hunt and Crossley": "Hunt-Crossley", "rubber sphere": "橡胶球",
    "as it comes": "默认参数", "one joint": "单关节", "there and back": "往返",
    "two joints in a circle": "双关节画圆", "the circle": "同一圆", "backwards": "反向",
}  # fmt: skip
"""English words, as programs print them, to the Chinese ones."""
_WORDS = re.compile(rf"\b({'|'.join(sorted(map(re.escape, CHINESE), key=len, reverse=True))})\b")


def cell(text: str, language: str) -> str:
    """Return a table's cell in a language, word by word."""
    return _WORDS.sub(lambda found: CHINESE[found[1]], text) if language == "zh" else text


def value(text: str, language: str) -> str:
    """Return a value inside of a sentence in a language: as it is unless all of it is in the list."""
    return CHINESE.get(text, text) if language == "zh" else text
