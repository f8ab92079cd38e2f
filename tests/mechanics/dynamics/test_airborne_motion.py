from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.dynamics.airborne_motion import fly, follow_shape
from surefoot.worlds.rigid.bodies import box

RATES = np.linspace(3.0, 9.0, 12)


def legs(robot):
    """Legs that swing out and back: positions, velocities and accelerations over time."""
    mean, swing = robot.nominal[7:], 0.3 * np.sin(np.arange(12))

    def shape(t):
        return mean + swing * (1 - np.cos(RATES * t)), swing * RATES * np.sin(RATES * t)

    def acceleration(t, _q, _v):
        return swing * RATES**2 * np.cos(RATES * t)

    return shape, acceleration


def test_momentum_is_kept_under_any_torques(go2):
    rng = np.random.default_rng(0)
    v = rng.normal(size=18)
    amplitude, phase = 2.0 * rng.normal(size=12), rng.uniform(0, 6, 12)
    flight = fly(
        go2,
        go2.nominal,
        v,
        0.3,
        dt=5e-4,
        torque=lambda t, q, v: amplitude * np.sin(20 * t + phase) - 0.1 * v[6:],
    )
    drift = flight.momentum - flight.momentum[0]
    drift[:, 2] += go2.mass * 9.81 * flight.time
    assert np.abs(drift).max() < 1e-9
    assert np.abs(flight.v[-1] - v).max() > 1.0  # the legs did move
    fall = flight.com[0] + flight.momentum[0, :3] / go2.mass * 0.3 - [0, 0, 0.5 * 9.81 * 0.09]
    assert np.abs(flight.com[-1] - fall).max() < 1e-9


def test_dynamics_and_kinematics_tell_the_same_story(go2):
    """Forces from M and h on one side, conservation of momentum on the other."""
    shape, acceleration = legs(go2)
    carried = np.array([1.0, 0.0, 30.0, 0.2, -3.0, 0.5])
    kinematic = follow_shape(go2, go2.nominal, shape, 0.4, carried=carried, gravity=True)
    dynamic = fly(go2, kinematic.q[0], kinematic.v[0], 0.4, joint_acceleration=acceleration)
    assert np.abs(kinematic.q - dynamic.q).max() < 1e-8
    assert np.abs(dynamic.momentum[:, 3:] - carried[3:]).max() < 1e-9
    assert np.abs(kinematic.momentum[-1, :2] - carried[:2]).max() < 1e-9


def test_fourth_order(go2):
    shape, acceleration = legs(go2)
    start = follow_shape(go2, go2.nominal, shape, 0.01, carried=np.array([0, 0, 0, 1.0, 2.0, 3.0]))
    ends = [
        fly(go2, start.q[0], start.v[0], 0.2, joint_acceleration=acceleration, dt=dt).q[-1]
        for dt in (0.02, 0.01, 0.005, 0.0005)
    ]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:3]]
    assert 3.5 < np.log2(errors[0] / errors[1]) < 5.0
    assert 3.5 < np.log2(errors[1] / errors[2]) < 5.0


def test_free_body_keeps_energy_and_direction_of_momentum():
    body = box(1.0, (0.1, 0.2, 0.4))
    v = np.array([0, 0, 0, 0.1, 8.0, 0.1])  # about the middle axis: it flips over and over
    flight = fly(body, body.nominal, v, 3.0, torque=lambda *_: np.zeros(0))
    inertia = np.array(body.model.inertias[1].inertia)
    energy = 0.5 * np.einsum("ni,ij,nj->n", flight.v[:, 3:], inertia, flight.v[:, 3:])
    assert np.ptp(energy) < 1e-8 * energy[0]
    assert np.abs(flight.momentum[:, 3:] - flight.momentum[0, 3:]).max() < 1e-9
    assert flight.v[:, 4].min() < -7.0


def test_bad_input(go2):
    with pytest.raises(sf.ProblemError, match="either torque or joint_acceleration"):
        fly(go2, go2.nominal, np.zeros(18), 0.1)
    arm = sf.load_robot("panda")
    with pytest.raises(sf.ProblemError, match="does not fly"):
        fly(arm, arm.nominal, np.zeros(9), 0.1, torque=lambda *_: np.zeros(9))
