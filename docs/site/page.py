"""Course pages: one source per page, its code run once, its text in English and in Chinese.

A page is a Markdown file of `course/`:

    ---
    order: 110
    title: {en: A slope of 30 degrees, zh: 三十度的斜坡}
    ---
    # question

    :::en
    English text; {{mu:.3f}} is a number from the code above it.
    :::

    :::zh
    中文。
    :::

    # measurement

    ```python
    mu = 0.577
    ```

Headings are the words of `HEADINGS`, which are translated. Every `:::en` has a `:::zh` behind it. Code is one
program, run block after block; what it prints and the pyplot figures it leaves open follow the block. A line
that is nothing but `{{rows}}` becomes the rows of a table if `rows` is a list of tuples.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import yaml

COURSE = Path(__file__).resolve().parents[2] / "course"
LANGUAGES = ("en", "zh")
HEADINGS = {
    "question": {"en": "Question", "zh": "问题"},
    "prediction": {"en": "Prediction", "zh": "预测"},
    "derivation": {"en": "Derivation", "zh": "推导"},
    "measurement": {"en": "Measurement", "zh": "测量"},
    "answer": {"en": "Answer", "zh": "回答"},
    "symptom": {"en": "Symptom", "zh": "症状"},
    "breaking": {"en": "Breaking it on purpose", "zh": "故意弄坏"},
    "cure": {"en": "Cause and cure", "zh": "原因与修复"},
}
_PART = re.compile(
    r"^```python\n(?P<code>.*?)^```$|^:::(?P<language>\w+)\n(?P<text>.*?)^:::$|^# (?P<heading>[^\n]+)$",
    re.M | re.S,
)


@dataclass(frozen=True)
class Part:
    """A piece of a page: `kind` is "heading", "code" or a language; `line` is where it starts."""

    kind: str
    text: str
    line: int


@dataclass(frozen=True)
class Page:
    """A course page as read from its file.

    Attributes
    ----------
    name
        Name of the file without its ending, also of the rendered page.
    order
        Place in the course: chapters count in hundreds.
    title
        By language.
    after
        Section of the textbook's chapter that the page follows, as "52.2"; "52" for all of it.
    site_only
        Too heavy for the tests: run when the site is built, and only then.
    parts
        In their order.
    """

    name: str
    order: int
    title: dict[str, str]
    after: str
    site_only: bool
    parts: tuple[Part, ...] = field(repr=False)

    @property
    def code(self) -> list[Part]:
        """The code blocks."""
        return [part for part in self.parts if part.kind == "code"]


def read_page(path: Path) -> Page:
    """Read a page and check its form.

    Raises
    ------
    ValueError
        If something stands outside of headings, code and languages, or a text lacks its other language.
    """
    _, head, body = path.read_text(encoding="utf-8").split("---\n", 2)
    facts, first = yaml.safe_load(head), head.count("\n") + 3
    parts, end = [], 0
    for found in _PART.finditer(body):
        _nothing_between(path, body[end : found.start()])
        end, line = found.end(), first + body.count("\n", 0, found.start())
        kind = "code" if found["code"] is not None else found["language"] or "heading"
        parts.append(Part(kind, found["code"] or found["text"] or found["heading"] or "", line))
    _nothing_between(path, body[end:])
    _check(path, parts)
    section = facts["order"] // 100
    after = facts.get("after", f"52.{section}" if 1 <= section <= 9 else "52")
    return Page(path.stem, facts["order"], facts["title"], after, facts.get("site_only", False), tuple(parts))


def _nothing_between(path: Path, text: str) -> None:
    if text.strip():
        raise ValueError(f"{path.name}: outside of headings, code and languages: {text.strip()[:60]!r}")


def _check(path: Path, parts: list[Part]) -> None:
    for part, after in zip(parts, [*parts[1:], Part("end", "", 0)], strict=True):
        if part.kind == "heading" and part.text not in HEADINGS:
            raise ValueError(
                f"{path.name}:{part.line}: heading {part.text!r} is none of {', '.join(HEADINGS)}"
            )
        if part.kind not in ("heading", "code", *LANGUAGES):
            raise ValueError(f"{path.name}:{part.line}: no such language: {part.kind!r}")
        if part.kind == "en" and after.kind != "zh":
            raise ValueError(f"{path.name}:{part.line}: the Chinese of this text is missing")
    if sum(p.kind == "en" for p in parts) != sum(p.kind == "zh" for p in parts):
        raise ValueError(f"{path.name}: a Chinese text without its English")


def pages() -> list[Page]:
    """Return all pages of the course, in order."""
    return sorted(map(read_page, COURSE.glob("*.md")), key=lambda page: page.order)
