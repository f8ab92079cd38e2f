"""The glossary has every term: what counts as one is found in the pages and the code, not in a list.

A term is (1) an entry of the course's glossary; (2) a word of a public name, a class on a wing's face or a
command, unless it is ordinary English; (3) a compound that ends in a head of the glossary's own compounds
(contact, cone, force, step, ...), stands on four pages or in the public docstrings of eight modules, and is
not merely narrowed by an ordinary word.
"""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import surefoot
from surefoot.app.cli.commands import COMMANDS
from tests.test_words import entries, words_of

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "surefoot"
PAGES = 4
"""On how many pages a compound stands before it is a term."""
MODULES = 8
"""In the docstrings of how many modules."""

COURSE_ONLY = {
    "flight": "airborne phase: flight alone has two meanings",
    "falling cat": "an example, no term of the package",
}
"""Entries of the course's glossary that are none here, and why."""


def word_set(text: str) -> frozenset[str]:
    """Return the words of a text."""
    return frozenset(text.split())


FUNCTION_WORDS = word_set(
    """
    a all an and another are as at be between both by each either every few first for four from had has
    have how if in into is it its last less many more most much neither no nor not of on one only or
    other own per same second so such ten than that the their then these this those three through to two
    under what where which whole whose with within without
    """
)
NARROWED = word_set(
    """
    active broken common constant desired different exact first-order fixed flat free given joint
    largest least level linear long lowest mean middle mujoco nearest next normal old point rigid
    second-order short simulated smallest total wanted whole-body wrong zero
    """
)
"""Words that narrow a term and make no other one: the largest velocity is a velocity."""
ORDINARY = word_set(
    """
    arguments arrays assert bench box can capsule carry certify check com combine course damper
    detection dialect distribute doctor drive ekf end ending examples export flat from geometry grid
    height ice identify input lab lawful lcp legs levels load message method mpc mujoco named names
    needed noise on options over packed parameter picture pit place plane product rates read record
    recorder register repair report rl run scan seeded sets shape solid solve sphere spring stand
    summarise surefoot targets thrown translate walk warmup weights wire work wrapper write
    """
)
"""English of every day, names of software and shapes, and letters that the glossary spells out."""


@cache
def terms() -> frozenset[str]:
    return frozenset(term.lower() for term, *_ in entries())


@cache
def known_words() -> frozenset[str]:
    return frozenset(word for term in terms() for word in re.findall(r"[a-zé]+", term))


def is_known(word: str) -> bool:
    """Tell whether a word is part of a term, in the singular or the plural."""
    forms = {word, word.removesuffix("s"), word.removesuffix("es"), re.sub("ies$", "y", word)}
    return bool(forms & known_words() or forms & ORDINARY)


def public_names() -> Iterator[str]:
    """Yield what `import surefoot as sf` has, the classes on the wings' faces, and the commands."""
    yield from (name for name in dir(surefoot) if not name.startswith("_"))
    yield from COMMANDS
    for face in SOURCE.glob("*/__init__.pyi"):
        text = face.read_text(encoding="utf-8")
        yield from (name for name in re.findall(r" as (\w+)", text) if re.match("[A-Z][a-z]", name))


def prose(page: Path) -> str:
    """Return a page without its code and addresses."""
    text = re.sub(r"```.*?```", " . ", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return re.sub(r"\]\([^)]*\)", "", re.sub(r"`[^`]*`", " . ", text))


def docstrings(module: Path) -> str:
    """Return the docstrings of a module and of what is public in it, code left out."""
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
    nodes = [
        node for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))) if isinstance(node, kinds)
    ]
    public = (node for node in nodes if not getattr(node, "name", "a").startswith("_"))
    return re.sub(r"`[^`]*`", " . ", " . ".join(ast.get_docstring(node) or "" for node in public))


def compounds(texts: Iterator[str], least: int) -> set[str]:
    """Return the compounds of a term's head that stand in `least` texts and are not just narrowed."""
    heads = "|".join(sorted({term.split()[-1] for term in terms() if " " in term}, key=len, reverse=True))
    pattern = re.compile(rf"(?<![-'’\w])([a-zA-Zé][\w-]+)\s({heads})(?:s|es)?\b(?!-)")
    found: dict[str, int] = defaultdict(int)
    for text in texts:
        for pair in {f"{a.lower()} {head}" for a, head in pattern.findall(text)}:
            found[pair] += 1
    ordinary = FUNCTION_WORDS | NARROWED
    return {pair for pair, count in found.items() if count >= least and pair.split()[0] not in ordinary}


def test_it_has_the_terms_of_the_course() -> None:
    text = (ROOT / "course" / "en" / "glossary.md").read_text(encoding="utf-8")
    found = re.findall(r'\("5\d\.\d+", "([^"]+)"', text)
    assert len(found) >= 40
    parts = {part for term in found for part in term.split(", ")} - COURSE_ONLY.keys()
    assert {p for p in parts if not {p.lower(), p.lower().removesuffix("s")} & terms()} == set()


def test_the_words_of_public_names_are_explained() -> None:
    missing = {word: name for name in public_names() for word in words_of(name) if not is_known(word)}
    assert missing == {}, "add the term to docs/glossary.md and docs/zh/glossary.md"


def test_compounds_of_the_pages_are_explained() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "cookbook").glob("*.md")]
    texts = (prose(page) for page in pages if page.name not in ("glossary.md", "settings.md"))
    assert compounds(texts, PAGES) - terms() == set(), "add the term, in both languages"


def test_compounds_of_the_docstrings_are_explained() -> None:
    texts = (docstrings(module) for module in SOURCE.rglob("*.py"))
    assert compounds(texts, MODULES) - terms() == set(), "add the term, in both languages"


def test_both_languages_have_the_same_terms() -> None:
    chinese = re.findall(
        r"^\| ([^|]+?) \| ([^|]+?) \|",
        (ROOT / "docs" / "zh" / "glossary.md").read_text("utf-8"),
        re.MULTILINE,
    )[2:]
    assert {term.lower() for term, _ in chinese} == terms()
    assert [term for term, name in chinese if not re.search("[一-鿿]", name)] == []


def test_the_table_of_ordinary_words_holds_no_term_and_nothing_unused() -> None:
    used = {word for name in public_names() for word in words_of(name)}
    assert ORDINARY & known_words() == set()
    assert ORDINARY - used == set()
