"""Names in plain field language: no private words, no bare participles, one meaning a term and a class name.

The glossary (docs/glossary.md) says what terms mean; ten rules of writing are in CONTRIBUTING.md. The tables
of exceptions below may shrink, and must where an entry is no longer needed; they may not grow.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import surefoot

SOURCE = Path(surefoot.__file__).parent
ROOT = Path(__file__).resolve().parents[1]
GLOSSARY = ROOT / "docs" / "glossary.md"

PRIVATE = frozenset(
    (
        *("wanted", "wants", "asked", "asks", "told", "tell", "tells", "seen", "unseen", "lost", "loses"),
        *("carry", "carries", "carried", "believe", "believes", "believed", "belief", "likewise", "gone"),
        *("laid", "lays", "said", "says", "unsaid", "whoever", "somebody"),
    )
)
"""Words that leave open what is meant: reference, command, request, measured and estimated do not."""

PUBLIC = "public: a name of the interface, a key of a file or of printed JSON"
LATER = "its package is being rewritten; renamed with it"

EXCEPTIONS: dict[str, str] = {
    "BeliefTerrain": LATER,
    "LostMotion": LATER,
    "SeenStairs": LATER,
    "_carried": LATER,
    "_seen": LATER,
    "asked": LATER,
    "asked_by": PUBLIC,
    "belief": LATER,
    "believed": PUBLIC,
    "believed_mu": PUBLIC,
    "carried": LATER,
    "carry": LATER,
    "carry_out": "the verb of an experiment or a run, in its usual sense",
    "carry_over": PUBLIC,
    "ground_belief": LATER,
    "laid": LATER,
    "lost": PUBLIC,
    "lost_workers": PUBLIC,
    "said": LATER,
    "says": PUBLIC,
    "seen_stairs": LATER,
    "tell_wrench": LATER,
    "told": LATER,
    "wanted": PUBLIC,
}
"""Name to the reason why its private word stays."""
MOST_EXCEPTIONS = 24
"""How many there may be: lower it with each that goes."""

PARTICIPLES: dict[str, int] = {
    "app/lab": 4,
    "base/compilation": 5,
    "base/errors": 2,
    "base/memory": 4,
    "base/settings": 2,
    "contact/batch": 4,
    "contact/derivative": 1,
    "contact/files": 2,
    "contact/laws": 9,
    "contact/problem": 1,
    "contact/solvers": 1,
    "mechanics/collision": 2,
    "mechanics/dynamics": 16,
    "mechanics/robot": 1,
    "motion/control": 1,
    "motion/drive": 1,
    "motion/estimation": 2,
    "motion/gaits": 1,
    "motion/ground": 2,
    "motion/planning": 2,
    "motion/standing": 2,
    "motion/walking": 27,
    "records/audit": 9,
    "records/identification": 4,
    "records/log": 3,
    "worlds/experiments": 1,
    "worlds/interface": 1,
    "worlds/mujoco": 1,
    "worlds/rigid": 2,
    "worlds/running": 3,
}
"""Most functions that a bare participle names; none where a package is missing."""

NOT_PARTICIPLES = frozenset(("need", "feed", "speed", "seed", "embed", "shed", "exceed", "proceed", "bleed"))
IRREGULAR = frozenset(
    (
        *(
            "bent",
            "broken",
            "built",
            "caught",
            "chosen",
            "done",
            "drawn",
            "driven",
            "fallen",
            "felt",
            "found",
        ),
        *(
            "given",
            "gone",
            "grown",
            "held",
            "hidden",
            "kept",
            "known",
            "laid",
            "led",
            "lost",
            "made",
            "meant",
        ),
        *("met", "risen", "said", "seen", "sent", "shaken", "shown", "spent", "struck", "swept", "taken"),
        *("thrown", "told", "torn", "worn", "written"),
    )
)
"""Participles without -ed; not `left`, `put`, `set` and `bound`, which are nouns or imperatives, too."""


def words_of(name: str) -> list[str]:
    """Return the words of a name in snake_case or CamelCase, in lower case."""
    return [word.lower() for word in re.findall(r"[a-z]+|[A-Z]+(?![a-z])|[A-Z][a-z]*", name)]


def is_participle(name: str) -> bool:
    """Tell whether a name is one word, and that a participle: `turned`, `_laid`, not `speed`."""
    words = words_of(name)
    if len(words) != 1 or words[0] in NOT_PARTICIPLES:
        return False
    return words[0] in IRREGULAR or (words[0].endswith("ed") and len(words[0]) > 4)


@cache
def trees() -> dict[str, ast.Module]:
    """Return the trees of all modules by their path in the package."""
    return {
        path.relative_to(SOURCE).as_posix(): ast.parse(path.read_text(encoding="utf-8"))
        for path in sorted(SOURCE.rglob("*.py"))
    }


def names_in(path: str, tree: ast.Module) -> Iterator[str]:
    """Yield the names of a module, its classes, its functions and its public attributes."""
    yield Path(path).stem
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        if isinstance(node, ast.ClassDef):
            fields = (part.target for part in node.body if isinstance(part, ast.AnnAssign))
            yield from (one.id for one in fields if isinstance(one, ast.Name) and not one.id.startswith("_"))
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            own = isinstance(node.value, ast.Name) and node.value.id == "self"
            if own and not node.attr.startswith("_"):
                yield node.attr


def private_names(path: str, tree: ast.Module) -> set[str]:
    """Return the names of a module that contain a private word."""
    return {name for name in names_in(path, tree) if PRIVATE & set(words_of(name))}


def is_value(node: ast.FunctionDef) -> bool:
    """Tell whether a function is a property or answers yes or no: its name may be an adjective then."""
    property_like = any("property" in ast.unparse(one) for one in node.decorator_list)
    answer = "" if node.returns is None else ast.unparse(node.returns)
    return property_like or answer in ("bool", "BoolArray")


def participles(tree: ast.Module) -> list[str]:
    """Return the names of a module's functions that are bare participles."""
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return [node.name for node in functions if is_participle(node.name) and not is_value(node)]


def package_of(path: str) -> str:
    """Return the wing and package of a module's path."""
    return "/".join(path.split("/")[:2]).removesuffix(".py")


def test_a_private_word_and_a_participle_are_found() -> None:
    tree = ast.parse(
        "class Told:\n    wanted: int\n    def _turned(self): self.asked = 1\n    def speed(self): ..."
    )
    assert private_names("motion/gone.py", tree) == {"gone", "Told", "wanted", "asked"}
    assert participles(tree) == ["_turned"]
    assert participles(ast.parse("@property\ndef solved(self): ...\ndef is_held() -> bool: ...")) == []


def test_names_have_no_private_words() -> None:
    """New ones get the field's term; a table of exceptions that is too long for its names fails, too."""
    found = {name: path for path, tree in trees().items() for name in private_names(path, tree)}
    assert {name: path for name, path in found.items() if name not in EXCEPTIONS} == {}
    assert sorted(set(EXCEPTIONS) - set(found)) == []
    assert len(EXCEPTIONS) <= MOST_EXCEPTIONS


def test_functions_are_verbs() -> None:
    """No function is named by a bare participle; packages that still have some may not get more."""
    found: dict[str, list[str]] = {}
    for path, tree in trees().items():
        found.setdefault(package_of(path), []).extend(participles(tree))
    more = {package: names for package, names in found.items() if len(names) > PARTICIPLES.get(package, 0)}
    assert more == {}


def test_a_class_name_has_one_meaning_within_a_wing() -> None:
    """Two files of a wing define no public class of one name."""
    homes: dict[tuple[str, str], list[str]] = {}
    for path, tree in trees().items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                homes.setdefault((path.split("/", maxsplit=1)[0], node.name), []).append(path)
    twice = {name: paths for (_, name), paths in homes.items() if len(paths) > 1}
    assert twice == {}


def entries() -> list[tuple[str, str, str, str]]:
    """Return the rows of the glossary: term, meaning, unit, file."""
    lines = [line for line in GLOSSARY.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    cells = [tuple(cell.strip() for cell in line.strip("| ").split(" | ")) for line in lines[2:]]
    return [(term, meaning, unit, file.strip("`")) for term, meaning, unit, file in cells]


def test_the_glossary_has_one_line_a_term() -> None:
    terms = [term for term, *_ in entries()]
    assert len(terms) >= 60
    assert sorted(terms, key=str.lower) == terms
    assert len({term.lower() for term in terms}) == len(terms)
    assert not {"step", "flight", "touch", "touches"} & set(terms), "say which: time step, footstep, stair"


@pytest.mark.parametrize("entry", entries(), ids=lambda entry: entry[0])
def test_a_term_has_a_meaning_a_unit_and_a_home(entry: tuple[str, str, str, str]) -> None:
    term, meaning, unit, file = entry
    assert (SOURCE / file).is_file(), file
    assert meaning[:1].isupper() or meaning[:1] in "ΓG", meaning
    assert meaning.endswith("."), meaning
    assert re.fullmatch(r"·|-|[\w/²³·., ]+", unit), unit
    assert not PRIVATE & set(words_of(term))
