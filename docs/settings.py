"""Print docs/settings.md: every setting of the package with its unit, value, meaning and source.

Run: python -m docs.settings writes the page; with --check nothing is written, and the exit code is 1 if the
page says something else. Settings are the fields that `surefoot.base.settings.setting` makes; they are found
by reading the sources, so that none can be left out.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import inspect
import sys
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import surefoot
from surefoot.base.settings import SettingInfo, info_of

PAGE = Path(__file__).resolve().with_suffix(".md")
SOURCE = Path(surefoot.__file__).resolve().parent
HEAD = """# Settings

Numbers that decide how the package behaves and judges, with where each value comes from. A source that is a
command was run on that day and chose the value among others; the command repeats the choice. {judgement}
means that nobody has compared the value with others.

**{total} settings: {measured} chosen by a command, {judged} by judgement.** Of gains, behaviours and gaits,
which `surefoot bench ablation` can vary, {varied} of {motion} are chosen by a command; of limits of verdicts
{limited} of {limits}.

This page is printed from the sources by `python -m docs.settings`. Tolerances of algorithms, codes and bounds
of input are no settings and stand beside the code that uses them.
"""


def calls_of(path: Path) -> Iterator[tuple[str, str]]:
    """Yield the class and the name of every field of a file that is made by `setting`."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef):
            for part in node.body:
                made = part.value if isinstance(part, ast.AnnAssign) else None
                if isinstance(made, ast.Call) and ast.unparse(made.func) == "setting":
                    assert isinstance(part, ast.AnnAssign)
                    yield node.name, ast.unparse(part.target)


def settings_classes() -> list[type[Any]]:
    """Return the dataclasses of the package that have settings, by module and place."""
    found = []
    for path in sorted(SOURCE.rglob("*.py")):
        names = dict.fromkeys(owner for owner, _ in calls_of(path))
        if names:
            parts = ("surefoot", *path.relative_to(SOURCE).with_suffix("").parts)
            module = importlib.import_module(".".join(parts).removesuffix(".__init__"))
            found += [getattr(module, name) for name in names]
    return found


def rows_of(owner: type[Any]) -> list[tuple[str, Any, SettingInfo]]:
    """Return name, value and what else is known of a dataclass's own settings, without nested ones."""
    own = inspect.get_annotations(owner)
    known = ((one, info_of(owner, one.name)) for one in fields(owner) if one.name in own)
    return [(one.name, one.default, info) for one, info in known if info is not None and info.source]


def page() -> str:
    """Return the page."""
    owners = settings_classes()
    every = [info for owner in owners for _, _, info in rows_of(owner)]
    measured = sum(info.measured for info in every)
    motion = [i for o in owners if o.__module__.startswith("surefoot.motion.") for _, _, i in rows_of(o)]
    varied = sum(info.measured for info in motion)
    parts = [
        HEAD.format(
            judgement='"judgement, not measured"', total=len(every), measured=measured,
            judged=len(every) - measured, varied=varied, motion=len(motion), limited=measured - varied,
            limits=len(every) - len(motion),
        )
    ]  # fmt: skip
    for owner in owners:
        place = "/".join(owner.__module__.split(".")[1:])
        about = (owner.__doc__ or "").strip().split("\n")[0]
        parts.append(f"## {owner.__name__}\n\n{about} (`{place}.py`)\n\n{_table(owner)}")
    return "\n".join(parts)


def _table(owner: type[Any]) -> str:
    lines = ["| setting | value | unit | allowed | meaning | source |", "|---|---|---|---|---|---|"]
    for name, value, info in rows_of(owner):
        cells = (f"`{name}`", _shown(value), info.unit, _allowed(info), info.meaning, info.source)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return ", ".join(map(_shown, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _allowed(info: SettingInfo) -> str:
    if info.low is None and info.high is None:
        return ""
    if info.high is None:
        return f"≥ {info.low:g}"
    return f"≤ {info.high:g}" if info.low is None else f"{info.low:g} to {info.high:g}"


def main() -> int:
    """Write the page, or check it; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing")
    given = parser.parse_args()
    text = page()
    if given.check:
        old = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
        return int(old != text)
    PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
