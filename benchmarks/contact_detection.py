"""How late and how well contacts and friction are told without sensors in the feet: docs/estimation.md.

Run: python -m benchmarks.contact_detection [--quick] [--json]. Runs are walked in their worlds; the detector
then sees q, v and torques, exact and with noise, and its answers are held against the forces of the world.
The tracker of friction sees walks onto ground that is more slippery than the controller was told.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from rich.table import Table

from benchmarks.detection_errors import detection_errors
from benchmarks.printing import options, show, table
from benchmarks.walks import Walk, known_robot
from surefoot.arrays import FloatArray
from surefoot.audit.motion import touching
from surefoot.estimation.contact_detection import ContactDetector
from surefoot.estimation.friction import FrictionTracker
from surefoot.log import Log
from surefoot.simulation.run import Push
from surefoot.spatial import GRAVITY

WALKS = tuple(
    Walk(robot, (0.4, 0.0, 0.0), "trot", terrain, world=world)
    for robot, world, terrain in (
        ("go2", "mujoco", "flat"), ("go2", "rigid", "flat"), ("go2", "mujoco", "slope:10"),
        ("anymal_c", "mujoco", "flat"), ("solo12", "mujoco", "flat"),
    )
)  # fmt: skip
DURATION = 1.5
"""Of these walks [s]."""
LINEAR, ANGULAR, JOINTS, TORQUE = 0.03, 0.02, 0.05, 0.01
"""Noise (standard deviation, white in every row) of the base's velocity [m/s, rad/s], the joints' [rad/s],
and of a torque as a share of m g times 1 m over the number of joints."""
BELIEVED, PUSH = 0.6, (30.0, 40.0, 0.0)
"""Friction that the controller counts on, and the force of its push on slippery ground [N]."""


def noisy(log: Log, seed: int) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Yield q, v and torques row by row with the noise above."""
    random = np.random.default_rng(seed)
    v, tau = log["v"].copy(), log["torques"].copy()
    for columns, size in ((slice(0, 3), LINEAR), (slice(3, 6), ANGULAR), (slice(6, None), JOINTS)):
        v[:, columns] += size * random.normal(size=v[:, columns].shape)
    tau += TORQUE * log.fact("mass") * GRAVITY / tau.shape[1] * random.normal(size=tau.shape)
    yield from zip(log["q"], v, tau, strict=True)


def detection_table(walks: Sequence[Walk]) -> Table:
    """Return delays and errors of the contact detector."""
    columns = ("run", "noise", "touchdown", "lift-off", "missed", "false", "contacts", "rows wrong")
    cells = []
    for walk in walks:
        robot, log = known_robot(walk.robot), walk.log(0, DURATION)
        truth = touching(log)
        exact = zip(log["q"], log["v"], log["torques"], strict=True)
        for name, rows in (("no", exact), ("yes", noisy(log, 0))):
            detector = ContactDetector(robot, log.fact("dt"))
            told = np.array([detector.update(*row).contact for row in rows])
            e = detection_errors(told, truth, log.fact("dt"))
            times = [_delays(d) for d in (e.touchdown_delays, e.lift_off_delays)]
            counts = (str(e.missed), str(e.false), str(e.contacts), f"{100 * e.wrong_share:.1f} %")
            cells.append((f"{walk.robot} {walk.world} {walk.terrain}", name, *times, *counts))
    return table(columns, cells, "contacts from torques and kinematics, delays in ms: median, worst")


def _delays(delays: FloatArray) -> str:
    if not delays.size:
        return "-"
    worst = delays[np.argmax(np.abs(delays))]
    return f"{1e3 * np.median(delays):.0f}, {1e3 * worst:.0f}"


def slippery_walk(world: str, mu: float) -> Log:
    """Return the log of a Go2 that trots at 0.6 m/s, and is pushed, on less friction than it was told."""
    push = Push(0.8, PUSH, 0.2)
    walk = Walk(velocity=(0.6, 0.0, 0.0), mu=mu, believed_mu=BELIEVED, world=world, pushes=(push,))
    return walk.log(0, 2.0)


def friction_answers(world: str, mu: float) -> tuple[float, FloatArray, float]:
    """Return the time from first slip to first answer [s], all answers, and the highest lower bound."""
    log, random = slippery_walk(world, mu), np.random.default_rng(0)
    least, dt = 0.05 * log.fact("mass") * GRAVITY, log.fact("dt")
    tracker = FrictionTracker(log["forces"].shape[1], dt, least=least)
    known = []
    for forces, velocities in zip(log["forces"], log["contact_velocities"], strict=True):
        known.append(tracker.update(forces * (1.0 + 0.1 * random.normal(size=forces.shape)), velocities))
    high = np.array([k.high for k in known])
    told, slid = np.isfinite(high), np.array([k.sliding for k in known])
    walking = slice(round(0.1 / dt), None)  # the first rows are the robot's landing
    wait = int(np.argmax(told[walking].any(axis=1))) - int(np.argmax(slid[walking].any(axis=1)))
    return wait * dt, high[told], max(float(k.low.max()) for k in known)


def friction_table(cases: Sequence[tuple[str, float]]) -> Table:
    """Return how soon and how well a slide tells friction."""
    rows = []
    for world, mu in cases:
        wait, answers, low = friction_answers(world, mu)
        ends = f"{answers.min():.3f} to {answers.max():.3f}"
        rows.append((world, f"{mu:g}", f"{1e3 * wait:.0f}", ends, f"{low:.3f}"))
    columns = ("world", "true mu", "ms to answer", "answers (all feet, all times)", "highest low")
    return table(columns, rows, f"friction while it goes, believed {BELIEVED}, forces with 10 % noise")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print both tables."""
    given = options(__doc__, "one run for each table").parse_args(arguments)
    cases = [(world, mu) for world in ("rigid", "mujoco") for mu in (0.15, 0.25)]
    detection = detection_table(WALKS[:1] if given.quick else WALKS)
    show([detection, friction_table(cases[1:2] if given.quick else cases)], given.json)


if __name__ == "__main__":
    main()
