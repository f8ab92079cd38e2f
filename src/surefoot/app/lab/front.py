"""The file of a page as a browser gets it: viser's, with our title, a word while it loads, and phones."""

from __future__ import annotations

import gzip
from functools import lru_cache
from typing import Any

from surefoot.app.viz import palette

TITLE = "Surefoot lab"
PHONE = 600
"""A window narrower than this has the panel below the scene, not over it [pixels]."""
PANEL = 46
"""Height of that panel, as a percentage of the window's."""
_STYLE = f"""<style>
.surefoot-loading{{position:fixed;inset:0;display:flex;flex-direction:column;align-items:center;
justify-content:center;gap:.6em;
font:18px {palette.TEXT_FAMILY};color:{palette.INK};background:{palette.PAPER}}}
.surefoot-loading small{{color:{palette.NOTE};font-size:14px}}
@media (max-width:{PHONE}px){{
#root > div > div > div[style*="flex-grow: 1"]{{margin-bottom:{PANEL}vh}}
#root .mantine-Paper-root[style*="position: fixed"][style*="bottom: 0px"]{{
width:100%!important;height:{PANEL}vh;max-height:{PANEL}vh!important}}
#root .mantine-Paper-root [style*="width: 20em"]{{width:100%!important}}
}}
</style>"""
_LOADING = (
    f'<div class="surefoot-loading">{TITLE} is loading<small>a drawing program of 0.8 MB, once</small></div>'
)
_CHANGES = (
    (b"<title>Viser</title>", f"<title>{TITLE}</title>{_STYLE}".encode()),
    (b'<div id="root"></div>', f'<div id="root">{_LOADING}</div>'.encode()),
)
"""What is replaced in viser's file; a version without it is served as it is."""


@lru_cache(maxsize=4)
def dress_file(body: bytes, packed: bool) -> bytes:
    """Return a page's file, gzipped or not, with our title, our styles, and a word while it loads."""
    text = gzip.decompress(body) if packed else body
    for old, new in _CHANGES:
        text = text.replace(old, new, 1)
    return gzip.compress(text) if packed else text


def dress_answer(answer: Any) -> None:
    """Put title, styles and the word into an answer of viser's server that is a page."""
    if not answer.headers.get("Content-Type", "").startswith("text/html"):
        return
    body = dress_file(bytes(answer.body), answer.headers.get("Content-Encoding") == "gzip")
    answer.body = body
    if "Content-Length" in answer.headers:
        del answer.headers["Content-Length"]
        answer.headers["Content-Length"] = str(len(body))
