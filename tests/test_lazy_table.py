"""Tables of objects that are imported when they are asked for."""

import subprocess
import sys

import pytest

from surefoot.app.cli.commands import COMMANDS
from surefoot.app.export import TARGETS
from surefoot.base.errors import ProblemError
from surefoot.base.lazy_table import LazyTable
from surefoot.contact.solvers.solver import SOLVERS
from surefoot.motion.planning.tasks.task_names import TASKS
from surefoot.worlds.interface.world_names import PACKAGES, WORLDS
from surefoot.worlds.sweep import EXPERIMENTS


def test_an_entry_is_imported_by_its_place_or_returned_as_it_is():
    table = LazyTable("root", {"square": "math:sqrt"})
    table["same"] = abs
    assert table.load("square")(9.0) == 3.0
    assert table.load("same") is abs
    assert [table.object_name(name) for name in table] == ["sqrt", "abs"]


@pytest.mark.parametrize("name", ["cube", 3, None, ["square"]])
def test_an_unknown_name_is_refused_with_the_valid_ones(name):
    table = LazyTable("root", {"square": "math:sqrt", "same": abs})
    with pytest.raises(ProblemError, match=r"unknown root .*; valid names: same, square"):
        table.load(name)


@pytest.mark.parametrize("table", [COMMANDS, TASKS, TARGETS, SOLVERS, EXPERIMENTS], ids=lambda t: t.kind)
def test_every_entry_of_the_package_can_be_imported(table):
    for name in table:
        assert table.load(name) is not None, name


def test_worlds_that_need_packages_are_worlds():
    assert set(PACKAGES) <= set(WORLDS)
    assert WORLDS.load("rigid").__name__ == WORLDS.object_name("rigid")


def test_the_names_of_commands_are_read_without_importing_one():
    code = "import sys; from surefoot.app.cli.commands import COMMANDS; "
    code += "print([name for name in COMMANDS if f'surefoot.app.cli.{name}' in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
