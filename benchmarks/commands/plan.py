"""`surefoot bench plan`: shooting beside iLQR on MuJoCo, a jump beside Crocoddyl, contact-implicit MPC."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console

from benchmarks.printing import table
from surefoot.app.cli import extras
from surefoot.app.cli.console import show


def plan(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer repeats, a short walk, one push.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Time a solver beside iLQR on MuJoCo's differences, a jump beside Crocoddyl, and walk without a gait."""
    from benchmarks.planning import iteration, jump_rival, walking
    from surefoot.mechanics.robot import load_robot

    extras.require((*extras.robot_packages("go2"), "mujoco"))
    robot = load_robot("go2")
    found = {"solver": iteration.measure(robot, quick), "jump": jump_rival.measure(robot)}
    found["mpc"] = walking.measure(robot, quick)
    show(found, json, _print)


def _print(console: Console, found: dict[str, Any]) -> None:
    _print_solver(console, found["solver"])
    _print_jump(console, found["jump"])
    _print_walk(console, found["mpc"])


def _print_jump(console: Console, found: dict[str, Any]) -> None:
    names = (
        "", "CPU s", "iterations", "converged", "torque / limit", "beyond the cone [N]", "feet off [cm]",
        "in the replay", "replay apart [cm]", "hits",
    )  # fmt: skip
    rows = [
        (
            name, f"{one['seconds']:.2f}", str(one["iterations"]), "yes" if one["converged"] else "NO",
            f"{one['torque']:.2f}", f"{one['beyond_cone']:.2g}",
            *(f"{100.0 * one[key]:.2g}" for key in ("off", "replay_off", "apart")), str(one["hits"]),
        )
        for name, one in found.items() if not isinstance(one, str)
    ]  # fmt: skip
    console.print(table(names, rows, "a jump of Go2, 0.4 m ahead in knots of 10 ms"))
    for name, said in found.items():
        if isinstance(said, str):
            console.print(f"{name} {said}")


def _print_solver(console: Console, found: dict[str, Any]) -> None:
    knot = ", ".join(f"{name} {1e6 * seconds:.0f} µs" for name, seconds in found["knot"].items())
    console.print(f"a knot of Go2 on four feet, processor time: {knot}")
    keys = {
        f"ours, {1e3 * found['dt']:g} ms knots": "ours",
        f"ours, {1e3 * found['rival_dt']:g} ms knots, no feet in the cost": "same",
        f"MuJoCo, {1e3 * found['rival_dt']:g} ms knots, mjd_transitionFD": "mujoco",
    }
    parts = ("derivative", "riccati", "rollout", "iteration")
    rows = [(name, *(f"{1e3 * found[key][part]:.2f}" for part in parts)) for name, key in keys.items()]
    names = ("", "derivatives", "Riccati", "rollout", "iteration")
    console.print(table(names, rows, f"N = {found['knots']}, ms"))
    console.print(f"derivatives, MuJoCo / ours: {found['derivative_ratio']:.1f}")
    for name, one in found["descent"].items():
        costs = ", ".join(f"{cost:.4g}" for cost in one["costs"][:: len(one["costs"]) // 5])
        console.print(f"{name}: cost {costs}; {1e3 * one['seconds']:.0f} ms")


def _print_walk(console: Console, found: dict[str, Any]) -> None:
    console.print(
        f"contact-implicit MPC: N = {found['knots']}, dt = {1e3 * found['dt']:g} ms, "
        f"{found['iterations']} iteration(s) every {1e3 * found['interval']:g} ms"
    )
    names = (
        "",
        "up",
        "s",
        "m/s",
        "lean",
        "duty",
        "diagonal",
        "front apart",
        "strides/s",
        "clearance",
        "depth",
    )
    walks = {f"{found['walk']['seconds']:.0f} s": found["walk"]}
    walks |= {f"push {p['direction']} +{p['phase']:g} s": p for p in found["pushes"]}
    walks |= found["variants"]
    rows = [
        (
            name, "yes" if w["done"] else "NO", f"{w['seconds']:.1f}", f"{w['speed']:.3f}",
            f"{w['tilt']:.1f}°", f"{w['duty']:.2f}", f"{w['together']:.2f}", f"{w['apart']:.2f}",
            f"{w['stride']:.1f}", f"{1e3 * w['clearance']:.0f} mm", f"{-1e3 * w['depth']:.1f} mm",
        )
        for name, w in walks.items()
    ]  # fmt: skip
    console.print(table(names, rows, "walks"))
    drawn = found["drawn"]
    console.print(
        f"friction 0.5 to 0.7, payload to 0.8 kg, two pushes, seeds: {sum(w['done'] for w in drawn)} of "
        f"{len(drawn)} walked to the end"
    )
    up = sum(p["done"] for p in found["pushes"])
    console.print(f"pushes of 60 N for 0.1 s survived: {up} of {len(found['pushes'])}")
    for name, tick in found["tick"].items():
        console.print(
            f"a whole tick, {name} time: median {1e3 * tick['median']:.2f} ms, 99th percentile "
            f"{1e3 * tick['p99']:.2f} ms ({1.0 / tick['p99']:.0f} Hz)"
        )
    console.print(f"the first plan, from nothing: {1e3 * found['first_tick']:.0f} ms")
