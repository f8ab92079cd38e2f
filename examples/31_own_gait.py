"""A gait of one's own: as phases, as mode numbers; and what is refused.

Run: python examples/31_own_gait.py
"""

from __future__ import annotations

import numpy as np

import surefoot as sf


def main(duration: float = 4.0) -> dict[str, float]:
    """Return the mean velocities of an amble made from phases and of the same one made from mode numbers."""
    # an amble: the feet touch down one after the other, a quarter of a cycle apart, with little overlap
    amble = sf.Gait.from_phases("amble", period=0.5, duty=0.6, offset=[0.25, 0.75, 0.0, 0.5])
    for begin, end, mode in zip(amble.switching, amble.switching[1:], amble.modes, strict=False):
        print(f"{begin:.3f} s to {end:.3f} s: mode {mode:2d}, {mode:04b}")
    same = sf.Gait("amble", amble.switching, amble.modes, feet=4)

    robot, speeds = sf.load_robot("go2"), {}
    for name, gait in (("phases", amble), ("modes", same)):
        controller = sf.WalkingController(robot, sf.VelocityCommand.constant(0.4), gait)
        log = sf.run(sf.MujocoWorld(robot), controller, sf.Scenario(duration, mu=0.6))
        speeds[name] = sf.summarise_walk(log).velocity.forward.measured
        print(f"from {name}: {speeds[name]:.3f} m/s, duty {np.round(log['planned'][400:].mean(axis=0), 2)}")

    try:
        sf.Gait("pronk", switching=[0.0, 0.1, 0.6], modes=[15, 0], feet=4)
    except sf.ProblemError as error:
        print("refused:", error)
        speeds["refused"] = 1.0
    return speeds


if __name__ == "__main__":
    main()
