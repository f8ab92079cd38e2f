"""Put the site's sources together: pages of the docs, the reference, and the course in two languages."""

from __future__ import annotations

import re
import shutil
import tempfile
import traceback
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from docs.site import labels, reference, render
from docs.site.execute import run_page
from docs.site.page import LANGUAGES, Page, pages
from docs.site.recipe import recipes, run_recipe

ROOT = Path(__file__).resolve().parents[2]
LANDINGS = ("extend", "cookbook/README", "learn", "do", "understand", "look-up")
"""Pages that lead to others: two on a shelf, and four shelves. A page is below the first that links to it."""
BESIDES = {
    "learn": ["/course/index"],
    "look-up": ["/api/index", "/docs/README", "/CHANGELOG", "/CONTRIBUTING", "/README"],
}
"""What stands in the menus of shelves and is no page of the docs."""
ZH = Path(__file__).with_name("zh")
ZH_ORDER = ("learn", "first-steps", "do", "look-up", "understand")
"""Pages of the docs that are there in Chinese, too, in the order of their menu."""
COPIED = ("docs/*.md", "docs/cookbook/*.md", "docs/images/*", "README.md", "CHANGELOG.md", "CONTRIBUTING.md")
SECTIONS = {
    0: {"en": "Start here", "zh": "从这里开始"},
    1: {"en": "Contact and friction laws", "zh": "接触与摩擦定律"},
    2: {"en": "Friction cones", "zh": "摩擦锥"},
    3: {"en": "Complementarity made smooth", "zh": "互补约束的光滑化"},
    4: {"en": "Contact Jacobians", "zh": "接触雅可比"},
    5: {"en": "Centroidal momentum", "zh": "质心动量"},
    6: {"en": "Angular momentum", "zh": "角动量"},
    7: {"en": "Force distribution", "zh": "接触力分配"},
    8: {"en": "Simulators", "zh": "仿真器"},
    9: {"en": "Learning with contact", "zh": "学习与接触"},
    10: {"en": "Capstone", "zh": "综合练习"},
    11: {"en": "Tables, measured anew", "zh": "重新测量的表格"},
    12: {"en": "Traps, shown happening", "zh": "陷阱演示"},
    13: {"en": "Troubleshooting", "zh": "故障排查手册"},
    14: {"en": "Errata, self-test and references", "zh": "勘误、自测与参考"},
}
"""Hundreds of a page's order, and what stands above them."""
TITLE = {"en": "The course", "zh": "课程"}
ABOUT = {
    "en": "Contact mechanics of legged robots by measurement: the theory of a textbook chapter derived "
    "and run, its exercises, its tables measured anew, its traps shown happening, its errors put right, and "
    "a troubleshooting manual that breaks things. The chapter is chapter 52 of *Robotics Tutorial* by "
    "Pengfei Guo, licensed CC BY 4.0; the course follows its order in words and measurements of its own. "
    "All code uses public names and runs when this site is built; all numbers in the texts come out "
    "of it, and what they claim is asserted.",
    "zh": "用测量来学习足式机器人的接触力学：推导并运行一章教材的理论，做完全部习题，重新测量其表格，"
    "演示其陷阱，订正其错误，并附一份故意制造故障的排查手册。"
    "教材是 Pengfei Guo 的《Robotics Tutorial》第 52 章（CC BY 4.0）；"
    "本课程参照其次序，文字与测量均为我们自己的。"
    "全部代码只用公开接口，在构建本站时执行；文中数字都来自这些代码，结论由断言检验。",
}


def assemble(build: Path, only: Iterable[str] | None = None, jobs: int = 2) -> dict[str, Path]:
    """Write the source trees below `build`; return them by language.

    Parameters
    ----------
    build
        Folder whose `source-en` and `source-zh` are replaced.
    only
        Names of course pages to run; None for all.
    jobs
        Processes that run pages.
    """
    trees = {language: build / f"source-{language}" for language in LANGUAGES}
    for tree in trees.values():
        shutil.rmtree(tree, ignore_errors=True)
        (tree / "course" / "figures").mkdir(parents=True)
    chosen = [page for page in pages() if only is None or page.name in set(only)]
    if labels.chinese_font() is None:
        print("figures of the Chinese pages stay English: no font for them, apt install fonts-wqy-microhei")
    with ProcessPoolExecutor(jobs) as pool:
        list(pool.map(_run, chosen, [trees] * len(chosen)))
    for picture in (trees["en"] / "course" / "figures").iterdir():
        shutil.copy(picture, trees["zh"] / "course" / "figures")
    for language, tree in trees.items():
        (tree / "course" / "index.md").write_text(contents(chosen, language), encoding="utf-8")
    (trees["zh"] / "index.md").write_text(_zh_front(), encoding="utf-8")
    _zh_docs(trees["zh"] / "docs")
    _copy(trees["en"])
    _cookbook(trees["en"] / "docs" / "cookbook")
    reference.write(trees["en"] / "api")
    return trees


def _run(page: Page, trees: dict[str, Path]) -> None:
    try:
        render.write(run_page(page, trees["en"] / "course" / "figures"), trees)
    except Exception as error:
        places = [frame for frame in traceback.extract_tb(error.__traceback__) if "course/" in frame.filename]
        line = places[-1].lineno if places else 0
        raise RuntimeError(f"course/{page.name}.md:{line}: {type(error).__name__}: {error}") from error


def contents(chosen: list[Page], language: str) -> str:
    """Return the course's list of contents."""
    lines = [f"# {TITLE[language]}", "", ABOUT[language], ""]
    for hundred, title in SECTIONS.items():
        names = [page.name for page in chosen if page.order // 100 == hundred]
        if names:
            caption = title[language] if not 1 <= hundred <= 9 else f"52.{hundred} {title[language]}"
            lines += ["```{toctree}", ":maxdepth: 1", f":caption: {caption}", "", *names, "```", ""]
    return "\n".join(lines)


def _zh_front() -> str:
    shelves = [f"docs/{path.stem}" for path in sorted(ZH.glob("*.md"), key=lambda p: ZH_ORDER.index(p.stem))]
    return "\n".join([
        "# Surefoot 中文", "", ABOUT["zh"], "", '<a href="../index.html">English documentation</a>', "",
        "```{toctree}", ":maxdepth: 2", "", *shelves, "course/index", "```", "",
    ])  # fmt: skip


def _zh_docs(folder: Path) -> None:
    """Write the Chinese shelves: code is the English page's, links to other pages lead to its tree."""
    folder.mkdir(parents=True, exist_ok=True)
    here = {path.name for path in ZH.glob("*.md")}

    def linked(found: re.Match[str]) -> str:
        if found[2] in here or found[2].startswith("../course/"):
            return found[0]
        return f'<a href="../../docs/{found[2].removesuffix(".md")}.html">{found[1]}</a>'

    for path in ZH.glob("*.md"):
        text = path.read_text(encoding="utf-8")
        for number, block in enumerate(code_blocks(ROOT / "docs" / path.name), 1):
            text = text.replace(f"{{{{{number}}}}}", block)
        (folder / path.name).write_text(_LINK.sub(linked, text), encoding="utf-8")


def code_blocks(path: Path) -> list[str]:
    """Return the fenced blocks of a page, fences included."""
    return re.findall(r"^```\w+\n.*?^```$", path.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def _copy(tree: Path) -> None:
    """Copy what the repository already says, links to its other files turned into their names."""
    for pattern in COPIED:
        for path in ROOT.glob(pattern):
            target = tree / path.relative_to(ROOT)
            target.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix == ".md":
                target.write_text(without_code_links(path), encoding="utf-8")
            else:
                shutil.copy(path, target)
    shutil.copy(Path(__file__).with_name("index.md"), tree / "index.md")
    for name, below in menus().items():
        page = tree / "docs" / f"{name}.md"
        menu = ["", "```{toctree}", ":hidden:", "", *below, "```", ""]
        page.write_text(page.read_text(encoding="utf-8") + "\n".join(menu), encoding="utf-8")


def _cookbook(folder: Path) -> None:
    """Run the recipes whose modules are installed, and put a notebook beside each page."""
    for recipe in recipes():
        if not recipe.missing:
            with tempfile.TemporaryDirectory() as scratch:
                printed = run_recipe(recipe, Path(scratch))
            for block, text in zip(recipe.blocks, printed, strict=True):
                if text != block.prints:
                    raise RuntimeError(
                        f"{recipe.path.name}:{block.line}: prints {text!r}, not {block.prints!r}"
                    )
        name = recipe.path.stem
        (folder / f"{name}.ipynb").write_text(render.recipe_notebook(recipe), encoding="utf-8")
        page = folder / recipe.path.name
        link = f"\n{{download}}`{render.NOTEBOOK['en']} <{name}.ipynb>`\n"
        page.write_text(page.read_text(encoding="utf-8") + link, encoding="utf-8")


def menus() -> dict[str, list[str]]:
    """Return the documents below each landing page, in the order of its links, each below one."""
    docs, found, taken = ROOT / "docs", dict[str, list[str]](), {"README", *LANDINGS[2:]}
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


_LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)#\s:]+)\)")


_PLACE = re.compile(r'^<a id="([\w-]+)"></a>$', re.MULTILINE)


def without_code_links(path: Path) -> str:
    """Return a page whose links to folders and files outside the site are code spans, anchors MyST's."""

    def kept(found: re.Match[str]) -> str:
        target = (path.parent / found[2]).resolve()
        if target == ROOT / "course":
            return f"[{found[1]}](/course/index.md)"
        inside = target.suffix in (".md", ".png", ".svg") and target.is_file()
        return found[0] if inside else f"{found[1]} (`{target.relative_to(ROOT)}`)"

    return _PLACE.sub(r"(\1)=", _LINK.sub(kept, path.read_text(encoding="utf-8")))
