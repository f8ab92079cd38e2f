"""The documentation site: a complete reference, a link checker that finds faults, and it builds."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import surefoot
from docs.site import reference
from docs.site.assemble import BESIDES, LANDINGS, SECTIONS, ZH, code_blocks, menus
from docs.site.links import broken_links, loaded_from_outside, undocumented
from docs.site.page import COURSE, pages, read_page

ROOT = Path(__file__).resolve().parents[2]
DOCS = [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "cookbook").glob("*.md")]
OTHERS = {name for names in BESIDES.values() for name in names if not name.startswith("/docs/")}


def test_every_public_name_is_in_the_reference(tmp_path: Path) -> None:
    reference.write(tmp_path)
    text = "\n".join(path.read_text() for path in tmp_path.glob("*.rst"))
    names = [name for names in reference.public_names().values() for name in names]
    assert {*names, "laws", "__version__"} == set(dir(surefoot))
    missing = [name for name in names if f"surefoot.{name}\n" not in text]
    assert missing == []
    index = (tmp_path / "index.rst").read_text()
    assert all(f"   {path.stem}\n" in index for path in tmp_path.glob("*.rst") if path.stem != "index")


def test_broken_links_are_found(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text(
        '<a id="here" href="b.html#there">x</a><a href="none.html">y</a><a href="#here">'
    )
    (tmp_path / "b.html").write_text(
        '<script src="https://example.org/x.js"></script><a href="a.html#no">z</a>'
    )
    assert broken_links(tmp_path) == [
        "a.html: no anchor b.html#there",
        "a.html: no none.html",
        "b.html: no anchor a.html#no",
    ]
    assert loaded_from_outside(tmp_path) == ["b.html: loads https://example.org/x.js"]
    assert undocumented(tmp_path, ["solve"]) == ["surefoot.solve is not in the reference"]


def test_every_page_is_below_one_landing_page() -> None:
    """The home leads to four shelves; these, and the two landing pages on them, lead to everything else."""
    home = (ROOT / "docs" / "site" / "index.md").read_text()
    for shelf in ("learn", "do", "look-up", "understand"):
        assert f"](docs/{shelf}.md)" in home
        assert f"\ndocs/{shelf}\n" in home
    below = [name for names in menus().values() for name in names]
    assert len(below) == len(set(below))
    pages_there = {f"/docs/{path.relative_to(ROOT / 'docs').with_suffix('')}" for path in DOCS}
    assert pages_there == {*below, *(f"/docs/{shelf}" for shelf in LANDINGS[2:])} - OTHERS


@pytest.mark.parametrize("path", sorted(ZH.glob("*.md")), ids=lambda path: path.stem)
def test_a_chinese_page_says_what_the_english_one_says(path: Path) -> None:
    """The same links in the same order, and all of its code: what one page gains the other must gain, too."""
    english = ROOT / "docs" / path.name

    def links(page: Path) -> list[str]:
        found = re.findall(r"\]\(([\w./-]+?\.md|\.\./course)", page.read_text(encoding="utf-8"))
        return [Path(link).stem for link in found if "CHANGELOG" not in link]

    assert [link.replace("index", "course") for link in links(path)] == links(english)
    text = path.read_text(encoding="utf-8")
    assert re.findall(r"^\{\{(\d+)\}\}$", text, re.MULTILINE) == [
        str(n) for n in range(1, len(code_blocks(english)) + 1)
    ]


def test_every_course_page_belongs_to_a_section() -> None:
    for page in pages():
        assert page.order // 100 in SECTIONS, page.name


def test_a_page_of_both_languages_builds(tmp_path: Path) -> None:
    pytest.importorskip("sphinx", reason="the site needs Sphinx: pip install -e '.[docs]', or make docs")
    pytest.importorskip("furo", reason="the site needs its theme: pip install -e '.[docs]', or make docs")
    from docs.site import render
    from docs.site.__main__ import sphinx
    from docs.site.assemble import contents
    from docs.site.execute import run_page

    page = read_page(COURSE / "52.2.1-pyramids.md")
    trees = {language: tmp_path / language for language in ("en", "zh")}
    figures = trees["en"] / "course" / "figures"
    figures.mkdir(parents=True)
    render.write(run_page(page, figures), trees)
    (tmp_path / "zh" / "course" / "figures").symlink_to(figures)
    tree = trees["zh"] / "course"
    (tree / "index.md").write_text(contents([page], "zh"), encoding="utf-8")
    assert sphinx(tree, tmp_path / "html", "zh_CN", 1) == 0
    built = (tmp_path / "html" / f"{page.name}.html").read_text(encoding="utf-8")
    assert "41.4 %" in built
    assert "测量" in built
    notebook = json.loads((tree / "notebooks" / f"{page.name}.ipynb").read_text(encoding="utf-8"))
    assert sum(cell["cell_type"] == "code" for cell in notebook["cells"]) == len(page.code)
