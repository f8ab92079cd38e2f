"""Sources of settings: a command of the ablation names the setting that it stands at, and can be run."""

from __future__ import annotations

import re
import shlex
from importlib.util import find_spec
from typing import Any

import pytest
import typer

from benchmarks.ablation.parts import FIRST_SEED, PARTS, TASKS
from benchmarks.ablation.trials import Trials
from benchmarks.ablation.varying import Setting, known_settings, try_values, verdict
from benchmarks.commands.ablation import ablation
from docs.settings import rows_of, settings_classes

COMMAND = re.compile(r"`surefoot bench ablation ([^`]*)`")
RANGE = re.compile(r"as good from \S.* to \S.*")
SETTINGS = {name: one for name, one in known_settings().items() if COMMAND.search(one.info.source)}
VARIED = {name: one for name, one in SETTINGS.items() if one.info.measured and "--vary" in one.info.source}


def options(source: str) -> dict[str, Any]:
    """Return the options of the command in a source, parsed as the command line parses them."""
    app = typer.Typer(add_completion=False)
    app.command()(ablation)
    (words,) = COMMAND.findall(source)
    with typer.main.get_command(app).make_context("ablation", shlex.split(words)) as context:
        return dict(context.params)


@pytest.mark.parametrize("one", SETTINGS.values(), ids=SETTINGS)
def test_a_command_names_the_setting_that_it_stands_at(one: Setting) -> None:
    given = options(one.info.source)
    assert set(given["task"] or ()) <= set(TASKS)
    if given["vary"] is None:
        assert set(given["only"]) <= set(PARTS)
        return
    assert given["vary"] == one.name
    assert given["seeds"] >= 3, "two seeds say nothing of noise"
    assert one.values(given["value"], given["factor"]), "nothing would be tried"
    assert RANGE.search(one.info.source), "the verdict stands behind the date"


@pytest.mark.long
def test_a_program_that_chose_a_setting_is_there() -> None:
    program = re.compile(r"`python -m ([\w.]+)[^`]*`")
    named = {
        name
        for owner in settings_classes()
        for _, _, info in rows_of(owner)
        if info.measured
        for name in program.findall(info.source)
    }
    assert "benchmarks.limits" in named
    assert [name for name in sorted(named) if find_spec(name) is None] == []


@pytest.mark.long
def test_a_fresh_run_repeats_the_choice() -> None:
    name = "WalkSettings.horizon"
    one, given = VARIED[name], options(VARIED[name].info.source)
    trials = Trials(range(FIRST_SEED, FIRST_SEED + given["seeds"]), 1, lambda *_: None)
    values = one.values(given["value"], given["factor"])
    found = try_values(one, values, trials, given["task"] or one.tasks, outwards=not given["value"])
    said = verdict(one, found)
    assert said.startswith("as good from")
    assert said in one.info.source
