"""Measured tables of planning: shooting, schedules, softening, gradients."""

from __future__ import annotations

from typing import Any

from docs.measured import Rows, Table, printed

PROBLEMS = ("ball", "slide", "hopper", "push")
METHODS = ("given schedule", "own shooting", "direct method")


def _softening(data: Any, table: str, product: bool = True) -> Rows:
    """Return a row per form and a column per problem: solved, iterations, time, gap times impulse, cost."""
    cells: dict[str, dict[str, str]] = {}
    for row in data[table]:
        parts = [f"{row['solved']}/{row['starts']}", f"{row['iterations']:.0f}", f"{row['seconds']:.1f} s"]
        if product:
            parts.append(f"{row['product']:.0e}")
        if table in ("race", "recommended") and row["cost"]:  # none where nothing is chosen, null if unsolved
            parts.append(f"{row['cost']:.2f}")
        cells.setdefault(row["variant"], {})[row["problem"]] = ", ".join(parts)
    return [[variant, *(by[name] for name in PROBLEMS)] for variant, by in cells.items()]


def _steps_along(data: Any) -> Rows:
    """Return the median step along a search direction, and how often the Hessian was made convex."""
    cells: dict[str, dict[str, str]] = {}
    for row in data["race"]:
        said = f"{row['step']:.2f}, {100.0 * row['regularised']:.0f} %"
        cells.setdefault(row["variant"], {})[row["problem"]] = said
    return [[variant, *(by[name] for name in PROBLEMS)] for variant, by in cells.items()]


def _iteration(data: Any) -> Rows:
    """Return the milliseconds of an iteration's parts, here and on MuJoCo's steps."""
    found = data["solver"]
    own, both = 1e3 * found["dt"], 1e3 * found["rival_dt"]
    rows = {
        "ours": f"ours, knots of {own:g} ms",
        "same": f"ours, knots of {both:g} ms, no feet in the cost",
        "mujoco": f"MuJoCo, knots of {both:g} ms, `mjd_transitionFD`",
    }
    parts = ("derivative", "riccati", "rollout", "iteration")
    return [[name, *(f"{1e3 * found[key][part]:.2g}" for part in parts)] for key, name in rows.items()]


def _costs(data: Any) -> Rows:
    """Return the single figures of `bench plan`: what a knot, a tick and the first call take."""
    found, mpc = data["solver"], data["mpc"]
    tick = mpc["tick"]["processor"]
    names = {"ours": "here", "mujoco": "on MuJoCo"}
    knots = ", ".join(f"{name} {1e6 * seconds:.0f}" for name, seconds in found["knot"].items())
    descents = [
        f"{names[key]} from {one['costs'][0]:.2f} to {one['costs'][-1]:.2f} in {1e3 * one['seconds']:.0f} ms"
        for key, one in found["descent"].items()
    ]
    return [
        ["a knot of Go2 on four feet [µs]", knots],
        ["differences on MuJoCo / derivatives", f"{found['derivative_ratio']:.0f} times as long"],
        ["ten iterations", "; ".join(descents)],
        ["a whole tick of the controller", f"median {1e3 * tick['median']:.1f} ms"],
        ["... 99th percentile", f"{1e3 * tick['p99']:.1f} ms ({1.0 / tick['p99']:.0f} Hz)"],
        ["... the first, from nothing", f"{1e3 * mpc['first_tick']:.0f} ms"],
    ]


def _without_gait(data: Any) -> Rows:
    """Return a row per walk of the contact-implicit controller; all pushes in one."""
    found = data["mpc"]

    def row(name: str, up: str, *walks: Any) -> list[str]:
        def mean(key: str) -> float:
            return sum(float(w[key]) for w in walks) / len(walks)

        speeds = sorted(w["speed"] for w in walks)
        speed = f"{speeds[0]:.3f}" if len(walks) == 1 else f"{speeds[0]:.2f} to {speeds[-1]:.2f}"
        return [
            name, up, speed, f"{max(w['tilt'] for w in walks):.1f}°", f"{mean('duty'):.2f}",
            f"{mean('together'):.2f}", f"{mean('apart'):.2f}", f"{mean('stride'):.1f}",
            f"{1e3 * mean('clearance'):.0f} mm", f"{-1e3 * min(w['depth'] for w in walks):.1f} mm",
        ]  # fmt: skip

    def count(walks: Any) -> str:
        return f"{sum(w['done'] for w in walks)} of {len(walks)}"

    long, pushes, drawn = found["walk"], found["pushes"], found["drawn"]
    rows = [
        row(f"{long['seconds']:.0f} s at 0.5 m/s", "yes" if long["done"] else "no", long),
        row("60 N for 0.1 s, four directions, three phases of the stride", count(pushes), *pushes),
    ]
    if drawn:
        rows.append(row("friction, payload and two pushes by chance", count(drawn), *drawn))
    named = found["variants"].items()
    return [*rows, *(row(name, "yes" if walk["done"] else "no", walk) for name, walk in named)]


def _plans(data: Any) -> Rows:
    names = ("`jump 0.4`", "`jump-up 0.2`", "`backflip`")
    return [
        [name, plan["status"], plan["goal"], f"{plan['law_residual']:.1e}"]
        for name, plan in zip(names, data, strict=True)
    ]


def _executed(data: Any) -> Rows:
    return [
        [
            row["task"], row["motors"], f"{row['landed']} of {row['seeds']}", str(row["lawful"]),
            f"{row['torque_use_max']:.2f}", f"{row['speed_use_max']:.2f}", f"{row['moved']:.2f} m",
            "-" if row["task"] == "stand-up" else f"{row['turned']:.0f}°",
        ]
        for row in data
    ]  # fmt: skip


def _slopes(data: Any, title: str, *columns: str) -> Rows:
    """Return a row per method and a column per task, the named cells of each together."""

    def short(cell: str) -> str:
        number = float(cell.removesuffix(" %"))
        return f"{number:.0f}" if number >= 100.0 else f"{number:.2g}"

    cells: dict[str, list[str]] = {}
    for table in data:
        if title in table["title"]:
            for method, *found in printed([table], title, "method", *columns):
                cells.setdefault(method, []).append(" / ".join(map(short, found)))
    return [[method, *row] for method, row in cells.items()]


def _searches(data: Any) -> Rows:
    cells: dict[str, list[str]] = {}
    for table in data:
        if "steps downhill" in table["title"]:
            names = ("method", "arrived", "off the best (median)", "CPU s a search")
            for method, arrived, off, spent in printed([table], "steps downhill", *names):
                cells.setdefault(method, []).append(f"{arrived}, {off}, {spent} s")
    return [[method, *row] for method, row in cells.items()]


HOPPER = "python -m benchmarks.three_methods"
GRADIENTS = "python -m benchmarks.gradients"
SOFTENING = "surefoot bench softening --table race --table recommended --starts 5"
PLAN = "surefoot bench plan"
FROM_STARTS = (
    "method", "own start", "CPU s", "iterations", "cost", "law residual", "misses by", "random starts",
    "CPU s, median", "cost, median",
)  # fmt: skip
FIVE_TASKS = ("", "ball and wall", "pushed block", "hopper", "friction of a slide", "Go2 landing")
BY_PROBLEM = ("form", *PROBLEMS)
WITHOUT_GAIT = (
    "", "up", "m/s", "lean", "duty", "diagonal", "front apart", "strides/s", "clearance", "depth",
)  # fmt: skip
EXECUTED = ("plan", "motors", "landed", "lawful", "torque use", "speed use", "moved", "turned")

TABLES = {
    "race": Table(SOFTENING, "reports/softening.md", BY_PROBLEM, lambda data: _softening(data, "race")),
    "recommended": Table(
        SOFTENING, "reports/softening.md", BY_PROBLEM, lambda data: _softening(data, "recommended"),
    ),
    "causes": Table(
        "surefoot bench softening --table causes --few 4", "reports/softening.md", BY_PROBLEM,
        lambda data: _softening(data, "causes"),
    ),
    "progress": Table(SOFTENING, "reports/softening.md", BY_PROBLEM, _steps_along),
    "first": Table(
        "surefoot bench softening --table first --few 4", "reports/softening.md", BY_PROBLEM,
        lambda data: _softening(data, "first", product=False),
    ),
    "methods": Table(
        HOPPER, "three-methods.md", FROM_STARTS, lambda data: printed(data, "from its own start")
    ),
    "changes": Table(
        HOPPER, "three-methods.md", ("change", *METHODS), lambda data: printed(data, "task is changed")
    ),
    "by_hand": Table(
        HOPPER, "three-methods.md", ("take-off", "touchdown", "given schedule"),
        lambda data: printed(data, "schedules by hand"),
    ),
    "bias": Table(
        GRADIENTS, "reports/gradients.md", FIVE_TASKS,
        lambda data: _slopes(data, "slopes at", "bias, exact slope")
    ),
    "bias_smoothed": Table(
        GRADIENTS, "reports/gradients.md", FIVE_TASKS,
        lambda data: _slopes(data, "slopes at", "bias, smoothed loss")
    ),
    "scatter": Table(
        GRADIENTS, "reports/gradients.md", FIVE_TASKS,
        lambda data: _slopes(data, "slopes at", "spread of a sample", "wrong way"),
    ),
    "searches": Table(GRADIENTS, "reports/gradients.md", FIVE_TASKS, _searches),
    "without_gait": Table(PLAN, "contact-implicit-mpc.md", WITHOUT_GAIT, _without_gait),
    "iteration": Table(
        PLAN, "shooting.md", ("ms", "derivatives", "Riccati", "rollout", "iteration"), _iteration
    ),
    "costs": Table(PLAN, "shooting.md", ("processor time, one core", ""), _costs),
    "plans": Table(
        "surefoot plan jump 0.4 --no-video --no-report; surefoot plan jump-up 0.2 --no-video --no-report; "
        "surefoot plan backflip --no-video --no-report", "schedules.md",
        ("command", "status", "what the motion does", "law residual"), _plans,
        said="`surefoot plan jump 0.4 --no-video --no-report`; "
        "`surefoot plan jump-up 0.2 --no-video --no-report` (exit code 1); "
        "`surefoot plan backflip --no-video --no-report`",
    ),
    "executed": Table(
        "surefoot bench execution", "reports/executing-plans.md", EXECUTED, _executed, long=True,
    ),
}  # fmt: skip
