"""`surefoot walk --keep-states` and `--resume`: states of a walk in its log, and going on from one."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from surefoot.app.cli import parsing
from surefoot.app.cli.robots import is_file
from surefoot.app.cli.run_files import PARTS
from surefoot.app.cli.scenario_file import ScenarioFile
from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.app.cli.policy import PolicyOptions
    from surefoot.app.cli.walk_options import WalkOptions
    from surefoot.records.log.kept_states import KeptState
    from surefoot.worlds.running.run_state import RunState, StateKeeper

MADE_BY = ("surefoot", "mujoco", "pin", "numba", "numpy")
"""Packages in whose versions a walk goes on to the last bit."""
LEAVING = ("out", "video", "hd", "report", "as_json", "view", "keep_states", "resume", "at")
"""Options that say nothing of what happens to the robot."""
CHANGES = ("duration", "push", "velocity")
"""Options that a walk which goes on may be given anew."""


@dataclass(frozen=True)
class Resumed:
    """A walk that goes on from a kept state.

    Attributes
    ----------
    asked, said
        Options and scenario: those of the walk that has kept it, but for what was given anew.
    state
        Where it begins.
    velocity
        (3,) another velocity that was given: forward, left [m/s], yaw rate [rad/s]; None for none.
    """

    asked: WalkOptions
    said: ScenarioFile
    state: RunState
    velocity: tuple[float, float, float] | None

    def start(self, controller: Any) -> RunState:
        """Return the state, of a walk that is steered to another velocity where one was given.

        The gait stays the one that was chosen for the first velocity.
        """
        if self.velocity is None:
            return self.state
        state = copy.deepcopy(self.state)
        inner, own, around = controller, state.controller, None
        while isinstance(own, dict):  # of what is around the walker
            inner, own, around = inner.controller, own["controller"], own
        if own is None:
            return state
        inner.resume(own)
        inner.steer(self.velocity)
        steered = inner.state
        inner.reset()
        if around is None:
            return replace(state, controller=steered)
        around["controller"] = steered
        return state


def _find_given(context: typer.Context) -> list[str]:
    """Return the names of the parameters that stand on the command line."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return [name for name, source in sources.items() if source is not None and source.name == "COMMANDLINE"]


def resume_walk(context: typer.Context, asked: WalkOptions) -> Resumed | None:
    """Return the walk that is to go on, None where a new one begins.

    Raises
    ------
    ProblemError
        For a log without states, or none at that time; what cannot be given anew; other versions of the
        packages; files that are broken or were changed.
    """
    if asked.resume is None:
        if asked.at is not None:
            raise ProblemError("--at is of --resume LOG")
        return None
    if asked.at is None:
        raise ProblemError("--resume takes --at TIME, from which the walk is to go on [s]")
    fixed = [name for name in _find_given(context) if name not in (*LEAVING, *CHANGES)]
    if fixed:
        spoken = ", ".join("ROBOT" if name == "robot" else _spoken(name) for name in fixed)
        new = ", ".join(map(_spoken, CHANGES))
        raise ProblemError(f"--resume goes on with the walk as it was: it takes {new}, not {spoken}")
    kept = _read(asked.resume, asked.at)
    from surefoot.worlds.running.run_state import RunState

    about = kept.about
    _check_versions(about["versions"], asked.resume)
    options = {name: value for name, value in about["options"].items() if name not in LEAVING}
    given = {name: getattr(asked, name) for name in _find_given(context) if name in CHANGES}
    velocity = parsing.velocity(given.pop("velocity")) if "velocity" in given else None
    now = replace(asked, **{**options, **given})
    said = ScenarioFile(**{name: _tuples(value) for name, value in about["scenario"].items()})
    state = RunState.from_arrays(dict(kept.arrays), kept.facts)
    if now.duration <= state.time:
        raise ProblemError(f"--duration {now.duration:g} ends before the kept state of {state.time:g} s")
    return Resumed(now, said, state, velocity)


def _spoken(name: str) -> str:
    """Return an option as it is written."""
    return "--" + {"as_json": "json"}.get(name, name).replace("_", "-")


def _tuples(value: Any) -> Any:
    """Return what JSON holds with tuples in the place of lists."""
    return tuple(value) if isinstance(value, list) else value


def _read(path: Path, time: float) -> KeptState:
    """Return the last state at a time or before, of a log or of the folder of a run.

    Raises
    ------
    ProblemError
        Where there is none.
    """
    from surefoot.records import read_log
    from surefoot.records.log.kept_states import read_kept_state

    real_number("--at", time, low=0.0)
    if path.is_dir():
        path = next((path / name for name in ("log.npz", PARTS) if (path / name).exists()), path)
    log = read_log(path)
    dt = float(log.fact("dt"))
    begin, end = (float(log["time"][k]) for k in (0, -1)) if len(log) else (math.nan, math.nan)
    if not begin - 0.5 * dt <= time <= end + 1.5 * dt:
        raise ProblemError(f"--at {time:g}: {path} tells of {begin:.3f} to {end + dt:.3f} s")
    kept = read_kept_state(path, time, dt)
    if not isinstance(kept.about, dict) or kept.about.get("command") != "walk":
        raise ProblemError(f"{path} has kept states, but not of a surefoot walk")
    return kept


def _versions() -> dict[str, str]:
    """Return the versions of the packages by which a walk is made."""
    out = {}
    for name in MADE_BY:
        try:
            out[name] = version(name)
        except PackageNotFoundError:
            out[name] = "none"
    return out


def _check_versions(kept: dict[str, str], path: Path) -> None:
    """Refuse states of other versions, from which no walk goes on as the first one did."""
    other = [
        f"{name} {kept.get(name, 'none')}, this is {now}"
        for name, now in _versions().items()
        if kept.get(name, "none") != now
    ]
    if other:
        raise ProblemError(f"{path} was made by other versions: {'; '.join(other)}")


def state_keeper(asked: WalkOptions, said: ScenarioFile, learned: PolicyOptions) -> Keep | None:
    """Return what keeps states in the log's folder, None where none are to be kept.

    Raises
    ------
    ProblemError
        For a time that is no positive number, a walk that is steered by hand, and controllers whose state
        is not known.
    """
    if asked.keep_states is None:
        return None
    real_number("--keep-states", asked.keep_states, low=1e-3)
    if asked.view:
        raise ProblemError("--keep-states is of a walk that nobody steers: it does not go with --view")
    if learned.policy is not None or asked.planner != "convex":
        which = "--policy" if learned.policy is not None else f"--planner {asked.planner}"
        raise ProblemError(f"--keep-states goes with --planner convex: {which} does not tell its state")
    about = {
        "command": "walk", "versions": _versions(),
        "options": {name: value for name, value in _plain(asked).items() if name not in LEAVING},
        "scenario": {name: value for name, value in _plain(said).items() if name in said.given},
    }  # fmt: skip
    return Keep(asked.keep_states, about)


@dataclass(frozen=True)
class Keep:
    """What keeps states: the time between two of them [s], and what the walk was made with."""

    every: float
    about: dict[str, Any]

    def into(self, folder: Path) -> StateKeeper:
        """Return the keeper that writes into a log's folder of parts."""
        from surefoot.records.log.kept_states import KeptState, keep_state
        from surefoot.worlds.running.run_state import StateKeeper

        def take(state: RunState) -> None:
            keep_state(folder, KeptState(state.step, state.time, *state.to_arrays(), self.about))

        return StateKeeper(self.every, take)


def _plain(options: Any) -> dict[str, Any]:
    """Return the fields of a dataclass as JSON can hold them, paths of files in full."""

    def plain(name: str, value: Any) -> Any:
        if isinstance(value, Path) or (name == "robot" and value is not None and is_file(value)):
            return str(Path(value).absolute())
        return list(value) if isinstance(value, Iterable) and not isinstance(value, (str, dict)) else value

    return {one.name: plain(one.name, getattr(options, one.name)) for one in fields(options)}
