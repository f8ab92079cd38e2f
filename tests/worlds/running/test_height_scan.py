"""The range sensor: rays against closed forms, what edges hide, rate, latency and errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.spatial import quaternion_from_rotation, rotation_about, rotation_from_quaternion
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain, StairsTerrain
from surefoot.worlds.running.height_scan import ActiveRangeSensor, RangeSensor, cast_rays

PERFECT = RangeSensor().scaled(0.0)
PERFECT = replace(PERFECT, dropped=0.0)


def test_rays_meet_a_plane_where_algebra_says() -> None:
    rng, slope = np.random.default_rng(0), SlopeTerrain(15.0)
    rays = rng.normal(size=(300, 3))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    origin, normal = np.array([0.1, 0.2, 0.7]), slope.normal([0.0, 0.0])
    with np.errstate(divide="ignore"):
        wanted = -(origin @ normal) / (rays @ normal)
    wanted = np.where((wanted > 0.0) & (wanted < 1.95), wanted, np.inf)
    found = cast_rays(slope, origin, rays, 2.0)
    sure = ~((found < np.inf) & (found > 1.9))
    assert found[sure] == pytest.approx(wanted[sure], abs=1e-3)


def test_an_edge_hides_what_lies_behind_it() -> None:
    down = StairsTerrain(-0.2, 0.5, 1)  # the ground drops by 0.2 m at x = 0
    origin = np.array([-0.4, 0.0, 0.4])
    angles = np.linspace(0.2, 1.4, 400)
    rays = np.column_stack([np.cos(angles), np.zeros(400), -np.sin(angles)])
    far = cast_rays(down, origin, rays, 1.2)
    hits = origin + far[far < np.inf, None] * rays[far < np.inf]
    low = hits[hits[:, 2] < -0.1]
    assert low[:, 0].min() > 0.2 - 0.04  # the ray over the edge falls 0.4 m in 0.4 m, 0.2 m more behind it
    assert (hits[:, 2] > -0.01).any()


def test_points_of_a_perfect_sensor_lie_on_the_ground(go2: Robot) -> None:
    slope = SlopeTerrain(8.0)
    sensor = ActiveRangeSensor(PERFECT, go2, slope, 0.001, 1)
    q = go2.nominal.copy()
    q[3:7] = quaternion_from_rotation(rotation_about(np.array([0.0, 0.0, 1.0]), 0.7))
    scans = [sensor.look(q, 0.001 * k) for k in range(60)]
    assert [k for k, scan in enumerate(scans) if scan is not None] == [40]  # 40 ms late
    scan = scans[40]
    assert scan is not None
    assert scan.time == 0.0
    points = q[:3] + scan.points @ rotation_from_quaternion(q[3:7]).T
    assert len(points) > 500
    assert np.abs(points[:, 2] - slope.height(points[:, :2])).max() < 0.01


def test_a_real_sensor_is_off_by_as_much_as_it_says(go2: Robot) -> None:
    errors = []
    for seed in range(12):
        sensor = ActiveRangeSensor(RangeSensor(latency=0.0, stray=0.0), go2, FlatTerrain(), 0.001, seed)
        scan = sensor.look(go2.nominal, 0.0)
        assert scan is not None
        errors.append((go2.nominal[2] + scan.points[:, 2]) / np.sqrt(scan.variances))
    scatter = np.concatenate([e - e.mean() for e in errors]).std()
    assert 0.5 < scatter < 1.6
    assert np.std([e.mean() for e in errors]) > 0.3  # its mounting's errors differ from run to run


@pytest.mark.parametrize(
    "wrong", [{"rate": 0.0}, {"reach": 0.0}, {"across": 200.0}, {"dropped": 0.9, "stray": 0.2}, {"rows": 1}]
)
def test_sensors_that_cannot_be_are_refused(go2: Robot, wrong: dict[str, float]) -> None:
    with pytest.raises(ProblemError):
        ActiveRangeSensor(replace(RangeSensor(), **wrong), go2, FlatTerrain(), 0.001, 0)  # type: ignore[arg-type]
