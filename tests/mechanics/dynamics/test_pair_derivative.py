"""Steps of bodies that touch each other: every block of their derivative against differences of the step.

One contact of each kind: points, edges and faces that touch, corners beyond a border, several at once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.mechanics.collision import Box, Capsule, Sphere
from surefoot.mechanics.dynamics import Stepper
from tests.mechanics.dynamics.test_derivative import EXACT, check, fine_motion  # noqa: F401

BALL, BRICK, ROD = Sphere(0.1), Box((0.2, 0.3, 0.24)), Capsule(0.05, 0.3)
OPTIONS = replace(EXACT, stabilisation="none")


def turn(axis, degrees: float) -> tuple[float, ...]:
    """The quaternion of a turn about an axis."""
    way = np.array(axis) / np.linalg.norm(axis)
    return tuple(pinocchio.Quaternion(pinocchio.exp3(np.radians(degrees) * way)).coeffs().tolist())


CASES = {
    "balls": ([BALL, BALL], [None, None], (0.1, 0.05)),
    "ball and face": ([BRICK, BALL], [((1, 2, 3), 4.0), None], (0.02, 0.03)),
    "ball and edge": ([BRICK, BALL], [((1, 2, 3), 4.0), None], (0.13, 0.03)),
    "ball and corner": ([BRICK, BALL], [((1, 2, 3), 4.0), None], (0.13, 0.18)),
    "crossed rods": ([ROD, ROD], [((1, 0, 0), 85.0), ((0.2, 1, 0), 80.0)], (0.02, 0.03)),
    "corner and face": ([BRICK, BRICK], [((1, 2, 3), 4.0), ((1, 2, 0.5), 50.0)], (0.02, 0.01)),
    "crossed edges": ([BRICK, BRICK], [((1, 0.1, 0), 45.0), ((0, 1, 0.1), 40.0)], (0.01, 0.02)),
    "faces": ([BRICK, BRICK], [((1, 0.3, 0.2), 0.4), ((1, 1.3, 0.2), 0.43)], (0.03, 0.02)),
    "beyond a border": ([BRICK, BRICK], [((1, 0.3, 0.2), 0.4), ((1, 1.3, 0.2), 3.0)], (0.12, -0.06)),
}  # fmt: skip
"""Two shapes, the lower one first, how they are turned, and where the upper one is."""


def apart(case: str, gap: float, restitution: float) -> tuple[Stepper, np.ndarray, np.ndarray]:
    """Two bodies with this gap [m] between them, and below the lower one."""
    shapes, turns, (x, y) = CASES[case]
    turns = [(0.0, 0.0, 0.0, 1.0) if t is None else turn(*t) for t in turns]
    bodies = [sf.Body(f"b{k}", s, 1.0 + k, (x * k, y * k, 0.6 * k), t, (0.1 + 0.3 * k, 0.1, -0.4 - 0.9 * k),
                      (0.3, 0.1 - 0.4 * k, 0.2), restitution=restitution)
              for k, (s, t) in enumerate(zip(shapes, turns, strict=True))]  # fmt: skip
    scene = sf.Scene(bodies)
    stepper, (q, v) = Stepper(scene, None, OPTIONS, geometry=scene.geometry), scene.start()
    for at in (2, 9):
        for _ in range(40):
            gaps, spheres = stepper.contacts(stepper.start(q)).gaps, len(stepper.bodies.contacts.points)
            least = gaps[:spheres].min() - gap if at == 2 else gaps[spheres:].min() - gap
            q[[2, 9] if at == 2 else [9]] -= min(least, 0.05)
    return stepper, q, v


@pytest.mark.usefixtures("fine_motion")
@pytest.mark.parametrize("mu", [0.1, 3.0], ids=["slide", "stick"])
@pytest.mark.parametrize("case", CASES)
@pytest.mark.sampled(4)
def test_two_bodies_on_the_ground(case: str, mu: float) -> None:
    stepper, q, v = apart(case, 7.3e-4, 0.3 if case == "balls" else 0.0)
    d = check(stepper, stepper.start(q, v), np.zeros(0), mu=mu)
    assert d.step.impulses[len(stepper.bodies.contacts.points) :, 2].max() > 0.0  # of the pair
