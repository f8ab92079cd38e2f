"""Put the site's two source trees together: each mirrors the repository with the pages of one language.

English: the docs, the reference, the cookbook with notebooks, the course. Chinese: `docs/zh` and the course.
A link that stays in its tree is Sphinx's to follow; one into the other tree is written as an address of the
built site, and marked where it leads from Chinese to English.
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

from docs.course.pages import LANGUAGES
from docs.site import reference
from docs.site.figures import with_figure
from docs.site.recipe import recipes, run_recipe

ROOT = Path(__file__).resolve().parents[2]
LANDINGS = ("extend", "cookbook/README", "reports/README", "learn", "do", "understand", "look-up")
"""Pages that lead to others: three on a shelf, and four shelves. A page is below the first that names it."""
BESIDES = {
    "learn": ["/course/en/index"],
    "look-up": ["/api/index", "/docs/README", "/CHANGELOG", "/CONTRIBUTING", "/README"],
}
"""What stands in the menus of shelves and is no page of the docs."""
ZH = ROOT / "docs" / "zh"
ZH_ORDER = ("learn", "first-steps", "do", "look-up", "glossary", "understand")
"""Pages of the docs that are there in Chinese, too, in the order of their menu."""
COPIED = {
    "en": (
        "docs/*.md", "docs/cookbook/*.md", "docs/reports/*.md", "docs/images/*", "README.md", "CHANGELOG.md",
        "CONTRIBUTING.md", "course/en/*",
    ),
    "zh": ("docs/zh/*.md", "course/zh/*"),
}  # fmt: skip
NOTEBOOK = {"en": "This page as a notebook", "zh": "本页的 Jupyter 笔记本"}
_LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)#\s:]+)(#[\w-]+)?\)")
_PLACE = re.compile(r'^<a id="([\w-]+)"></a>$', re.MULTILINE)


def assemble(build: Path) -> dict[str, Path]:
    """Write the source trees `source-en` and `source-zh` below `build` anew; return them by language."""
    trees = {language: build / f"source-{language}" for language in LANGUAGES}
    for language, tree in trees.items():
        shutil.rmtree(tree, ignore_errors=True)
        for pattern in COPIED[language]:
            for path in sorted(ROOT.glob(pattern)):
                copied(path, tree, language)
        index = tree / "course" / language / "index.md"
        index.write_text(with_menus(index.read_text(encoding="utf-8")), encoding="utf-8")
    shutil.copy(Path(__file__).with_name("index.md"), trees["en"] / "index.md")
    (trees["zh"] / "index.md").write_text(_zh_front(), encoding="utf-8")
    for name, below in menus().items():
        page = trees["en"] / "docs" / f"{name}.md"
        page.write_text(page.read_text(encoding="utf-8") + _menu(below), encoding="utf-8")
    _cookbook(trees["en"] / "docs" / "cookbook")
    reference.write(trees["en"] / "api")
    return trees


def copied(path: Path, tree: Path, language: str) -> None:
    """Copy a file of the repository into a tree, links turned; of the course notebooks, not their sources."""
    target = tree / path.relative_to(ROOT)
    target.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".ipynb":
        (target.parent / "notebooks").mkdir(exist_ok=True)
        shutil.copy(path, target.parent / "notebooks")
        target.write_text(json.dumps(_notebook(path, language)), encoding="utf-8")
    elif path.suffix != ".md":
        shutil.copy(path, target)
    elif not path.with_suffix(".ipynb").exists():
        target.write_text(turned(path, path.read_text(encoding="utf-8"), language), encoding="utf-8")


def _notebook(path: Path, language: str) -> dict[str, Any]:
    """Return a page of the course: pictures with their words, and a link to the notebook itself."""
    book: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    for cell in book["cells"]:
        if cell["cell_type"] == "markdown":
            cell["source"] = turned(path, "".join(cell["source"]), language)
        for output in cell.get("outputs", []):
            alt = output.get("metadata", {}).get("image/png", {}).get("alt")
            if alt:  # MyST-NB takes it from the cell
                cell["metadata"]["mystnb"] = {"image": {"alt": alt}}
    book["cells"][0]["source"] = with_figure(path.stem, book["cells"][0]["source"], language)
    book["cells"][-1]["source"] += f"\n\n{{download}}`{NOTEBOOK[language]} <notebooks/{path.name}>`"
    return book


def turned(path: Path, text: str, language: str) -> str:
    """Return a page's text with its links made for the site.

    Links into the other tree become addresses, links to folders and files outside of the site their names,
    and anchors MyST's.
    """

    def kept(found: re.Match[str]) -> str:
        words, anchor = found[1], found[3] or ""
        target = (path.parent / found[2]).resolve()
        if (
            not target.is_relative_to(ROOT)
            or target.suffix not in (".md", ".ipynb", ".png", ".svg")
            or not target.is_file()
            or (target.suffix == ".ipynb" and not target.is_relative_to(ROOT / "course"))
        ):
            return f"{words} (`{target.relative_to(ROOT)}`)"
        place = target.relative_to(ROOT)
        chinese = "zh" in place.parts
        if chinese == (language == "zh"):
            return found[0]
        up = "../" * (len(path.relative_to(ROOT).parts) - 1)
        there = f"{up}zh/{place}" if chinese else f"{up}../{place}"
        if not chinese and words != "English":
            words += "（英文）"
        page = there.removesuffix(target.suffix) + ".html"
        return f'<a href="{page}{anchor}" hreflang="{"zh" if chinese else "en"}">{words}</a>'

    return _PLACE.sub(r"(\1)=", _LINK.sub(kept, text))


def with_menus(text: str) -> str:
    """Return the course's contents with a hidden menu for each of its headings, whose links it lists."""
    parts = re.split(r"^## (.*)$", text, flags=re.MULTILINE)
    out = parts[0]
    for title, body in zip(parts[1::2], parts[2::2], strict=True):
        below = re.findall(r"^- \[.*\]\(([\w.-]+)\.ipynb\)", body, re.MULTILINE)
        out += f"## {title}{body}" + _menu(below, f":caption: {title}")
    return out


def _menu(below: list[str], *options: str) -> str:
    return "\n".join(["", "```{toctree}", ":hidden:", *options, "", *below, "```", "", ""])


def _zh_front() -> str:
    return "\n".join([
        "# Surefoot 中文", "",
        "Surefoot 是足式机器人的接触层：哪些接触力在物理上可能，应当用哪些力，运动是否遵守了定律。"
        "中文部分有整个课程、最初五分钟与术语表；操作说明与参考是英文的，链接处都已注明。", "",
        '<a href="../index.html" hreflang="en">English documentation（英文）</a>', "",
        "```{toctree}", ":maxdepth: 2", "",
        *(f"docs/zh/{name}" for name in ZH_ORDER), "course/zh/index", "```", "",
    ])  # fmt: skip


def code_blocks(path: Path) -> list[str]:
    """Return the fenced blocks of a page, fences included."""
    return re.findall(r"^```\w+\n.*?^```$", path.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def _cookbook(folder: Path) -> None:
    """Run the recipes whose modules are installed, and put a notebook beside each page."""
    import jupytext

    for recipe in recipes():
        if not recipe.missing:
            with tempfile.TemporaryDirectory() as scratch:
                printed = run_recipe(recipe, Path(scratch))
            for block, text in zip(recipe.blocks, printed, strict=True):
                if text != block.prints:
                    raise RuntimeError(
                        f"{recipe.path.name}:{block.line}: prints {text!r}, not {block.prints!r}"
                    )
        page = folder / recipe.path.name
        (folder / "notebooks").mkdir(exist_ok=True)
        book = jupytext.reads(recipe.text, fmt="md")
        (folder / "notebooks" / f"{page.stem}.ipynb").write_text(
            jupytext.writes(book, "ipynb"), encoding="utf-8"
        )
        link = f"\n{{download}}`{NOTEBOOK['en']} <notebooks/{page.stem}.ipynb>`\n"
        page.write_text(page.read_text(encoding="utf-8") + link, encoding="utf-8")


def menus() -> dict[str, list[str]]:
    """Return the documents below each landing page, in the order of its links, each below one."""
    docs, found, taken = ROOT / "docs", dict[str, list[str]](), {"README", *LANDINGS[3:]}
    for name in LANDINGS:
        page = docs / f"{name}.md"
        links = [
            (page.parent / link[2]).resolve() for link in _LINK.finditer(page.read_text(encoding="utf-8"))
        ]
        inside = [path for path in links if path.suffix == ".md" and path.is_relative_to(docs)]
        below = [str(path.relative_to(docs).with_suffix("")) for path in inside]
        fresh = [one for one in dict.fromkeys(below) if one not in taken]
        taken |= set(fresh)
        found[name] = [f"/docs/{one}" for one in fresh] + BESIDES.get(name, [])
    return found
