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
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import kernel
from surefoot.motion.control.body_motion import BodyReference
from surefoot.motion.control.mpc import BodyState, ConvexMpc
from surefoot.motion.control.whole_body import Kinematics
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.body_settings import BODY_MOTION
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.walking_body import BodyPlan
from surefoot.motion.walking.walking_feet import Feet
from surefoot.motion.walking.walking_kernels import stance_places, turned_arms


class Ramps(NamedTuple):
    """When the ramps of the feet's normal forces began, see `ramp_shares`.

    Attributes
    ----------
    landed
        (n,) time of the schedule at which each foot began to carry [s].
    stood
        (n,) which feet carried in the step before.
    time
        Time of the schedule in the step before [s].
    """

    landed: FloatArray
    stood: BoolArray
    time: float = math.inf  # no time has passed before the first step

    @staticmethod
    def of(feet: int) -> Ramps:
        """Return the ramps of so many feet that have always stood."""
        return Ramps(np.full(feet, -math.inf), np.ones(feet, dtype=bool))


class ForceHorizon(NamedTuple):
    """A plan that is set up and has still to be solved.

    Attributes
    ----------
    reference
        Of the body.
    places, contacts
        (N, n, 3), (N, n) where feet stand [m], and which.
    """

    reference: BodyReference
    places: FloatArray
    contacts: BoolArray


class ForcePlan(NamedTuple):
    """The forces and the motion that a plan begins with.

    Attributes
    ----------
    made
        Time at which it was made [s].
    forces
        (n, 3) of its first step, contact frames [N].
    motion
        (5, 3) at that time: centre of mass [m], its velocity [m/s], angular velocity [rad/s], and the
        planned accelerations [m/s²], [rad/s²].
    rotation
        (3, 3) of the body then.
    """

    made: float
    forces: FloatArray
    motion: FloatArray
    rotation: FloatArray


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
    dt
        Time between the steps of the controller [s].
    ramp
        Length of a ramp [s]; 0 for none.
    """

    def __init__(
        self, mpc: ConvexMpc, offsets: FloatArray, radii: FloatArray, dt: float, ramp: float
    ) -> None:
        self.mpc, self.offsets, self.radii, self.dt = mpc, offsets, radii, dt
        self.ramp = max(ramp, 1e-9)

    def shares(
        self, ramps: Ramps, schedule: ContactSchedule, clock: GaitClock, stance: BoolArray,
        touching: BoolArray | None = None,
    ) -> tuple[Ramps, FloatArray]:  # fmt: skip
        """Return the ramps, and the shares of the largest normal forces of (n,) feet that carry: (n,).

        To be called at every step: a foot's ramp begins when it first carries, and goes on while the foot
        feels the ground, (n,); None where that is not known, and all do.
        """
        time, ramp = clock.time, self.ramp * clock.rate
        shares, phases = np.empty(len(self.radii)), schedule.phases(time)
        elapsed = max(time - ramps.time, 0.0)
        ramps = Ramps(ramps.landed.copy(), ramps.stood.copy(), time)
        early = ramp_shares(
            phases, stance, stance if touching is None else touching, ramps.stood, ramps.landed, time,
            elapsed, BODY_MOTION.landed, ramp, shares,
        )  # fmt: skip
        for k in range(len(shares)) if early else ():
            if early >> k & 1:
                left = (_lift_off(schedule, k, time) - time) / ramp
                shares[k] = min(shares[k], max(left, 0.0))
        return ramps, shares

    def set_up(
        self, time: float, schedule: ContactSchedule, clock: GaitClock, feet: Feet, body: BodyPlan,
        stance: float, before: ForcePlan | None, pending: bool,
    ) -> ForceHorizon:  # fmt: skip
        """Return the horizon that begins at the next step; without a plan before it, at this one.

        Parameters
        ----------
        time
            Now [s].
        schedule, clock
            When feet should stand, and the time on it.
        feet, body
            What carries, and where the body should be.
        stance
            Length of a stance [s].
        before, pending
            The plan before, None for the first; whether one that is set up has still to be solved.
        """
        N, dt = self.mpc.horizon, self.mpc.dt
        ahead = 0.0 if before is None else self.dt
        tick = dt * clock.rate
        # The plan is solved one step from now, so its horizon begins there; the clock of the gait runs at its
        # rate.
        start = clock.time + ahead * clock.rate
        contacts = schedule.horizon(start, tick, N)
        if start < 0.0:
            contacts[start + tick * (np.arange(N) + 0.5) < 0.0] = True
        # The first step is what is, not what was planned: forces are commanded of it.
        on = feet.stance
        contacts[0] = on
        for k in np.flatnonzero(on & ~feet.planned):  # landed early: carries on
            later = np.flatnonzero(contacts[1:, k])
            contacts[: 1 + (later[0] if len(later) else 0), k] = True
        reference = body.reference(N, dt, ahead)
        arms = turned_arms(self.offsets, body.yaw + body.velocity[2] * dt * np.arange(N + 1))
        places = stance_places(
            contacts, on, feet.ground.copy(), feet.target, feet.frames, self.radii, reference.position, arms,
            round(0.5 * stance / tick), body.ground, body.position, body.slope,
        )  # fmt: skip
        if before is not None and not pending:
            # Once for every plan made: while a horizon is pending, the plan before is the one whose points
            # have been moved already.
            self.mpc.shift(max(time + ahead - before.made, 0.0))
        return ForceHorizon(reference, places, contacts)

    def solve(
        self, horizon: ForceHorizon, time: float, now: Kinematics, frames: FloatArray, mu: float = math.inf
    ) -> ForcePlan:
        """Return the plan of a horizon from the state of now.

        Parameters
        ----------
        horizon
            As it was set up.
        time
            Now [s].
        now
            The body.
        frames
            (n, 3, 3) of the feet's ground, rotation_world_contact.
        mu
            Friction to count on; infinite for that of the MPC [-].
        """
        state = BodyState(now.rotation, now.com, now.com_velocity, now.angular_velocity)
        plan = self.mpc.solve(
            state, *horizon, frames, mu=None if mu == math.inf else np.full(len(self.radii), mu)
        )
        motion, dt = np.empty((5, 3)), self.mpc.dt
        motion[0], motion[1], motion[2] = now.com, now.com_velocity, now.angular_velocity
        motion[3] = (plan.linear_velocity[1] - plan.linear_velocity[0]) / dt
        motion[4] = (plan.angular_velocity[1] - plan.angular_velocity[0]) / dt
        return ForcePlan(time, plan.first, motion, now.rotation.copy())


def _lift_off(schedule: ContactSchedule, k: int, time: float) -> float:
    """Return when a foot that carries is planned to lift; one that landed early, after its stance."""
    planned, _, end = schedule.phase(k, time)
    return end if planned else schedule.phase(k, end)[2]


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
