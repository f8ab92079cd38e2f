"""Measured tables of solvers, worlds and batches: contact, statics, forces, what speed costs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from docs import speed_tables
from docs.measured import Rows, Table


def _rigid(data: Any) -> Rows:
    def line(name: str, cell: Callable[[Any], str]) -> list[str]:
        return [name, *(cell(world) for world in data)]

    return [
        line("wall time of one simulated second, controller included", lambda w: f"{w['wall']:.3f} s"),
        line("world step, median", lambda w: f"{1e6 * w['step']['median']:.0f} µs"),
        line(
            "resting force against m g, worst of the last half second",
            lambda w: f"{100.0 * w['weight_error']:.3f} %",
        ),
        line("deepest penetration", lambda w: f"{1e3 * w['penetration']:.4f} mm"),
        line(
            "energy beyond the start's and the motors' work",
            lambda w: "" if w["energy_made"] is None else f"{max(0.0, w['energy_made']):.1g} J",
        ),
    ]


def _against_mujoco(data: str) -> Rows:
    """Return the figures of examples/26_rigid_and_mujoco.py, a column per world and one for a convex law."""
    lines = (line.split() for line in data.splitlines() if "picture" not in line)
    fact = {name: float(value) for name, value in lines}

    def line(name: str, key: str, unit: str, digits: str) -> list[str]:
        keys = (f"{world}_{key}" for world in ("rigid", "mujoco", "convex"))
        return [name, *(f"{fact[key]:{digits}} {unit}" if key in fact else "" for key in keys)]

    apart = ", ".join(f"{fact[f'standing_{deg}deg_percent']:.2f} % ({deg}°)" for deg in (0, 10))
    closed = f"{fact['closed_form_distance']:.5f} m"
    return [
        ["standing Go2 on slopes, largest difference of a foot's force", "", apart, ""],
        line(f"block pushed at 2 m/s, mu = 0.5: distance ({closed} by the formula)", "distance", "m", ".5f"),
        line("mean normal force over the slide (19.62 N)", "mean_force", "N", ".2f"),
        line("largest normal force", "largest_force", "N", ".4g"),
        line("highest the block rises", "highest_mm", "mm", ".2g"),
        line("creep of a block that should stick on 20°", "creep", "m/s", ".2g"),
    ]


def _verdicts(data: Any) -> Rows:
    names = ("possible", "agreed", "in_band", "disagreed", "verified")
    return [[c["rival"], *(f"{c[name]} of {c['cases']}" for name in names)] for c in data["agreement"]]


def _questions(data: Any) -> Rows:
    rows, last = [], ""
    for race in data["speed"]:
        times = (f"{1e6 * race['timing'][key]:.0f}" for key in ("median", "p99"))
        question = race["question"] if race["question"] != last else ""
        rows.append([question, race["who"], *times, f"{race['ratio']:.2f}"])
        last = race["question"]
    return rows


def _batches(data: Any) -> Rows:
    """Return microseconds a problem without and with its gradient; rivals where they ran."""
    times, error = data["times"], data["velocity_error"]
    rows = {
        "compiled loop, one thread": ("compiled loop, solve", "compiled loop, solve and vjp"),
        "`solve_batch`, one thread": ("solve_batch, one thread", "solve_batch, one thread, with vjp"),
        "`solve_batch`, all threads": ("solve_batch, all threads", "solve_batch, all threads, with vjp"),
        f"Pinocchio's ADMM in a loop, at {error['Pinocchio']:.1e}": ("Pinocchio ADMM, solve", ""),
        "JAX through 200 sweeps, batched": ("", "JAX through sweeps, with vjp"),
    }
    cells = {
        name: [f"{1e6 * times[key]:.2f}" if key in times else "" for key in both]
        for name, both in rows.items()
    }
    return [[name, *both] for name, both in cells.items() if any(both)]


def _accuracy(data: Any) -> Rows:
    """Return how exact `ForceDistributor` is, a column per force weight."""
    found = list(data["accuracy"].values())

    return [
        ["not solved", *(f"{one['not_solved']} of {one['instances']}" for one in found)],
        [
            "from the optimum: median / 99 % / worst",
            *(" / ".join(f"{value:.1e}" for value in one["error"]) + " N" for one in found),
        ],
        ["worst cone violation", *(f"{one['cone_violation']:.1e} N" for one in found)],
    ]


def _comparison(data: Any) -> Any:
    """Return the comparison of solvers that `bench contact` printed; null stands for infinity."""
    from benchmarks.contact.comparison import Comparison, Run

    runs = ({name: np.inf if value is None else value for name, value in run.items()} for run in data["runs"])
    return Comparison(data["tol"], tuple(Run(**run) for run in runs))


def contact(data: Any) -> Rows:
    """Return a row per contact solver: problems solved, and the median times of both kinds."""
    found = _comparison(data)
    rows = []
    for name in sorted(found.solvers, key=lambda name: name != found.ours_fresh):
        ready, fresh = (found.families(name, kind)[-1] for kind in ("ready", "fresh"))
        label = {found.ours_fresh: "`ContactSolver`", "auto": "`auto` (`ContactProblem` and `solve`)"}.get(
            name, name if " " in name else f"`{name}`"
        )
        solved = f"{ready.solved} of {ready.problems}"
        rows.append([label, solved, *(f"{1e6 * row.median:.1f}" for row in (ready, fresh))])
    return rows


def families(data: Any) -> Rows:
    """Return a row per family of contact problems: our times with a new G, and Pinocchio's best over them."""
    found = _comparison(data)
    who = found.ours_fresh
    rivals = [name for name in found.solvers if name.startswith("pinocchio")]
    ratios = found.ratios(rivals, who, "fresh")
    ratios["all"] = [x for group in ratios.values() for x in group]
    rows = []
    for row in found.families(who, "fresh"):
        own = np.array(ratios.get(row.family, []))
        numbers = (1e6 * row.median, 1e6 * row.p99)
        ratio = (f"{np.exp(np.mean(np.log(own))):.2f}", f"{own.min():.2f}") if own.size else ("no rival", "")
        rows.append([row.family, *(f"{x:.1f}" for x in numbers), *ratio])
    return rows


def readme(data: Any) -> Rows:
    """Return what questions take here and elsewhere: forces, statics, contact and MPC."""
    forces, statics, contacts, walk, standing = data
    exact = {name: cells for name, *cells in speed_tables.allocation(forces)}
    short = {name: cells[0].split(" / ")[0] for name, cells in exact.items()}
    facets = {name: float(time) for name, time in short.items() if "8 facets" in name}
    best = min(facets, key=facets.__getitem__)
    share = f"{best} {facets[best]:g} µs; Clarabel, exact, {short['Clarabel, exact']} µs"
    asked = {(race["question"], race["who"]): 1e6 * race["timing"]["median"] for race in statics["speed"]}
    new = [f"{time:.0f}" for (question, _), time in asked.items() if "what is new" in question]
    stand = [
        f"{who} {time:.0f} µs"
        for (question, who), time in asked.items()
        if question.startswith("can it stand, 4 points (") and not who.startswith("surefoot")
    ]
    by = {row[0]: row[1:] for row in contact(contacts)}
    auto = next(row for name, row in by.items() if name.startswith("`auto`"))
    rivals = "; ".join(
        f"{said} {by[name][1]}, {by[name][2]} µs ({by[name][0]})"
        for name, said in NAMED_RIVALS.items()
        if name in by
    )
    plans = {row[0]: row[1:] for row in speed_tables.horizons(walk)}
    mpc = [[plans[scene][k].split(" / ")[0] for scene in ("trot", "limit")] for k in range(3)]
    step = next(row[2] for row in speed_tables.steps(walk) if row[1] == "whole step")
    return [
        ["share a wrench among four feet", short["Surefoot, exact"], share, "`surefoot bench forces`"],
        [
            "can it stand on four feet? asked again; a fresh stance; building it, too", "; ".join(new),
            "; ".join(stand), "`surefoot bench statics`",
        ],
        [
            "solve a contact problem, Coulomb's law, 1 to 25 contacts, to 1e-9: a ready one; a new matrix "
            f"each call ({by['`ContactSolver`'][0]} solved)",
            f"{auto[1]}; {by['`ContactSolver`'][2]}", rivals, "`surefoot bench contact`",
        ],
        [
            "plan ten steps of a trot; at its friction limit (MPC)", "; ".join(mpc[0]),
            f"the solve alone: fastest QP with facets {', '.join(mpc[1])} µs; Clarabel, exact, "
            f"{', '.join(mpc[2])} µs", "`surefoot bench walk`",
        ],
        ["step of the walking controller, plans included; 99th percentile", step.replace(" / ", "; "), "",
         "`surefoot bench walk`"],
        ["step of the standing controller, on four feet, pushed",
         f"{standing['controller_step_us']['median']:.0f}", "", "`surefoot stand`"],
    ]  # fmt: skip


STATICS, FORCES = "surefoot bench statics", "surefoot bench forces"
CONTACT, WALK = "surefoot bench contact", "surefoot bench walk"
STAND = "surefoot stand go2 --push 3:0,40,0:0.2 --no-video --no-report"
NAMED_RIVALS = {
    "pinocchio pgs": "Pinocchio's PGS",
    "pinocchio admm": "its ADMM",
    "pinocchio admm spectral anderson": "with Anderson acceleration",
    "siconos nsgs": "Siconos' NSGS",
}
"""Those that the README compares with; docs/reports/choosing-a-solver.md has all."""
WARM = (
    "trajectory", "cones active in", "iterations", "cold", "warm", "ratio", "loop: cold", "loop: warm",
    "loop: ratio",
)  # fmt: skip
SCENES = ("scene", "Surefoot, exact cones", "fastest QP, 4 or 8 facets", "Clarabel, exact cones")
VERDICTS = ("against", "possible", "agree", "differ within 1e-7 of the load", "differ", "verified")
WEIGHTS = ("", "force weight 0.1", "force weight 0.01", "force weight 1e-4")

TABLES = {
    "rigid": Table("surefoot bench rigid go2", "reports/rigid-world.md", ("", "rigid", "MuJoCo"), _rigid),
    "against_mujoco": Table(
        "python examples/26_rigid_and_mujoco.py", "reports/rigid-world.md",
        ("", "rigid", "MuJoCo", "rigid, convex law"), _against_mujoco, reads=str,
    ),
    "verdicts": Table(STATICS, "reports/statics.md", VERDICTS, _verdicts),
    "questions": Table(
        STATICS, "reports/statics.md", ("question", "who", "median [µs]", "99 % [µs]", "ratio"), _questions
    ),
    "contact": Table(
        CONTACT, "reports/choosing-a-solver.md",
        ("solver", "solved", "ready problem, median [µs]", "new G each call"), contact,
    ),
    "families": Table(
        CONTACT, "reports/choosing-a-solver.md", ("family", "median [µs]", "99 % [µs]", "ratio", "least"),
        families
    ),
    "batches": Table(
        "surefoot bench batch", "batches.md",
        ("four contacts of Go2, µs a problem", "solve", "solve and vjp"), _batches,
    ),
    "allocation": Table(
        FORCES, "reports/force-distribution.md", ("", "easy", "near the boundary", "wrench out of reach"),
        speed_tables.allocation,
    ),
    "warm": Table(FORCES, "reports/force-distribution.md", WARM, speed_tables.warm_starts),
    "accuracy": Table(
        f"{FORCES} --instances 10000 --count 2 --no-stands", "force-distribution.md", WEIGHTS, _accuracy,
    ),
    "horizons": Table(WALK, "reports/mpc.md", SCENES, speed_tables.horizons),
    "steps": Table(WALK, "reports/walking.md", ("robot", "call", "median / 99 % [µs]"), speed_tables.steps),
    "readme": Table(
        "; ".join((FORCES, STATICS, CONTACT, WALK, STAND)), "speed.md",
        ("question", "Surefoot, exact cones, median [µs]", "rivals", "command"), readme,
    ),
}  # fmt: skip
