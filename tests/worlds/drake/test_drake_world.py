"""The world in Drake's own process: the same robot, the same conventions."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.cli.main import main
from surefoot.base.errors import ModelError, ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.contact.laws.soft import SpringDamper
from surefoot.mechanics.terrain import rough_ground
from surefoot.worlds.drake import drake_python
from surefoot.worlds.drake.drake_world import DrakeWorld
from surefoot.worlds.rigid.bodies import ball
from tests.worlds.running.engine_worlds import contacts_after, flight_errors

pytestmark = pytest.mark.skipif(
    not drake_python.present(), reason="Drake is not here; SUREFOOT_DRAKE_PYTHON names a Python with it"
)


def test_flight_is_pinocchios() -> None:
    """In the air, with motors and a push, Drake's error is that of semi-implicit Euler: first order in dt."""
    errors = flight_errors(DrakeWorld, (2e-3, 1e-3), 1e-4)
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert errors[1] < 0.05


def test_a_payload_weighs_and_rests() -> None:
    world = DrakeWorld(ball(2.0, 0.1), payload=1.0)
    reading = contacts_after(world, 300)
    assert reading.forces[0, 2] == pytest.approx(3.0 * GRAVITY, rel=1e-4)
    assert -1e-5 < reading.gaps[0] < 0.0
    assert world.time == pytest.approx(0.3)


def test_friction_can_change() -> None:
    world, stops = DrakeWorld(ball(2.0, 0.1), mu=0.5), []
    for mu in (0.5, 0.1):
        world.set_friction(mu)
        world.reset(world.robot.nominal, np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
        stops.append(contacts_after(world, 50).forces[0])
    for force, mu in zip(stops, (0.5, 0.1), strict=True):
        assert np.linalg.norm(force[:2]) == pytest.approx(mu * force[2], rel=1e-3)


def test_contact_in_drakes_words() -> None:
    words = sf.translate(SpringDamper(1e4, 100.0), "drake", 2.0).parameters
    world = DrakeWorld(ball(2.0, 0.1), contact=words)
    assert contacts_after(world, 1000).gaps[0] == pytest.approx(-2.0 * GRAVITY / 1e4, rel=1e-4)
    with pytest.raises(ProblemError, match="valid names: lagged, sap, similar, tamsi"):
        DrakeWorld(ball(), contact={"discrete_contact_approximation": "soft", "each_body": {}})


def test_ground_that_it_does_not_take() -> None:
    with pytest.raises(ModelError, match="takes planes and boxes"):
        DrakeWorld(ball(), rough_ground(1, 0.03))


@pytest.mark.parametrize(
    "words", [["stand", "go2", "--duration", "1", "--slope", "10"], ["walk", "go2", "--duration", "1.5"]]
)
def test_robots_stand_and_walk_there(
    words: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    options = ["--world", "drake", "--no-video", "--no-report", "--json", "--out", str(tmp_path)]
    assert main([*words, *options]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["outcome"] in ("stood", "walked")


@pytest.mark.parametrize(
    ("contact", "told"),
    [
        (3, "contact must be a mapping"),
        ({}, "contact must be a mapping with one named each_body"),
        ({"each_body": {}}, "unknown discrete_contact_approximation 'None'"),
        (
            {"each_body": {"stiffness": 1.0}, "discrete_contact_approximation": "sap"},
            "unknown proximity property",
        ),
        (
            {"each_body": {"point_contact_stiffness": 0.0}, "discrete_contact_approximation": "sap"},
            "point_contact_stiffness must be positive",
        ),
    ],
)
def test_contacts_that_drake_has_not(contact: object, told: str) -> None:
    with pytest.raises(ProblemError, match=told):
        DrakeWorld(ball(), contact=contact)  # type: ignore[arg-type]


def test_numbers_that_drake_cannot_take() -> None:
    for words in ({"mu": np.inf}, {"payload": np.inf}, {"dt": np.nan}):
        with pytest.raises(ProblemError, match=next(iter(words))):
            DrakeWorld(ball(), **words)  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="terrain must be a Terrain"):
        DrakeWorld(ball(), "slope:10")  # type: ignore[arg-type]


def test_a_closed_world_says_so() -> None:
    world = DrakeWorld(ball())
    world.step(np.zeros(0))
    here = world.q_v()[0]
    world.close()
    with pytest.raises(ModelError, match="this drake world is closed"):
        world.step(np.zeros(0))
    with pytest.raises(ModelError, match="this drake world is closed"):
        world.set_friction(0.1)
    assert world.q_v()[0] == pytest.approx(here)
