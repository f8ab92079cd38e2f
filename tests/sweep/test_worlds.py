"""A box in every world, held against Coulomb's law over ranges of friction, slope and softness."""

from __future__ import annotations

import math

import pytest
from scipy.integrate import solve_ivp

from surefoot.errors import ProblemError
from surefoot.spatial import GRAVITY
from surefoot.sweep import Sample, sweep_from_dict
from surefoot.sweep.experiments import make_experiment
from surefoot.sweep.experiments.worlds import coulomb_way


def content(**settings: object) -> dict[str, object]:
    ranges = {"mu": [0.1, 1.0], "slope": [-40, 40], "mass": [0.5, 2.0]}
    return {"experiment": "worlds", "seed": 1, "settings": settings, "ranges": ranges}


@pytest.mark.parametrize("mu", [0.0, 0.2, 0.7])
@pytest.mark.parametrize("degrees", [-30.0, 0.0, 20.0])
@pytest.mark.parametrize("speed", [-1.0, 0.0, 1.5])
def test_the_closed_form_solves_coulombs_equation(mu: float, degrees: float, speed: float) -> None:
    """Friction regularised at 1e-5 m/s, integrated by SciPy's Radau method."""
    along, grip = GRAVITY * math.sin(math.radians(degrees)), mu * GRAVITY * math.cos(math.radians(degrees))
    found = solve_ivp(
        lambda t, x: [x[1], -along - grip * math.tanh(x[1] / 1e-5)],
        (0.0, 0.6), [0.0, speed], method="Radau", rtol=1e-7, atol=1e-9,
    )  # fmt: skip
    assert coulomb_way(mu, degrees, speed, 0.6) == pytest.approx(found.y[0, -1], abs=2e-5)


def test_the_rigid_world_keeps_to_coulombs_law_everywhere() -> None:
    config = sweep_from_dict(content(world="rigid"))
    for sample in config.space.sample(range(16)):
        result = config.experiment.run(sample)
        assert result["off"] < 0.5 * GRAVITY * 0.5 * 1e-3  # half a step's change of speed, all the way
        assert result["agrees"]
        assert result["depth_max"] < 1e-9


def test_a_soft_ground_is_off_by_more_the_softer_it_is() -> None:
    pytest.importorskip("mujoco")
    experiment = make_experiment("worlds", {"world": "mujoco"})
    results = [
        experiment.run(Sample(0, 1, {"mu": 0.5, "slope": 10.0, "time_constant": seconds}))
        for seconds in (0.004, 0.04, 0.2)
    ]
    off, depths = ([result[name] for result in results] for name in ("off", "depth_max"))
    assert off == sorted(off)
    assert depths == sorted(depths)
    assert [result["agrees"] for result in results] == [True, True, False]


@pytest.mark.parametrize(
    ("settings", "ranges", "told"),
    [
        ({"world": "bullet"}, {}, "unknown world 'bullet'"),
        ({"tolerance": -1.0}, {}, "tolerance"),
        ({"world": "drake"}, {"time_constant": [0.01, 0.1]}, "time_constant is of world mujoco"),
        ({}, {"stiffness": 1e5}, "stiffness is of world rigid, the settings say world mujoco"),
        ({}, {"com_x": [0.0, 0.1]}, "unknown parameter of worlds 'com_x'"),
    ],
)
def test_wrong_settings(settings: dict[str, object], ranges: dict[str, object], told: str) -> None:
    with pytest.raises(ProblemError, match=told):
        sweep_from_dict({"experiment": "worlds", "settings": settings, "ranges": ranges})
