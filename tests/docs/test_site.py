"""The documentation site: a complete reference, a link checker that finds faults, and it builds."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import surefoot
from docs.site import reference
from docs.site.assemble import BESIDES, LANDINGS, ZH, ZH_ORDER, code_blocks, menus, turned, with_menus
from docs.site.links import broken_links, loaded_from_outside, undocumented

ROOT = Path(__file__).resolve().parents[2]
DOCS = [
    *(ROOT / "docs").glob("*.md"),
    *(ROOT / "docs" / "cookbook").glob("*.md"),
    *(ROOT / "docs" / "reports").glob("*.md"),
]
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
    assert list(reference.verbs()) == ["Constrain", "Solve", "Check", "Walk", "Look"]
    assert all(f".. rubric:: {verb}\n" in index for verb in reference.verbs())
    assert {*dir(surefoot)} - {"__version__"} == set(re.findall(r":py:obj:`~surefoot\.(\w+)`", index))


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
    assert pages_there == {*below, *(f"/docs/{shelf}" for shelf in LANDINGS[3:])} - OTHERS


@pytest.mark.parametrize("name", ["do", "first-steps", "learn", "look-up", "understand"])
def test_a_chinese_page_says_what_the_english_one_says(name: str) -> None:
    """The same links in the same order, and all of its code: what one page gains the other must gain, too."""
    english, chinese = ROOT / "docs" / f"{name}.md", ZH / f"{name}.md"

    def links(page: Path) -> list[str]:
        found = re.findall(r"\]\(([\w./-]+?\.md)", page.read_text(encoding="utf-8"))
        return [Path(link).stem for link in found if "CHANGELOG" not in link]

    assert links(chinese) == links(english)
    assert code_blocks(chinese) == code_blocks(english)


def test_the_chinese_glossary_has_every_term_of_the_english_one() -> None:
    terms = [
        re.findall(r"^\| ([^|]+?) \|", (folder / "glossary.md").read_text(encoding="utf-8"), re.MULTILINE)[1:]
        for folder in (ROOT / "docs", ZH)
    ]
    assert {*terms[0]} - {"---"} <= {*terms[1]}
    assert {path.stem for path in ZH.glob("*.md")} == {*ZH_ORDER}


def test_links_of_a_tree_stay_in_it_or_are_addresses_of_the_other() -> None:
    page = ROOT / "course" / "zh" / "errata.md"
    text = "[a](self-test.ipynb) [b](../../docs/lab.md#cone) [c](../../docs/zh/glossary.md) "
    text += "[d](../../pyproject.toml)"
    assert turned(page, text, "zh") == (
        '[a](self-test.ipynb) <a href="../../../docs/lab.html#cone" hreflang="en">b（英文）</a> '
        "[c](../../docs/zh/glossary.md) d (`pyproject.toml`)"
    )
    text = "[English](../en/errata.ipynb)"
    assert turned(page, text, "zh") == '<a href="../../../course/en/errata.html" hreflang="en">English</a>'
    text = "[中文](../zh/errata.ipynb)"
    notebook = "examples/notebooks/01_a_cone.ipynb"  # which is no page of the site
    assert turned(ROOT / "docs" / "notebooks.md", f"[1](../{notebook})", "en") == f"1 (`{notebook}`)"
    page = ROOT / "course" / "en" / "errata.md"
    assert turned(page, text, "en") == '<a href="../../zh/course/zh/errata.html" hreflang="zh">中文</a>'


def test_the_courses_contents_become_menus() -> None:
    text = with_menus("# C\n\n## One\n\n- [a](x.ipynb)\n- [b](y.1.ipynb)\n\n## Two\n\n- [c](z.ipynb)\n")
    assert text.count("{toctree}") == 2
    assert ":caption: One\n\nx\ny.1\n```" in text


@pytest.mark.long
def test_a_page_of_both_languages_builds(tmp_path: Path) -> None:
    """Numbers, mathematics, a figure in words: from what is kept, without running anything."""
    pytest.importorskip("myst_nb", reason="the site needs MyST-NB: pip install -e '.[docs]', or make docs")
    pytest.importorskip("furo", reason="the site needs its theme: pip install -e '.[docs]', or make docs")
    from docs.site.__main__ import sphinx
    from docs.site.assemble import copied

    for language, code, words in (("en", "en", "Measurement"), ("zh", "zh_CN", "测量")):
        tree = tmp_path / language
        for name in ("52.2.1-pyramids", "theory-3-lcp"):
            copied(ROOT / "course" / language / f"{name}.ipynb", tree, language)
        folder = tree / "course" / language
        (folder / "index.md").write_text(
            "# T\n\n```{toctree}\n52.2.1-pyramids\ntheory-3-lcp\n```\n", encoding="utf-8"
        )
        assert sphinx(folder, tmp_path / "html" / language, code, 1) == 0
        built = (tmp_path / "html" / language / "52.2.1-pyramids.html").read_text(encoding="utf-8")
        assert "41.4" in built
        assert words in built
        assert re.search(r'<img alt="(Figure: |图：)[^"]{20}', built)
        theory = (tmp_path / "html" / language / "theory-3-lcp.html").read_text(encoding="utf-8")
        assert theory.count("<math") > 40
        assert "<mi>λ</mi>" in theory
