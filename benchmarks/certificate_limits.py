"""Vary the settings of certificates of motions, or of repairs, one at a time, over motions of a known truth.

Run: python -m benchmarks.certificate_limits [NAME...] [--repairs] [--walks 3] [--seconds 4]
[--people FILE...] [--json]. NAME is a setting of `CertificateSettings`, or with --repairs of
`RepairSettings`; all without one.

Walks of the G1 in MuJoCo are lawful: at 30 and 120 Hz, without and with noise, and with the errors that
retargeted walks have (`retarget`). So are knees without strength at their stops, and legs that straighten
with motors just as fast as they need. Unlawful are the same walks spoilt in the ways of
`benchmarks.certify.corruptions`, the knees away from their stops, and the legs with motors half as fast. A
case is right by the share of its frames that are: lawful ones possible, spoilt ones impossible, by half where
it cannot tell; its whole verdict counts as much as its frames. The score is the mean of lawful cases and of
spoilt ones, each kind by half, less ten times the share of lawful frames that are called impossible: a
certificate promises never to do that.

With --people motions that people walked are lawful too, as retargeting to the G1 left them (files that
`surefoot certify` reads, 30 frames a second, the first minute): each counts as a walk does. Settings that are
to forgive real errors are decided by these.

Repairs are judged on impossible motions that need what the setting is for (`benchmarks.certify.repair_cases`:
walks spoilt in the ways that a repair mends, a foot that is raised, ground that heaves, knees that are too
slow): the score is the mean share of impossible frames that are mended, less the mean change of the joints in
rad, and less a tenth of the logarithm of how much longer or shorter the motion lasts. With --people they are
judged on those motions alone.

A choice is repeated if no value that was tried scores higher by more than 0.01, and at least one does
worse; a setting whose value makes no difference is not decided by these motions.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from benchmarks.certify.corruptions import resampled, spoil_each
from benchmarks.certify.executed import noisy
from benchmarks.certify.recordings import walks
from benchmarks.certify.repair_cases import RATE, changed, knees, repair_cases, rising_motion, slow_knees
from benchmarks.limit_choice import Choice, vary
from surefoot.base.arrays import BoolArray
from surefoot.base.errors import check_name
from surefoot.base.settings import DescribedSetting, describe
from surefoot.records.certificates.certificate_settings import CertificateSettings
from surefoot.records.motions.motion import Motion
from surefoot.records.repairs.repair_settings import RepairSettings

RATES = (RATE, 120.0)
"""Of the walks [Hz]; they are spoilt at the first."""
OFF, WANDER, SKATE, WANDERING = 0.004, 0.01, 0.12, 0.3
"""Errors of retargeted walks: mean height and its deviation [m], speed of resting feet [m/s], how often [Hz].

Of six walks of LAFAN1 as Unitree retargeted them: where the lower foot rests, its lowest point is 9 mm below
10 mm above the ground (5th and 95th percentile), and it slides at up to 0.06 to 0.23 m/s (80th).
"""
FALSE = 10.0
"""Weight of lawful frames that are called impossible, over that of frames that are right."""
NOISE = 0.01
"""Differences of scores that say nothing: a single motion's verdict makes up as much."""
LONGER = 0.1
"""Weight of the logarithm of how much longer or shorter a mended motion lasts."""


@dataclass(frozen=True)
class Case:
    """A motion, and the frames (T,) that are spoilt; None for a lawful one."""

    name: str
    motion: Motion
    spoilt: BoolArray | None = None

    def judge(self, settings: CertificateSettings) -> tuple[float, float]:
        """Return how much of it is judged rightly, 0 to 1, and the share of frames wrongly impossible."""
        report = sf.certify_motion(self.motion.robot, self.motion, settings=settings)
        judged = np.isfinite(report.frames.share)
        if not judged.any():
            return 0.0, 0.0
        looked_at = judged if self.spoilt is None else judged & self.spoilt
        verdicts, wanted = (
            report.frames.verdict[looked_at],
            "possible" if self.spoilt is None else "impossible",
        )
        right = 0.5 * (
            np.mean(verdicts == wanted) + np.mean((verdicts == wanted) | (verdicts == "cannot tell"))
        )
        wrong = float(np.mean(verdicts == "impossible")) if self.spoilt is None else 0.0
        return 0.5 * (float(right) + (report.verdict == wanted)), wrong


def lawful_cases(motions: Sequence[Motion]) -> Iterator[Case]:
    """Yield walks as they were executed."""
    rng = np.random.default_rng(0)
    for motion in motions:
        for rate in RATES:
            one = resampled(motion, rate)
            yield Case(f"{motion.name} at {rate:g} Hz", one)
            yield Case(f"{motion.name} at {rate:g} Hz, noise", noisy(one, rng))
        yield Case(f"{motion.name}, as retargeted", retarget(resampled(motion, RATES[0])))


def retarget(motion: Motion) -> Motion:
    """Return a motion that rises and sinks, and slides to and fro, by what retargeting leaves."""
    phase = 2.0 * np.pi * WANDERING * np.arange(len(motion)) / motion.rate
    q = motion.q.copy()
    q[:, 0] += SKATE / (2.0 * np.pi * WANDERING) * np.sin(phase)
    q[:, 2] += OFF + WANDER * np.cos(phase)
    return replace(motion, q=q)


def spoilt_cases(motions: Sequence[Motion]) -> Iterator[Case]:
    """Yield walks spoilt in every way."""
    for corruption, one, touched in spoil_each([resampled(motion, RATES[0]) for motion in motions]):
        yield Case(f"{one.name}, {corruption.name}", one, touched)


def motor_cases(motion: Motion) -> Iterator[Case]:
    """Yield weak knees at their stops and away from them, motors that are fast enough and that are not."""
    robot = motion.robot
    mine = knees(robot)
    q = np.tile(robot.nominal, (45, 1))
    q[:, 2] -= min(robot.sphere_bottoms(robot.nominal))
    weak = changed(robot, effort_limits=np.where(mine, 1.0, robot.effort_limits))
    every = np.ones(len(q), dtype=np.bool_)
    for bent, spoilt in ((0.02, None), (0.2, every)):
        stopped = changed(weak, model=robot.model.copy())
        upper = np.array(robot.model.upperPositionLimit)
        upper[7:][mine] = robot.nominal[7:][mine] + bent
        stopped.model.upperPositionLimit = upper
        name = f"weak knees {bent:g} rad from their stops"
        yield Case(name, Motion(stopped, q, RATES[0], name), spoilt)
    rising = rising_motion(robot)
    speeds = np.abs(np.gradient(rising.q[:, 7:], 1.0 / rising.rate, axis=0))
    fastest = np.all(speeds[:, mine] > 0.55 * speeds.max(), axis=1)
    for share, spoilt in ((1.0 / 1.02, None), (0.5, fastest)):
        name = f"rising, motors of the knees {share:.2f} times as fast as they turn"
        yield Case(name, slow_knees(rising, share), spoilt)


def certificate_score(lawful: Sequence[Case], spoilt: Sequence[Case], settings: CertificateSettings) -> float:
    """Return how well certificates judge, at most 1."""
    good, bad = ([case.judge(settings) for case in cases] for cases in (lawful, spoilt))
    right = 0.5 * (np.mean([r for r, _ in good]) + np.mean([r for r, _ in bad]))
    return float(right - FALSE * np.mean([wrong for _, wrong in good]))


def repair_score(motions: Sequence[Motion], settings: RepairSettings) -> float:
    """Return how much repairs of spoilt motions mend, less how far they change them, and their lengths."""
    found = [sf.repair_motion(sf.certify_motion(one.robot, one), settings) for one in motions]
    longer = [abs(np.log(one.motion.duration / one.before.motion.duration)) for one in found]
    changes = [one.joint_change for one in found]
    return float(np.mean([one.mended for one in found]) - np.mean(changes) - LONGER * np.mean(longer))


def first_minute(motion: Motion) -> Motion:
    """Return the beginning of a motion."""
    return replace(motion, q=motion.q[: round(60.0 * motion.rate)])


def certificate_scores(
    motions: Sequence[Motion], people: Sequence[Motion]
) -> Callable[[CertificateSettings], float]:
    """Return what scores settings of certificates on walks, and on motions of people."""
    fast, slow = list(motor_cases(motions[0])), [*spoilt_cases(motions)]
    lawful = [*lawful_cases(motions), *(Case(one.name, one) for one in people)]
    lawful += [*(case for case in fast if case.spoilt is None)]
    spoilt = [*slow, *(case for case in fast if case.spoilt is not None)]
    return partial(certificate_score, lawful, spoilt)


def vary_setting(one: DescribedSetting, chosen: Any, score: Callable[[Any], float], noise: float) -> Choice:
    """Return what comes of varying a setting."""
    whole = int if one.info.whole else float
    return vary(one, lambda value: score(replace(chosen, **{one.name: whole(value)})), noise)


def main() -> None:
    """Print two lines for each setting: the verdict, and the scores of the values tried."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="settings (default: all)")
    parser.add_argument("--repairs", action="store_true", help="settings of repairs, not of certificates")
    parser.add_argument("--walks", type=int, default=3, help="walks of different commands")
    parser.add_argument("--seconds", type=float, default=4.0, help="length of each")
    parser.add_argument("--people", nargs="+", type=Path, default=[], help="retargeted motions of people")
    parser.add_argument("--json", action="store_true", help="print JSON")
    given = parser.parse_args()
    settings = RepairSettings() if given.repairs else CertificateSettings()
    every = {one.name: one for one in describe(settings)}
    for name in given.names:
        check_name("setting", name, tuple(every))
    robot = sf.load_robot("g1")
    people = [first_minute(sf.read_motion(path, robot, fps=RATES[0])) for path in given.people]
    motions = [] if given.repairs and people else list(walks(robot, given.walks, given.seconds))
    of_certificates = None if given.repairs else certificate_scores(motions, people)
    found = []
    for name in given.names or every:
        score = of_certificates or partial(repair_score, people or repair_cases(name, motions))
        one = vary_setting(every[name], settings, score, NOISE)
        found.append(asdict(one) | {"verdict": one.verdict})
        if not given.json:
            print(f"{name:12} {one.value:8.4g} {every[name].info.unit:6} {one.verdict}")
            print(f"{'':12} " + ", ".join(f"{v:.4g}: {s:.4f}" for v, s in one.tried), flush=True)
    if given.json:
        print(json.dumps(found))
    else:
        print(
            f"{sum(one['verdict'].startswith('as good') for one in found)} of {len(found)} settings decided"
        )


if __name__ == "__main__":
    main()
