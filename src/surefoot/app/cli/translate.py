"""`surefoot translate`: contact parameters of one simulator in another's words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.app.cli import options
from surefoot.app.cli.console import show, table
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from rich.console import Console

NAMES = "physical, hunt-crossley, mujoco, drake, physx, isaaclab, bullet, ..."
"""Some of them; a wrong name is answered with all."""
_UNITS = {
    "rest_depth": "rest depth [m]",
    "restitution": "restitution",
    "frequency": "frequency [rad/s]",
    "settling_time": "settling time to 2 % [s]",
}


def translate(
    source: Annotated[
        str,
        typer.Argument(help=f"Whose parameters are given: {NAMES}, hertz."),
    ],
    to: Annotated[str, typer.Argument(help=f"Whose parameters are wanted: {NAMES}.")],
    values: Annotated[
        list[str] | None, typer.Argument(help="NAME=VALUE, e.g. stiffness=2e4 damping=40 or solref=0.02,1.")
    ] = None,
    mass: Annotated[float, typer.Option(help="Effective mass of the contact, 1/G_nn [kg].")] = 1.0,
    dt: Annotated[float, typer.Option(help="Step of the engines [s].")] = 1e-3,
    keep: Annotated[str, typer.Option(help="motion or rest, where both cannot be kept.")] = "motion",
    prove: Annotated[bool, typer.Option("--prove", help="Run the wanted engine, if it is here.")] = False,
    as_json: options.AsJson = False,
) -> int:
    """Print a contact's parameters as another simulator takes them, what agrees and what is lost."""
    from surefoot.contact import combination_rules
    from surefoot.contact import translate as translated
    from surefoot.contact.translation.translation import read_contact

    contact = read_contact(source, _values(values or []), mass=mass, speed=1.0)
    found = translated(contact, to, mass, dt=dt, keep=keep)
    measured = None
    if prove:
        from surefoot.worlds.experiments.drops import measure

        measured = measure(to, found.parameters, found.translated, mass, dt=dt)
    families = (_family(source), _family(to))
    facts: dict[str, Any] = {
        "from": source,
        "to": to,
        "mass": mass,
        "dt": dt,
        "parameters": found.parameters,
        "lost": found.lost,
        "agreement": {
            name: {**q._asdict(), "agrees": q.proven(seen), "measured": seen}
            for name, q in found.agreement.items()
            for seen in (getattr(measured, name, None),)
        },
        "friction_rules": {n: words for n, words in combination_rules().items() if _family(n) in families},
    }
    show(facts, as_json, _print, highlight=False, soft_wrap=True)
    return 0


def _family(engine: str) -> str:
    """Return the engine of a name: several names are one engine's."""
    first = engine.split("-")[0]
    return "physx" if first == "isaaclab" else first


def _values(texts: list[str]) -> dict[str, Any]:
    """Return the values of "name=1" or "name=1,2"."""
    found: dict[str, Any] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            numbers = [float(x) for x in value.split(",")]
        except ValueError:
            numbers = []
        if not (name and equals and numbers):
            raise ProblemError(f"{text!r} is not of the form NAME=VALUE, e.g. stiffness=2e4 or solref=0.02,1")
        if name in found:
            raise ProblemError(f"{name} is given twice")
        found[name] = numbers if len(numbers) > 1 else numbers[0]
    return found


def _print(console: Console, facts: dict[str, Any]) -> None:
    console.print(f"{facts['from']} to {facts['to']}, for {facts['mass']:g} kg at the contact:")
    for name, value in _flat(facts["parameters"]):
        console.print(f"  {name} = {value}")
    proven = any(row["measured"] is not None for row in facts["agreement"].values())
    numbers = ("given", "translated", *(["measured"] if proven else []))
    rows = [
        (_UNITS[name], *(f"{row[key]:.6g}" for key in numbers), "yes" if row["agrees"] else "no")
        for name, row in facts["agreement"].items()
    ]
    header = ("", facts["from"], facts["to"], *numbers[2:], "agrees")
    console.print(table(header, rows, left=("", "agrees")))
    for line in facts["lost"]:
        console.print(f"lost: {line}")
    for name, words in facts["friction_rules"].items():
        console.print(f"friction of two surfaces in {name}: {words}")


def _flat(values: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield nested settings as dotted names."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            parts = value if isinstance(value, tuple) else (value,)
            yield prefix + name, " ".join(f"{x:.10g}" if isinstance(x, float) else str(x) for x in parts)
