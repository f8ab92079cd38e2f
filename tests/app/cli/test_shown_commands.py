"""Every command that README and docs show runs, and ends with the exit code that the page promises.

They run in a folder that holds the files they name. To save time benchmarks get `--quick` and short horizons,
runs no film and no report (test_stand.py and test_walk.py make those), and walks end after `SHORT` seconds
where nothing is to happen later: past the ramp and several steps, up the stairs where there is terrain.
"""

from __future__ import annotations

import runpy
import shlex
from collections.abc import Generator, Iterator
from copy import deepcopy
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import surefoot as sf
from benchmarks.ablation import trials as ablation_trials
from benchmarks.ablation.trials import Change
from benchmarks.problems.logged_runs import CleanRun
from benchmarks.problems.tosses import ELBOW, random_tosses, write_tosses
from benchmarks.softening import race
from surefoot.app.cli.extras import missing
from surefoot.app.cli.main import main
from surefoot.app.course.exercises import solution_text
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solvers import solver as solvers
from surefoot.mechanics.robot.catalog import find, robots_folder
from surefoot.motion.planning import planner
from surefoot.records.identification import identify
from surefoot.records.identification.thrown_body import thrown_body
from surefoot.worlds.interface.world_names import WORLDS, packages_of
from tests.records.identification.hopper import write_hopper
from tests.records.log.test_log_completion import write as write_table
from tests.worlds.mujoco.strangers import thrown_crate

ROOT = Path(__file__).resolve().parents[3]
CHECK = runpy.run_path(str(ROOT / "docs" / "check.py"), run_name="check")
PAGES = [
    page
    for page in CHECK["PAGES"]
    if page.name not in ("CHANGELOG.md", "CONTRIBUTING.md") and page.parent.name != "zh"  # as in English
]
SHORT, SHORT_ON_TERRAIN = 3.0, 5.0
HORIZON = 24
"""Steps of the longest horizon of a bench: of a hundred the rivals need eleven minutes."""
QUICK_PAGES = (
    "README.md", "tour.md", "first-steps.md", "standing.md", "statics.md", "stance-files.md", "cones.md",
    "momentum.md", "jacobians.md", "contact-files.md", "contact-sequences.md", "translate.md", "audit.md",
    "lab.md", "regions.md", "why-it-fell.md", "replay.md", "model-replay.md",
)  # fmt: skip
"""Pages whose commands take seconds: they run in `make test`, those of the others in `make test-all`."""
LONG_COMMANDS = ("bench", "plan", "sweep", "walk", "warmup")
"""What takes long on any page."""


def as_run(words: tuple[str, ...]) -> tuple[str, ...]:
    """Return a command as it is run here."""
    words = tuple(word for word in words if word not in ("--no-video", "--no-report"))
    if words[0] == "bench":
        out = [*words] if "--quick" in words else [*words, "--quick"]
        if "--horizon" in words:
            at = words.index("--horizon") + 1
            out[at] = str(min(int(words[at]), HORIZON))
        return tuple(out)
    if words[0] == "lab":
        return (*words, "--port", "0", "--seconds", "0.2") if len(words) > 1 else words
    if words[0] == "course":  # `mine.py` is there already, to be checked
        return tuple(
            "new.py" if before == "--stub" else word
            for before, word in zip(("", *words), words, strict=False)
        )
    if words[0] == "identify" and "--folds" in words:  # each fold fits every law anew
        at = words.index("--folds") + 1
        return (*words[:at], str(min(int(words[at]), 3)), *words[at + 1 :])
    if words[0] == "robot":  # it waits for somebody who drives it: tests/motion/drive has both
        return (*words, "--seconds", "0.2")
    if words[0] == "worlds":  # all of them in all worlds are tests/worlds/experiments/test_experiments.py's
        names = words if len(words) > 1 and not words[1].startswith("-") else (words[0], "slide", *words[1:])
        return (*names, "--no-pictures")
    if words[0] == "plan":
        return (*words, "--no-video", "--no-report")
    if words[0] == "sweep":
        return (*_alone(words), "--samples", "4", "--backend", "serial")
    if words[0] not in ("stand", "walk"):
        return words
    if {"--keep-states", "--resume"} & set(words):  # a walk that goes on keeps the events of the walk before
        return (*words, "--no-video", "--no-report")
    out = [*words, "--no-video", "--no-report"]
    events = [float(words[k + 1].split(":")[0]) for k, word in enumerate(words) if word == "--push"]
    if "--scenario" in words:
        said = yaml.safe_load((ROOT / words[words.index("--scenario") + 1]).read_text(encoding="utf-8"))
        events += [float(ice.get("from", 0.0)) for ice in said.get("ice", ())]
    even = "--terrain" not in words and not any("/ice" in word for word in words)
    short = SHORT if even and max(events, default=0.0) < SHORT - 1.0 else SHORT_ON_TERRAIN
    if words[0] == "walk" and max(events, default=0.0) < short - 1.0:
        at = out.index("--duration") if "--duration" in out else len(out)
        out[at : at + 2] = ["--duration", f"{short:g}"]
    return tuple(out)


def _alone(words: tuple[str, ...]) -> Iterator[str]:
    """Yield the words of a sweep without those that say how many samples run where."""
    rest = iter(words)
    for word in rest:
        if word in ("--samples", "--backend", "--workers", "--address"):
            next(rest)
        else:
            yield word


def same_run(words: tuple[str, ...]) -> tuple[str, ...]:
    """Return what tells one run from another: not how a benchmark prints, nor counts that --quick sets."""
    if words[0] != "bench":
        return words
    out, rest = [], iter(words)
    for word in rest:
        if word in ("--out", "--instances", "--seeds", "--duration"):
            next(rest)
        elif word != "--json":
            out.append(word)
    return tuple(out)


def all_shown() -> list[Any]:
    """Return (words as run, exit code), each once, the id naming page and command."""
    found: dict[Any, Any] = {}
    for shown in (s for page in PAGES for s in CHECK["shown_commands"](page)):
        if shown.words[0] == "drive" and shown.code == 0:  # it needs a robot: tests/motion/drive has both
            continue
        words = as_run(shown.words)
        before = found.get((same_run(words), shown.code))
        if before is None or len(words) > len(before[0]):
            found[same_run(words), shown.code] = (words, shown)
    return [
        pytest.param(
            words, s.code, id=f"{s.page}: {shlex.join(s.words)}",
            marks=() if s.page in QUICK_PAGES and words[0] not in LONG_COMMANDS else pytest.mark.long,
        )
        for words, s in found.values()
    ]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with every file that the pages' commands name."""
    place = tmp_path_factory.mktemp("shown")
    G = np.diag([1.0, 1.0, 0.5, 2.0, 1.0, 1.0]) + 0.1
    problem = ContactProblem(G, np.array([0.3, -0.1, -1.0, 0.0, 0.2, -0.5]), 0.5)
    (place / "problems").mkdir()
    (place / "FOLDER").mkdir()
    for name in ("problem.npz", "problem.dat", "problem.hdf5", "problems/a.dat", "FOLDER/a.npz"):
        sf.write_problem(problem, place / name)
    sf.write_problem(problem, place / "problems" / "b.hdf5")
    (place / "lcp.dat").write_text("2\n0\n2\n2\n2 2\n2 1\n1 2\n-5 -6\n")
    (place / "examples").symlink_to(ROOT / "examples")
    (place / "FILE").write_bytes((ROOT / "examples" / "stances" / "slope.yaml").read_bytes())
    text = (robots_folder() / find("a1").urdf).read_text()
    for foot, name in zip(find("a1").feet, "abcd", strict=True):
        text = text.replace(f'"{foot}"', f'"{name}"')
    (place / "my.urdf").write_text(text)
    for name, seed, tosses in (("tosses", 0, 16), ("train", 1, 8), ("test", 2, 8), ("cube_third", 3, 12)):
        write_tosses(random_tosses(tosses, [0.2, 0.1, 0.003], seed=seed, frames=30), place / f"{name}.npz")
    (place / "elbow.urdf").write_text(ELBOW)
    elbow = thrown_body(place / "elbow.urdf")
    for name, tosses in (("even", 8), ("odd", 4), ("third", 12), ("rest", 8), ("elbow", 16)):
        jointed = random_tosses(tosses, [0.2, 0.1, 0.003], seed=len(name), frames=24, body=elbow)
        write_tosses(jointed, place / f"{name}.npz")
    (place / "example-robot-data").symlink_to(robots_folder().parent)
    CleanRun(duration=0.3).make().save(place / "log.npz")
    CleanRun(duration=0.3).make().save(place / "crate.npz")
    CleanRun(duration=0.3).make().save(place / "walk.mcap")
    CleanRun(gait="trot", velocity=(0.5, 0.0, 0.0), duration=2.5).make().save(place / "walk.npz")
    (place / "sweep.yaml").write_text(
        "experiment: walk\nsettings: {robot: go2}\nranges: {armature: [0, 0.1]}\n"
    )
    write_table(CleanRun(duration=0.3), place)  # run.csv, run.yaml
    write_hopper(place)
    for name in ("motion.csv", "slow.csv"):  # a robot that stands still
        np.savetxt(place / name, np.tile(sf.load_robot("g1").nominal, (40, 1)), delimiter=",")
    (place / "raw.csv").write_text("".join(f"{0.01 * k},36.8,36.8\n" for k in range(50)))
    steps = (ROOT / "docs" / "first-steps.md").read_text(encoding="utf-8")
    (place / "mine.py").write_text(solution_text("52.2.1"), encoding="utf-8")
    (place / "mine.yaml").write_text(steps.split("```yaml\n")[1].split("```")[0])
    log = CleanRun(duration=0.3).make()
    log["forces"][100:200, 0] *= -1.0
    log.save(place / "fallen.npz")
    thrown_crate(12.0).save(place / "thrown.npz")
    return place


@pytest.fixture(scope="module", autouse=True)
def done_once() -> Iterator[None]:
    """Let commands that ask for the same plan, way through a small program, trial or fit to tosses share it.

    Of a hundred and fifty ablations each task is walked as it is, the first with its setting changed, too:
    that all settings can be changed is tests/benchmarks/test_ablation.py's.
    """
    plans, ways, trials, fits = dict[str, Any](), dict[Any, Any](), dict[Any, Any](), dict[Any, Any]()
    make_plan, race_all, walk_all = planner.plan, race.run, ablation_trials.run_trials
    fit_all = identify.identify

    def fit(tosses: Any, law: Any, *, found: Any = None, test: Any = None, **options: Any) -> Any:
        if found is not None:
            return fit_all(tosses, law, found=found, test=test, **options)
        options.pop("progress")
        thrown = tuple(None if one is None else one.states.tobytes() for one in (tosses, test))
        key = thrown, law.name, *sorted(options.items())
        if key not in fits:
            fits[key] = fit_all(tosses, law, test=test, **options)
        return fits[key]

    def run_trials(
        change: Change, tasks: list[str], seeds: range, longest: float | None
    ) -> Generator[dict[str, Any], None, None]:
        for task in tasks:
            key = task, change.without, bool(change.changes) and not any(changed for *_, changed in trials)
            if key not in trials:
                trials[key] = list(walk_all(change, [task], seeds, longest))
            yield from trials[key]

    def plan(robot: Any, task: str, amount: float | None = None, *, tell: Any = None, **options: Any) -> Any:
        key = f"{robot and robot.name} {task} {amount} {sorted(options.items())}"
        if key not in plans:
            plans[key] = make_plan(robot, task, amount, tell=tell, **options)
        return deepcopy(plans[key])

    def run(variants: Any, problems: Any, starts: int, note: Any) -> Iterator[Any]:
        for name in problems:
            for variant in variants:
                key = name, starts, replace(variant, name="")
                if key not in ways:
                    (ways[key],) = race_all([variant], [name], starts, note)
                row, answer = ways[key]
                yield replace(row, variant=variant.name), answer

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planner, "plan", plan)
        patch.setattr(race, "run", run)
        patch.setattr(identify, "identify", fit)
        patch.setattr(ablation_trials, "run_trials", run_trials)
        yield


@pytest.fixture
def my_method() -> Iterator[None]:
    """Register the solver that docs/add-a-solver.md makes up."""
    entry = solvers.registry()["nsgs"]
    solvers.register("my_method", laws=entry.laws, bilateral=entry.bilateral)(entry.function)
    yield
    solvers.registry().pop("my_method")


def expanded(words: tuple[str, ...], place: Path) -> list[str]:
    """Return the words with patterns of files replaced by the files, as a shell does."""
    out: list[str] = []
    for word in words:
        files = sorted(str(f.relative_to(place)) for f in place.glob(word)) if "*" in word else []
        out += files or [word]
    return out


@pytest.mark.parametrize(("words", "code"), all_shown())
@pytest.mark.usefixtures("my_method")
def test_shown_command_ends_as_the_page_says(
    words: tuple[str, ...], code: int, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    asked = {b for a, b in pairwise(words) if a in ("--world", "--replay")} & set(WORLDS)
    absent = sorted(name for name in asked if missing(packages_of(name)))
    if absent and code == 0:
        pytest.skip(f"{', '.join(absent)} is not here")
    if words[0] == "sweep" and "--seed" in words and code == 2:  # another sweep must have begun there
        at = words.index("--seed")
        assert main(expanded(words[:at] + words[at + 2 :], folder)) == 0
    if "--merge" in words:  # what is merged must have run
        at = words.index("--merge")
        assert main([*words[:at], "--out", f"{words[at + 1]}/all", "--samples", "4"]) == 0
    if "--resume" in words and not list(folder.glob("pushed/*/")):  # what goes on must have begun
        (begun,) = (
            p.values[0] for p in all_shown() if "--keep-states" in p.values[0] and "pushed" in p.values[0]
        )
        assert main(list(begun)) == 0
    assert main(expanded(words, folder)) == code


def test_every_page_with_commands_is_run() -> None:
    pages = {str(p.id).split(":")[0] for p in all_shown()}
    assert {"README.md", "standing.md", "walking.md", "tour.md", "cones.md", "files.md"} <= pages
    assert len(all_shown()) > 50
