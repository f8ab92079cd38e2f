"""How many contradictions between the channels of a log an audit finds: the table of docs/reports/audit.md.

Run: python -m benchmarks.spoils [--json]. Thirty lawful logs, most of them of no known robot
(`benchmarks.problems.plain_logs`), are spoilt in thirteen ways, each of which leaves some channels as they
are: a kick in mid-run, half of the weight carried while nothing falls, momentum of another scale, places that
jump, velocities in another unit, gaps of the other sign, forces in other axes. Counted is what exceeds the
tolerance that docs/channels-of-one-motion.md states, worked out from the lawful log; and what is found of the
rest.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from itertools import islice
from typing import Any

import numpy as np

from benchmarks.problems.plain_logs import KICK, PlainLog, plain_logs
from surefoot.base.arrays import FloatArray
from surefoot.base.numerics.windows import sliding_mean, sliding_sum
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit import audit_log
from surefoot.records.audit.checks import CHECKS
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.log_context import Setting, setting_of
from surefoot.records.audit.rows import Rows, lacking
from surefoot.records.log import Log

Numbers = np.random.Generator
Arrays = dict[str, Any]


@dataclass(frozen=True)
class Lawful:
    """A lawful log as spoils see it.

    Attributes
    ----------
    log
        Itself.
    rows
        All of them as the audit reads them.
    """

    log: Log
    rows: Rows

    @property
    def setting(self) -> Setting:
        """What the audit knows of it."""
        return self.rows.setting

    def limit(self, check: str) -> FloatArray | None:
        """Return a law's limit in every row: (T, c); None where the log does not let it be judged."""
        one = next(c for c in CHECKS if c.name == check)
        if lacking(self.log, one.needs) or one.doubt(self.log, self.setting):
            return None
        return one.measure(self.rows)[1]

    def over(self, check: str, size: FloatArray) -> bool:
        """Return whether a size (T,) or (T, c) goes beyond twice a law's limit somewhere."""
        limit = self.limit(check)
        if limit is None:
            return False
        return bool((size > 2.0 * (limit[:, -1] if size.ndim == 1 else limit[:, : size.shape[1]])).any())


@dataclass(frozen=True)
class Spoil:
    """A way to spoil a log.

    Attributes
    ----------
    name, title
        Key, and one line for the table.
    needs
        Channels that it changes.
    change
        From a copy of the arrays, the lawful log and a generator; writes to the copy, and returns whether
        what it did exceeds the stated tolerance. None for a kick, which the loop makes itself.
    """

    name: str
    title: str
    needs: tuple[str, ...]
    change: Callable[[Arrays, Lawful, Numbers], bool] | None


def _half(a: Arrays, lawful: Lawful, rng: Numbers) -> bool:
    """Half of what the contacts give is in the log, and the momentum's rate is as if that were all."""
    a["forces"] *= 0.5
    force = np.einsum("tpij,tpj->ti", lawful.rows.frames, lawful.rows.forces)
    if "momentum_rate" in a:
        a["momentum_rate"][:, :3] -= 0.5 * force
        arm = a["contact_positions"] - a["com"][:, None]
        each = np.einsum("tpij,tpj->tpi", lawful.rows.frames, lawful.rows.forces)
        a["momentum_rate"][:, 3:] -= 0.5 * np.cross(arm, each).sum(axis=1)
    w = lawful.rows.window(LIMITS.consistency.time)
    missing = np.linalg.norm(0.5 * sliding_mean(force, 2 * w), axis=1)
    return lawful.over("acceleration", missing) or lawful.over("motion", missing)


def _scaled(scale: float) -> Callable[[Arrays, Lawful, Numbers], bool]:
    def change(a: Arrays, lawful: Lawful, rng: Numbers) -> bool:
        speed = np.linalg.norm(a["momentum"][:, :3], axis=1) / (lawful.setting.weight / GRAVITY)
        a["momentum"] *= scale
        w = lawful.rows.window(LIMITS.consistency.time)
        return lawful.over("centre of mass", abs(scale - 1.0) * sliding_sum(speed * lawful.rows.dt, w))

    return change


def _com_jumps(way: float) -> Callable[[Arrays, Lawful, Numbers], bool]:
    def change(a: Arrays, lawful: Lawful, rng: Numbers) -> bool:
        row = int(rng.integers(len(a["com"]) // 4, 3 * len(a["com"]) // 4))
        a["com"][row:] += way * _direction(rng)
        return True

    return change


def _contact_jumps(way: float) -> Callable[[Arrays, Lawful, Numbers], bool]:
    def change(a: Arrays, lawful: Lawful, rng: Numbers) -> bool:
        count, points = a["gaps"].shape
        row, point = int(rng.integers(count // 4, 3 * count // 4)), int(rng.integers(points))
        by = way * _direction(rng)
        a["contact_positions"][row:, point] += by
        size, loads = np.zeros((2, count, points))
        size[row:, point] = way
        loads[row:, point] = np.linalg.norm(
            np.cross(by, np.einsum("tij,tj->ti", lawful.rows.frames[:, point], lawful.rows.forces[:, point]))[
                row:
            ],
            axis=1,
        )
        w = lawful.rows.window(LIMITS.balance.smooth)
        along = size * abs(float(by[2])) / way
        return (
            lawful.over("contact jump", size) or lawful.over("gap place", along)
            or lawful.over("pressing", np.asarray(sliding_mean(loads.sum(axis=1), w)))
        )  # fmt: skip

    return change


def _velocities(scale: float) -> Callable[[Arrays, Lawful, Numbers], bool]:
    def change(a: Arrays, lawful: Lawful, rng: Numbers) -> bool:
        off = abs(scale - 1.0) * np.array(a["contact_velocities"])
        a["contact_velocities"] *= scale
        w = lawful.rows.window(LIMITS.continuity.gap_time)
        way = np.abs(sliding_sum(off[..., 2] * lawful.rows.dt[:, None], w))
        mean = np.linalg.norm(sliding_mean(off, lawful.rows.window(LIMITS.continuity.smooth)), axis=2)
        return lawful.over("gap rate", way) or lawful.over("contact velocity", mean)

    return change


def _gap_signs(a: Arrays, lawful: Lawful, rng: Numbers) -> bool:
    a["gaps"] *= -1.0
    return lawful.over("penetration", lawful.rows.gaps) or lawful.over(
        "gap place", 2.0 * np.abs(lawful.rows.gaps)
    )


def _late_rate(a: Arrays, lawful: Lawful, rng: Numbers) -> bool:
    change = np.diff(a["momentum_rate"][:, :3], axis=0, prepend=a["momentum_rate"][:1, :3])
    a["momentum_rate"][1:] = a["momentum_rate"][:-1].copy()
    w, dt = lawful.rows.window(LIMITS.balance.smooth), lawful.rows.dt[:, None]
    off = np.linalg.norm(sliding_sum(change * dt, w), axis=1) / (lawful.setting.weight / GRAVITY)
    missing = np.linalg.norm(sliding_mean(change, w), axis=1)
    return lawful.over("momentum", off) or lawful.over("balance", missing)


def _swapped(a: Arrays, lawful: Lawful, rng: Numbers) -> bool:
    """Tangents in the other order: left-handed contact axes."""
    f = np.array(a["forces"])
    a["forces"] = f[..., [1, 0, 2]]
    off = np.linalg.norm(
        sliding_mean((a["forces"] - f).sum(axis=1), lawful.rows.window(LIMITS.balance.smooth)), axis=1
    )
    return lawful.over("balance", off) or lawful.over("motion", off)


def _direction(rng: Numbers) -> FloatArray:
    out = rng.normal(size=3)
    return np.asarray(out / np.linalg.norm(out))


SPOILS = (
    Spoil("kick", f"a kick of {KICK:g} m/s in one row", (), None),
    Spoil("half", "half of the weight carried, and nothing falls", ("forces", "normals"), _half),
    Spoil("momentum x3", "momentum of three times the size", ("momentum",), _scaled(3.0)),
    Spoil("momentum x1.1", "momentum of 1.1 times the size", ("momentum",), _scaled(1.1)),
    Spoil("com 5 cm", "the centre of mass jumps by 5 cm", ("com",), _com_jumps(0.05)),
    Spoil("com 1 cm", "the centre of mass jumps by 1 cm", ("com",), _com_jumps(0.01)),
    Spoil("contact 5 cm", "a contact point jumps by 5 cm", ("contact_positions",), _contact_jumps(0.05)),
    Spoil("contact 1 cm", "a contact point jumps by 1 cm", ("contact_positions",), _contact_jumps(0.01)),
    Spoil("velocities x57.3", "contact velocities by degrees", ("contact_velocities",), _velocities(57.3)),
    Spoil("velocities x0.5", "contact velocities halved", ("contact_velocities",), _velocities(0.5)),
    Spoil("gap signs", "gaps of the other sign", ("gaps",), _gap_signs),
    Spoil("late rate", "the momentum's rate a row late", ("momentum_rate",), _late_rate),
    Spoil("frames", "forces with their tangents swapped", ("forces",), _swapped),
)  # fmt: skip


@dataclass(frozen=True)
class SpoilScore:
    """What came out for one way to spoil.

    Attributes
    ----------
    name, title
        Of the way.
    logs
        That have what it changes.
    exceed, found
        How many exceed the stated tolerance, and how many of those break a law.
    below, seen
        How many do not, and how many of those break a law all the same.
    missed
        Names of the logs that exceed it and were not found.
    """

    name: str
    title: str
    logs: int
    exceed: int
    found: int
    below: int
    seen: int
    missed: tuple[str, ...]


def lawful_log(log: Log) -> Lawful:
    """Return a log with its rows."""
    return Lawful(log, Rows(log, setting_of(log, None), 0, len(log)))


def spoil_log(one: PlainLog, lawful: Lawful, spoil: Spoil, seed: int) -> tuple[Log, bool] | None:
    """Return the spoilt log and whether it exceeds the tolerance; None where it lacks what is changed."""
    log = lawful.log
    if spoil.change is None:
        told = "momentum" in log or not lawful.setting.why_no_motion
        return one.make(True), told or KICK * lawful.setting.dt > 2.0 * LIMITS.continuity.way
    if any(name not in log for name in spoil.needs):
        return None
    arrays = {name: np.array(array) for name, array in log.arrays.items()}
    with np.errstate(all="ignore"):
        exceeds = spoil.change(arrays, lawful, np.random.default_rng([seed, 56]))
    return Log(arrays, log.facts, channels=log.channels), exceeds


def measure(most: int | None = None) -> Iterator[SpoilScore | str]:
    """Yield a line for each lawful log, of so many at most, that is called broken, and then the scores."""
    rows: dict[str, list[tuple[str, bool, bool]]] = {spoil.name: [] for spoil in SPOILS}
    for seed, one in enumerate(islice(plain_logs(), most)):
        log = one.make(False)
        report = audit_log(log)
        if report.verdict == "broken":
            yield f"{one.name}: {report.sentence}"
        lawful = lawful_log(log)
        for spoil in SPOILS:
            made = spoil_log(one, lawful, spoil, seed)
            if made is not None:
                found = audit_log(made[0]).verdict == "broken"
                rows[spoil.name].append((one.name, made[1], found))
    for spoil in SPOILS:
        all_of = rows[spoil.name]
        large, small = ([r for r in all_of if r[1] is want] for want in (True, False))
        yield SpoilScore(
            spoil.name, spoil.title, len(all_of), len(large), sum(r[2] for r in large), len(small),
            sum(r[2] for r in small), tuple(r[0] for r in large if not r[2]),
        )  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print JSON")
    given = parser.parse_args()
    out = list(measure())
    alarms, scores = [x for x in out if isinstance(x, str)], [x for x in out if isinstance(x, SpoilScore)]
    if given.json:
        print(json.dumps({"alarms": alarms, "spoils": [asdict(s) for s in scores]}))
        return
    print(f"{'spoil':18}{'logs':>6}{'exceed':>8}{'found':>8}{'below':>8}{'seen':>8}  missed")
    for s in scores:
        print(f"{s.name:18}{s.logs:6}{s.exceed:8}{s.found:8}{s.below:8}{s.seen:8}  {', '.join(s.missed)}")
    exceed, found = sum(s.exceed for s in scores), sum(s.found for s in scores)
    print(f"{found} of {exceed} that exceed the tolerance found ({100.0 * found / max(exceed, 1):.1f} %)")
    below, seen = sum(s.below for s in scores), sum(s.seen for s in scores)
    print(f"{seen} of {below} below it; {len(alarms)} alarms on lawful logs")
    for line in alarms:
        print("    " + line[:250])


if __name__ == "__main__":
    main()
