"""Pages of the course in a real Chromium: no error, no sideways scrolling at any width, Chinese glyphs."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from benchmarks.browser import Browser, find_chromium
from docs.site.page import COURSE, pages, read_page

CHROMIUM = find_chromium()
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(
        CHROMIUM is None, reason="no Chromium: apt install chromium, or set SUREFOOT_CHROMIUM"
    ),
]
NAMES = ("errata", "start-here", "theory-2-cones")
WIDE = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
GLYPHS = """(() => { const c = document.createElement('canvas').getContext('2d');
c.font = '40px ' + getComputedStyle(document.querySelector('article p')).fontFamily;
const shape = t => { c.clearRect(0, 0, 60, 60); c.fillText(t, 2, 45);
return c.getImageData(0, 0, 60, 60).data.join(); };
return shape('锥') !== shape('力') && shape('锥') !== shape('\\ue123'); })()"""
"""Whether two characters are drawn, and otherwise than one that no font has."""


@pytest.fixture(scope="module")
def html(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("sphinx", reason="the site needs Sphinx: pip install 'surefoot[docs]', or make docs")
    pytest.importorskip("furo", reason="the site needs its theme: pip install 'surefoot[docs]', or make docs")
    from docs.site import render
    from docs.site.__main__ import PARTIAL, sphinx
    from docs.site.assemble import contents
    from docs.site.execute import run_page

    place = tmp_path_factory.mktemp("site")
    trees = {language: place / language for language in ("en", "zh")}
    figures = trees["en"] / "course" / "figures"
    figures.mkdir(parents=True)
    chosen = [read_page(COURSE / f"{name}.md") for name in NAMES]
    for page in chosen:
        render.write(run_page(page, figures), trees)
    (trees["zh"] / "course" / "figures").symlink_to(figures)
    for language, code in (("en", "en"), ("zh", "zh_CN")):
        tree = trees[language] / "course"
        (tree / "index.md").write_text(contents(chosen, language), encoding="utf-8")
        assert sphinx(tree, place / "html" / language, code, 1, ["-D", PARTIAL]) == 0
    return place / "html"


@pytest.mark.parametrize("width", [400, 800, 1300])
def test_pages_fit_and_say_no_error(html: Path, width: int) -> None:
    assert CHROMIUM is not None
    with Browser(CHROMIUM, width, 850) as browser:
        tab = browser.open("about:blank")
        tab.call("Log.enable")
        for language in ("en", "zh"):
            for name in NAMES:
                address = (html / language / f"{name}.html").as_uri()
                tab.call("Page.navigate", url=address)
                tab.wait_for(f"location.href === {address!r} && document.readyState === 'complete'")
                assert tab.ask(WIDE) <= 0, (language, name)
                assert tab.ask("[...document.images].every(i => i.complete && i.naturalWidth > 300)")
        assert not tab.errors


def test_chinese_is_drawn(html: Path) -> None:
    assert CHROMIUM is not None
    fonts = subprocess.run(["fc-list", ":lang=zh"], capture_output=True, check=False).stdout
    if not fonts:
        pytest.skip("no font with Chinese: apt install fonts-wqy-microhei")
    with Browser(CHROMIUM) as browser:
        tab = browser.open((html / "zh" / "theory-2-cones.html").as_uri())
        tab.wait_for("document.readyState === 'complete' && document.querySelector('article p') !== null")
        assert tab.ask(GLYPHS)


def test_every_page_is_a_notebook_of_its_code(html: Path) -> None:
    import json

    assert len(pages()) > 60
    for name in NAMES:
        text = (html.parent / "zh" / "course" / "notebooks" / f"{name}.ipynb").read_text(encoding="utf-8")
        names: dict[str, object] = {"__name__": "__main__"}
        for cell in json.loads(text)["cells"]:
            if cell["cell_type"] == "code":
                exec(compile("".join(cell["source"]), f"{name}.ipynb", "exec"), names)
