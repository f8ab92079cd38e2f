"""Pages in a real Chromium: no error, no sideways scrolling at any width, Chinese glyphs, search from a disk.

Three pages of the course are built for it; SUREFOOT_SITE=docs/build/html takes all that `make docs` built.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from docs.course.pages import COURSE
from tests.browser import Browser, Tab, find_chromium

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
    if "SUREFOOT_SITE" in os.environ:
        return Path(os.environ["SUREFOOT_SITE"]).resolve()
    pytest.importorskip("sphinx", reason="the site needs Sphinx: pip install 'surefoot[docs]', or make docs")
    pytest.importorskip("furo", reason="the site needs its theme: pip install 'surefoot[docs]', or make docs")
    from docs.site.__main__ import sphinx
    from docs.site.assemble import copied

    place = tmp_path_factory.mktemp("site")
    listed = "\n".join(NAMES)
    for language, code in (("en", "en"), ("zh", "zh_CN")):
        tree = place / language
        for name in NAMES:
            copied(COURSE / language / f"{name}.ipynb", tree, language)
        index = tree / "course" / language / "index.md"
        index.write_text(f"# Course\n\n```{{toctree}}\n{listed}\n```\n", encoding="utf-8")
        out = place / "html" / ("zh" if language == "zh" else "")
        words = ["-D", "suppress_warnings=myst.xref_missing", "-D", f"root_doc=course/{language}/index"]
        assert sphinx(tree, out, code, 1, words) == 0
    return place / "html"


@pytest.fixture
def tab(request: pytest.FixtureRequest) -> Iterator[Tab]:
    """A tab of a width; what the browser itself reports on a page is among its errors, too."""
    assert CHROMIUM is not None
    width = getattr(request, "param", 800)
    with Browser(CHROMIUM, width, 850) as browser:
        tab = browser.open("about:blank")
        heard = tab.heard

        def hear(event: dict[str, Any]) -> None:
            if event["method"] == "Log.entryAdded" and event["params"]["entry"]["level"] == "error":
                tab.errors.append(event["params"]["entry"]["text"])
            heard(event)

        tab.heard = hear  # type: ignore[method-assign]
        tab.call("Log.enable")
        metrics = {"width": width, "height": 850, "deviceScaleFactor": 1, "mobile": False}
        tab.call("Emulation.setDeviceMetricsOverride", **metrics)  # Chromium's window is never below 500
        assert tab.ask("innerWidth") == width
        yield tab


def visit(tab: Tab, address: str) -> None:
    tab.call("Page.navigate", url=address)
    tab.wait_for(f"location.href === {address!r} && document.readyState === 'complete'")


@pytest.mark.parametrize("tab", [400, 800, 1300], indirect=True)
def test_pages_fit_and_say_no_error(html: Path, tab: Tab) -> None:
    built = [page for page in html.rglob("*.html") if not {"_static", "_downloads"} & {*page.parts}]
    assert len(built) >= 2 * len(NAMES)
    for page in built:
        visit(tab, page.as_uri())
        assert tab.ask(WIDE) <= 0, page
        assert not tab.errors, page
        tab.wait_for(
            "[...document.images].every(i => (i.loading = 'eager', i.complete && i.naturalWidth > 0))"
        )
    assert not [address for address in tab.requests if not address.startswith("file:")]


@pytest.mark.parametrize(
    ("tree", "words"), [("", "facets"), ("zh/", "锥"), ("zh/", "力矩"), ("zh/", "摩擦锥")]
)
def test_the_search_finds_every_page_from_a_disk(html: Path, tab: Tab, tree: str, words: str) -> None:
    """In Chinese as many pages as hold the words anywhere in their text: there is nothing between them."""
    visit(tab, f"{(html / tree / 'search.html').as_uri()}?q={quote(words)}")
    tab.wait_for("/[0-9]|one page/.test(document.querySelector('.search-summary')?.innerText)")
    found = set(tab.ask("[...document.querySelectorAll('ul.search li a')].map(a => a.href.split(/[?#]/)[0])"))
    sources = [p for p in (html / tree / "course").glob("*/*.html") if words in article(p)]
    assert sources
    assert {page.as_uri() for page in sources} <= found
    assert not tab.errors


def article(page: Path) -> str:
    """What stands on a page, without its menus."""
    text = page.read_text(encoding="utf-8").split("<article", 1)[1].split("</article>", 1)[0]
    return re.sub(r"<(style|script).*?</\1>|<[^>]*>", "", text, flags=re.DOTALL)


def test_chinese_is_drawn(html: Path, tab: Tab) -> None:
    fonts = subprocess.run(["fc-list", ":lang=zh"], capture_output=True, check=False).stdout
    if not fonts:
        pytest.skip("no font with Chinese: apt install fonts-wqy-microhei")
    visit(tab, (html / "zh" / "course" / "zh" / "theory-2-cones.html").as_uri())
    assert tab.ask(GLYPHS)


def test_every_page_has_its_notebook(html: Path) -> None:
    for language in ("", "zh"):
        found = {path.stem for path in (html / language / "_downloads").glob("*/*.ipynb")}
        assert found >= {*NAMES}


def test_mathematics_is_drawn(html: Path, tab: Tab) -> None:
    visit(tab, (html / "course" / "en" / "theory-2-cones.html").as_uri())
    sizes = tab.ask("[...document.querySelectorAll('math')].map(m => m.getBoundingClientRect().width)")
    assert len(sizes) > 10
    assert min(sizes) > 3


@pytest.mark.parametrize("tree", ["", "zh/"])
def test_the_figure_of_a_page_is_drawn(html: Path, tab: Tab, tree: str) -> None:
    """Its colours come with the page; other pages load nothing of it."""
    course = html / tree / "course" / ("zh" if tree else "en")
    visit(tab, (course / "theory-2-cones.html").as_uri())
    tab.wait_for("document.querySelectorAll('[data-figure] svg .handle').length === 1")
    tab.wait_for("getComputedStyle(document.querySelector('[data-figure] .exact')).stroke.startsWith('rgb')")
    visit(tab, (course / "errata.html").as_uri())
    assert tab.ask("document.querySelectorAll('script[src*=figures]').length") == 0
    assert not tab.errors
