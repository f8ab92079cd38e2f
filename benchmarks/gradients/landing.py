"""The robot's task: a Go2 lands with theta m/s of forward speed and should end near its start."""

from __future__ import annotations

import numpy as np

import surefoot as sf
from benchmarks.gradients.systems import Path
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.contact.laws.soft import SoftLaw

STIFFNESS, DAMPING, GOAL = 60.0, 3.0, 0.05
"""Of the joints' controller [N m/rad, N m s/rad], and how far forward it should end [m]."""


class Landing:
    """A Go2 falls from a few centimetres onto slippery ground; joint springs hold its pose."""

    name, low, high = "Go2 landing", -1.0, 2.0

    def __init__(self, steps: int = 120, dt: float = 2e-3, mu: float = 0.25, height: float = 0.04) -> None:
        self.robot, self.steps, self.dt, self.mu = sf.load_robot("go2"), steps, dt, mu
        self.start = sf.place(self.robot)
        self.posture = self.start[7:].copy()
        self.start[2] += height

    def run(
        self, theta: float, derivative: bool = False, smoothing: float = 0.0, law: SoftLaw | None = None
    ) -> Path:
        """Return the path of the base (steps + 1, 3), the loss and its derivative."""
        world = sf.RigidWorld(self.robot, mu=self.mu, dt=self.dt, law=law)
        v = np.zeros(self.robot.model.nv)
        v[0] = theta
        world.reset(self.start, v)
        dq, dv = np.zeros_like(v), np.zeros_like(v)
        dv[0], leaving, path = 1.0, None, [self.start[:3]]
        for _ in range(self.steps):
            q, v = world.q_v()
            world.step(STIFFNESS * (self.posture - q[7:]) - DAMPING * v[6:])
            if derivative:
                torques = -STIFFNESS * dq[6:] - DAMPING * dv[6:]
                moved = world.derivative(smoothing).jvp(q=dq, v=dv, torques=torques, leaving=leaving)
                dq, dv, leaving = moved.q, moved.v, moved.leaving
            path.append(world.q_v()[0][:3])
        q = world.q_v()[0]
        off = float(q[0] - self.start[0]) - GOAL
        # dq is along the base's own axes
        forward = float((rotation_from_quaternion(q[3:7]) @ dq[:3])[0]) if derivative else np.nan
        return Path(np.array(path), 100.0 * off**2, 200.0 * off * forward)

    def soft(self, theta: float, stiffness: float) -> float:
        """Return the loss on springs of a stiffness [N/m]; their damping is close to critical."""
        damping = float(np.sqrt(stiffness * self.robot.mass / 4.0))
        return self.run(theta, law=sf.laws.SpringDamper(stiffness, damping)).loss
