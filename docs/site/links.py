"""Look for broken links in a built site: every relative link's file and anchor must be there."""

from __future__ import annotations

from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class _Page(HTMLParser):
    """Links and anchors of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key in ("id", "name") and value:
                self.anchors.add(value)
            if key in ("href", "src") and value:
                self.links.append(value)


@cache
def _read(path: Path) -> _Page:
    page = _Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def broken_links(site: Path) -> list[str]:
    """Return a line for every link of a site that leads nowhere."""
    faults = []
    for path in sorted(site.rglob("*.html")):
        if "_static" in path.relative_to(site).parts:
            continue
        for link in _read(path).links:
            fault = _fault(path, link)
            if fault:
                faults.append(f"{path.relative_to(site)}: {fault}")
    return faults


def _fault(path: Path, link: str) -> str | None:
    parts = urlsplit(link)
    if parts.scheme or parts.netloc or link.startswith(("#!", "data:")):
        return None
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    target = target / "index.html" if target.is_dir() else target
    if not target.exists():
        return f"no {link}"
    anchor = unquote(parts.fragment)
    if anchor and target.suffix == ".html" and anchor not in _read(target).anchors:
        return f"no anchor {link}"
    return None


def loaded_from_outside(site: Path) -> list[str]:
    """Return a line for every script, style or image that a page would fetch from the network."""
    out = []
    for path in sorted(site.rglob("*.html")):
        page = _Outside()
        page.feed(path.read_text(encoding="utf-8"))
        out += [f"{path.relative_to(site)}: loads {link}" for link in page.found]
    return out


class _Outside(HTMLParser):
    """What a page loads from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        loads = {"script": "src", "img": "src", "iframe": "src"}.get(tag)
        if tag == "link" and given.get("rel") in ("stylesheet", "preload", "icon", "shortcut icon"):
            loads = "href"
        link = given.get(loads or "") or ""
        if link.startswith(("http:", "https:", "//")):
            self.found.append(link)


def undocumented(site: Path, names: list[str]) -> list[str]:
    """Return a line for every public name without an entry in the reference."""
    anchors = {anchor for path in (site / "api").glob("*.html") for anchor in _read(path).anchors}
    return [f"surefoot.{name} is not in the reference" for name in names if f"surefoot.{name}" not in anchors]
