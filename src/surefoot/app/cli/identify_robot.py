"""`surefoot identify LOG.npz`: motors, payload, latency and friction of a robot that walked, for a sweep."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from surefoot.app.cli.console import fit_table, say, show
from surefoot.app.cli.extras import require, robot_packages
from surefoot.app.cli.output import check_out, new_run_folder
from surefoot.app.cli.robots import load
from surefoot.base.errors import ProblemError, writing

if TYPE_CHECKING:
    from rich.console import Console

    from surefoot.records.identification.walked_robot import RobotFit

HIGHEST_MU = 1.0
"""End of the sweep's range of friction where no foot slid: a choice, not a finding."""


def is_log(path: Path) -> bool:
    """Return whether an .npz file is a log and not one of tosses."""
    try:
        return path.suffix == ".npz" and "channels.npy" in zipfile.ZipFile(path).namelist()
    except (OSError, zipfile.BadZipFile):
        return False  # whoever reads it says what is wrong


def identify_robot(path: Path, model: Path | None, out: Path, as_json: bool, given: dict[str, Any]) -> int:
    """Fit a robot to a walk, and write the ranges of a sweep; `given` options mean nothing to it."""
    if unused := [name for name, changed in given.items() if changed]:
        raise ProblemError(f"{path} is a robot's log: {', '.join(unused)} are of tosses")
    from surefoot.records import read_log
    from surefoot.records.identification.walked_robot import identify_robot as fit

    check_out(out)
    log = read_log(path)
    name = str(log.fact("robot")) if model is None else str(model)
    require(robot_packages(name))
    found = fit(load(name, feet_needed=True), log)
    written = _write_sweep(new_run_folder(out, "identify") / "sweep.yaml", path, name, found)
    facts = {
        "robot": name, "fit": {n: vars(e) for n, e in found.parameters.items()}, "notes": found.notes,
        "feet": [foot._asdict() for foot in found.feet], "under": [str(foot) for foot in found.feet],
        "sweep": str(written),
    }  # fmt: skip
    show(facts, as_json, _print)
    return 0


def _write_sweep(file: Path, log: Path, robot: str, found: RobotFit) -> Path:
    """Write what was found as the ranges of a sweep; return the file."""
    ranges = []
    for name, e in found.parameters.items():
        high = max(HIGHEST_MU, e.low) if math.isinf(e.high) else e.high
        comment = "" if math.isfinite(e.high) else "  # no foot slid: the upper end is a choice"
        ranges.append(f"  {name}: [{max(0.0, e.low):.4g}, {max(0.0, high):.4g}]{comment}")
    text = (
        f"# 95 % intervals of what {log.name} tells, by surefoot identify\nexperiment: walk\nsamples: 256\n"
    )
    settings = f"settings: {{robot: {robot}, believed_mu: {found.parameters['mu'].low:.3g}}}"
    with writing(file):
        file.write_text("\n".join([text + settings, "ranges:", *ranges, ""]))
    return file


def _print(console: Console, facts: dict[str, Any]) -> None:
    console.print(fit_table(facts["fit"], f"what the walk of {facts['robot']} tells", left=1))
    say(console, *facts["under"], *facts["notes"], f"ranges for surefoot sweep: {facts['sweep']}")
