"""Measured tables of walking: stacks, speeds, motors, loads, estimates, faults, sweeps."""

from __future__ import annotations

from typing import Any

from docs.measured import Rows, Table, printed


def _stacks(data: Any, *beginnings: str, without: tuple[str, ...] = ()) -> Rows:
    """Return a row per task of Surefoot's whose name begins with one of some words, all without any."""

    def cell(value: float | None, digits: int, scale: float = 1.0) -> str:
        return "-" if value is None else f"{scale * value:.{digits}f}"

    rows = []
    for row in data["rows"]:
        name = row["task"]
        if row["stack"] != "surefoot" or not name.startswith(beginnings or ("",)) or name.endswith(without):
            continue
        low, high = (100.0 * row["survival"][end] for end in ("low", "high"))
        faults = "; ".join(f"{fault}: {count}" for fault, count in row["faults"].items())
        rows.append(
            [
                f"`{name}`{'*' if row['must'] else ''}",
                f"{row['survived']}/{row['trials']} ({low:.0f} to {high:.0f} %)",
                str(row["held"]),
                cell(row["forward"], 3),
                cell(row["slip"], 1, 1e3),
                cell(row["cost_of_transport"], 2),
                cell(row["torque_use"], 2),
                cell(row["speed_use"], 2),
                f"{cell(row['step_us'], 0)}, {cell(row['step_p99_us'], 0)}",
                cell(row["real_time"], 1),
                faults.replace("|", "/"),
            ]
        )
    return rows


def _speeds(data: Any) -> Rows:
    rows = []
    for row in data:
        vx, _, turn = row["wanted"]
        name = f"{vx:g} m/s" if vx else f"turning at {turn:g} rad/s"
        if row["wanted"] != row["commanded"]:
            name += f", slowed to {row['commanded'][0]:.3g}"
        rows.append(
            [
                name, str(row["good"]), str(row["lawful"]), f"{row['error']:.3f}", f"{1e3 * row['slip']:.1f}",
                f"{row['speed_use']:.2f}", f"{row['torque_use']:.2f}",
                f"{row['rate']:.1f}, {row['usual_rate']:.1f}",
            ]
        )  # fmt: skip
    return rows


def _motor_speeds(data: Any) -> Rows:
    """Return a row per trot of `benchmarks.actuators`; its name is speed, motors and commands."""
    rows, last = [], ""
    for walk, *cells in printed(
        data, "speeds", "walk", "laws and limits kept", "velocity [m/s]", "slip [mm]", "fastest joint [%]",
        "beyond its speed [%]", "torque cut off [%]",
    ):  # fmt: skip
        speed, motors, commands = walk.split(", ")
        rows.append(["" if speed == last else speed, f"{motors}, {commands}", *cells])
        last = speed
    return rows


def _loads(data: Any, title: str) -> Rows:
    """Return a row per walk of `benchmarks.loads`: without and with the observer."""
    columns = (
        "walk", "observer", "walked", "lawful", "lean [deg]", "after 2 s", "velocity off [m/s]", "slip [mm]",
        "found [kg]", "at [m]",
    )  # fmt: skip
    rows: dict[str, dict[str, list[str]]] = {}
    for walk, observer, *cells in printed(data, title, *columns):
        rows.setdefault(walk, {})[observer] = cells
    out = []
    for walk, by in rows.items():
        off, on = by["off"], by["on"]
        both = [f"{a}, {b}" for a, b in zip(off[:6], on[:6], strict=True)]
        out.append([walk, *both, f"{on[6]} kg at {on[7]}" if on[7] else f"{on[6]} kg"])
    return out


def _payloads(data: Any) -> Rows:
    """Return the payloads of one seed and the one that was walked with many."""
    few, many = data
    found = {row[0]: row for row in _loads(few, "payloads")}
    for row in _loads(many, "payloads"):
        found[row[0]] = [f"{row[0]}, 20 seeds", *row[1:]]
    return list(found.values())


def _faults(data: Any) -> Rows:
    """Return the largest level of every fault that all seeds survived, and the next one."""
    return [
        [
            f"{row['title']} [{row['unit']}]",
            "none" if row["survived"] is None else f"{row['survived']:g}",
            "(last level)" if row["next_level"] is None else f"{row['next_level']:g}",
        ]
        for row in data["faults"]
    ]


def _seeded_faults(data: Any) -> Rows:
    """Return what is done to a log, what should be found, and how often it was found right."""
    return [
        [
            f"`{row['name']}`", row["title"], f"{row['amplitude']:.3g} {row['unit']}".strip(),
            row["symptom"] or "cannot tell", f"{row['noticed']} of {row['trials']}",
            f"{row['found']} of {row['trials']}",
        ]
        for row in data["faults"]
    ]  # fmt: skip


def _alarms(data: Any) -> Rows:
    """Return all faults together, and clean runs that were called otherwise."""
    found, noticed, trials = (
        sum(row[key] for row in data["faults"]) for key in ("found", "noticed", "trials")
    )
    return [[f"{found} of {trials}", f"{noticed} of {trials}", f"{len(data['alarms'])} of {data['clean']}"]]


def _spoils(data: Any) -> Rows:
    """Return what is done to lawful logs, and how many of those that it makes contradictory are found."""
    rows = [
        [
            f"`{row['name']}`", row["title"], f"{row['logs']}", f"{row['found']} of {row['exceed']}",
            f"{row['seen']} of {row['below']}",
        ]
        for row in data["spoils"]
    ]  # fmt: skip
    logs, found, exceed, seen, below = (
        sum(row[key] for row in data["spoils"]) for key in ("logs", "found", "exceed", "seen", "below")
    )
    alarms = f"all; called broken without a spoil: {len(data['alarms'])} of 30"
    return [*rows, ["", alarms, f"{logs}", f"{found} of {exceed}", f"{seen} of {below}"]]


def _walks(data: Any) -> Rows:
    """Return a row per walk: what was wanted and came, in the largest component, slip and the laws."""
    rows = []
    for said, found in zip(WALKS, data, strict=True):
        parts = {name: found["velocity"][name] for name in ("forward", "left", "turn")}
        name, part = max(parts.items(), key=lambda item: abs(item[1]["commanded"]))
        unit = {"forward": "m/s", "left": "m/s to the left", "turn": "rad/s"}[name]
        slip = max(foot["slip"] for foot in found["feet"])
        laws = "kept" if not found["laws_broken"] else "; ".join(found["laws_broken"])
        climb = f", {abs(found['climb']):.1f} m {'up' if found['climb'] > 0.0 else 'down'}"
        moved = f"{part['measured']:.3f} {unit}" + (climb if "slope" in said or "stairs" in said else "")
        rows.append([f"`{said}`", moved, f"{1e3 * slip:.2g} mm", laws])
    return rows


def _bins(data: Any, parameter: str) -> Any:
    return data["parameters"][parameter]


def _timid(data: Any) -> Rows:
    """Return shares and median velocities of the narrow and the wide sweep over the commanded speed."""
    return [
        [
            narrow["bin"],
            *(f"{one['value']:.3f}" for one in (narrow, wide)),
            *(f"{one['medians']['velocity']:.2f}" for one in (narrow, wide)),
        ]
        for narrow, wide in zip(*(_bins(one, "speed") for one in data), strict=True)
    ]


def _soft(data: Any) -> Rows:
    """Return medians of the sweep over the ground's softness."""
    scales = {
        "sink": (1e3, ".2g"),
        "ground_work": (1.0, ".2f"),
        "slip": (1e3, ".2g"),
        "laws_broken": (1.0, "g"),
    }

    def cell(value: float, form: str) -> str:
        return f"{float(f'{value:{form}}'):g}" if form.endswith("g") else f"{value:{form}}"

    return [
        [row["bin"], *(cell(scale * row["medians"][name], form) for name, (scale, form) in scales.items())]
        for row in _bins(data, "time_constant")
    ]


TASKS = "speed- turn-3 push- payload- ice slope- stairs- delay noise weak-joint robot- estimate"
EVERY_TASK = "surefoot bench stacks --stack surefoot --seeds 20"
STACKS = " ".join([EVERY_TASK, *(f"--task {name}" for name in TASKS.split())])
STACK_COLUMNS = (
    "task", "survived", "held", "m/s", "slip [mm]", "CoT", "torque", "joint speed", "CPU, 99 % [µs]",
    "x real", "what was wrong",
)  # fmt: skip
SPEED_COLUMNS = (
    "velocity",
    "good",
    "lawful",
    "error",
    "slip [mm]",
    "joint speed",
    "torque",
    "rate [N m/ms], 99.9 %",
)
WALKS = (
    "go2 --velocity 0.5 --duration 20",
    "go2 --velocity 1.0 --duration 20",
    "go2 --velocity 0,0.3,0 --duration 20",
    "go2 --velocity 0,0,0.8 --duration 20",
    "go2 --velocity 0.4 --terrain slope:15 --duration 20",
    "go2 --velocity 0.4 --terrain slope:-15 --duration 20",
    "go2 --velocity 0.4 --terrain rough:1,0.04 --duration 15",
    "go2 --velocity 0.3 --terrain stairs:0.08,0.3 --duration 15",
    "go2 --push 3:0,100,0:0.1 --push 6:0,-100,0:0.1",
    "go2 --scenario examples/scenarios/ice.yaml",
    "anymal",
    "anymal_c",
    "a1",
    "go1",
)
"""Walks of docs/reports/walking.md."""
TRUTH = "--scenario examples/scenarios/true_state.yaml"
"""What tells a walk its true state; the walk on ice has a scenario of its own that does."""
ALL_WALKS = "; ".join(
    f"surefoot walk {walk} --seed 1 {'' if '--scenario' in walk else f'{TRUTH} '}--no-video --no-report"
    for walk in WALKS
)
ACTUATORS = "python -m benchmarks.actuators --part"
LOADS = "python -m benchmarks.loads"
FEW = f"{LOADS} --seeds 1 --duration 4 --part"
MANY = f"{LOADS} --seeds 20 --part payloads --only 'hard: 5 kg at (0.1'"
STATE, SLIPPERY = "python -m benchmarks.state_estimate", "python -m benchmarks.slippery_walks"
AUDIT = "python -m benchmarks.audit"
SWEEP = "surefoot sweep examples/sweeps"
MOTOR_SPEEDS = (
    "trot", "motors, commands", "laws and limits kept", "velocity [m/s]", "longest slip [mm]",
    "fastest joint [%]", "beyond its speed [% of steps]", "torque cut off [% of steps]",
)  # fmt: skip
MOTORS = (
    "walk", "walked", "laws and limits kept", "velocity [m/s]", "slip [mm]", "fastest joint [%]",
    "links touched",
)  # fmt: skip
LOAD = (
    "walk: without, with the observer", "walked", "lawful", "lean [deg]", "after 2 s", "velocity off [m/s]",
    "slip [mm]", "found",
)  # fmt: skip
ERRORS = ("run", "walked", "v rms [mm/s]", "drift [%]", "tilt rms [deg]", "heading [deg]", "lawful")
KNOWN = (
    "task", "knowledge", "upright, on course", "95 %", "lawful too", "speed [m/s]", "worst slip [mm]",
)  # fmt: skip

TABLES = {
    "stacks": Table(
        STACKS, "reports/stacks.md", STACK_COLUMNS,
        lambda data: _stacks(data, without=("-map",)), long=True,
    ),
    "bipeds": Table(
        EVERY_TASK, "reports/bipeds.md", STACK_COLUMNS, lambda data: _stacks(data, "g1-"), long=True,
    ),
    "stairs": Table(
        STACKS, "reports/terrain-knowledge.md", STACK_COLUMNS,
        lambda data: _stacks(data, "stairs-", "ice"), long=True,
    ),
    "speeds": Table(
        "surefoot bench speeds --seeds 20", "reports/speed-limits.md", SPEED_COLUMNS, _speeds, long=True,
    ),
    "motor_speeds": Table(
        f"{ACTUATORS} speeds --seeds 2 --duration 5", "reports/actuators.md", MOTOR_SPEEDS, _motor_speeds
    ),
    "motor_robots": Table(
        f"{ACTUATORS} robots --seeds 1 --duration 4", "reports/actuators.md", MOTORS,
        lambda data: printed(data, "robots", *MOTORS),
    ),
    "late_commands": Table(
        f"{ACTUATORS} delays --only '5 ms' --seeds 20 --duration 4", "late-commands.md", MOTORS,
        lambda data: printed(data, "delays", *MOTORS),
    ),
    "payloads": Table(f"{FEW} payloads; {MANY}", "reports/loads.md", LOAD, _payloads),
    "loaded_robots": Table(
        f"{FEW} robots", "reports/loads.md", LOAD, lambda data: _loads(data, "robots")
    ),
    "disturbances": Table(
        f"{FEW} disturbances", "reports/loads.md", LOAD, lambda data: _loads(data, "disturbances")
    ),
    "state_errors": Table(
        STATE, "reports/estimation.md", ERRORS, lambda data: printed(data, "state estimate", *ERRORS)
    ),
    "state_cost": Table(
        STATE, "reports/estimation.md",
        ("robot", "filter: predict", "filter: update", "forces", "contacts", "all"),
        lambda data: printed(data, "CPU time"),
    ),
    "slippery": Table(
        SLIPPERY, "reports/estimation.md",
        ("world", "true mu", "first answer after the first slip [ms]", "all answers", "highest lower bound"),
        lambda data: printed(data, "friction while"),
    ),
    "knowledge": Table(
        "python -m benchmarks.terrain_knowledge --seeds 5 --task slope --task ice --task ice-unaware "
        "--task patch", "reports/terrain-knowledge.md", KNOWN,
        lambda data: printed(data, "go2", *KNOWN),
    ),
    "walks": Table(
        ALL_WALKS, "reports/walking.md", ("`surefoot walk ...`", "measured", "slip", "laws"), _walks,
        said="each line's command with `--seed 1`, measured on the true state",
    ),
    "faults": Table(
        "surefoot bench faults --estimator truth --seeds 20 --duration 4", "reports/walking.md",
        ("fault", "survived", "not survived"), _faults, long=True,
    ),
    "seeded_faults": Table(
        AUDIT, "reports/audit.md", ("fault", "what is done", "amplitude", "told as", "noticed", "all right"),
        _seeded_faults, long=True,
    ),
    "spoils": Table(
        "python -m benchmarks.spoils", "reports/audit.md",
        ("spoil", "what is done", "logs", "beyond the tolerance, found", "below it, found all the same"),
        _spoils, long=True,
    ),
    "alarms": Table(
        AUDIT, "reports/audit.md", ("foot, time and cause right", "noticed", "false alarms on clean runs"),
        _alarms,
        long=True,
    ),
    "timid": Table(
        f"{SWEEP}/walk-narrow.yaml; {SWEEP}/walk-wide.yaml", "reports/sweeps.md",
        (
            "commanded speed [m/s]", "narrow: share that walked as told", "wide",
            "narrow: median velocity [m/s]", "wide",
        ),
        _timid, long=True,
    ),
    "soft_ground": Table(
        f"{SWEEP}/soft.yaml --json", "reports/sweeps.md",
        ("time constant [s]", "sink [mm]", "ground's work [J]", "slip [mm]", "laws broken"), _soft,
    ),
}  # fmt: skip
