"""Every page of the course runs, asserts what it says, and says it in both languages.

The pages are notebooks whose outputs are kept: these must be what a run gives, to the printed digits.
"""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from docs.course import kernel, labels, pages
from docs.course.labels import label, left_in_english
from docs.course.pages import (
    COURSE,
    LANGUAGES,
    UNKEPT,
    code,
    expressions,
    filled,
    kept,
    names,
    only,
    pair_faults,
    source,
)

pytest.importorskip("matplotlib", reason="the pages draw: pip install -e '.[viz]'")

PAGES = names()
CONTENTS = yaml.safe_load((COURSE / "contents.yaml").read_text(encoding="utf-8"))
EXERCISES = (3, 3, 3, 3, 3, 3, 2, 2, 2)
"""How many there are in each section of the chapter."""
CHAPTER = Path(__file__).resolve().parents[2] / "shared" / "CHAPTER.md"
HEADINGS = {
    "Question": "问题", "Prediction": "预测", "Derivation": "推导", "Measurement": "测量", "Answer": "回答",
    "Symptom": "症状", "Breaking it on purpose": "故意弄坏", "Cause and cure": "原因与修复",
}  # fmt: skip
SYSTEMS = {
    "Pinocchio", "Crocoddyl", "TSID", "OCS2", "ProxQP", "OSQP", "ECOS", "Mosek", "cddlib",
    "PATH", "Ifopt", "Ipopt", "MuJoCo", "MJX", "Drake", "Isaac",
    "STOCS", "ci-SCvx", "ContactBench", "Posa", "Manchester", "Pang", "Kurtz",
}  # fmt: skip
"""What the chapter's restatement names; the chapter itself names five more."""
PICTURE, ALL = 60e3, 15e6
"""Largest kept picture, and all kept notebooks together [bytes]."""


def text_of(name: str, language: str) -> str:
    """Return a page's source without its code."""
    text = source(name, language).read_text(encoding="utf-8")
    for cell in code(text):
        text = text.replace(cell, "")
    return text


def run(name: str) -> Any:
    """Run a page, where there is what runs notebooks."""
    for module in ("jupytext", "nbclient", "ipykernel"):
        pytest.importorskip(module, reason="the pages are notebooks: pip install -e '.[course]'")
    if lacking := pages.missing(name):
        pytest.skip(f"the page needs {lacking}, which is not installed")
    from docs.course.run import run

    return run(name)


def tags(cell: dict[str, Any]) -> list[str]:
    """Return a cell's tags."""
    found: list[str] = cell["metadata"].get("tags", [])
    return found


@pytest.mark.long
@pytest.mark.parametrize("name", PAGES)
def test_the_page_runs_and_what_is_kept_is_what_it_says(name: str) -> None:
    ran = run(name)
    assert ran.faults() == []
    for language in LANGUAGES:
        said = re.findall(
            r"[a-z]+", " ".join(re.findall(r"<data.*?</data>|^\|.*", ran.texts[language], re.M)).lower()
        )
        assert "nan" not in said


@pytest.mark.parametrize("name", PAGES)
def test_a_notebook_is_its_source(name: str) -> None:
    pytest.importorskip("jupytext", reason="it pairs them: pip install -e '.[course]'")
    assert pair_faults(name) == []


@pytest.mark.parametrize("name", PAGES)
def test_the_four_files_of_a_page_are_one(name: str) -> None:
    """Equal code in both languages, run, its pictures told in words."""
    books = {language: kept(name, language)["cells"] for language in LANGUAGES}
    codes = {k: [c["source"] for c in book if c["cell_type"] == "code"] for k, book in books.items()}
    assert codes["en"] == codes["zh"]
    assert code(source(name, "en").read_text("utf-8")) == code(source(name, "zh").read_text("utf-8"))
    for language, book in books.items():
        cells = [cell for cell in book if cell["cell_type"] == "code"]
        assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
        assert not any(cell["outputs"] for cell in cells if UNKEPT in tags(cell)), "it depends on the machine"
        for output in (output for cell in cells for output in cell["outputs"]):
            assert output["output_type"] in ("stream", "display_data"), "a value that nobody asked for"
            if output["output_type"] == "display_data":
                assert len(base64.b64decode(output["data"]["image/png"])) < PICTURE
                alt = output["metadata"]["image/png"]["alt"]
                assert alt.startswith({"en": "Figure: ", "zh": "图："}[language])
                assert len(alt) > 10
    if "clock." in str(codes["en"]):
        assert any(UNKEPT in tags(cell) for cell in books["en"]), "a time of the machine is not kept"


def test_the_kept_notebooks_are_small_and_name_no_machine() -> None:
    books = list(COURSE.glob("*/*.ipynb"))
    assert sum(path.stat().st_size for path in books) < ALL
    for path in books:
        found = re.findall(r"/home/|/root/|/tmp/|/work/|site-packages", path.read_text(encoding="utf-8"))
        assert not found, path


@pytest.mark.parametrize("name", PAGES)
def test_the_form_of_a_page(name: str) -> None:
    english = source(name, "en").read_text(encoding="utf-8")
    assert any("assert " in cell for cell in code(english))
    imports = re.findall(r"(?:from|import) (surefoot[\w.]*)", "\n".join(code(english)))
    assert not [module for module in imports if "._" in module], "public names only"
    titles = {k: re.findall(r"^## (.*)$", text_of(name, k), re.MULTILINE) for k in LANGUAGES}
    assert [HEADINGS[title] for title in titles["en"]] == titles["zh"]
    assert len(re.findall(r"[\u4e00-\u9fff]", text_of(name, "zh"))) > 80
    for language in LANGUAGES:
        text = text_of(name, language)
        assert not re.search(r"^:::|\{\{|</data>\?|>\?</data>", text, re.MULTILINE)
        assert f"python -m docs.course {name}`" in text, "how to run it"
        other = {"en": "zh", "zh": "en"}[language]
        assert f"](../{other}/{name}.ipynb)" in text


@pytest.mark.parametrize("name", PAGES)
def test_mathematics_is_latex(name: str) -> None:
    """Outside of tables of names, code and alternative texts no Greek letter and no power stands bare."""
    for language in LANGUAGES:
        text = re.sub(
            r"<data.*?</data>|\$\$?[^$]+\$\$?|`[^`]*`|^\|.*", "", text_of(name, language), flags=re.M | re.S
        )
        assert not re.findall(r"[αβγδεζθκλπρστφωᵀ⁻√‖⁺]", text)


def test_both_contents_list_the_same_pages_in_the_same_order() -> None:
    listed = {
        k: re.findall(
            r"^- \[.*\]\(([\w.-]+)\.ipynb\)", (COURSE / k / "index.md").read_text(encoding="utf-8"), re.M
        )
        for k in LANGUAGES
    }
    assert listed["en"] == listed["zh"] == PAGES
    for language in LANGUAGES:
        there = {path.name for path in (COURSE / language).iterdir()}
        assert there == {"index.md", *(f"{name}{end}" for name in PAGES for end in (".md", ".ipynb"))}
    assert {path.name for path in COURSE.iterdir()} == {"contents.yaml", "solutions", *LANGUAGES}
    assert {path.stem for path in (COURSE / "solutions").glob("*.py")} == set(CONTENTS["exercises"])


def test_the_chinese_pages_link_to_chinese_ones() -> None:
    for path in [*(COURSE / "zh").glob("*.md"), *(COURSE.parent / "docs" / "zh").glob("*.md")]:
        for words, link in re.findall(r"\[([^\]]*)\]\(([^)#\s]+)", path.read_text(encoding="utf-8")):
            twin = COURSE.parent / "docs" / "zh" / Path(link).name
            if "://" not in link and words not in ("English", "英文版", "英文术语表"):
                assert "/en/" not in link, path
                assert not twin.exists() or (path.parent / link).resolve() == twin, f"{path.name}: {link}"


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
        "systems": 29,
        "told in running text": 2,
    }
    assert {name: len(CONTENTS[name]) for name in sizes} == sizes
    named = [page for part in CONTENTS.values() for pages_of in part.values() for page in pages_of]
    assert all(pages_of for part in CONTENTS.values() for pages_of in part.values())
    assert set(PAGES) == set(named)
    for name, pages_of in CONTENTS["exercises"].items():
        assert all(page.startswith(name) for page in pages_of)


def table_rows(page: str, language: str) -> list[str]:
    """The rows of all tables of a page."""
    return [line for line in text_of(page, language).splitlines() if line.startswith("| ")]


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_trap_has_its_row_with_its_section_its_number_and_its_pages(language: str) -> None:
    rows = {row.split("|")[1].strip(): row for row in table_rows("traps", language)}
    for name, pages_of in CONTENTS["traps"].items():
        number, section = name.split()[:2]
        row = rows[number.rstrip(".")]
        assert row.split("|")[2].strip() == section
        assert f"t[{number.rstrip('.')}]" in row, "a number of its own"
        assert re.findall(r"\(([\w.-]+)\.ipynb\)", row) == pages_of


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_system_has_its_row_with_law_whether_it_runs_and_where(language: str) -> None:
    rows = table_rows("table-systems", language)
    five = {"acados", "Dojo", "DiffTaichi", "ContactNets", "Humanoid-Gym"}
    assert five <= set(CONTENTS["systems"])
    for system in CONTENTS["systems"]:
        key = re.sub(r"MIT's convex MPC", "MIT", system).split(",")[0].split(" and others")[0]
        (row,) = [row for row in rows if key in row.split("|")[1] and len(row.split("|")) == 7]
        cells = [cell.strip() for cell in row.split("|")[1:-1]]
        assert all(cells)
        assert re.search(r"\.(ipynb|md)\)", cells[-1])


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
    named = re.findall(r"(?:^| )(\d+)\. (52\.\d(?:\.\d)?)(?= )", boxes, re.MULTILINE)
    assert [f"{number}. {section}" for number, section in named] == [
        " ".join(name.split()[:2]) for name in CONTENTS["traps"]
    ]
    for system in SYSTEMS:
        assert system in text, "a system that the chapter does not name"
        assert any(system in name for name in CONTENTS["systems"]), system
    derived = text.split("what each derives")[1].split("##")[0]
    shown = {name.split()[0] for name in CONTENTS["sections"]}
    for section in re.findall(r"52\.\d(?:\.\d)?(?= )", derived):
        assert section in shown or any(name.startswith(section) for name in shown) or section == "52.3.2", (
            section
        )


@pytest.mark.parametrize("name", [name for name in PAGES if name.startswith("theory-")])
def test_a_theory_page_predicts_derives_runs_and_draws(name: str) -> None:
    text = source(name, "en").read_text(encoding="utf-8")
    found = re.findall(r"^## (.*)$", text_of(name, "en"), re.MULTILINE)
    assert found == ["Question", "Prediction", "Derivation", "Measurement", "Answer"]
    assert any("plt.subplots" in cell for cell in code(text))


def test_values_and_tables_in_texts() -> None:
    text = """mu <data value="x:.2f">?</data>, <data value="d['a'] &lt; 2">old</data>

| k | |
| --- | --- |
| 1 | old |

<!-- rows: rows -->
"""
    assert expressions(text) == ["x:.2f", "d['a'] < 2", "rows rows"]
    values = ["0.58", "fell", [["inner, 4 facets", "done"], ["osqp", "innermost"]]]
    english, chinese = (filled(text, values, language) for language in LANGUAGES)
    assert """<data value="x:.2f">0.58</data>, <data value="d['a'] &lt; 2">fell</data>""" in english
    assert "| --- | --- |\n| inner, 4 facets | done |\n| osqp | innermost |\n\n<!-- rows: rows -->" in english
    assert "摔倒" in chinese
    assert "| 内接, 4 面 | 完成 |\n| osqp | innermost |" in chinese
    assert filled(english, values, "en") == english, "a second run changes nothing"


MINI = """---
jupytext:
  formats: md:myst,ipynb
  text_representation:
    extension: .md
    format_name: myst
kernelspec:
  display_name: Python 3
  language: python
  name: python3
---

# Title

```{{code-cell}} ipython3
import matplotlib.pyplot as plt

x = {x}
print(x)
plt.plot([1, x], label="force")
plt.xlabel("unheard of")
plt.legend();
```

It is <data value="x:.1f">?</data>.
"""


@pytest.mark.long
def test_what_is_no_longer_current_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "COURSE", tmp_path)
    for language, x in (("en", 2), ("zh", 3)):
        (tmp_path / language).mkdir()
        (tmp_path / language / "mini.md").write_text(MINI.format(x=x))
    assert any("code differs" in fault for fault in pair_faults("mini"))
    ran = run("mini")
    ran.keep()
    assert pair_faults("mini") == []
    assert ran.left == ["unheard", "of"]
    assert run("mini").faults() == [
        f"mini: a figure says {w!r}: translate in docs/course/labels.yaml" for w in ran.left
    ]
    page = tmp_path / "zh" / "mini.md"
    assert '<data value="x:.1f">2.0</data>' in page.read_text()
    assert (
        kept("mini", "zh")["cells"][1]["outputs"][1]["metadata"]["image/png"]["alt"] == "图：unheard of，力"
    )
    page.write_text(page.read_text().replace(">2.0<", ">2.1<"))
    assert any("zh/mini.md: line" in fault and "2.0" in fault for fault in run("mini").faults())
    assert any("zh/mini.ipynb is not its .md's" in fault for fault in pair_faults("mini"))


def test_pages_are_chosen_by_name_or_how_it_begins() -> None:
    known = ["52.2.1-pyramids", "52.2.2-wrench-cone", "errata"]
    assert only(["52.2"], known) == known[:2]
    assert only(["course/zh/errata.md", "52.2.1"], known) == ["errata", "52.2.1-pyramids"]
    assert only([], known) == known
    with pytest.raises(ValueError, match=r"no page 'x'; there are 52\.2\.1"):
        only(["x"], known)


@pytest.mark.parametrize("font", [labels.chinese_font(), None])
def test_a_figure_is_drawn_in_chinese_where_a_font_is(font: str | None) -> None:
    """A missing glyph is a warning, and fails here; without a font the words alone are Chinese."""
    from matplotlib.figure import Figure

    figure = Figure()
    left, right = figure.subplots(1, 2)
    left.plot([1, 2], [1.0, 2.0], label="worst\ndirection")
    left.set(xlabel="least $F_z$ allowed [N]", title="unheard of")
    left.set_xticks([1, 2], ["infeasible", "solved"])
    left.legend()
    right.barh(["rigid", "MuJoCo, elliptic"], [1.0, 2.0])
    assert kernel.description(figure, "en") == (
        "Figure: unheard of, least F_z allowed [N], worst direction, infeasible, solved. "
        "rigid, MuJoCo, elliptic"
    )
    english = kernel.picture(figure)
    said = labels.translate(figure, font)
    assert {
        "最坏方向",
        "允许的最小 $F_z$ [N]",
        "不可行",
        "已求解",
        "刚性",
        "MuJoCo，椭圆锥",
        "unheard of",
    } <= {*said}
    assert [text for text in said if left_in_english(text)] == ["unheard of"]
    assert kernel.description(figure, "zh") == (
        "图：unheard of，允许的最小 F_z [N]，最坏方向，不可行，已求解。刚性，MuJoCo，椭圆锥"
    )
    if font is not None:
        assert kernel.picture(figure) != english


@pytest.mark.parametrize("width", [4.6, 7.0, 10.4])
def test_small_texts_are_raised_to_12_pixels_as_shown(width: float) -> None:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    figure = Figure(figsize=(width, 3.0), dpi=110)
    axis = figure.add_subplot(xlabel="x", title="t")
    axis.plot([1.0, 2.0], label="a")
    axis.legend(fontsize=6)
    kernel.make_legible(figure)
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
