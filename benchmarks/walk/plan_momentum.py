"""Angular momentum in walking's cost: less of it after kicks, and what happens if it is forced to zero.

Two walks of a full rigid body, each with plans that leave angular momentum free, weigh it, bound it softly,
and all but forbid it.

Run: python -m benchmarks.walk.plan_momentum [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from benchmarks.problems.walking import INERTIA, TICK, choose_scenes, record
from surefoot.control.mpc import MpcMomentum, MpcWeights
from surefoot.viz.style import FOOT_COLOURS, new_figure, save

TERMS = {
    "free": None,
    "weight 30": MpcMomentum(weight=(30.0, 30.0, 30.0)),
    "bound 0.08": MpcMomentum(bound=(0.08, 0.08, np.inf), beyond=1000.0),
    "weight 1e5": MpcMomentum(weight=(1e5, 1e5, 1e5)),
}
SCENES = ("limit", "trot")


def main(folder: Path, ticks: int = 150) -> dict[str, float]:
    """Return peak momenta [N m s] and largest tilts [deg] by "scene, term"."""
    figure, axes = new_figure(1, len(SCENES), size=(9.0, 4.0))
    facts: dict[str, float] = {}
    for axis, scene in zip(axes[0], choose_scenes(SCENES), strict=True):
        print(f"{scene.title}:\n  plans       peak |h|  its mean  largest tilt  mean distance")
        for colour, (name, term) in zip(FOOT_COLOURS, TERMS.items(), strict=False):
            walk = record(scene, ticks, weights=MpcWeights(momentum=term))
            state = [given.state for given in walk]
            wanted = [given.reference for given in walk]
            h = np.array([s.rotation @ INERTIA @ s.rotation.T @ s.angular_velocity for s in state])
            size = np.linalg.norm(h, axis=1)
            up = [s.rotation[:, 2] @ r.rotation[0][:, 2] for s, r in zip(state, wanted, strict=True)]
            tilt = np.degrees(np.arccos(np.clip(up, -1.0, 1.0)))
            off = [np.linalg.norm(s.position - r.position[0]) for s, r in zip(state, wanted, strict=True)]
            print(
                f"  {name:<11} {size.max():.3f}     {size.mean():.3f}     {tilt.max():5.1f} deg     "
                f"{np.mean(off):.3f} m"
            )
            facts |= {f"{scene.name}, {name}, peak": float(size.max())}
            facts |= {f"{scene.name}, {name}, tilt": float(tilt.max())}
            axis.plot(TICK * np.arange(ticks), tilt, color=colour, label=name)
        axis.set(xlabel="time [s]", ylabel="tilt [deg]", title=scene.title)
        axis.legend()
    out = folder / "plan_momentum"
    out.mkdir(parents=True, exist_ok=True)
    if not (out / "tilt.png").exists():
        print("picture:", save(figure, out / "tilt.png"))
    return facts


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
