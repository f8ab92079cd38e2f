"""Spheres over ground: gaps, nearest points and frames by hand, and what contacts make of velocities."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.mechanics.dynamics.detection import Contacts, GroundBelow
from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain, Terrain

RADII = np.array([0.1, 0.2])
CENTRES = np.array([[1.0, 2.0, 0.5], [-1.0, 0.0, 0.1]])


def test_level_ground_is_a_radius_below_the_height_of_a_sphere() -> None:
    ground = GroundBelow(FlatTerrain(), RADII)
    gaps, frames = ground.below(CENTRES)
    np.testing.assert_allclose(gaps, [0.4, -0.1])
    np.testing.assert_array_equal(frames, np.broadcast_to(np.eye(3), (2, 3, 3)))
    np.testing.assert_allclose(ground.nearest(CENTRES), [[1.0, 2.0, 0.4], [-1.0, 0.0, -0.1]])
    np.testing.assert_allclose(ground.above, RADII)


def test_a_slope_s_gap_is_along_its_normal() -> None:
    """z cos a - x sin a, less the radius."""
    angle = math.radians(20.0)
    c, s = math.cos(angle), math.sin(angle)
    ground = GroundBelow(SlopeTerrain(20.0), RADII)
    gaps, frames = ground.below(CENTRES)
    np.testing.assert_allclose(gaps, CENTRES[:, 2] * c - CENTRES[:, 0] * s - RADII, atol=1e-12)
    normal = np.array([-s, 0.0, c])
    np.testing.assert_allclose(frames[:, :, 2], [normal, normal], atol=1e-12)
    np.testing.assert_allclose(ground.nearest(CENTRES), CENTRES - RADII[:, None] * normal, atol=1e-12)


class Bowl(Terrain):
    """z = (x² + y²) / 2."""

    def height(self, xy: np.ndarray) -> np.ndarray:  # type: ignore[override]
        return np.asarray(0.5 * (np.asarray(xy) ** 2).sum(axis=-1))

    def gradient(self, xy: np.ndarray) -> np.ndarray:  # type: ignore[override]
        return np.array(xy)


def test_curved_ground_is_the_tangent_plane_below_the_centre() -> None:
    ground = GroundBelow(Bowl(), RADII)
    centres = np.array([[0.75, 0.0, 1.0], [0.0, 0.0, 0.2]])
    gaps, frames = ground.below(centres)
    # a slope of 3 / 4: normal (-0.6, 0, 0.8), height 9 / 32 below the first
    np.testing.assert_allclose(gaps, [0.8 * (1.0 - 9.0 / 32.0) - 0.1, 0.0], atol=1e-9)
    np.testing.assert_allclose(frames[0, :, 2], [-0.6, 0.0, 0.8], atol=1e-9)
    np.testing.assert_allclose(frames[1], np.eye(3), atol=1e-9)
    np.testing.assert_allclose(ground.nearest(centres), [[0.81, 0.0, 0.92], [0.0, 0.0, 0.0]], atol=1e-9)
    assert not ground.above.size


def test_a_plane_above_the_origin_lifts_what_stands_on_it() -> None:
    class Table(FlatTerrain):
        def height(self, xy: np.ndarray) -> np.ndarray:  # type: ignore[override]
            return np.asarray(np.full(np.shape(xy)[:-1], 0.3))

    gaps, _ = GroundBelow(Table(), RADII).below(CENTRES)
    np.testing.assert_allclose(gaps, [0.1, -0.4], atol=1e-12)


def test_velocities_and_efforts_are_dual() -> None:
    rng = np.random.default_rng(0)
    contacts = Contacts(np.zeros(2), CENTRES, np.tile(np.eye(3), (2, 1, 1)), rng.normal(size=(6, 5)))
    v, forces = rng.normal(size=5), rng.normal(size=(2, 3))
    moved = contacts.velocities(v)
    assert moved.shape == (2, 3)
    assert moved[1, 2] == pytest.approx(contacts.J[5] @ v)
    assert contacts.effort(forces) @ v == pytest.approx((forces * moved).sum())
    kept = contacts.kept()
    for own, other in zip(kept, contacts, strict=True):
        assert np.array_equal(own, other)
        assert not np.shares_memory(own, other)
