"""Piles of random bodies: every law at every step, no body in another, no energy from nowhere."""

from __future__ import annotations

from itertools import combinations

import coal
import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.collision import Box, Capsule, Sphere
from surefoot.worlds.rigid.scene import Body, Scene, SceneWorld


def thrown(rng, count, **surface):
    """Bodies of random shape, mass, spin and place above each other."""
    bodies = []
    for k in range(count):
        shape = (
            Sphere(rng.uniform(0.03, 0.1)),
            Box(tuple(rng.uniform(0.05, 0.2, 3))),
            Capsule(rng.uniform(0.02, 0.06), rng.uniform(0.05, 0.3)),
        )[rng.integers(3)]
        turn, place = rng.normal(size=4), np.array([*rng.uniform(-0.1, 0.1, 2), 0.4 + 0.3 * k])
        bodies.append(
            Body(
                f"b{k}",
                shape,
                float(10.0 ** rng.uniform(-1, 1)),
                tuple(place),
                tuple(turn / np.linalg.norm(turn)),
                tuple(0.5 * rng.normal(size=3)),
                tuple(3.0 * rng.normal(size=3)),
                **surface,
            )
        )
    return bodies


def deepest(world, bodies):
    """How far two bodies are in each other, by coal alone [m]."""
    solids = {b.name: b.shape.solid() for b in bodies}
    poses = {
        b.name: coal.Transform3s(world.pose(b.name).rotation, world.pose(b.name).position) for b in bodies
    }
    return max(
        -coal.distance(
            solids[a], poses[a], solids[b], poses[b], coal.DistanceRequest(), coal.DistanceResult()
        )
        for a, b in combinations(solids, 2)
    )


@pytest.mark.parametrize(
    ("seed", "terrain", "dt"),
    [
        (0, None, 1e-3),
        (1, None, 5e-3),
        (2, sf.SlopeTerrain(15.0), 1e-3),
        (3, sf.StairsTerrain(0.1, 0.3, 3), 1e-3),
        (5, sf.StairsTerrain(-0.1, 0.3, 3), 1e-3),
    ],
)
def test_piles_obey_every_law(seed, terrain, dt):
    rng = np.random.default_rng([8, seed])
    bodies = thrown(rng, 7, friction=float(rng.uniform(0.1, 0.9)))
    world, unsolved = SceneWorld(Scene(bodies), terrain, mu=0.5, dt=dt), 0
    energy, weight = world.energy(), 9.81 * sum(b.mass for b in bodies)
    heaviest = max(b.mass for b in bodies)
    for k in range(round(0.9 / dt)):
        world.step()
        step = world.last
        unsolved += step.unsolved
        assert step.worst_residual < 1e-6
        assert step.impulses[:, 2].min(initial=0.0) > -1e-8 * heaviest  # the solver's tolerance is a velocity
        assert step.gaps.min(initial=0.0) > -2e-6
        assert step.contact_work < 1e-7
        slack = np.abs(np.minimum(step.impulses[:, 2] / (weight * dt), step.velocities[:, 2]))
        assert slack[step.gaps < 0.0].max(initial=0.0) < 1e-6
        assert world.energy() <= energy + 1e-6 * weight + 1e-2 * weight * dt * dt
        energy = world.energy()
        if k % 50 == 0:
            assert deepest(world, bodies) < 10.0 * dt * dt + 1e-5
    assert unsolved <= 1


@pytest.mark.parametrize(
    ("seed", "terrain"),
    [
        (141, sf.StairsTerrain(0.1, 0.3, 3)),  # a rolling box: its edge leaves, its face is caught
        (139, sf.StairsTerrain(-0.1, 0.3, 3)),
        (147, None),  # turned into the ground by 31 um
    ],
)
def test_at_5_ms_all_energy_that_is_made_is_accounted_for(seed, terrain):
    """Two sources, both of second order in dt, and no other.

    What a turning body moves out of another is lifted: the projection's potential energy. And a contact that
    comes up at u < g dt is caught by an impulse of at most m (g dt - u), at a mean speed of u / 2: together
    at most m g^2 dt^2 / 8.
    """
    rng, dt = np.random.default_rng([8, seed]), 5e-3
    bodies = thrown(rng, 7, friction=float(rng.uniform(0.1, 0.9)))
    world = SceneWorld(Scene(bodies), terrain, mu=0.5, dt=dt)
    energy, moved = world.energy(), world.stepper.bodies
    caught, rest = 9.81**2 * dt * dt / 8.0 * sum(b.mass for b in bodies), np.zeros(world.model.nv)
    for _ in range(round(0.9 / dt)):
        q, v = world.q_v()
        world.step()
        impact, lifted = world.last.impact, 0.0
        if impact is not None:
            coasted = moved.coasting.advance(q, v, 0.5 * dt).q
            lifted = moved.energy(impact.q, rest) - moved.energy(coasted, rest)
        assert world.last.gaps.min(initial=0.0) > -2e-6
        assert world.energy() <= energy + max(lifted, 0.0) + caught
        energy = world.energy()


def test_a_heavy_body_on_a_light_one_stands():
    """A thousand times as heavy."""
    cube = Box((0.2, 0.2, 0.2))
    world = SceneWorld(
        Scene([Body("light", cube, 0.1, (0, 0, 0.1)), Body("heavy", cube, 100.0, (0, 0, 0.3))])
    )
    for _ in range(200):
        world.step()
    assert np.abs(world.q_v()[1]).max() < 1e-8
    assert world.unsolved == 0


def test_bodies_that_start_in_each_other_are_parted():
    cube = Box((0.2, 0.2, 0.2))
    world = SceneWorld(Scene([Body("a", cube, 1.0, (0, 0, 0.1)), Body("b", cube, 1.0, (0.01, 0, 0.29))]))
    world.step()
    assert world.pose("b").position[2] - world.pose("a").position[2] > 0.2 - 1e-5
    assert np.abs(world.q_v()[1]).max() < 1e-6
