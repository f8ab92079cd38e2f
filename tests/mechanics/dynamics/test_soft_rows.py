"""Rows of soft contacts by hand: a spring with a damper, its wall, and its tangents."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from surefoot.mechanics.dynamics.impacts import LostMotion
from surefoot.mechanics.dynamics.soft_impacts import Graph, SoftRows

DT, STIFFNESS, DAMPING = 0.01, 1000.0, 20.0


class Spring:
    """f = -k (gap + dt u) - d u, without regard to where it pulls."""

    def __init__(self, slope: float = DT * STIFFNESS + DAMPING) -> None:
        self.slope = slope

    def over_step(self, gaps: Any, speeds: Any, arriving: Any, dt: float) -> tuple[Any, Any]:
        del arriving
        force = -STIFFNESS * (gaps + dt * speeds) - DAMPING * speeds
        return force, np.full(np.shape(force), self.slope)


GAPS = np.array([-0.002, -0.002, 0.001, 0.003])
SPEEDS = np.array([-0.1, 0.3, -0.2, 0.0])


def graph(law: Any = None) -> Graph:
    """Return the graph of a law, a spring unless given."""
    own: Any = law or Spring()
    return Graph(own, DT, GAPS, np.array([-0.5, -0.5, -0.5, -0.5]))


def test_the_wall_is_where_the_step_ends_at_the_surface_with_the_damper_s_jump() -> None:
    """At u = -gap / dt the spring is slack, and the damper alone presses where that is downwards."""
    own = graph()
    np.testing.assert_allclose(own.wall, [0.2, 0.2, -0.1, -0.3])
    np.testing.assert_allclose(own.jump, [0.0, 0.0, DT * DAMPING * 0.1, DT * DAMPING * 0.3], atol=1e-15)


def test_impulses_press_below_the_wall_alone() -> None:
    """1000 (0.002 + 0.001) + 20 x 0.1 = 5 N, and 1000 x 0.001 + 20 x 0.2 = 5 N of the third."""
    impulses, slopes = graph().impulses(SPEEDS)
    np.testing.assert_allclose(impulses, [0.05, 0.0, 0.05, 0.0])
    np.testing.assert_allclose(slopes, [DT * 30.0, 0.0, DT * 30.0, 0.0])
    at_wall, _ = graph().impulses(np.array([0.2, 0.2, -0.1, -0.3]))
    assert not at_wall.any()
    flat, _ = graph(Spring(0.0)).impulses(SPEEDS)
    assert not flat.any()


@pytest.mark.parametrize("slope", [np.inf, np.nan])
def test_a_law_without_numbers_is_a_lost_motion(slope: float) -> None:
    with pytest.raises(LostMotion):
        graph(Spring(slope)).impulses(SPEEDS)
    lost = graph()
    lost.gaps = GAPS * np.inf
    with pytest.raises(LostMotion):
        lost.impulses(SPEEDS)


def test_rows_are_tangents_of_the_law_and_end_at_the_wall() -> None:
    """λ = 0.05 - 0.3 (u - u₀) is u + λ / 0.3 - 0.05 / 0.3 - u₀ = 0."""
    at_wall = np.array([False, False, False, True])
    rows = SoftRows(graph(), SPEEDS, at_wall)
    assert rows.on.tolist() == [True, False, True, True]
    assert rows.at_wall.tolist() == at_wall.tolist()
    np.testing.assert_allclose(rows.compliance, [1.0 / 0.3, 0.0, 1.0 / 0.3, 0.0])
    np.testing.assert_allclose(rows.bias, [-0.05 / 0.3 + 0.1, -0.2, -0.05 / 0.3 + 0.2, 0.3])
    np.testing.assert_allclose(rows.most, [np.inf, np.inf, np.inf, 0.06])
    pressed = SoftRows(graph(), SPEEDS, np.array([True, False, False, False]))
    assert pressed.compliance[0] == 0.0
    assert pressed.bias[0] == pytest.approx(-0.2)
