"""52.5: centroidal momentum, composite inertia, and the rate of momentum."""

from __future__ import annotations

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near, short

PROPERTIES = Properties()
holds = PROPERTIES.holds


def _rotation(rng: np.random.Generator) -> np.ndarray:
    found, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return found if np.linalg.det(found) > 0 else found[:, [1, 0, 2]]


def _links(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return masses, places and inertias of links, each inertia that of three pairs of points."""
    n = int(rng.integers(2, 7))
    inertias = []
    for _ in range(n):
        turn, size = _rotation(rng), rng.uniform(0.01, 0.3, 3)
        inertias.append(turn @ np.diag([size[1] + size[2], size[0] + size[2], size[0] + size[1]]) @ turn.T)
    return rng.uniform(0.2, 8, n), rng.normal(size=(n, 3)) * 0.5, np.array(inertias)


@holds("52.5.1", "the matrix gives the momentum that the links have one by one")
def _check_sum_over_links(answer: Answer, rng: np.random.Generator) -> None:
    (masses, places, inertias), R = _links(rng), _rotation(rng)
    axes, v = str(rng.choice(["local", "world"])), rng.normal(size=6)
    speed, spin = (R @ v[:3], R @ v[3:]) if axes == "local" else (v[:3], v[3:])
    places_w = places @ R.T
    velocities = speed + np.cross(spin, places_w)
    centre, mean = masses @ places_w / masses.sum(), masses @ velocities / masses.sum()
    angular = np.zeros(3)
    for m, x, u, own in zip(masses, places_w, velocities, inertias, strict=True):
        angular += m * np.cross(x - centre, u - mean) + R @ own @ R.T @ spin
    found = answer.numbers((6, 6), "momentum_matrix", masses, places, inertias, R, axes) @ v
    near(found[:3], masses.sum() * mean, "the linear momentum")
    near(found[3:], angular, "the angular momentum")


@holds("52.5.1", "the linear block is m R with base axes, m 1 with world axes")
def _check_linear_block(answer: Answer, rng: np.random.Generator) -> None:
    mass, R, axes, v = (
        rng.uniform(1, 80),
        _rotation(rng),
        str(rng.choice(["local", "world"])),
        rng.normal(size=3),
    )
    found = answer.numbers((3, 3), "linear_block", mass, R, axes) @ v
    near(found, mass * (R @ v if axes == "local" else v), "block times velocity")


@holds("52.5.2", "the centre of mass has no first moment")
def _check_no_first_moment(answer: Answer, rng: np.random.Generator) -> None:
    masses, places, _ = _links(rng)
    centre = answer.numbers((3,), "centre_of_mass", masses, places)
    moment = masses @ (places - centre)
    expect(np.abs(moment).max() < 1e-5 * masses.sum(), f"the first moment is {short(moment)}, expected zero")


@holds("52.5.2", "spun about any axis the links have the energy of the composite inertia")
def _check_energy(answer: Answer, rng: np.random.Generator) -> None:
    (masses, places, inertias), spin = _links(rng), rng.normal(size=3)
    centre = masses @ places / masses.sum()
    speeds = np.linalg.norm(np.cross(spin, places - centre), axis=1)
    energy = 0.5 * masses @ speeds**2 + 0.5 * sum(spin @ own @ spin for own in inertias)
    found = answer.numbers((3, 3), "composite_inertia", masses, places, inertias)
    near(found, found.T, "the matrix")
    near(0.5 * spin @ found @ spin, energy, "the energy")


@holds("52.5.2", "moving all links by the same way changes nothing")
def _check_moved(answer: Answer, rng: np.random.Generator) -> None:
    (masses, places, inertias), way = _links(rng), rng.normal(size=3) * 5
    here = answer.numbers((3, 3), "composite_inertia", masses, places, inertias)
    near(
        answer.numbers((3, 3), "composite_inertia", masses, places + way, inertias),
        here,
        "the inertia, moved",
    )


@holds("52.5.2", "stretched legs have more of it than tucked ones")
def _check_stretched(answer: Answer, rng: np.random.Generator) -> None:
    (masses, places, inertias), more = _links(rng), rng.uniform(1.1, 2.0)
    tucked = answer.numbers((3, 3), "composite_inertia", masses, places, inertias)
    stretched = answer.numbers((3, 3), "composite_inertia", masses, more * places, inertias)
    expect(np.trace(stretched) > np.trace(tucked), "stretching the links has not raised it")


@holds("52.5.3", "the rate is that of points with internal forces, each moving by Newton's law")
def _check_points(answer: Answer, rng: np.random.Generator) -> None:
    n = int(rng.integers(3, 9))
    masses, places = rng.uniform(0.2, 4, n), rng.normal(size=(n, 3)) + rng.normal(size=3) * 3
    feet = int(rng.integers(1, min(n, 4)))
    forces = np.zeros((n, 3))
    forces[:feet] = rng.normal(size=(feet, 3)) * 50 + [0, 0, 80]
    inner = np.zeros((n, 3))
    for i in range(n):
        for j in range(i):
            pull = rng.normal() * 20 * (places[j] - places[i])
            inner[i] += pull
            inner[j] -= pull
    accelerations = (forces + inner) / masses[:, None] + [0, 0, -9.81]
    com = masses @ places / masses.sum()
    right = np.r_[masses @ accelerations, np.cross(places - com, masses[:, None] * accelerations).sum(axis=0)]
    found = answer.numbers((6,), "momentum_rate", com, masses.sum(), places[:feet], forces[:feet])
    near(found[:3], right[:3], "the rate of linear momentum")
    near(found[3:], right[3:], "the rate of angular momentum")


@holds("52.5.3", "in flight linear momentum falls and angular momentum stays")
def _check_flight(answer: Answer, rng: np.random.Generator) -> None:
    mass, com = rng.uniform(1, 80), rng.normal(size=3) * 5
    found = answer.numbers((6,), "momentum_rate", com, mass, np.zeros((0, 3)), np.zeros((0, 3)))
    near(found, np.r_[0, 0, -9.81 * mass, 0, 0, 0], "the rate")
