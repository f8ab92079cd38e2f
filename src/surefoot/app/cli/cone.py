"""`surefoot cone`: a friction cone's pyramids as numbers and as a picture."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from surefoot.app.cli import options, parsing
from surefoot.app.cli.console import say, show, table
from surefoot.app.cli.extras import draw_into

MOST_ROWS = 32
"""Rows of a table; with more facets the rest is left to --json."""


def cone(
    mu: Annotated[float, typer.Option(help="Friction coefficient.")] = 0.6,
    facets: Annotated[int, typer.Option(help="Sides of the pyramid, at least 3.")] = 8,
    fit: Annotated[str, typer.Option(help="inner or outer.")] = "inner",
    out: options.PictureOut = Path("runs"),
    picture: options.Picture = True,
    as_json: options.AsJson = False,
) -> int:
    """Print the half-spaces, the rays and the exact fit errors of a friction pyramid, and draw it."""
    from surefoot.contact import FrictionCone
    from surefoot.contact.cones.polyhedral import checked_fit

    parsing.friction("--mu", mu)
    pyramid = FrictionCone(mu).polyhedral(facets, checked_fit(fit))

    def draw(folder: Path) -> Path:
        from surefoot.app.viz.cone_plots import draw_pyramid

        return draw_pyramid(pyramid, folder / "pyramid.png")

    path, note = draw_into(picture and mu > 0.0, out, "cone", draw)
    facts: dict[str, Any] = {
        "mu": mu,
        "facets": facets,
        "fit": fit,
        "halfspaces": pyramid.halfspaces,
        "rays": pyramid.rays,
        "fit_error": asdict(pyramid.fit_error),
        "picture": path,
        "note": note,
    }
    show(facts, as_json, _print)
    return 0


def _print(console: Console, facts: dict[str, Any]) -> None:
    if facts["mu"] == 0.0:
        console.print(
            "Without friction the cone is one ray, the normal, and so is every pyramid: no facets, no error. "
            "Its rows are f_x = f_y = 0 and f_z >= 0."
        )
        say(console, facts["note"])
        return
    console.print(
        f"Friction cone of mu = {facts['mu']:g} as an {facts['fit']} pyramid with {facts['facets']} sides."
    )
    for title, rows, names in (
        ("Half-spaces, a . f <= 0", facts["halfspaces"], ("a_x", "a_y", "a_z")),
        ("Rays, f = sum of beta_i ray_i, beta >= 0", facts["rays"], ("f_x", "f_y", "f_z")),
    ):
        numbers = ((str(k), *(f"{x + 0.0:.6f}" for x in row)) for k, row in enumerate(rows[:MOST_ROWS]))
        listed = table(("#", *names), numbers, title, left=0)
        if len(rows) > MOST_ROWS:
            listed.caption = f"and {len(rows) - MOST_ROWS} more, see --json"
        console.print(listed)
    error = facts["fit_error"]
    verb = "gives up" if facts["fit"] == "inner" else "promises too much, by"
    console.print(
        f"Against the exact cone it {verb} {100 * error['radial']:.3f} % of the friction in its worst "
        f"direction and {100 * error['area']:.3f} % of the section's area."
    )
    if facts["picture"]:
        console.print(f"Picture: {facts['picture']}", soft_wrap=True)
    say(console, facts["note"])
