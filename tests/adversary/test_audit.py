"""Attempts to make the auditor call a log lawful that is not.

The lawful log is a block that is dragged, at rest, lifted and set down by the laws themselves, written out
in plain NumPy; every forgery changes it in one way.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.records.audit import LawFigures
from surefoot.records.audit.limits import LIMITS
from tests.records.audit.logs import check_laws

MU, WEIGHT, DT, STEPS = 0.5, 160.0, 1e-3, 1200
Motion = dict[str, np.ndarray]


def lawful(seed: int) -> Motion:
    """Four feet: two stick, one slides there and back, one is in the air for the middle third."""
    rng = np.random.default_rng(seed)
    t = DT * np.arange(STEPS)
    f, v, gap = np.zeros((STEPS, 4, 3)), np.zeros((STEPS, 4, 3)), np.zeros((STEPS, 4))
    normal = WEIGHT / 4 * (1.0 + 0.3 * np.sin(2 * np.pi * t[:, None] + rng.uniform(0, 6, 4)))
    f[..., 2] = normal
    for k in (0, 1, 3):
        angle, use = rng.uniform(0, 2 * np.pi), rng.uniform(0.0, 0.9, STEPS)
        f[:, k, 0], f[:, k, 1] = (MU * normal[:, k] * use * g for g in (np.cos(angle), np.sin(angle)))
    heading = rng.uniform(0, 2 * np.pi)
    speed = 0.3 * np.sin(2 * np.pi * t / t[-1])
    v[:, 2, 0], v[:, 2, 1] = speed * np.cos(heading), speed * np.sin(heading)
    f[:, 2, :2] = -MU * normal[:, 2, None] * np.sign(speed)[:, None] * [np.cos(heading), np.sin(heading)]
    flight = (t > 0.4) & (t < 0.8)
    f[flight, 3] = 0.0
    gap[flight, 3] = 0.05 * np.sin(np.pi * (t[flight] - 0.4) / 0.4) + 1e-6
    v[flight, 3] = rng.normal(size=(int(flight.sum()), 3))
    gap -= np.where(f[..., 2] > 0.0, rng.uniform(0.0, 5e-5, gap.shape), 0.0)
    return {"forces": f, "gaps": gap, "velocities": v, "mu": np.full(STEPS, MU)}


def verdict(motion: Motion) -> tuple[list[str], LawFigures]:
    laws = check_laws(**motion, weight=WEIGHT, dt=DT)
    return laws.broken(WEIGHT), laws


SEEDS = range(5)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_lawful_log_is_lawful(seed: int) -> None:
    broken, laws = verdict(lawful(seed))
    assert broken == []
    assert laws.judged == ("unilateral", "Coulomb", "dissipation")


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", ["forces", "gaps", "velocities", "mu"])
def test_no_entry_may_be_other_than_finite(name: str, bad: float) -> None:
    """Anywhere: a loaded foot or one in the air, first row or last, normal or tangential."""
    rng = np.random.default_rng(1)
    size = lawful(0)[name].size
    for at in (0, 1, 2, size - 1, *rng.integers(0, size, 30)):
        motion = lawful(0)
        motion[name].flat[at] = bad
        if name == "mu" and bad < 0.0:
            with pytest.raises(ProblemError, match="mu must be >= 0"):
                verdict(motion)
            continue
        broken, laws = verdict(motion)
        assert any("not finite" in line for line in broken)
        named = {"mu": "friction"}.get(name, name)
        assert [line.split()[0] for line in laws.not_finite] == [named]


def test_finite_numbers_whose_products_are_not_are_no_way_out() -> None:
    for name, value in (("forces", 1e200), ("velocities", 1e200), ("gaps", -1e308), ("forces", -1e308)):
        motion = lawful(0)
        motion[name][600:602] = value
        assert verdict(motion)[0]
    motion = lawful(0)
    motion["forces"][600], motion["velocities"][600] = 1e308, -1e308
    assert verdict(motion)[0]


def swap_forces(m: Motion) -> None:
    m["forces"][:] = m["forces"][:, [3, 1, 2, 0]]


def swap_velocities(m: Motion) -> None:
    m["velocities"][:] = m["velocities"][:, [2, 1, 0, 3]]


def rotate_feet(m: Motion) -> None:
    m["gaps"][:] = np.roll(m["gaps"], 1, axis=1)


def pull_once(m: Motion) -> None:
    m["forces"][777, 1, 2] = -0.002 * WEIGHT


def pull_and_hide(m: Motion) -> None:
    """A pull at one foot that another one makes up for."""
    m["forces"][777, 1, 2] -= WEIGHT
    m["forces"][777, 0, 2] += WEIGHT


def pull_in_the_air(m: Motion) -> None:
    m["forces"][600, 3] = [0.0, 0.0, -1.0]


def sink(m: Motion) -> None:
    m["gaps"][300, 1] = -1.5e-3


def sink_unloaded(m: Motion) -> None:
    m["gaps"][600, 3] = -2e-3


def leave_the_cone_once(m: Motion) -> None:
    m["forces"][100, 0, :2] = 1.01 * MU * m["forces"][100, 0, 2] * np.array([0.6, 0.8])


def friction_from_nothing(m: Motion) -> None:
    """Tangential force on a foot without a normal force."""
    m["forces"][600, 3] = [3.0, 0.0, 0.0]


def friction_on_a_breath(m: Motion) -> None:
    """... and with one just below what counts as loaded."""
    m["forces"][600, 3], m["gaps"][600, 3] = [3.0, 0.0, 0.9e-3 * WEIGHT], 0.0


def push_from_afar(m: Motion) -> None:
    m["forces"][600, 3] = [0.0, 0.0, 40.0]


def push_from_a_little_away(m: Motion) -> None:
    """So little force and gap that their product is small."""
    m["forces"][600, 3], m["gaps"][600, 3] = [0.0, 0.0, 10.0], 4e-3


def slide_without_friction(m: Motion) -> None:
    m["forces"][100:150, 2, :2] = 0.0


def slide_with_half(m: Motion) -> None:
    m["forces"][:, 2, :2] *= 0.5


def slide_across(m: Motion) -> None:
    m["forces"][:, 2, :2] = m["forces"][:, 2, 1::-1] * np.array([1.0, -1.0])


def driven_by_friction(m: Motion) -> None:
    m["forces"][:, 2, :2] *= -1.0


def creep(m: Motion) -> None:
    """A sticking foot that wanders at 9 mm/s, slower than what counts as sliding at an instant."""
    m["velocities"][:, 0, 0] += 9e-3
    m["forces"][:, 0, :2] = 0.0


def hop_and_slide(m: Motion) -> None:
    """Unloaded for a step in every five, so that no slide lasts."""
    m["forces"][:, 2, :2] = 0.0
    m["forces"][::5, 2, 2] = 0.0


def stop_and_go(m: Motion) -> None:
    """Slow for a step in every two, so that no run of sliding steps lasts."""
    m["forces"][:, 2, :2] = 0.0
    m["velocities"][::2, 2, :2] = 0.0


def believed_friction(m: Motion) -> None:
    """The log's ground becomes ice, its forces do not."""
    m["mu"][800:] = 0.05


FORGERIES = [
    swap_forces, swap_velocities, rotate_feet, pull_once, pull_and_hide, pull_in_the_air, sink, sink_unloaded,
    leave_the_cone_once, friction_from_nothing, friction_on_a_breath, push_from_afar, push_from_a_little_away,
    slide_without_friction, slide_with_half, slide_across, driven_by_friction, creep, hop_and_slide,
    stop_and_go, believed_friction,
]  # fmt: skip


@pytest.mark.parametrize("forge", FORGERIES, ids=lambda f: f.__name__)
def test_every_forgery_is_found(forge: Callable[[Motion], None]) -> None:
    for seed in SEEDS:
        motion = lawful(seed)
        forge(motion)
        assert verdict(motion)[0], seed


def test_units_do_not_matter() -> None:
    """The same motion of a robot a thousand times lighter or heavier gets the same verdict."""
    for scale in (1e-3, 1e3):
        for forge in (None, *FORGERIES):
            motion = lawful(0)
            if forge is not None:
                forge(motion)
            plain = verdict(motion)[0]
            motion["forces"] *= scale
            scaled = check_laws(**motion, weight=scale * WEIGHT, dt=DT).broken(scale * WEIGHT)
            assert len(scaled) == len(plain)


def test_sampling_does_not_matter() -> None:
    """A slide that lacks half its friction is as long at 1, 2, 4 and 8 ms."""
    found = []
    for every in (1, 2, 4, 8):
        motion = lawful(0)
        slide_with_half(motion)
        part = {name: array[::every] for name, array in motion.items()}
        found.append(check_laws(**part, weight=WEIGHT, dt=every * DT).free_slide_max)
    np.testing.assert_allclose(found, found[0], rtol=0.02)
    # against the integral of mu f_n |v| by quadrature: half of it is missing
    motion = lawful(0)
    speed = np.hypot(motion["velocities"][:, 2, 0], motion["velocities"][:, 2, 1])
    normal = motion["forces"][:, 2, 2]
    assert found[0] == pytest.approx(
        (0.5 - LIMITS.laws.lag) * DT * float(normal @ speed) / normal.max(), rel=0.02
    )
