"""A Go2 trots over rough ground and takes a push: velocity, footfalls and cones.

Run: python examples/30_trot.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import surefoot as sf
from surefoot.app.viz.walk_plots import draw_footfalls, draw_velocity
from surefoot.mechanics.terrain.rough import rough_ground


def main(folder: Path, duration: float = 5.0) -> dict[str, float]:
    """Return the mean forward velocity after 2 s, the highest use of a cone, and the commanded excess."""
    robot, terrain = sf.load_robot("go2"), rough_ground(seed=1, height=0.04)
    controller = sf.WalkingController(robot, sf.VelocityCommand.constant(0.4), "trot", terrain)
    push = sf.Push(start=2.5, force=(0.0, 100.0, 0.0), duration=0.1)
    scenario = sf.Scenario(duration, mu=0.6, pushes=[push], seed=0)
    log = sf.run(sf.MujocoWorld(robot, terrain, mu=0.6), controller, scenario)

    summary = sf.summarise_walk(log)
    forward = summary.velocity.forward.measured
    print(f"{summary.outcome} {summary.distance:.2f} m at {forward:.3f} m/s")
    for foot in summary.feet:
        print(f"{foot.name}: {foot.footfalls} footfalls, down {100 * foot.duty:.0f} % of the time")

    out = folder / "30_trot"
    out.mkdir(parents=True, exist_ok=True)
    for draw, name in ((draw_velocity, "velocity.png"), (draw_footfalls, "footfalls.png")):
        if not (out / name).exists():
            print("picture:", draw(log, out / name))
    return {
        "walked": float(summary.success),
        "forward": forward,
        "cone_use": max(foot.cone_use_max for foot in summary.feet),
        "commanded_excess": summary.commanded_cone_excess,
    }


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
