"""Energy along the normal, rings about the true force, and logs whose channels are not of one motion."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.audit.continuity import state_slips
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.restitution import _peak_since_touchdown, _since_touchdown, returned_work
from surefoot.records.audit.symptoms.fits import pyramid_facets
from surefoot.records.log import Log
from tests.records.audit.logs import STAND, TROT, changed, log_of


def ball(restitution: float, after: bool) -> Log:
    """Return the log of a ball that falls from 0.3 m, with velocities before or after a row's impulse."""
    dt, g, z, v, rows = 2.5e-4, 9.81, 0.3, 0.0, list[tuple[float, ...]]()
    for _ in range(6000):
        free = v - g * dt
        lands = z + dt * free < 0.0
        new = -restitution * v if lands and abs(v) > 0.1 else (0.0 if lands else free)
        rows.append(((new - free) / dt, z, new if after else v))
        v, z = new, z + dt * new
    force, gap, speed = np.array(rows).T
    vectors = np.zeros((2, len(force), 1, 3))
    vectors[0, :, 0, 2], vectors[1, :, 0, 2] = force, speed
    channels = {
        "forces": vectors[0], "contact_velocities": vectors[1], "gaps": gap[:, None],
        "mu": np.full(len(force), 0.5),
    }  # fmt: skip
    return sf.log_from_arrays(channels, dt=dt, facts={"mass": 1.0})


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize(
    ("restitution", "lawful"),
    [(0.0, True), (0.6, True), (1.0, True), (1.03, False), (1.1, False), (1.25, False)],
)
def test_a_ball_never_comes_back_higher(restitution: float, lawful: bool, after: bool) -> None:
    report = sf.audit_log(ball(restitution, after))
    assert ("restitution" not in report.laws_broken) is lawful, report.sentence
    assert lawful or "energy gain" in {s.name for s in report.symptoms}


@pytest.mark.parametrize(("depth", "lawful"), [(2e-3, True), (-2e-3, False)])
def test_a_foot_that_pushes_again_before_it_has_left_is_in_one_touch(depth: float, lawful: bool) -> None:
    """It takes 1 J at 1 m/s, is held inside soft ground without a force, and is thrown out with 0.04 J."""
    count, dt = 60, 1e-3
    force, speed, gap = np.zeros((count, 1, 3)), np.zeros((count, 1, 3)), np.full((count, 1), 0.01)
    gap[10:42] = -depth  # above the ground in between: two touches
    force[10:20, 0, 2], speed[10:20, 0, 2], gap[10:20] = 100.0, -1.0, -2e-3
    force[40, 0, 2], speed[40:42, 0, 2], gap[40:42] = 20.0, 2.0, [[-2e-3], [0.0]]
    channels = {"forces": force, "contact_velocities": speed, "gaps": gap, "mu": np.full(count, 0.5)}
    report = sf.audit_log(sf.log_from_arrays(channels, dt=dt, facts={"mass": 5.0}))
    assert ("restitution" not in report.laws_broken) is lawful, report.sentence


@pytest.mark.parametrize("e", [0.3, 1.0, 1.2])
def test_the_work_of_an_impulse_is_the_change_of_kinetic_energy(e: float) -> None:
    v = np.array([-2.0, -2.0, 2.0 * e, 2.0 * e])[:, None]
    force = np.array([0.0, 2.0 * (1.0 + e) / 1e-3, 0.0, 0.0])[:, None]
    given, _ = returned_work(force, v, np.full(4, 1e-3), force > 0.0, after=False)
    assert given[1, 0] == pytest.approx(0.5 * 4.0 * (e**2 - 1.0))


def test_a_force_that_rings_about_the_true_one_breaks_newton_s_law() -> None:
    log = log_of(STAND)
    forces = np.array(log["forces"])
    forces[100:400:2, 0] *= 2.0
    forces[101:400:2, 0] = 0.0
    assert "motion" in sf.audit_log(changed(log, forces=forces)).laws_broken


def test_positions_follow_from_velocities_in_a_tumbling_flight() -> None:
    pin = pytest.importorskip("pinocchio")
    model = sf.load_robot("go2").model
    rng, dt = np.random.default_rng(0), 1e-3
    q, v = pin.neutral(model), rng.normal(size=model.nv)
    rows = []
    for _ in range(60):
        rows.append((q.copy(), v.copy()))
        new = v + 10.0 * dt * rng.normal(size=model.nv)
        q, v = pin.integrate(model, q, 0.5 * dt * (v + new)), new
    slips = state_slips(*(np.array(part) for part in zip(*rows, strict=True)), np.full(60, dt))
    assert slips is not None
    assert np.abs(slips[:, 6:]).max() < 1e-12
    assert np.abs(slips).max() < 1e-5  # the base turns within a row


def test_a_joint_that_is_thrown_about_in_coarse_steps_is_one_motion() -> None:
    """Rules of stepping differ by half a step of the last change of speed, however fast that grows."""
    dt, still = 5e-3, np.zeros((60, 1, 3))
    v = np.concatenate([np.zeros(30), -20.0 * np.arange(1, 31)])[:, None]
    q = np.cumsum(np.vstack([np.zeros((1, 1)), dt * v[1:]]), axis=0)  # q' = q + dt v'
    for shown, lawful in ((q, True), (q + 0.8 * (np.arange(60) > 10)[:, None], False)):
        channels = {"q": shown, "v": v, "forces": still, "gaps": still[..., 0] + 1.0, "mu": np.full(60, 0.5)}
        report = sf.audit_log(sf.log_from_arrays(channels, dt=dt, facts={"mass": 5.0}))
        assert ("state" not in report.laws_broken) is lawful, report.sentence


def test_a_log_that_is_exactly_constant_is_no_stale_buffer() -> None:
    log = log_of(STAND)
    arrays = {name: np.repeat(np.array(array)[300:301], 400, axis=0) for name, array in log.arrays.items()}
    arrays["time"] = np.arange(400) * float(log.fact("dt"))
    arrays["v"] = np.zeros(arrays["v"].shape)
    arrays["contact_velocities"] = np.zeros(arrays["contact_velocities"].shape)
    arrays["forces"][:, 0, 2] = -20.0
    names = {s.name for s in sf.audit_log(Log(arrays, log.facts, channels=log.channels)).symptoms}
    assert "frozen" not in names
    assert names & {"pull", "reversed", "wrong scale", "bias", "unexplained motion"}


@pytest.mark.parametrize("facets", [4, 8])
@pytest.mark.parametrize("phase", [0.0, 0.1, 0.3, 0.6])
def test_a_pyramid_is_recognised_at_any_phase(facets: int, phase: float) -> None:
    rng = np.random.default_rng(1)
    angle = rng.uniform(0.0, 2.0 * np.pi, 400)
    sector = 2.0 * np.pi / facets
    off = (angle - phase + 0.5 * sector) % sector - 0.5 * sector
    use = np.stack([np.cos(angle), np.sin(angle)], axis=1) / np.cos(off)[:, None]
    use = use[np.hypot(*use.T) > 1.01]
    found = pyramid_facets(use, LIMITS.fits)
    assert found is not None
    assert found[0] == facets
    assert abs((found[1] - phase + 0.5 * sector) % sector - 0.5 * sector) < np.radians(3.0)


def test_one_direction_of_too_much_friction_is_no_pyramid() -> None:
    assert pyramid_facets(np.full((50, 2), [1.1, 0.2]), LIMITS.fits) is None


def test_contact_velocities_that_are_not_the_joints_break_a_law() -> None:
    log = log_of(TROT)
    velocities = np.array(log["contact_velocities"])
    velocities[:, 1] *= 1.3
    assert "contact velocity" in sf.audit_log(changed(log, contact_velocities=velocities)).laws_broken


def test_sums_and_peaks_begin_anew_at_every_touchdown() -> None:
    rng = np.random.default_rng(0)
    values, loaded = rng.uniform(0.0, 2.0, (60, 5)), rng.random((60, 5)) < 0.8
    sums, peaks = np.zeros(5), np.zeros(5)
    for t in range(60):
        sums, peaks = (
            np.where(loaded[t], new, 0.0) for new in (sums + values[t], np.maximum(peaks, values[t]))
        )
        np.testing.assert_allclose(_since_touchdown(values, loaded)[t], sums, rtol=1e-13)
        np.testing.assert_array_equal(_peak_since_touchdown(values, loaded)[t], peaks)
