"""A Go2 trots up a slope and is pushed: every ground force moves inside its friction cone. An animation.

Run: python examples/02_pushed_on_a_slope.py [ANIMATION.webp]
"""

from __future__ import annotations

import sys
from pathlib import Path

import surefoot as sf

SIZE, RATE = (720, 405), 15
SECONDS = 4.0


def main(animation: Path, seconds: float = SECONDS) -> sf.Log:
    """Return the log of the walk, and draw it."""
    robot, slope, mu = sf.load_robot("go2"), sf.SlopeTerrain(12.0), 0.6
    controller = sf.WalkingController(robot, sf.VelocityCommand.constant(0.5), "trot", slope)
    push = sf.Push(start=2.0, force=(0.0, 100.0, 0.0), duration=0.1)
    scenario = sf.Scenario(seconds, mu, pushes=(push,), start=sf.place(robot, slope))
    log = sf.run(sf.MujocoWorld(robot, slope, mu), controller, scenario)
    print(sf.audit_log(log).sentence)

    if animation.exists():
        print(f"{animation} exists already, not drawn again")
        return log
    try:
        from PIL import Image

        from surefoot.app.viz.film import frames_of, write_animation

        frames = [Image.fromarray(picture) for picture in frames_of(log, robot, slope, RATE, SIZE)]
    except (ImportError, sf.SurefootError) as error:
        print(f"no animation: {error}")
        return log
    write_animation(frames, animation, RATE)
    print(f"animation: {animation}")
    return log


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs/02_pushed_on_a_slope.webp"))
