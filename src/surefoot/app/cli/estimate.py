"""`surefoot estimate LOG --robot R`: a robot's state from a log that somebody else wrote."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.app.cli import options
from surefoot.app.cli.console import say, show
from surefoot.app.cli.extras import require, robot_packages
from surefoot.app.cli.output import check_out, new_run_folder
from surefoot.app.cli.robots import load

if TYPE_CHECKING:
    from rich.console import Console


def estimate(
    log: Annotated[Path, typer.Argument(help="A log of any format, see docs/logs.md.")],
    robot: Annotated[str, typer.Option(help="A known robot, a .urdf or an .xml (MJCF) file.")] = "go2",
    terrain: Annotated[
        str | None,
        typer.Option(help="Ground ahead of where the log begins: slope:DEG, stairs:HEIGHT,DEPTH, ..."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder in which a new one is made.")] = Path("runs"),
    as_json: options.AsJson = False,
) -> int:
    """Estimate state and contacts from a robot's IMU, encoders and feet, and whether to trust them.

    Order of joints, swapped sides and units are found and told; the new log.npz can be audited.
    """
    from surefoot.app.estimation.offline_estimate import estimate_state
    from surefoot.mechanics import read_terrain
    from surefoot.records import read_log

    check_out(out)
    ground = None if terrain is None else read_terrain(terrain, "--terrain")
    given = read_log(log)
    require(robot_packages(robot))
    found = estimate_state(given, load(robot, feet_needed=True), ground=ground)
    file = new_run_folder(out, "estimate") / "log.npz"
    found.save(file)
    q, trusted = found["q"], found["trusted"]
    facts: dict[str, Any] = {
        "robot": found.facts["robot"], "rows": len(found),
        "seconds": float(found["time"][-1] - found["time"][0]),
        "end": q[-1, :7].tolist(), "trusted": float(trusted.mean()), "told": found.facts["computed"],
        "log": str(file),
    }  # fmt: skip
    show(facts, as_json, _print)
    return 0


def _print(console: Console, facts: dict[str, Any]) -> None:
    x, y, z = facts["end"][:3]
    say(
        console,
        f"{facts['robot']}: {facts['seconds']:.1f} s, {facts['rows']} rows; the base ends at "
        f"{x:.2f}, {y:.2f}, {z:.2f} m; trusted in {100.0 * facts['trusted']:.0f} % of the rows",
        *facts["told"],
        f"log: {facts['log']}",
    )
