"""`surefoot identify LOG.csv --model LEG.urdf`: a leg's joints and the sensor that its foot stands on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.app.cli.console import fit_table, say, show
from surefoot.app.cli.extras import require, robot_packages
from surefoot.app.cli.output import check_out, new_run_folder
from surefoot.base.errors import ProblemError, writing

if TYPE_CHECKING:
    from rich.console import Console

    from surefoot.records.identification.force_model import FootForces, ForceModel
    from surefoot.records.identification.leg_motion import LegLog


def identify_forces(
    log: Path, model: Path | None, test: Path | None, out: Path, as_json: bool, given: dict[str, Any]
) -> int:
    """Fit a leg's forces to a sensor, and tell those of another log; `given` options mean nothing to it."""
    if unused := [name for name, changed in given.items() if changed]:
        raise ProblemError(f"{log} is a leg's log: {', '.join(unused)} are of tosses (.npz)")
    if model is None:
        raise ProblemError(f"{log} is a leg's log: --model must name its URDF or MJCF file")
    require(robot_packages(str(model)))
    from surefoot.mechanics import load_robot
    from surefoot.records.identification.force_model import TERMS, ForceModel
    from surefoot.records.identification.leg_motion import read_leg_log

    check_out(out)
    robot = load_robot(model, fixed_base=True)
    other = None if test is None else read_leg_log(test)
    found = ForceModel.fit(robot, log)
    forces = None if other is None else found.estimate(other)
    keys = ("value", "low", "high", "unit")
    joints = {
        joint: {t: dict(zip(keys, (*e, TERMS[t]), strict=True)) for t, e in terms.items()}
        for joint, terms in found.joints.items()
    }
    facts: dict[str, Any] = {
        "fit": joints, "axes": found.axes, "offset": found.offset, "delay": found.delay, "test": None,
        "hysteresis": found.length, "unseen_error_rms": found.rms, "notes": found.notes,
    }  # fmt: skip
    if other is not None and forces is not None:
        written = str(_write_forces(new_run_folder(out, "identify") / "forces.csv", forces))
        facts["test"] = {"forces": written, **_summarise_forces(found, other, forces)}
    show(facts, as_json, _print)
    return 0


def _write_forces(path: Path, forces: FootForces) -> Path:
    """Write forces as CSV; return the file."""
    heads = [f"{kind}_{axis}" for kind in ("force", "low", "high") for axis in "xyz"]
    names = ["time", *heads, "vertical", "contact", "friction_used"]
    f = forces
    columns = (f.time, f.forces, f.low, f.high, f.vertical, f.contact, f.friction_used)
    with writing(path):
        np.savetxt(path, np.column_stack(columns), "%.6g", ",", header=",".join(names), comments="")
    return path


def _summarise_forces(found: ForceModel, log: LegLog, forces: FootForces) -> dict[str, Any]:
    """Return what the forces say, and how far they are from a sensor if the log has one."""
    used = forces.friction_used[forces.contact]
    facts: dict[str, Any] = {
        "rows": len(forces.time),
        "touchdowns": forces.touchdowns,
        "contact_share": forces.contact.mean(),
        "friction_used": {"median": float(np.median(used)), "most": float(used.max())} if used.size else None,
    }
    if log.sensor is not None:
        from surefoot.records.identification.force_model import TOUCHING

        axis, up = found.vertical_axis
        inside = (log.sensor >= forces.low) & (log.sensor <= forces.high)
        facts["error_rms"] = np.sqrt(((forces.forces - log.sensor) ** 2).mean(axis=0))
        facts["inside_interval"] = inside.mean(axis=0)
        facts["wrong_share"] = np.mean((up * log.sensor[:, axis] > TOUCHING) != forces.contact)
    return facts


def _print(console: Console, facts: dict[str, Any]) -> None:
    fit = {f"{joint} {term}": e for joint, terms in facts["fit"].items() for term, e in terms.items()}
    console.print(fit_table(fit, "what the joints keep to themselves"))
    say(console, *facts["notes"])
    test = facts["test"]
    if test is None:
        return
    say(
        console,
        f"forces: {test['forces']}, {test['rows']} rows, {100 * test['contact_share']:.1f} % in contact",
        "touchdowns [s]: " + (", ".join(f"{t:.3f}" for t in test["touchdowns"]) or "none"),
    )
    if test["friction_used"]:
        say(console, "friction used: median {median:.3f}, at most {most:.3f}".format(**test["friction_used"]))
    if "error_rms" in test:
        rms, inside = (", ".join(f"{x:.3g}" for x in test[k]) for k in ("error_rms", "inside_interval"))
        say(console, f"the sensor differs by {rms} N rms; shares inside the intervals {inside}")
        say(console, f"rows with a wrong contact: {100 * test['wrong_share']:.2f} %")
