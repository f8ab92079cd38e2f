"""Does every verdict prove itself, in exact arithmetic? And does it agree with Clarabel where that can tell?

`python tests/adversary/test_standing_verdicts.py --count 3000` asks more of the same; the test asks a sample.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from stance_families import FAMILIES, SCALES, corner_contacts, question

import surefoot as sf
from surefoot.contact.solvers.backends import ConeProgram, End, solve_program

BAND = Fraction(4, 10**9)
"""Forces may leave their cones, and miss the load, by this share of the load."""
LEAST_REACH = 9e3
"""Loads that forces would have to add up to where a verdict is "impossible"."""
TELLS = 1e-5
"""Margin, in loads, from which on the oracle is believed."""


def rational(values):
    """Return exact fractions of floats, nested as they came."""
    array = np.asarray(values, dtype=float)
    if array.ndim == 0:
        return Fraction(float(array))
    return [rational(v) for v in array]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def size_of_load(verdict, corners):
    """Return the load as a force [N], its moment divided by the contacts' distance."""
    arms = [float(np.linalg.norm(p - verdict.com)) for p, _, _ in corners]
    arm = max(math.sqrt(sum(a * a for a in arms) / len(arms)), 1e-300)
    return math.hypot(np.linalg.norm(verdict.load[:3]), np.linalg.norm(verdict.load[3:]) / arm), arm


def forces_break_a_law(verdict, corners):
    """Return what is wrong with the forces of a possible verdict, or an empty string."""
    scale, arm = size_of_load(verdict, corners)
    allowed, com = BAND * Fraction(scale), rational(verdict.com)
    total = [-w for w in rational(verdict.load)]
    if not np.all(np.isfinite(verdict.forces)):
        return "forces are not finite"
    for (p, R, mu), f in zip(corners, verdict.corner_forces, strict=True):
        force = rational(f)
        axes = rational(R)
        world = [dot(row, force) for row in axes]
        moment = cross([a - b for a, b in zip(rational(p), com, strict=True)], world)
        total = [t + x for t, x in zip(total, [*world, *moment], strict=True)]
        friction = rational(mu)
        side = force[0] ** 2 + force[1] ** 2
        limit = friction * force[2] + allowed * (1 + friction)
        if force[2] < -allowed or limit < 0 or side > limit * limit:
            return f"force {f} is outside its cone, mu {mu}"
    worst = max(max(map(abs, total[:3])), max(map(abs, total[3:])) / Fraction(arm))
    return f"the load is missed by {float(worst) / scale:.3g} of it" if worst > allowed else ""


def certificate_fails(verdict, corners):
    """Return what is wrong with the proof of an impossible verdict, or an empty string."""
    y, com = rational(verdict.certificate), rational(verdict.com)
    work = dot(y, rational(verdict.load))
    if work >= 0:
        return "the load does no negative work"
    scale, _ = size_of_load(verdict, corners)
    if verdict.reach < LEAST_REACH * scale:
        return f"the proof reaches {verdict.reach / scale:.3g} loads only"
    lack = (
        Fraction(0) if math.isinf(verdict.reach) else -work / rational(verdict.reach) * Fraction(1001, 1000)
    )
    for p, R, mu in corners:
        arm = [a - b for a, b in zip(rational(p), com, strict=True)]
        push = [a + b for a, b in zip(y[:3], cross(y[3:], arm), strict=True)]
        z = [dot(column, push) for column in rational(R.T)]
        least = z[2] + lack  # of the work on forces whose normal component is one, less mu times the side
        if least < 0 or rational(mu) ** 2 * (z[0] ** 2 + z[1] ** 2) > least * least:
            return f"an admissible force at mu {mu} does negative work beyond the reach {verdict.reach:.3g}"
    return ""


def clarabel_margin(verdict, corners):
    """Return how far the cones' apices may rise for the forces found, in loads; None without any."""
    pytest.importorskip("clarabel")
    scale, arm = size_of_load(verdict, corners)
    blocks = []
    for p, R, mu in corners:
        axes = np.column_stack([R[:, 2], mu * R[:, 0], mu * R[:, 1]])
        blocks.append(np.vstack([axes, np.cross((p - verdict.com) / arm, axes.T).T]))
    A = np.hstack(blocks)
    m = A.shape[1]
    w = verdict.load / scale / np.array([1, 1, 1, arm, arm, arm])
    shift = np.zeros(m)
    shift[::3] = 1.0
    level = np.hstack([A, (A @ shift)[:, None]])
    cones = np.hstack([-np.eye(m), np.zeros((m, 1))])
    program = ConeProgram.of(
        None, [*np.zeros(m), -1.0], zero=(level, w), nonneg=(np.eye(m + 1)[m:], [1.0]),
        second_order=(cones, np.zeros(m)),
    )  # fmt: skip
    found = solve_program(program, tol=None)
    if found.end is not End.SOLVED:
        return None
    x = np.array(found.x[:m]) + found.x[m] * shift  # forces, put onto the equations and looked at again
    x += np.linalg.lstsq(A, w - A @ x, rcond=1e-15)[0]
    if np.abs(A @ x - w).max() > 1e-12 or np.abs(x).max() > 1e3:
        return None
    return float(np.min(x[::3] - np.hypot(x[1::3], x[2::3])))


def judge(rng, family):
    """Ask one question; return the status, what is wrong, and whether the oracle had a word."""
    asked = question(rng, family, float(rng.choice(SCALES)))
    push = np.zeros(6)
    if rng.random() < 0.3:
        push = rng.normal(size=6) * asked.mass * 3.0 * np.array([1, 1, 1, *[0.3 * asked.length] * 3])
    verdict = sf.can_stand(asked.stance, asked.com, asked.mass, push)
    corners = corner_contacts(asked.stance)
    wrong = []
    if verdict.feasible != (verdict.status == "possible"):
        wrong.append("status and feasible differ")
    if verdict.status != "undecided":
        wrong.append((forces_break_a_law if verdict.feasible else certificate_fails)(verdict, corners))
        if not verdict.verify():
            wrong.append(f"{verdict} does not verify")
    truth = clarabel_margin(verdict, corners)
    tells = truth is not None and truth > TELLS
    if tells and not verdict:
        wrong.append(f"{verdict}, by the oracle {truth:.3g} loads")
    return verdict.status, [f"{family}, scale {asked.length:g}: {text}" for text in wrong if text], tells


def run(count, seed):
    """Judge `count` stances; return what was wrong, the statuses, and how often the oracle could tell."""
    rng, wrong, statuses, told = np.random.default_rng(seed), [], Counter(), 0
    for k in range(count):
        status, found, tells = judge(rng, FAMILIES[k % len(FAMILIES)])
        wrong += [f"stance {k}: {text}" for text in found]
        statuses[status] += 1
        told += tells
    return wrong, statuses, told


def test_every_verdict_proves_itself():
    wrong, statuses, told = run(360, 0)
    assert not wrong, "\n".join(wrong)
    assert statuses["possible"] > 80
    assert statuses["impossible"] > 80
    assert statuses["undecided"] < 20
    assert told > 100


def test_friction_that_squeezing_needs_is_bounded():
    """Four hands in a chimney: mu N = m g for ten loads of N, whatever less could do in theory."""
    sides = [sf.PointContact([0.3 * s, 0.1 * t, 0], [-s, 0, 0]) for s in (-1, 1) for t in (-1, 1)]
    stance, weight = sf.Stance(sides), 15.0 * 9.81
    assert sf.friction_needed(stance, [0, 0, 0], 15.0) == pytest.approx(0.1, rel=1e-6)
    assert sf.friction_needed(stance, [0, 0, 0], 15.0, force_limit=weight) == pytest.approx(1.0, rel=1e-6)
    assert sf.friction_needed(stance, [0, 0, 0], 15.0, force_limit=math.inf) < 1e-6


@pytest.mark.parametrize("facets", [None, 6])
@pytest.mark.parametrize("bound", [math.inf, 200.0])
def test_endless_friction_holds_what_much_friction_holds(facets, bound):
    """A cone that is all but a half-space: forces within it still hold the robot, with the same margin."""
    rise = math.tan(math.radians(25.0))
    normal = np.array([-rise, 0.0, 1.0]) / math.hypot(1.0, rise)
    feet = [[x, y, rise * x] for x in (0.17, -0.19) for y in (0.16, -0.16)]
    margins = []
    for mu in (1e4, 1e6, 1e8, 1e9, 1e12, 1e100):
        stance = sf.Stance([sf.PointContact(p, normal, mu=mu, normal_max=bound) for p in feet])
        verdict = sf.can_stand(stance, [0.0, 0.0, 0.31], 16.085, facets=facets)
        assert verdict.status == "possible", f"mu {mu:g}: {verdict}"
        assert verdict.verify()
        assert forces_break_a_law(verdict, corner_contacts(stance)) == ""
        margins.append(verdict.margin)
        beside = sf.can_stand(stance, [5.0, 0.0, 0.31], 16.085, facets=facets)
        assert beside.status != "possible", f"mu {mu:g}: {beside}"
    np.testing.assert_allclose(margins, margins[0], rtol=1e-5)


def test_margin_shrinks_with_friction_and_never_jumps():
    feet = [[x, y, 0.0] for x in (0.2, -0.2) for y in (0.1, -0.1)]
    for mu in 10.0 ** np.arange(-8.0, 1.0):
        stance = sf.Stance([sf.PointContact(p, mu=mu) for p in feet])
        expected = mu * 15.0 * 9.81 / 4 / math.hypot(1.0, mu)
        margin = sf.can_stand(stance, [0, 0, 0.3], 15.0).margin
        assert margin == pytest.approx(expected, rel=1e-3, abs=1e-9 * 147.0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    lies, words, judged = run(options.count, options.seed)
    print("\n".join(lies))
    print(f"{len(lies)} wrong of {options.count}: {dict(words)}, the oracle could tell {judged}")
