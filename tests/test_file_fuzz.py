"""Files spoilt at random: a reader returns what they say, or refuses in one line."""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from surefoot.app.cli.scenario_file import WALK_KEYS, ScenarioFile
from surefoot.app.export import read_sequence
from surefoot.app.export.sequence_file import sequence_to_dict
from surefoot.base.errors import SurefootError
from surefoot.mechanics.stance.files import read_stance
from surefoot.motion.policy.publishers import read_description
from surefoot.motion.policy.spec import PolicySpec, missing
from surefoot.records.log.mapping import read_mapping
from surefoot.worlds.sweep.config import read_sweep
from tests.app.export.sequences import random_sequence
from tests.robots import go2

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
ODD: list[Any] = [
    None, True, False, 0, -1, 3, 1.5, -0.0, 1e308, float("nan"), float("inf"), 10**400, 2**63, "", "1.0",
    "1e3", "a", "ä\n\x85b", "x" * 500, [], {}, [[]], [None], {"a": None}, {1: 2}, {None: 1}, [1, [2, [3]]],
    ["1", 2], [True], [1, 2, 3], [float("nan")] * 3, {"low": 0, "high": []}, [[1, 2], [3]], {"scale": "a"},
]  # fmt: skip
MAPPING = {
    "time": "t", "feet": ["FL", "FR"], "joints": "knee", "facts": {"mass": 15.0},
    "channels": {"forces": {"from": ["f{foot}"], "unit": "N", "frame": "world", "scale": -1.0}, "q": "q"},
    "define": [{"name": "heat", "shape": [1], "unit": "K"}],
}  # fmt: skip


def read_policy(path: Path) -> object:
    """Return what a policy's description says; one that lacks keys is said by the caller."""
    robot = go2()
    table = read_description(path, robot)
    table.pop("convention", None)
    return None if missing(table) else PolicySpec.of(table, robot)


def seeds() -> dict[str, tuple[Callable[[Path], object], list[Any]]]:
    """Return by reader what reads a file, and contents of good files."""

    def contents(*patterns: str) -> list[Any]:
        return [yaml.safe_load(p.read_text()) for pattern in patterns for p in sorted(EXAMPLES.glob(pattern))]

    page = (EXAMPLES.parent / "docs" / "policies.md").read_text(encoding="utf-8")
    return {
        "stance": (read_stance, contents("stances/*.yaml")),
        "sweep": (read_sweep, contents("sweeps/*.yaml")),
        "mapping": (read_mapping, [MAPPING]),
        "scenario": (lambda path: ScenarioFile.read(path, WALK_KEYS), contents("scenarios/*.yaml")),
        "sequence": (read_sequence, [sequence_to_dict(random_sequence(seed)) for seed in range(3)]),
        "policy": (
            read_policy,
            [yaml.safe_load(page.split("```yaml\n")[1].split("```")[0]), *contents("policies/*.yaml")],
        ),
    }


def places(content: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the paths to all entries of a tree."""
    yield at
    if isinstance(content, (dict, list)):
        for key in content if isinstance(content, dict) else range(len(content)):
            yield from places(content[key], (*at, key))


def spoilt(content: Any, dice: random.Random) -> Any:
    """Return a tree with one to three entries replaced, removed, doubled, wrapped or named otherwise."""
    out = copy.deepcopy(content)
    for _ in range(dice.randint(1, 3)):
        way = dice.choice(list(places(out)))
        odd = copy.deepcopy(dice.choice(ODD))
        if not way:
            out = odd if dice.random() < 0.2 else out
            continue
        parent = out
        for key in way[:-1]:
            parent = parent[key]
        last, what = way[-1], dice.random()
        if what < 0.6:
            parent[last] = odd
        elif what < 0.7:
            del parent[last]
        elif what < 0.8:
            parent[last] = [parent[last]]
        elif isinstance(parent, dict):
            parent[odd if isinstance(odd, (str, int, float, type(None))) else "odd"] = parent[last]
        else:
            parent.insert(last, odd)
        if not isinstance(out, (dict, list)):
            break
    return out


def complaint(read: Callable[[Path], object], path: Path) -> str:
    """Return why a reader refuses a file, empty if it does not; any other error goes on to the test."""
    try:
        read(path)
    except SurefootError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", ["stance", "sweep", "mapping", "scenario", "sequence", "policy"])
def test_a_spoilt_file_is_read_or_refused_in_a_line(name: str, tmp_path: Path) -> None:
    read, good = seeds()[name]
    dice, refused = random.Random(name), 0
    path = tmp_path / ("a.json" if name == "sequence" else "a.yaml")
    write = json.dumps if name == "sequence" else yaml.safe_dump
    for content in good:
        path.write_text(write(content))
        assert complaint(read, path) == ""
    for _ in range(COUNT):
        content = spoilt(dice.choice(good), dice)
        try:
            path.write_text(write(content))
        except TypeError:  # JSON's keys are texts
            continue
        said = complaint(read, path)
        assert len(said.splitlines()) <= 1, content
        assert len(said) < 1500
        refused += said != ""
    assert refused > COUNT // 4


@pytest.mark.parametrize("name", ["stance", "sweep", "mapping", "scenario", "sequence", "policy"])
def test_a_cut_or_garbled_text_is_read_or_refused_in_a_line(name: str, tmp_path: Path) -> None:
    read, good = seeds()[name]
    dice = random.Random(name)
    path = tmp_path / ("a.json" if name == "sequence" else "a.yaml")
    text = json.dumps(good[0]) if name == "sequence" else yaml.safe_dump(good[0])
    for _ in range(COUNT):
        at, wide = dice.randrange(len(text)), dice.choice((0, 1, 5, len(text)))
        path.write_text(text[:at] + dice.choice(GARBLED) + text[at + wide :], encoding="utf-8")
        assert len(complaint(read, path).splitlines()) <= 1


GARBLED = (
    "",
    "\0",
    "\t",
    "&a [*a]",
    "{",
    "]",
    ": ",
    "- ",
    "? ",
    "!!set {a, b}",
    "'",
    "\n\n",
    "9" * 400,
    "!!binary x",
)
COUNT = 120
