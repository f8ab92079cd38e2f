"""Help, version, and how the program ends when nobody reads on."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest

import surefoot as sf
from surefoot.app.cli.commands import COMMANDS, load, summary
from surefoot.app.cli.typer_command import PANELS


def commands(group: Any = None, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield every command with its path, those of groups included."""
    for name, command in (
        {name: load(name) for name in COMMANDS} if group is None else group.commands
    ).items():
        if hasattr(command, "commands"):
            yield from commands(command, (*path, name))
        else:
            yield (*path, name), command


@pytest.mark.parametrize(("path", "command"), [pytest.param(*c, id=" ".join(c[0])) for c in commands()])
def test_help_shows_every_bracket_of_its_texts(
    path: tuple[str, ...], command: Any, printed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    said = printed(*path, "--help")
    written = [command.help, *(p.help for p in command.params if getattr(p, "help", None))]
    units = [u for text in written for u in re.findall(r"\[[^]]*\]", text.replace("\\", ""))]
    for unit in units:
        assert said.count(unit) >= 1, f"{unit} is missing"
    assert "\\" not in said


def test_there_are_25_commands_and_209_options_at_most(capfd: pytest.CaptureFixture[str]) -> None:
    """Besides `bench`; `pytest -s` prints both numbers."""
    ours = [(path, command) for path, command in commands() if path[0] != "bench"]
    options = {" ".join(path): [p for p in c.params if p.param_type_name == "option"] for path, c in ours}
    total = sum(map(len, options.values()))
    with capfd.disabled():
        print(f"\n{len(ours)} commands with {total} options, {len(options['walk'])} of them of walk")
    assert len(ours) <= 25  # estimate is the latest, with --robot, --out and --json
    assert total <= 209  # estimate's --terrain is the latest: nothing else tells a slope from the floor
    mute = [name for name, given in options.items() if not any("--json" in option.opts for option in given)]
    assert not mute, "every command prints JSON when it is asked to"
    kept = "feet gait planner velocity terrain terrain-knowledge mu push payload dropout commands actuators"
    kept += " collision world duration seed scenario view out no-video no-report json"
    names = {name for option in options["walk"] for name in (*option.opts, *option.secondary_opts)}
    assert {f"--{name}" for name in kept.split()} <= names
    assert len(options["walk"]) <= 30  # --keep-states, --resume, --at and --hd are the latest four


@pytest.mark.parametrize("words", [["-h"], ["check", "-h"], ["bench", "-h"], ["stand", "-h"]])
def test_h_is_help(words: list[str], printed: Any) -> None:
    assert "Usage: surefoot" in printed(*words)


def test_options_of_a_walk_stand_in_panels(printed: Any) -> None:
    said = printed("walk", "--help")
    panels = re.findall(r"^╭─ (\w+)", said, re.MULTILINE)
    assert set(panels) == {"Arguments", "Options", *PANELS}
    assert said.split("Options")[1].split("╭")[0].count("--") == 1, "--help alone stands in no panel"


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_says_of_a_command_what_its_help_does(name: str) -> None:
    assert summary(name) == " ".join(load(name).help.split("\n\n")[0].split())


def test_version(printed: Any) -> None:
    assert printed("--version") == f"surefoot {sf.__version__}\n"


def test_the_module_is_the_command_and_a_closed_pipe_is_no_traceback() -> None:
    program = [sys.executable, "-m", "surefoot", "cone", "--facets", "900", "--json", "--no-picture"]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == "{\n"
        process.stdout.close()
        said = process.stderr.read()
    assert said == ""
    assert process.returncode == 0
