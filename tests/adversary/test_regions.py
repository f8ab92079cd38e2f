"""Is the stated gap of a region true? Support functions by Clarabel, HiGHS and fractions, on hard stances.

`python tests/adversary/test_regions.py --count 1000` asks more of the same; the test asks a sample.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
import pytest
from rational_lp import largest
from scipy.optimize import linprog
from stance_families import FAMILIES, corner_contacts, directions, question

import surefoot as sf
from surefoot.contact.solvers.backends import ConeProgram, End, solve_program
from surefoot.mechanics.statics.com_region import zmp_region

GRAVITY = 9.81
EXACT, PYRAMIDS = 2e-6, 2e-7
"""What the oracles may be wrong by, as a share of the stance's size: interior point, simplex."""
BAND = 1e-9
"""Forces of a possible verdict may leave their cones by this share of the load."""

TOO_FINE = ("friction at its limit", "little friction")
"""Families of stances that turn on less than HiGHS's tolerances: their pyramids are judged by fractions."""


class Oracle:
    """The largest value of direction . place over a region; its own coordinates are centred, of size one."""

    def __init__(self, stance, mass, force_limit, com=None, height=None, facets=None, hair=0.0, exact=False):
        """Forces may leave their cones by `hair` loads: so much friction more, and the apices moved back."""
        corners = [(p, R, mu + hair) for p, R, mu in corner_contacts(stance)]
        places = np.array([p for p, _, _ in corners])
        self.middle = places.mean(axis=0)
        self.size = max(float(np.abs(places - self.middle).max()), 1e-9 * float(np.abs(places).max()), 1e-12)
        if com is not None:
            self.size = max(self.size, float(np.abs(com - self.middle).max()))
        blocks, self.mu = [], np.array([mu for _, _, mu in corners])
        for p, R, mu in corners:
            axes = np.column_stack([R[:, 2], mu * R[:, 0], mu * R[:, 1]])  # height, then sides over mu
            if facets is not None:
                angle = 2.0 * np.pi * np.arange(facets) / facets
                axes = axes @ np.array([np.ones(facets), np.cos(angle), np.sin(angle)])
            arm = (p - self.middle) / self.size
            blocks.append(np.vstack([axes, np.cross(arm, axes.T).T]))
        A, self.per = np.hstack(blocks), 3 if facets is None else facets
        force, moment = A[:3], A[3:]
        if com is None:  # moment = place x force, force = (0, 0, 1)
            self.rows, self.right = np.vstack([force, moment[2]]), np.array([0.0, 0.0, 1.0, 0.0])
            self.pick, self.offset = np.vstack([-moment[1], moment[0]]), np.zeros(2)
        else:
            arm = (com - self.middle) / self.size
            about = moment - np.cross(arm, force.T).T
            self.rows, self.right = np.vstack([force[2], about]), np.array([1.0, 0.0, 0.0, 0.0])
            self.pick, self.offset = -(com[2] - height) / self.size * force[:2], arm[:2]
        most = force_limit / (mass * GRAVITY)
        heads = np.zeros(A.shape[1])
        heads[:: self.per] = 1.0
        self.heads, self.most = (heads if facets is None else np.ones(A.shape[1])), most
        self.round, self.rational = facets is None, exact and facets is not None
        if hair > 0.0:
            self._move_apices_back(hair)

    def _move_apices_back(self, loads):
        """Move them so that the cones' faces move by so many loads, and 30 times that at most."""
        back = loads * np.minimum(np.hypot(1.0, self.mu) / self.mu, 30.0)
        shift = np.repeat(back, self.per)
        if self.round:
            shift *= self.heads
        else:
            shift /= self.per * math.cos(math.pi / self.per)
        self.right = self.right + self.rows @ shift
        self.offset = self.offset - self.pick @ shift
        self.most += float(self.heads @ shift)

    def reach(self, direction):
        """Return the support function [m], -inf where the region is empty, None where the oracle gives up."""
        cost = -(direction @ self.pick)
        value = self._cones(cost) if self.round else self._pyramids(cost)
        if value is None or math.isinf(value):
            return value
        return self.size * (value + direction @ self.offset) + direction @ self.middle[:2]

    def _pyramids(self, cost):
        if self.rational:
            return self._fractions(cost)
        limit = {} if math.isinf(self.most) else {"A_ub": self.heads[None], "b_ub": [self.most]}
        options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
        found = linprog(
            cost, A_eq=self.rows, b_eq=self.right, bounds=(0, None), method="highs", options=options, **limit
        )
        if found.status == 2:
            return -math.inf
        if found.status or np.abs(self.rows @ found.x - self.right).max() > 1e-9:
            return None
        return -found.fun

    def _fractions(self, cost):
        rows, right, gain = self.rows, self.right, -cost
        if not math.isinf(self.most):
            rows = np.vstack([np.hstack([rows, np.zeros((len(rows), 1))]), [*self.heads, 1.0]])
            right, gain = np.append(right, self.most), np.append(gain, 0.0)
        return float(largest(gain, rows, right))

    def _cones(self, cost):
        pytest.importorskip("clarabel")
        m = len(cost)
        bound = 1e6 if math.isinf(self.most) else self.most
        program = ConeProgram.of(
            None, cost, zero=(self.rows, self.right), nonneg=(self.heads[None], [bound]),
            second_order=(-np.eye(m), np.zeros(m)),
        )  # fmt: skip
        found = solve_program(program, tol=1e-9)
        if found.end is End.INFEASIBLE:
            return -math.inf
        x = found.x
        good = found.end is End.SOLVED and np.abs(self.rows @ x - self.right).max() < 1e-9
        return -float(cost @ x) if good and np.abs(x).max() < 1e4 else None


def judge(rng, family):
    """Ask for one region and return what is wrong with it, and how often the oracle had an answer."""
    asked = question(rng, family, 10.0 ** rng.choice([-3.0, 0.0, 0.0, 3.0]))
    facets = None if rng.random() < 0.5 else int(rng.integers(3, 9))
    tol = asked.length * 10.0 ** rng.uniform(-5.0, -2.0)
    stance, mass, com = asked.stance, asked.mass, None
    if rng.random() < 0.3 and family != "far away":
        com = asked.com
        region = zmp_region(stance, com, mass, tol, facets=facets)
    else:
        region = sf.com_region(stance, mass, tol, facets=facets)
    question_of = (stance, mass, region.force_limit, com, region.height, facets)
    exact = family in TOO_FINE
    oracle, widened = Oracle(*question_of, exact=exact), Oracle(*question_of, 4.0 * BAND, exact)
    allowed = oracle.size * (EXACT if facets is None else PYRAMIDS)
    allowed += 1e-12 * float(np.abs(oracle.middle).max())
    wrong, heard = [], 0
    if not region.empty:
        outer = region.outer
        if not len(outer):
            wrong.append("the outer polygon is empty and the region is not")
        elif max(region.distance(q) for q in outer) > region.gap * (1 + 1e-9):
            wrong.append("the outer polygon is farther from the inner one than the gap")
        if region.converged != (region.gap <= tol):
            wrong.append("converged does not say whether the gap is within the tolerance")
    for d in directions(rng, region.inner, 3):
        truth = oracle.reach(d)
        if truth is None:
            continue
        heard += 1
        if region.empty or math.isinf(truth):
            wrong += _emptiness(region, asked, truth, facets, com)
            break
        inner = float((region.inner @ d).max())
        if truth - inner > region.gap + allowed:
            wrong.append(f"true gap {truth - inner:.3g} m, stated {region.gap:.3g} m")
        wide = widened.reach(d)
        if wide is not None and inner - wide > allowed:
            wrong.append(f"the inner polygon reaches {inner - wide:.3g} m beyond the region")
    return [f"{family}, facets {facets}, tol {tol:.1e}: {text}" for text in wrong], heard


def _emptiness(region, asked, truth, facets, com):
    """Only a region with forces just inside or outside their cones may be empty for one and not the other."""
    if region.empty == math.isinf(truth) or math.isinf(region.gap):
        return []
    if asked.family == "friction at its limit" or asked.family == "little friction":
        return []  # the oracle's own tolerance on the cones decides
    return [f"empty: {region.empty}, by the oracle {math.isinf(truth)}"]


def run(count, seed):
    """Judge `count` stances; return what was wrong, and how many the oracle had a word on."""
    rng, wrong, heard = np.random.default_rng(seed), [], 0
    for k in range(count):
        found, answers = judge(rng, FAMILIES[k % len(FAMILIES)])
        wrong += [f"stance {k}: {text}" for text in found]
        heard += answers > 0
    return wrong, heard


@pytest.mark.long
def test_stated_gaps_are_true():
    wrong, heard = run(48, 0)
    assert not wrong, "\n".join(wrong)
    assert heard > 36


def test_fractions_agree_with_highs():
    rng = np.random.default_rng(4)
    for _ in range(20):
        rows, cost = rng.normal(size=(3, 8)), rng.normal(size=8)
        right = rows @ rng.uniform(size=8) * rng.choice([-1.0, 1.0])
        found = linprog(-cost, A_eq=rows, b_eq=right, bounds=(0, None), method="highs")
        expected = {0: -found.fun if found.status == 0 else 0.0, 2: -math.inf, 3: math.inf}[found.status]
        assert float(largest(cost, rows, right)) == pytest.approx(expected, abs=1e-9)


def test_a_segment_is_returned_whole():
    """Three feet in a line: leaving out the middle one must not take an end along."""
    places = ([-0.19, 0.24, 0.07], [-0.19, -0.09, 0.03], [-0.19, 0.075, 0.05])
    region = sf.com_region(sf.Stance([sf.PointContact(p, mu=0.8) for p in places]), 15.0)
    ends = region.inner[np.argsort(region.inner[:, 1])]
    np.testing.assert_allclose(ends, [[-0.19, -0.09], [-0.19, 0.24]], atol=1e-7)
    assert region.gap < 1e-3
    assert len(region.outer)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    lies, judged = run(options.count, options.seed)
    print("\n".join(lies))
    print(f"{len(lies)} wrong of {options.count} stances, {judged} judged")
