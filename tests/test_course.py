"""Every page of the course runs, asserts what it says, and says it in both languages."""

from __future__ import annotations

import re

import pytest

from docs.site.execute import filled, run_page
from docs.site.page import COURSE, LANGUAGES, Page, pages, read_page

PAGES = pages()
EXERCISES = (3, 3, 3, 3, 3, 3, 2, 2, 2)
"""How many there are in each section of the chapter."""

pytest.importorskip("matplotlib", reason="the pages draw: pip install -e '.[viz]'")


@pytest.mark.long
@pytest.mark.parametrize("page", [p for p in PAGES if not p.site_only], ids=lambda page: page.name)
def test_the_page_runs_and_what_it_asserts_holds(page: Page) -> None:
    ran = run_page(page)
    for language in LANGUAGES:
        text = "\n".join(text for _, text in ran.pieces[language])
        assert "{{" not in text
        assert "nan" not in re.findall(r"[a-z]+", text.lower())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_form_of_a_page(page: Page) -> None:
    assert any("assert " in part.text for part in page.code)
    assert set(page.title) == set(LANGUAGES)
    imports = re.findall(r"(?:from|import) (surefoot[\w.]*)", "\n".join(part.text for part in page.code))
    assert not [name for name in imports if "._" in name], "public names only"
    chinese = "".join(part.text for part in page.parts if part.kind == "zh")
    assert len(re.findall(r"[\u4e00-\u9fff]", chinese)) > 80


def test_every_exercise_of_the_chapter_has_a_page() -> None:
    wanted = {f"52.{s}.{n}" for s, count in enumerate(EXERCISES, 1) for n in range(1, count + 1)}
    wanted |= {"capstone", "across-chapters"}
    found = {
        match[0] for page in PAGES if (match := re.match(r"52\.\d\.\d|capstone|across-chapters", page.name))
    }
    assert found == wanted


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


def test_the_course_folder_holds_nothing_else() -> None:
    assert {path.suffix for path in COURSE.iterdir()} == {".md"}
