"""The pressure under a G1 sole while the robot leans forward: it moves to the toes, the heel comes off."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import surefoot as sf
from surefoot.laws import CompliantSolid, PressureField
from surefoot.spatial import GRAVITY
from surefoot.viz.pressure_field_plots import draw_sole_pressures

LEANS = (0.0, 3.0, 5.0, 6.5)
"""Of the robot as one body, about the middle of its soles [deg]."""


def main(parent: Path = Path("runs")) -> dict[str, float]:
    """Print area, pressure and friction torque for every lean, and draw them."""
    folder = parent / "sole-pressure"
    folder.mkdir(parents=True, exist_ok=True)
    robot = sf.load_robot("g1")
    foot = robot.feet[0]
    underside = float(foot.centres[0, 2] - foot.radius)
    sole = CompliantSolid.sole(foot.centres[:, :2], thickness=0.01, height=underside)
    field = PressureField(modulus=1e6, thickness=0.01, friction=0.6)

    height, middle = float(robot.com(robot.nominal)[2]), float(foot.centre[0])
    load = 0.5 * robot.mass * GRAVITY
    centres = [(middle + height * math.tan(math.radians(lean)), 0.0) for lean in LEANS]
    titles = [f"lean {lean:g}°" for lean in LEANS]
    path = folder / "sole-pressure.png"
    patches = draw_sole_pressures(field, sole, load, centres, titles, path)

    print(f"{load:.0f} N on the sole, centre of mass {height:.3f} m high")
    print("lean [deg]  centre [mm]  area [cm²]  largest [kPa]  spin limit [N m]")
    for lean, (x, _), patch in zip(LEANS, centres, patches, strict=True):
        numbers = f"{1e4 * patch.area:11.1f} {1e-3 * patch.largest:14.1f} {patch.spin_limit:17.2f}"
        print(f"{lean:10.1f} {1e3 * x:12.1f} {numbers}")
    print(f"picture: {path}")
    return {
        "load": load,
        "flat_area": patches[0].area,
        "toe_area": patches[-1].area,
        "toe_pressure": patches[-1].largest,
        "flat_spin": patches[0].spin_limit,
        "toe_spin": patches[-1].spin_limit,
    }


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
