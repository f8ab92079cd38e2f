"""Every page of the course runs, asserts what it says, and says it in both languages."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

from docs.site import labels
from docs.site.execute import filled, make_legible, run_page
from docs.site.labels import label, left_in_english
from docs.site.page import COURSE, LANGUAGES, Page, pages, read_page

PAGES = pages()
CONTENTS = yaml.safe_load((COURSE / "contents.yaml").read_text(encoding="utf-8"))
EXERCISES = (3, 3, 3, 3, 3, 3, 2, 2, 2)
"""How many there are in each section of the chapter."""
CHAPTER = Path(__file__).resolve().parents[2] / "shared" / "CHAPTER.md"

pytest.importorskip("matplotlib", reason="the pages draw: pip install -e '.[viz]'")


@pytest.mark.long
@pytest.mark.parametrize("page", [p for p in PAGES if not p.site_only], ids=lambda page: page.name)
def test_the_page_runs_and_what_it_asserts_holds(page: Page) -> None:
    ran = run_page(page)
    for language in LANGUAGES:
        text = "\n".join(text for _, text in ran.pieces[language])
        assert "{{" not in text
        assert "nan" not in re.findall(r"[a-z]+", text.lower())
    english = {text: left for text in ran.labels if (left := left_in_english(text))}
    assert not english, "in figures: translate in docs/site/zh/labels.yaml, or list among its names"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_form_of_a_page(page: Page) -> None:
    assert any("assert " in part.text for part in page.code)
    assert set(page.title) == set(LANGUAGES)
    imports = re.findall(r"(?:from|import) (surefoot[\w.]*)", "\n".join(part.text for part in page.code))
    assert not [name for name in imports if "._" in name], "public names only"
    chinese = "".join(part.text for part in page.parts if part.kind == "zh")
    assert len(re.findall(r"[\u4e00-\u9fff]", chinese)) > 80


def test_everything_in_the_chapter_has_its_pages() -> None:
    """Sections, exercises, tables, symptoms, traps, errata: no item and no page without the other."""
    exercises = {f"52.{s}.{n}" for s, count in enumerate(EXERCISES, 1) for n in range(1, count + 1)}
    assert set(CONTENTS["exercises"]) == exercises
    sizes = {
        "sections": 12,
        "capstone": 1,
        "across chapters": 1,
        "tables": 7,
        "symptoms": 7,
        "errata": 25,
        "traps": 24,
        "told in running text": 2,
    }
    assert {name: len(CONTENTS[name]) for name in sizes} == sizes
    named = [page for part in CONTENTS.values() for pages_of in part.values() for page in pages_of]
    assert all(pages_of for part in CONTENTS.values() for pages_of in part.values())
    assert {page.name for page in PAGES} == set(named)
    for name, pages_of in CONTENTS["exercises"].items():
        assert all(page.startswith(name) for page in pages_of)


@pytest.mark.skipif(not CHAPTER.exists(), reason="the chapter's restatement is not beside the checkout")
def test_the_contents_are_the_chapters() -> None:
    text = CHAPTER.read_text(encoding="utf-8")
    assert set(re.findall(r"^(52\.\d\.\d) ", text, re.MULTILINE)) == set(CONTENTS["exercises"])
    tables = text.split("## Tables to measure anew")[1].split("##")[0]
    assert [line.split(":")[0].split(" (")[0] for line in re.findall(r"^- (.*)", tables, re.MULTILINE)] == [
        *CONTENTS["tables"]
    ]
    symptoms = text.split("## Troubleshooting")[1].split("##")[0]
    assert [int(n) for n in re.findall(r"^(\d)\. ", symptoms, re.MULTILINE)] == [*CONTENTS["symptoms"]]
    boxes = text.split("## Traps that it names")[1].split("Also told")[0]
    assert len(re.findall(r"(?:^| )\d+\. (?=52\.)", boxes, re.MULTILINE)) == len(CONTENTS["traps"])
    derived = text.split("what each derives")[1].split("##")[0]
    shown = {name.split()[0] for name in CONTENTS["sections"]}
    for section in re.findall(r"52\.\d(?:\.\d)?(?= )", derived):
        assert section in shown or any(name.startswith(section) for name in shown) or section == "52.3.2", (
            section
        )


@pytest.mark.parametrize("page", [p for p in PAGES if p.name.startswith("theory-")], ids=lambda p: p.name)
def test_a_theory_page_predicts_derives_runs_and_draws(page: Page) -> None:
    headings = [part.text for part in page.parts if part.kind == "heading"]
    assert headings == ["question", "prediction", "derivation", "measurement", "answer"]
    assert any("plt.subplots" in part.text for part in page.code)


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        ("loose text\n", "outside of headings"),
        ("# nonsense\n", "is none of"),
        (":::en\nx\n:::\n", "Chinese of this text is missing"),
        (":::zh\nx\n:::\n", "without its English"),
        (":::fr\nx\n:::\n", "no such language"),
    ],
)
def test_a_page_of_wrong_form_is_refused(tmp_path, body: str, fault: str) -> None:
    path = tmp_path / "page.md"
    path.write_text("---\norder: 1\ntitle: {en: a, zh: b}\n---\n" + body)
    with pytest.raises(ValueError, match=fault):
        read_page(path)


def test_values_and_tables_in_texts() -> None:
    names = {"x": 0.5774, "rows": [(4, "41 %"), (8, "8 %")]}
    assert filled("mu {{x:.2f}}, {{2 * x:.1f}}", names) == "mu 0.58, 1.2"
    assert filled("| k | |\n{{rows}}", names) == "| k | |\n| 4 | 41 % |\n| 8 | 8 % |"
    words = {"rows": [("inner, 4 facets", "done"), ("osqp", "innermost")], "end": "fell"}
    assert filled("{{end}}\n{{rows}}", words, "zh") == "摔倒\n| 内接, 4 面 | 完成 |\n| osqp | innermost |"
    assert filled("{{end}}", words) == "fell"


FIGURE = """---
order: 1
title: {en: a, zh: b}
---
```python
import matplotlib.pyplot as plt

_, (left, right) = plt.subplots(1, 2)
left.plot([1, 2], [1.0, 2.0], label="worst\\ndirection")
left.set(xlabel="least $F_z$ allowed [N]", title="unheard of")
left.set_xticks([1, 2], ["infeasible", "solved"])
left.legend()
right.barh(["rigid", "MuJoCo, elliptic"], [1.0, 2.0])
```
"""


@pytest.mark.parametrize("font", [labels.chinese_font(), None])
def test_a_figure_is_drawn_in_chinese_where_a_font_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, font: str | None
) -> None:
    """A missing glyph is a warning, and fails here; without a font the English figure stays."""
    monkeypatch.setattr(labels, "chinese_font", lambda: font)
    (tmp_path / "page.md").write_text(FIGURE)
    ran = run_page(read_page(tmp_path / "page.md"), tmp_path)
    said = {"最坏方向", "允许的最小 $F_z$ [N]", "不可行", "已求解", "刚性", "MuJoCo，椭圆锥", "unheard of"}
    assert said <= {*ran.labels}
    assert [text for text in ran.labels if left_in_english(text)] == ["unheard of"]
    assert dict(ran.pieces["en"])["figure"] == "page-1.png"
    assert dict(ran.pieces["zh"])["figure"] == ("page-1.png" if font is None else "page-1-zh.png")
    assert len({path.read_bytes() for path in tmp_path.glob("*.png")}) == (1 if font is None else 2)


@pytest.mark.parametrize("width", [4.6, 7.0, 10.4])
def test_small_texts_are_raised_to_12_pixels_as_shown(width: float) -> None:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    figure = Figure(figsize=(width, 3.0), dpi=110)
    axis = figure.add_subplot(xlabel="x", title="t")
    axis.plot([1.0, 2.0], label="a")
    axis.legend(fontsize=6)
    make_legible(figure)
    figure.canvas.draw()
    shown = min(110 * width, 753.0) / (110 * width)  # a column is 753 px on a window of 800
    sizes = [t.get_fontsize() for t in figure.findobj(Text) if t.get_text()]
    assert len(sizes) > 10
    assert min(sizes) * 110 / 72 * shown >= 12.0 - 1e-9


def test_labels_take_the_longest_phrase_and_whole_words_alone() -> None:
    assert label("time [s]") == "时间 [s]"
    assert label("8 facets") == "8 面"
    assert label("timeless, force of the ground") == "timeless，地面的力"
    assert left_in_english("Go2 $f_x$ 5 N, 力 wobbles") == ["wobbles"]


def test_the_course_folder_holds_nothing_else() -> None:
    assert {path.name for path in COURSE.iterdir() if path.suffix != ".md"} == {"contents.yaml"}
