"""Forces of feet alone, without joints: symptoms that forces, gaps and velocities tell."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.limit_cases.made import MU, Made
from benchmarks.limit_cases.verdict import Verdict, audited, clean, named
from surefoot.base.arrays import FloatArray
from surefoot.records.audit import AuditReport


def symptom_cases() -> Iterator[Verdict]:
    """Yield the cases of symptoms."""
    yield from _pyramids()
    yield from _air()
    yield from _blows()
    yield from _chatter()
    yield from _repeated()
    yield from _order()
    reversed_log = Made(600)
    reversed_log.forces *= -1.0
    why = "the force on the ground: all of the weight, with the other sign"
    yield named("all forces reversed", why, reversed_log.log(), "reversed")
    pulled = Made(600)
    pulled.forces[200:320, 0, 2] *= -0.4
    yield named("one foot pulled", "suction of a tenth of the weight; the others carry", pulled.log(), "pull")


def _on_pyramid(facets: int, phase: float, angle: FloatArray, noise: float = 0.0) -> Made:
    """Return forces on the edge of a pyramid about the cone, at angles [rad], as far as they are outside."""
    rows = len(angle)
    made, sector = Made(rows), 2.0 * np.pi / facets
    off = (angle - phase + 0.5 * sector) % sector - 0.5 * sector
    rng = np.random.default_rng(2)
    reach = MU / np.cos(off) * (1.0 + noise * rng.uniform(-1.0, 1.0, rows))
    made.forces[:, 0, 0] = reach * np.cos(angle) * made.forces[:, 0, 2]
    made.forces[:, 0, 1] = reach * np.sin(angle) * made.forces[:, 0, 2]
    return made


def _pyramids() -> Iterator[Verdict]:
    round_about = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, 400)
    why = "a solver's tolerance of 0.35 % on every force"
    for facets, phase in ((4, 0.0), (4, 0.1), (4, 0.3), (8, 0.2)):
        made = _on_pyramid(facets, phase, round_about, 3.5e-3)
        yield named(f"a pyramid of {facets} turned by {phase:g}", why, made.log(), "coarse facets")
    corner = _on_pyramid(4, 0.0, np.full(400, 0.25 * np.pi), 3.5e-3)
    yield named("a corner of a pyramid", why, corner.log(), "coarse facets")
    few = _on_pyramid(4, 0.0, np.full(400, 0.25 * np.pi))
    few.forces[10:, 0, :2] = 0.0
    yield named("ten rows in a corner", "a touch of 10 ms at 1 kHz", few.log(), "coarse facets")
    for name, size, angle, why in (
        ("one direction", 1.2, 0.4 + 0.02 * np.sin(np.arange(400.0)), "a shove that turns by a degree"),
        ("all directions", 1.085, round_about, "a floor of 0.65 that was measured as 0.6"),
        ("two rows", 1.2, np.where(np.arange(400) == 0, 0.3, 0.8), "two samples are on some square always"),
        ("two percent", 1.02, np.full(400, 0.0), "friction is known to the second digit"),
    ):
        made = Made(400)
        made.forces[:, 0, 0] = size * MU * np.cos(angle) * made.forces[:, 0, 2]
        made.forces[:, 0, 1] = size * MU * np.sin(angle) * made.forces[:, 0, 2]
        if name == "two rows":
            made.forces[2:, 0, :2] = 0.0
        yield named(f"too much friction in {name}", why, made.log(), "too much friction")
    noisy = _on_pyramid(4, 0.0, round_about)
    rng, light = np.random.default_rng(6), slice(0, 80)
    noisy.forces[light, 0] = 2e-3 * noisy.weight * np.array([1.0, 0.0, 1.0])
    noisy.forces[light, 0, :2] *= 3.0 * rng.uniform(0.5, 1.0, (80, 1))
    why = "as the foot comes down it reads 0.2 % of the weight, and as much across: a cell's noise"
    yield named("a pyramid after a touchdown", why, noisy.log(), "coarse facets")


def _air() -> Iterator[Verdict]:
    for gap, normal, share, symptom, why in (
        (0.01, 7e-4, 1.0, "friction in the air", "a cell with an offset of 0.07 %, in the air"),
        (0.01, 0.0, 0.75, "friction in the air", "a stale contact that is dropped in every fourth row"),
        (0.01, 0.25, 1.0, "invisible geometry", "a foot that carries its quarter 1 cm above the ground"),
    ):
        made = Made(600)
        part = slice(200, 400)
        made.gaps[part, 0] = gap
        made.forces[part, 0] = made.weight * np.array([0.05, 0.0, normal])
        made.forces[part, 0, 2] *= 1.0 + 1e-3 * np.sin(np.arange(200.0))
        if share < 1.0:
            made.forces[part, 0, :][::4] = 0.0
        name = f"{normal:g} m g at a gap of {1e3 * gap:g} mm in {share:.0%} of the rows"
        yield named(name, why, made.log(), symptom)
    stepped = Made(600)
    stepped.gaps[200:400, 0] = 0.01
    stepped.forces[200:400, 0, 0] = 0.05 * stepped.weight
    stepped.forces[200:220, 0, 2] = 5e-4 * stepped.weight
    why = "a step that the map does not know: for 20 ms of 200 the foot only brushes it"
    yield named("a foot on an unknown step", why, stepped.log(), "invisible geometry")
    for gap, law, why in (
        (5e-5, "no forces", "forces that were never read, gaps to 0.05 mm"),
        (0.02, "", "a jump: feet 2 cm above the ground carry nothing"),
    ):
        made = Made(600)
        part = slice(200, 500)
        made.forces[part], made.gaps[part] = 0.0, gap
        if law:
            made.forces[part][::97] = 0.25 * made.weight * np.array([0.0, 0.0, 1.0])
        log = made.log()
        name = f"nothing carries at a gap of {1e3 * gap:g} mm"
        yield named(name, why, log, law) if law else clean(name, why, log)


def _blows() -> Iterator[Verdict]:
    for impulse, rows, symptom, why in (
        (1.0, 1, "", "a foot that stops all of its robot within a row takes its momentum once"),
        (10.0, 1, "one step impulse", "a force that was read as impulse over a step ten times too short"),
        (10.0, 2, "one step impulse", "the same between two samples"),
    ):
        made = Made(600)
        speed, mass = 0.5, float(made.facts["mass"])
        made.velocities[298:301, 0, 2] = -speed
        made.forces[300 : 300 + rows, 0, 2] = impulse * mass * speed / 1e-3 / rows
        name = f"{impulse:g} m v in {rows} row"
        log = made.log()
        yield named(name, why, log, symptom) if symptom else audited(name, why, log, _no_blow)


def _no_blow(report: AuditReport) -> bool:
    return "one step impulse" not in {found.name for found in report.symptoms}


def _chatter() -> Iterator[Verdict]:
    made = Made(800)
    part, on = slice(200, 500), (np.arange(300) // 5) % 2
    size = 0.5 * made.weight * on
    made.forces[part, 0, 2] = size
    made.velocities[part, 0, 0] = np.where(on, 0.2, 0.0)
    made.forces[part, 0, 0] = np.where(on, -MU * size, 0.0)
    why = "it rings and slides only while it is loaded, as friction lets it"
    yield named("chatter under load", why, made.log(), "chatter")


def _repeated() -> Iterator[Verdict]:
    for name, dt, held, symptom, why in (
        ("a stale sensor at 500 Hz", 2e-3, 10**6, "frozen", "the same sample throughout"),
        ("a cell of twelve bits at 200 Hz", 5e-3, 6, "", "a stand's force stays in one step of 30 ms"),
        ("a sensor of 25 Hz at 1 kHz", 1e-3, 40, "frozen", "forty rows are one sample"),
    ):
        made = Made(800, dt=dt)
        part = slice(200, 600)
        if symptom:
            rows = 200 + (np.arange(400) // held) * held
            made.forces[part, 0] = made.forces[np.minimum(rows, 599), 0]
        else:
            rows = (np.arange(800) // held) * held
            made.forces = made.forces[rows]
        log = made.log()
        yield named(name, why, log, symptom) if symptom else clean(name, why, log)
    for speed, symptom, why in (
        (1e-8, "", "statics solved to 1e-8: nothing is said to move"),
        (1e-3, "frozen", "a body that sways by a millimetre in a second, and forces that do not change"),
    ):
        made = Made(800)
        made.forces[:] = made.forces[:1]
        made.more["v"] = speed * np.cos(np.arange(800.0))[:, None] * np.ones(6)
        log = made.log()
        name = f"constant forces while it moves at {speed:g} m/s"
        yield named(name, why, log, symptom) if symptom else clean(name, why, log)


def _order() -> Iterator[Verdict]:
    """Yield two things in one log: what breaks a law comes before what breaks none."""
    for name, add in (("chatter", _rings), ("skating", _skates), ("leaning", _leans)):
        made = Made(1500)
        made.gaps[900:1100, 1] = 0.01
        add(made)
        why = "the other breaks no law"
        yield named(f"a foot held 1 cm up, and {name}", why, made.log(), "invisible geometry")


def _rings(made: Made) -> None:
    made.forces[200:500, 0, 2] *= np.where((np.arange(300) // 5) % 2, 1.5, 0.0)


def _skates(made: Made) -> None:
    _rings(made)
    made.velocities[200:500, 0, 0] = np.where((np.arange(300) // 5) % 2, 0.0, 0.2)


def _leans(made: Made) -> None:
    made.forces[200:500, [0, 3], 2] *= 1.6
    made.forces[200:500, [1, 2], 2] *= 0.4
