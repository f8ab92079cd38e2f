"""`surefoot policy`: what was understood of a learned policy; and the options that let one walk."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from surefoot.app.cli import options
from surefoot.app.cli.console import say, show, table
from surefoot.base.errors import ProblemError, check_name

if TYPE_CHECKING:
    from surefoot.app.cli.walk_options import Wiring

ASSUMED = "go2"
"""Robot that a policy is described for where neither an option nor the file's name says one."""
ACTIONS = ("describe",)
Spec = Annotated[
    Path | None,
    typer.Option(help="YAML that says what the network's numbers mean; else that of its stem beside it."),
]
Trust = Annotated[bool, typer.Option("--trust", help="Run TorchScript: it is code of the file's author.")]


@dataclass(frozen=True)
class PolicyOptions:
    """A learned policy that walks in the place of a planner."""

    policy: Annotated[
        Path | None, typer.Option(help="A network (.onnx, .pt) that walks; see docs/policies.md.")
    ] = None
    policy_spec: Spec = None
    trust: Trust = False

    def robot(self, name: str | None) -> str | None:
        """Return the robot's name, where none is said that of the network's file."""
        from surefoot.motion.policy.publishers import robot_of

        if self.policy is None and (self.policy_spec is not None or self.trust):
            raise ProblemError("--policy-spec and --trust are of a --policy")
        return name if name is not None or self.policy is None else robot_of(self.policy)

    def controller(self, robot: Any, command: Any, ground: Any, wired: Wiring) -> Any:
        """Return the policy for a robot, watched where states may be missing."""
        from surefoot.motion.drive.watchdog import Watchdog
        from surefoot.motion.policy.policy import Policy

        if wired.targets or wired.every != 1 or wired.latency is not None:
            raise ProblemError("--policy takes no --commands, control_rate or latency: it has its own")
        network = str(self.policy)
        policy = Policy(network, self.policy_spec, robot, command, terrain=ground, trust=self.trust)
        return Watchdog(policy, robot, 1e-3) if wired.dropouts else policy


def policy(
    action: Annotated[str, typer.Argument(help="describe: say what is understood, and what is missing.")],
    network: Annotated[Path, typer.Argument(help="Network of the policy: .onnx, or .pt with --trust.")],
    robot: Annotated[str | None, typer.Option(help="A known robot; else the one in the file's name.")] = None,
    policy_spec: Spec = None,
    trust: Trust = False,
    as_json: options.AsJson = False,
) -> int:
    """Print what is understood of a learned policy, from where, and what is missing.

    Exit code 0 if it can be used as it is, 1 if something is missing, 2 for wrong input.
    """
    from surefoot.mechanics import load_robot
    from surefoot.motion.policy.network import open_network
    from surefoot.motion.policy.policy import Policy
    from surefoot.motion.policy.publishers import beside, describe, robot_of
    from surefoot.motion.policy.spec import missing

    check_name("action", action, ACTIONS)
    named = robot or robot_of(network)
    known = load_robot(named or ASSUMED)
    described = describe(open_network(network, trust), policy_spec or beside(network), known)
    absent = missing(described.table)
    facts: dict[str, Any] = {
        "network": str(network), "robot": known.name, "robot_from": _origin(robot, named),
        "understood": described.table,
        "sources": described.sources, "missing": absent,
    }  # fmt: skip
    if not absent:
        used = Policy(network, policy_spec, known, trust=trust)
        facts |= {"observation": used.sizes, "notes": list(used.facts["notes"]), "step_us": _step_time(used)}
    show(facts, as_json, _print)
    return 1 if absent else 0


def _origin(option: str | None, named: str | None) -> str:
    """Return where the robot's name comes from."""
    return "--robot" if option else "the file's name" if named else "assumed"


def _step_time(policy: Any) -> float:
    """Return the median CPU time of an observation with its inference [us]."""
    spent = []
    for k in range(200):
        start = time.thread_time()
        policy.step(policy.still._replace(time=k / policy.spec.rate))
        spent.append(time.thread_time() - start)
    return 1e6 * median(spent)


def _print(console: Console, facts: dict[str, Any]) -> None:
    """Print what was understood as a table."""
    described, sources = facts["understood"], facts["sources"]
    rows = [(key, _short(value), sources[key]) for key, value in described.items()]
    header = ("key", "understood", "from")
    console.print(table(header, rows, f"{facts['network']} for {facts['robot']}", 3, header[1:]))
    if "observation" in facts:
        terms = ", ".join(f"{name} {size}" for name, size in facts["observation"])
        say(console, f"observation of {sum(n for _, n in facts['observation'])} numbers: {terms}")
        say(console, *facts["notes"])
        say(console, f"observation and inference: {facts['step_us']:.0f} us of CPU in the median")
    if facts["robot_from"] == "assumed":
        say(console, f"robot: {facts['robot']}, assumed, since the file's name says none; or --robot NAME")
    say(console, f"missing: {', '.join(facts['missing'])}" if facts["missing"] else "nothing is missing")


def _short(value: Any) -> str:
    """Return a value as text, a list of one number as that."""
    if isinstance(value, dict):
        return " ".join(f"{k} {_short(v)}".rstrip() for k, v in value.items() if v not in (None, 1.0))
    if isinstance(value, (list, tuple)) and len(value) > 1 and all(v == value[0] for v in value):
        return f"{value[0]} ({len(value)} times)"
    return ", ".join(map(_short, value)) if isinstance(value, (list, tuple)) else str(value)
