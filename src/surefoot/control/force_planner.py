"""When a walking body's forces are planned: the horizon is set up in one step and solved in the next.

A plan takes longer than all else that a step does. So that no step has to do it whole, which feet carry when,
how much, and where they stand is found out a step ahead; the program is built and solved from the state then.
The feet that have changed in between are in the bounds of the whole-body controller at once.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.body_motion import BodyReference
from surefoot.control.force_ramps import ForceRamps
from surefoot.control.mpc import BodyState, ConvexMpc
from surefoot.control.walking_body import BodyPlan
from surefoot.control.walking_feet import Feet
from surefoot.control.walking_kernels import stance_places, turned_arms
from surefoot.control.whole_body import Kinematics


class ForcePlanner:
    """Plans the forces of the coming steps of a walk.

    Parameters
    ----------
    mpc
        Solves for them.
    offsets
        (n, >= 2) where the feet belong about the centre of mass, heading axes [m].
    radii
        (n,) of the feet [m].
    step
        Time between the steps of the controller [s].

    Attributes
    ----------
    forces
        (n, 3) of the first step of the last plan, contact frames [N]; None before the first plan.
    motion
        (5, 3) at the time of the plan: centre of mass [m], its velocity [m/s], angular velocity [rad/s], and
        the planned accelerations [m/s²], [rad/s²].
    rotation
        (3, 3) of the body then.
    begun, made
        Times at which the last plan was set up, and solved [s].
    """

    def __init__(self, mpc: ConvexMpc, offsets: FloatArray, radii: FloatArray, step: float) -> None:
        self.mpc, self.offsets, self.radii, self.step = mpc, offsets, radii, step
        self.motion, self.rotation = np.zeros((5, 3)), np.eye(3)
        self.reset()

    def reset(self) -> None:
        """Forget the last plan."""
        self.mpc.reset()
        self.forces: FloatArray | None = None
        self.begun = self.made = -math.inf
        self._horizon: tuple[BodyReference, FloatArray, BoolArray, FloatArray] | None = None

    @property
    def pending(self) -> bool:
        """Whether what is set up has still to be solved."""
        return self._horizon is not None

    def set_up(
        self, time: float, clock: float, feet: Feet, body: BodyPlan, ramps: ForceRamps, stance: float
    ) -> None:
        """Find out what the horizon that begins at the next step is like; at the first plan, at this one.

        Parameters
        ----------
        time, clock
            Now, and on the schedule's clock [s].
        feet, body, ramps
            What carries, where the body should be, and the feet's ramps.
        stance
            Length of a stance [s].
        """
        N, dt = self.mpc.horizon, self.mpc.dt
        ahead = 0.0 if self.forces is None else self.step
        start = clock + ahead
        contacts = feet.schedule.horizon(start, dt, N)
        if start < 0.0:
            contacts[start + dt * (np.arange(N) + 0.5) < 0.0] = True
        contacts[0] = feet.carrying
        for k in np.flatnonzero(feet.carrying & ~feet.planned):  # landed early: carries on
            later = np.flatnonzero(contacts[1:, k])
            contacts[: 1 + (later[0] if len(later) else 0), k] = True
        reference = body.reference(N, dt, ahead)
        arms = turned_arms(self.offsets, body.yaw + body.velocity[2] * dt * np.arange(N + 1))
        places = stance_places(
            contacts, feet.carrying, feet.ground, feet.target, feet.frames, self.radii, reference.position,
            arms, round(0.5 * stance / dt), body.ground, body.position, body.slope,
        )  # fmt: skip
        if self.forces is not None and not self.pending:
            self.mpc.shift(max(time + ahead - self.made, 0.0))
        self._horizon = reference, places, contacts, ramps.ahead(start, dt, N)
        self.begun = time

    def solve(self, time: float, now: Kinematics, frames: FloatArray, mu: float | None) -> None:
        """Plan from the state of now.

        Parameters
        ----------
        time
            Now [s].
        now
            The body.
        frames
            (n, 3, 3) of the feet's ground, rotation_world_contact.
        mu
            Friction to count on; None for that of the MPC [-].
        """
        assert self._horizon is not None, "set_up comes first"
        reference, places, contacts, shares = self._horizon
        state = BodyState(now.rotation, now.com, now.com_velocity, now.angular_velocity)
        plan = self.mpc.solve(
            state, reference, places, contacts, frames,
            mu=None if mu is None else np.full(len(self.radii), mu), normal_share=shares,
        )  # fmt: skip
        motion, dt = self.motion, self.mpc.dt
        motion[0], motion[1], motion[2] = now.com, now.com_velocity, now.angular_velocity
        motion[3] = (plan.linear_velocity[1] - plan.linear_velocity[0]) / dt
        motion[4] = (plan.angular_velocity[1] - plan.angular_velocity[0]) / dt
        self.forces, self.rotation, self.made, self._horizon = plan.first, now.rotation, time, None
