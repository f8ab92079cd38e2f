"""A Go2 stands on a slope: forces, cones and a picture of both.

Run: python examples/01_stand.py [PICTURE.png]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import surefoot as sf
from surefoot.app.viz.video import Renderer, RenderError, cone_lines, log_arrows


def main(picture: Path) -> np.ndarray:
    """Return the mean normal forces of the last half second [N]."""
    robot, terrain, mu = sf.load_robot("go2"), sf.SlopeTerrain(20.0), 0.6
    q = sf.place(robot, terrain)

    verdict = sf.can_stand(robot.stance(q, mu=mu, terrain=terrain), robot.com(q), robot.mass)
    print("can it stand?", verdict)

    controller = sf.StandingController(robot, sf.StandingPlan(robot, terrain, q), terrain, q, mu)
    log = sf.run(sf.MujocoWorld(robot, terrain, mu), controller, sf.Scenario(1.0, mu))
    normal = log["forces"][-500:, :, 2].mean(axis=0)
    for name, force in zip(robot.foot_names, normal, strict=True):
        print(f"{name}: {force:.1f} N")

    if picture.exists():
        print(f"{picture} exists already, not drawn again")
        return normal
    try:
        renderer = Renderer(robot, terrain, 1200, 640, fine=True)
    except RenderError as error:
        print(error)
        return normal
    lines = cone_lines(log, len(log) - 1, terrain, 0.15, rays=16)
    pixels = renderer.frame(log["q"][-1], log_arrows(log, len(log) - 1, terrain, 0.0045), lines)
    renderer.close()

    from imageio.v2 import imwrite

    picture.parent.mkdir(parents=True, exist_ok=True)
    imwrite(picture, pixels)
    print(f"picture: {picture}")
    return normal


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs/01_stand.png"))
