"""What the contact-implicit controller minimises; what is in it decides the gait.

There is no schedule, no phase and no foothold in this cost. A trot comes out of five choices together:

- the body should move at the commanded speed, level and at its height, which no standing foot can for long;
- feet near the ground should not slip (`slip`), so one that has to move is lifted first;
- diagonal legs should use the same torques, mirrored (`diagonal`), and move alike (`diagonal_speed`): without
  it other gaits come out, and irregular ones;
- joints should stay near the nominal pose (`hip`, `knee`), which brings every foot back below its hip;
- torques are measured from those that hold the robot, spread over all feet (`torque`).

Source of the terms: G. Kim, D. Kang, J.-H. Kim, S. Hong, H.-W. Park, "Contact-implicit model predictive
control: controlling diverse quadruped motions without pre-planned contact modes or trajectories", IJRR 2024,
arXiv 2312.08961 (foot slip and clearance, symmetric control); weights are our own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ModelError
from surefoot.mechanics import Robot
from surefoot.motion.planning.shooting.costs import Costs, FootCost, JointCost, StateCost, TorqueCost
from surefoot.motion.planning.shooting.initial_torques import holding_torques


@dataclass(frozen=True)
class WalkWeights:
    """Weights of a walking cost, of half the squares of what they stand for, at every knot.

    Attributes
    ----------
    height, tilt, heading
        Of the base's height [1/m²], roll and pitch, and yaw [1/rad²].
    forward, vertical, spin
        Of the base's horizontal and vertical speed [s²/m²] and turning rate [s²/rad²], less the commanded.
    hip, knee
        Of the first joint of each leg and of the others, less the nominal pose [1/rad²].
    joint_speed
        [s²/rad²].
    slip, width
        Tangential speed of a foot near the ground [s²/m²], and the gap over which that fades [m].
    landing, landing_width
        Of a foot's normal speed near the ground [s²/m²], and the gap over which that fades [m].
    torque
        Of torques less those that hold the robot [1/(N m)²].
    diagonal
        Of the difference of diagonal legs' torques, mirrored [1/(N m)²].
    diagonal_speed
        Of the difference of their joint speeds, mirrored [s²/rad²].
    terminal
        Weights of the last state, in units of those of the others.
    """

    height: float = 147.0
    tilt: float = 130.0
    heading: float = 50.0
    forward: float = 40.0
    vertical: float = 8.0
    spin: float = 3.5
    hip: float = 21.0
    knee: float = 1.6
    joint_speed: float = 0.0042
    slip: float = 0.8
    width: float = 0.016
    landing: float = 0.5
    landing_width: float = 0.016
    torque: float = 0.004
    diagonal: float = 0.006
    diagonal_speed: float = 0.0092
    terminal: float = 0.3


def walking_costs(robot: Robot, q: FloatArray, weights: WalkWeights) -> Costs:
    """Return the cost of walking with a pose q (nq,) in the middle; wanted velocities are written in later.

    Raises
    ------
    ModelError
        For a robot without four legs of three joints.
    """
    if not robot.floating or robot.joints != 12 or len(robot.feet) != 4:
        raise ModelError(f"contact-implicit walking is for four legs of three joints, not for {robot.name}")
    w, state = weights, np.zeros(36)
    state[2], state[3:5], state[5] = w.height, w.tilt, w.heading
    state[6:18] = np.tile([w.hip, w.knee, w.knee], 4)
    state[18:20], state[20], state[21:24], state[24:] = w.forward, w.vertical, w.spin, w.joint_speed
    alike = _diagonal_legs(robot)
    coupling = np.zeros((24, 24))
    coupling[12:, 12:] = w.diagonal_speed * alike
    return Costs(
        StateCost(state, w.terminal * state, q),
        TorqueCost(w.torque, w.diagonal * alike, holding_torques(robot, q)),
        FootCost(w.slip, w.width, landing=w.landing, landing_width=w.landing_width),
        JointCost(10.0, 0.1, coupling=coupling if coupling.any() else None),
    )


def _diagonal_legs(robot: Robot) -> FloatArray:
    """Return (12, 12) D with zᵀ D z the squared differences of diagonal legs' joints, hips mirrored.

    Legs are the chains of three joints that carry the feet; a foot's diagonal is the one on the other side
    and at the other end of the robot.
    """
    places = robot.foot_positions(robot.nominal)[:, :2] - robot.com(robot.nominal)[:2]
    mirror, D = np.array([-1.0, 1.0, 1.0]), np.zeros((12, 12))
    legs = [np.flatnonzero(row[6:]) for row in robot.contact_points.foot_support]
    for a in range(4):
        b = int(np.argmin(places @ places[a]))
        for joint in range(3):
            row = np.zeros(12)
            row[legs[a][joint]], row[legs[b][joint]] = 1.0, -mirror[joint]
            D += 0.5 * np.outer(row, row)  # every pair is met twice
    return D
