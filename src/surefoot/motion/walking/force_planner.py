"""When a walking body's forces are planned: the horizon is set up in one step and solved in the next.

A plan takes longer than all else that a step does. So that no step has to do it whole, which feet carry when,
how much, and where they stand is found out a step ahead; the program is built and solved from the state then.
The feet that have changed in between are in the bounds of the whole-body controller at once.

A foot that carries its share of the weight from one millisecond to the next asks its motors for a step in
torque, and drops the body when it leaves. So the most that a foot may push grows along a line from the moment
it touches, and falls along one to the moment it is planned to lift. A foot that has been taken to stand for
an instant and does not touch any more waits with its ramp: pushed down in the air it would strike the ground.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import kernel
from surefoot.motion.control.body_motion import BodyReference
from surefoot.motion.control.mpc import BodyState, ConvexMpc
from surefoot.motion.control.whole_body import Kinematics
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.walking_body import BodyPlan
from surefoot.motion.walking.walking_feet import Feet
from surefoot.motion.walking.walking_kernels import stance_places, turned_arms

LANDED = 1e-3
"""A foot that touches has used this much of its ramp: it may push at once, if little [s]."""


class ForcePlanner:
    """Plans the forces of the coming steps of a walk.

    Parameters
    ----------
    mpc
        Solves for them.
    schedule
        When feet are planned to lift and land.
    offsets
        (n, >= 2) where the feet belong about the centre of mass, heading axes [m].
    radii
        (n,) of the feet [m].
    dt
        Time between the steps of the controller [s].
    ramp
        Length of a ramp [s]; 0 for none.

    Attributes
    ----------
    forces
        (n, 3) of the first step of the last plan, contact frames [N]; None before the first plan.
    motion
        (5, 3) at the time of the plan: centre of mass [m], its velocity [m/s], angular velocity [rad/s], and
        the planned accelerations [m/s²], [rad/s²].
    rotation
        (3, 3) of the body then.
    rate
        How many times as fast as time the schedule's clock goes.
    begun, made
        Times at which the last plan was set up, and solved [s].
    """

    def __init__(
        self, mpc: ConvexMpc, schedule: ContactSchedule, offsets: FloatArray, radii: FloatArray, dt: float,
        ramp: float,
    ) -> None:  # fmt: skip
        self.mpc, self.schedule, self.offsets, self.radii, self.dt = mpc, schedule, offsets, radii, dt
        self.ramp = max(ramp, 1e-9)
        self.motion, self.rotation = np.zeros((5, 3)), np.eye(3)
        self.reset()

    def reset(self) -> None:
        """Forget the last plan."""
        self.mpc.reset()
        self.forces: FloatArray | None = None
        self.begun = self.made = -math.inf
        self._horizon: tuple[BodyReference, FloatArray, BoolArray] | None = None
        self._landed = np.full(len(self.radii), -math.inf)
        self._stood: BoolArray = np.ones(len(self.radii), dtype=bool)
        self.rate = 1.0
        self._time = math.inf  # no time has passed before the first step

    @property
    def pending(self) -> bool:
        """Whether what is set up has still to be solved."""
        return self._horizon is not None

    def shares(self, time: float, stance: BoolArray, touching: BoolArray | None = None) -> FloatArray:
        """Return the shares at a time of the schedule [s] for (n,) feet that carry: (n,), 0 to 1.

        To be called at every step: a foot's ramp begins when it first carries, and goes on while the foot
        feels the ground, (n,); None where that is not known, and all do.
        """
        shares, phases = np.empty(len(self.radii)), self.schedule.phases(time)
        elapsed = max(time - self._time, 0.0)
        self._time = time
        early = ramp_shares(
            phases, stance, stance if touching is None else touching, self._stood,
            self._landed, time, elapsed, LANDED, self.ramp * self.rate, shares,
        )  # fmt: skip
        for k in range(len(shares)) if early else ():
            if early >> k & 1:
                left = (self._lift_off(k, time) - time) / (self.ramp * self.rate)
                shares[k] = min(shares[k], max(left, 0.0))
        return shares

    def _lift_off(self, k: int, time: float) -> float:
        """Return when a foot that carries is planned to lift; one that landed early, after its stance."""
        planned, _, end = self.schedule.phase(k, time)
        return end if planned else self.schedule.phase(k, end)[2]

    def set_up(self, time: float, clock: float, feet: Feet, body: BodyPlan, stance: float) -> None:
        """Find out what the horizon that begins at the next step is like; at the first plan, at this one.

        Parameters
        ----------
        time, clock
            Now, and on the schedule's clock [s].
        feet, body
            What carries, where the body should be, and the feet's ramps.
        stance
            Length of a stance [s].
        """
        N, dt = self.mpc.horizon, self.mpc.dt
        ahead = 0.0 if self.forces is None else self.dt
        tick = dt * self.rate
        # The plan is solved one step from now, so its horizon begins there; the clock of the gait runs at its
        # rate.
        start = clock + ahead * self.rate
        contacts = self.schedule.horizon(start, tick, N)
        if start < 0.0:
            contacts[start + tick * (np.arange(N) + 0.5) < 0.0] = True
        # The first step is what is, not what was planned: forces are commanded of it.
        contacts[0] = feet.stance
        for k in np.flatnonzero(feet.stance & ~feet.planned):  # landed early: carries on
            later = np.flatnonzero(contacts[1:, k])
            contacts[: 1 + (later[0] if len(later) else 0), k] = True
        reference = body.reference(N, dt, ahead)
        arms = turned_arms(self.offsets, body.yaw + body.velocity[2] * dt * np.arange(N + 1))
        places = stance_places(
            contacts, feet.stance, feet.ground, feet.target, feet.frames, self.radii, reference.position,
            arms, round(0.5 * stance / tick), body.ground, body.position, body.slope,
        )  # fmt: skip
        if self.forces is not None and not self.pending:
            # Once for every plan made: while a horizon is pending, `made` is of the plan before, whose points
            # have been moved already.
            self.mpc.shift(max(time + ahead - self.made, 0.0))
        self._horizon = reference, places, contacts
        self.begun = time

    def solve(self, time: float, now: Kinematics, frames: FloatArray, mu: float = math.inf) -> None:
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
            Friction to count on; infinite for that of the MPC [-].
        """
        assert self._horizon is not None, "set_up comes first"
        reference, places, contacts = self._horizon
        state = BodyState(now.rotation, now.com, now.com_velocity, now.angular_velocity)
        plan = self.mpc.solve(
            state, reference, places, contacts, frames,
            mu=None if mu == math.inf else np.full(len(self.radii), mu),
        )  # fmt: skip
        motion, dt = self.motion, self.mpc.dt
        motion[0], motion[1], motion[2] = now.com, now.com_velocity, now.angular_velocity
        motion[3] = (plan.linear_velocity[1] - plan.linear_velocity[0]) / dt
        motion[4] = (plan.angular_velocity[1] - plan.angular_velocity[0]) / dt
        self.forces, self.rotation, self.made, self._horizon = plan.first, now.rotation.copy(), time, None


@kernel
def ramp_shares(
    phases: FloatArray, stance: BoolArray, touching: BoolArray, carried: BoolArray, landed: FloatArray,
    time: float, elapsed: float, step: float, length: float, shares: FloatArray,
) -> int:  # fmt: skip
    """Fill (n,) shares of the largest normal force; return as a sum of 2^k the feet that landed early.

    Parameters
    ----------
    phases
        (n, 3) see `ContactSchedule.phases`.
    stance, touching
        (n,) which feet carry now, and which feel the ground.
    carried, landed
        (n,) which feet carried at the last step, and (n,) when they began to [s]: brought up.
    time, elapsed, step, length
        Now, since the last step, what is counted as carried already at a touchdown, and a ramp's length [s].
    shares
        1 for feet that do not carry. Those of feet that landed early have no end yet.
    """
    early = 0
    for k in range(shares.shape[0]):
        # The bound on the normal force is a trapezium over a stance: up from the moment it carries, down to
        # its planned lift-off, both along `length`.
        if stance[k] and not carried[k]:
            landed[k] = time
        elif stance[k] and not touching[k] and time - landed[k] + step < length:
            landed[k] += elapsed  # it may hang in the air still: more force would throw it at the ground
        carried[k] = stance[k]
        shares[k] = 1.0
        if stance[k]:
            # Early feet are still in a swing of the schedule, whose end is not that of the stance to come.
            used = time - landed[k] + step
            if phases[k, 0] > 0.0:
                used = min(used, phases[k, 2] - time)
            else:
                early |= 1 << k
            shares[k] = min(max(used / length, 0.0), 1.0)
    return early
