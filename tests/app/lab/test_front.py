"""The page's own file: a title, a word while it loads, and phones, whose panel hides nothing."""

from __future__ import annotations

import gzip
import urllib.request
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed: pip install -e '.[lab]'")

import surefoot as sf
from surefoot.app.lab import html_text
from surefoot.app.lab.front import TITLE, dress_answer, dress_file
from surefoot.app.lab.server import LabServer
from surefoot.app.lab.stand import StandPage, stand_drawing, start_state
from surefoot.app.viz import palette
from tests.browser import SOFTWARE, Browser, find_chromium

CHROMIUM = find_chromium()
PAGE = b'<head><title>Viser</title></head><body><div id="root"></div></body>'


def stand_page() -> StandPage:
    return StandPage(start_state(sf.load_robot("go2")))


def test_title_and_word_are_put_in_whether_it_is_packed_or_not() -> None:
    plain = dress_file(PAGE, False)
    assert b"<title>Surefoot lab</title>" in plain
    assert b"is loading" in plain
    assert gzip.decompress(dress_file(gzip.compress(PAGE), True)) == plain
    assert dress_file(b"<p>another version</p>", False) == b"<p>another version</p>"


def test_answers_that_are_no_pages_stay_as_they_are() -> None:
    script = SimpleNamespace(headers={"Content-Type": "text/javascript"}, body=PAGE)
    dress_answer(script)
    assert script.body == PAGE
    page = SimpleNamespace(headers={"Content-Type": "text/html", "Content-Length": "1"}, body=PAGE)
    dress_answer(page)
    assert page.headers["Content-Length"] == str(len(page.body))


def test_the_server_sends_it() -> None:
    with LabServer(stand_page, port=0) as server, urllib.request.urlopen(server.url, timeout=30) as answer:
        text = answer.read().decode()
    assert f"<title>{TITLE}</title>" in text
    assert "is loading" in text


def test_a_verdict_has_its_colour() -> None:
    state = start_state(sf.load_robot("go2"))
    assert palette.GOOD in stand_drawing(state).text
    state.com[0] += 0.5
    assert palette.BAD in stand_drawing(state).text
    assert "background" not in html_text.heading("plain")


@pytest.mark.long
@pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium: apt-get install chromium, or set SUREFOOT_CHROMIUM"
)
def test_on_a_phone_the_panel_is_below_the_scene(tmp_path: Path) -> None:
    assert CHROMIUM is not None
    with LabServer(stand_page, port=0) as server, Browser(CHROMIUM, 390, 844) as browser:
        tab = browser.open("about:blank")
        tab.call(
            "Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=False
        )
        tab.call("Page.navigate", url=server.url)
        tab.wait_for("document.body && document.body.innerText.includes('It can stand')", 180.0)
        scene = tab.ask("document.querySelector('canvas').getBoundingClientRect().bottom")
        panel = "document.querySelector('.mantine-Paper-root').getBoundingClientRect()"
        assert tab.ask("document.title") == TITLE
        assert tab.ask(f"{panel}.top") >= scene - 1.0
        assert tab.ask(f"{panel}.width") == 390.0
        assert 400.0 < scene < 600.0
        tab.screenshot(tmp_path / "phone.png")
        shown = f"[...document.querySelectorAll('#{SOFTWARE}')].filter(note => note.style.display !== 'none')"
        assert tab.ask(f"{shown}.length") == 0
