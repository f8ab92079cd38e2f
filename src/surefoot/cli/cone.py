"""`surefoot cone`: a friction cone's pyramids as numbers and as a picture."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from surefoot.arrays import real_number
from surefoot.cli.console import plain_console
from surefoot.cli.extras import picture_folder
from surefoot.cli.output import to_json
from surefoot.errors import ProblemError, unknown_name

PICTURE_FACETS = (3, 4, 8, 16)
MOST_ROWS = 32
"""Rows of a table; with more facets the rest is left to --json."""


def cone(
    mu: Annotated[float, typer.Option(help="Friction coefficient.")] = 0.6,
    facets: Annotated[int, typer.Option(help="Sides of the pyramid, at least 3.")] = 8,
    fit: Annotated[str, typer.Option(help="inner or outer.")] = "inner",
    phase: Annotated[float, typer.Option(help="Turn of the pyramid about the normal [deg].")] = 0.0,
    out: Annotated[Path, typer.Option(help="Parent of the new folder for the picture.")] = Path("runs"),
    picture: Annotated[bool, typer.Option("--picture/--no-picture", help="Draw the pyramids.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Print the half-spaces, the rays and the exact fit errors of a friction pyramid, and draw it."""
    from surefoot.cli import parsing
    from surefoot.cones import FrictionCone

    parsing.friction("--mu", mu)
    parsing.facet_count(facets)
    real_number("--phase", phase, low=-360.0, high=360.0)
    if fit not in ("inner", "outer"):
        raise ProblemError(unknown_name("fit", fit, ["inner", "outer"]))
    pyramid = FrictionCone(mu).polyhedral(facets, fit, math.radians(phase))  # type: ignore[arg-type]
    drawn, note = None, ""
    folder: Path | None = None
    if picture and mu > 0.0:
        folder, note = picture_folder(out, "cone")
    if folder is not None:
        from surefoot.viz.cone_plots import draw_pyramids

        chosen = sorted({*PICTURE_FACETS, facets} if facets <= 64 else set(PICTURE_FACETS))
        drawn = draw_pyramids(mu, chosen, math.radians(phase), folder / "pyramids.png")
    error = pyramid.fit_error
    facts: dict[str, Any] = {
        "mu": mu,
        "facets": facets,
        "fit": fit,
        "phase_deg": phase,
        "halfspaces": pyramid.halfspaces,
        "rays": pyramid.rays,
        "fit_error": {"radial": error.radial, "area": error.area},
        "picture": str(drawn) if drawn else None,
        "note": note,
    }
    if as_json:
        print(to_json(facts))
    else:
        _print(facts)
    return 0


def _print(facts: dict[str, Any]) -> None:
    from rich.table import Table

    console = plain_console()
    console.print(
        f"Friction cone of mu = {facts['mu']:g} as an {facts['fit']} pyramid with {facts['facets']} sides."
    )
    for title, rows, names in (
        ("Half-spaces, a . f <= 0", facts["halfspaces"], ("a_x", "a_y", "a_z")),
        ("Rays, f = sum of beta_i ray_i, beta >= 0", facts["rays"], ("f_x", "f_y", "f_z")),
    ):
        table = Table(title=title, title_justify="left")
        table.add_column("#", justify="right")
        for name in names:
            table.add_column(name, justify="right")
        for k, row in enumerate(rows[:MOST_ROWS]):
            table.add_row(str(k), *(f"{x + 0.0:.6f}" for x in row))
        if len(rows) > MOST_ROWS:
            table.caption = f"and {len(rows) - MOST_ROWS} more, see --json"
        console.print(table)
    error = facts["fit_error"]
    verb = "gives up" if facts["fit"] == "inner" else "promises too much, by"
    console.print(
        f"Against the exact cone it {verb} {100 * error['radial']:.3f} % of the friction in its worst "
        f"direction and {100 * error['area']:.3f} % of the section's area."
    )
    if facts["picture"]:
        console.print(f"Picture: {facts['picture']}", soft_wrap=True)
    if facts["note"]:
        console.print(facts["note"], soft_wrap=True, highlight=False)
