"""Products of cones act factor by factor."""

import numpy as np
import pytest

from surefoot import FrictionCone, Sole
from surefoot.contact.cones.product import ProductCone


def test_margin_is_the_least_inside_and_the_distance_outside():
    cone = ProductCone([FrictionCone(0.5), FrictionCone(1.0)])
    inside = np.array([0, 0, 10.0, 0, 0, 4.0])
    expected = min(FrictionCone(0.5).margin(inside[:3]), FrictionCone(1.0).margin(inside[3:]))
    assert cone.margin(inside) == pytest.approx(expected)
    outside = np.array([0, 0, -3.0, 0, 0, -4.0])
    assert cone.margin(outside) == pytest.approx(-5.0)


def test_empty_product():
    cone = ProductCone([])
    assert cone.dim == 0
    assert cone.contains(np.zeros(0))
    assert cone.project(np.zeros((4, 0))).shape == (4, 0)


def test_slices_follow_the_dimensions():
    cone = ProductCone([FrictionCone(0.5), Sole(0.1, 0.1, 0.5).closed_form(), FrictionCone(0.5)])
    assert [(s.start, s.stop) for s in cone.slices] == [(0, 3), (3, 9), (9, 12)]
