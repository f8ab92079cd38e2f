"""Audits of tosses: lawful ones are lawful within noise, spoilt frames are found, and nothing else is."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.problems.tosses import random_tosses
from surefoot.errors import ProblemError
from surefoot.estimation.toss_audit import audit_tosses
from surefoot.estimation.tosses import Cube, Tosses

MU, ROUND = 0.2, 0.05
DT = 1.0 / 148.0


@pytest.fixture(scope="module")
def lawful() -> Tosses:
    return random_tosses(24, [MU, 0.1, ROUND], seed=5, ground=(0.003, 0.01, -0.005))


@pytest.mark.parametrize(
    ("values", "seed", "noise"),
    [([0.4, 0.0, 0.0], 1, 1.0), ([0.25, 0.4, 0.15], 2, 1.2), ([0.3, 0.1, 0.0], 3, 0.0)],
)
def test_noise_explains_every_frame_of_lawful_tosses(values: list[float], seed: int, noise: float) -> None:
    found = audit_tosses(random_tosses(24, values, seed=seed, noise=noise))
    assert found.lawful
    assert (found.explained, found.violations, found.tosses) == (found.frames, (), {})
    assert found.exact < found.frames  # without noise no recording is lawful
    assert {name: law.beyond for name, law in found.laws.items()} == dict.fromkeys(found.laws, 0)


def shifted(tosses: Tosses, toss: int, frame: int, by: list[float], count: int = 1) -> Tosses:
    """Return tosses with the centre displaced in some frames of one."""
    states = tosses.states.copy()
    first = tosses.starts[toss] + frame
    states[first : first + count, :3] += by
    return replace(tosses, states=states)


def kicked(tosses: Tosses, toss: int, frame: int, speed: list[float]) -> Tosses:
    """Return tosses one of which gets another speed from a frame on, for ten frames, and stays displaced."""
    states = tosses.states.copy()
    rows = slice(tosses.starts[toss] + frame, tosses.starts[toss + 1])
    since = np.arange(rows.stop - rows.start)
    states[rows, :3] += np.outer(np.minimum(since, 10) * tosses.dt, speed)
    return replace(tosses, states=states)


def turned(tosses: Tosses, toss: int, frame: int, rate: float) -> Tosses:
    """Return tosses one of which turns otherwise from a frame on."""
    states = tosses.states.copy()
    rows = slice(tosses.starts[toss] + frame, tosses.starts[toss] + frame + 4)
    more = Rotation.from_rotvec(np.outer(np.arange(4) * tosses.dt, [rate, 0.0, 0.0]))
    states[rows, 3:7] = (more * Rotation.from_quat(states[rows, 3:7])).as_quat()
    return replace(tosses, states=states)


def at_rest(tosses: Tosses, frames: int = 20) -> int:
    """Return a toss that lies still for its last frames."""
    for k in range(len(tosses)):
        rows = slice(tosses.starts[k + 1] - frames, tosses.starts[k + 1])
        if np.ptp(tosses.states[rows, :3], axis=0).max() < 1e-3:
            return k
    raise AssertionError("none lies still")


@pytest.mark.parametrize(
    ("law", "spoil", "frame", "count"),
    [
        ("flight", lambda t, k: kicked(t, k, 4, [0.3, 0.0, 0.0]), 4, 1),
        ("spin", lambda t, k: turned(t, k, 3, 3.0), 3, 1),
        ("penetration", lambda t, k: shifted(t, k, 95, [0.0, 0.0, -0.002], 8), 95, 8),
        ("pull", lambda t, k: kicked(t, k, 92, [0.0, 0.0, -0.5]), 92, 1),
        ("friction", lambda t, k: kicked(t, k, 92, [0.4, 0.2, 0.0]), 92, 1),
    ],
)
def test_a_spoilt_toss_is_found_and_no_other(
    lawful: Tosses, law: str, spoil: Any, frame: int, count: int
) -> None:
    toss = at_rest(lawful)
    found = audit_tosses(spoil(lawful, toss), MU, ROUND)
    assert found.verdict == "broken"
    assert set(found.tosses) == {toss}
    assert found.laws[law].beyond == found.tosses[toss][law] >= count
    hits = [v for v in found.violations if v.law == law]
    assert any(v.start <= (frame + 0.5) * DT <= v.end + DT for v in hits)
    assert all(v.value > v.limit > 0.0 for v in found.violations)
    assert found.frames - found.explained == len(
        {(v.toss, round(v.start / DT) + i) for v in found.violations for i in range(v.frames)}
    )


def test_a_displaced_frame_is_told_from_a_force(lawful: Tosses) -> None:
    stray, force = shifted(lawful, 3, 5, [0.001, 0.0, 0.0]), kicked(lawful, 3, 5, [0.3, 0.0, 0.0])
    one, two = (audit_tosses(t, MU, ROUND).laws["flight"] for t in (stray, force))
    assert one.beyond == one.jumps >= 2
    assert two.beyond > two.jumps == 0


def test_the_same_tosses_on_less_friction_are_broken(lawful: Tosses) -> None:
    assert audit_tosses(lawful, MU, ROUND).lawful
    found = audit_tosses(lawful, 0.05, ROUND)
    assert found.verdict == "broken"
    assert {v.law for v in found.violations} == {"friction"}


def test_sharp_corners_are_in_the_ground_where_round_ones_touch(lawful: Tosses) -> None:
    found = audit_tosses(lawful, MU, 0.0)
    assert {v.law for v in found.violations} == {"penetration"}
    sphere = (np.sqrt(3.0) - 1.0) * ROUND * lawful.cube.half_side  # of what is left of the corner's tip
    assert 0.5 * sphere < max(v.value for v in found.violations) < sphere + 5e-4


def test_the_verdict_has_no_scale(lawful: Tosses) -> None:
    cube = lawful.cube
    states = lawful.states.copy()
    states[:, :3] *= 10.0
    states[:, 7:10] *= 10.0
    ten = Cube(10.0 * cube.half_side, 5.0 * cube.mass, 500.0 * cube.inertia)
    # a cube ten times as wide falls alike in a recording sqrt(10) times as slow
    slow = replace(lawful, states=states, cube=ten, dt=lawful.dt * np.sqrt(10.0))
    one, two = audit_tosses(lawful, MU, ROUND), audit_tosses(slow, MU, ROUND)
    assert two.lawful
    assert two.laws["friction"].exact == one.laws["friction"].exact


def test_what_cannot_be_told_is_not_lawful(lawful: Tosses) -> None:
    late = [range(a + 60, b) for a, b in zip(lawful.starts[:-1], lawful.starts[1:], strict=True)]
    rows = np.concatenate([list(r) for r in late])
    ends = np.concatenate([[0], np.cumsum([len(r) for r in late])])
    grounded = audit_tosses(Tosses(lawful.states[rows], ends, lawful.dt, cube=lawful.cube), MU, ROUND)
    assert (grounded.verdict, grounded.lawful) == ("cannot tell", False)
    assert "no toss flies long enough" in grounded.sentence
    early = np.concatenate([np.arange(a, a + 40) for a in lawful.starts[:-1]])
    moving = Tosses(lawful.states[early], np.arange(25) * 40, lawful.dt, cube=lawful.cube)
    assert "tell where the ground is" in audit_tosses(moving, MU, ROUND).reason
    states = lawful.states.copy()
    states[:, :3] += 2e-3 * np.random.default_rng(0).normal(size=(len(states), 3))
    coarse = audit_tosses(replace(lawful, states=states), MU, ROUND)
    assert coarse.verdict == "cannot tell"
    with pytest.raises(ProblemError, match="8 tosses or more"):
        audit_tosses(lawful.subset(range(7)))
    with pytest.raises(ProblemError, match="mu"):
        audit_tosses(lawful, -0.1)
    with pytest.raises(ProblemError, match="rounding"):
        audit_tosses(lawful, MU, 1.5)
