"""`surefoot region`: CoM region, support polygon and ZMP region side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from surefoot.arrays import real_number
from surefoot.cli.console import plain_console
from surefoot.cli.extras import picture_folder
from surefoot.cli.output import to_json
from surefoot.errors import ProblemError


def region(
    file: Annotated[
        Path | None, typer.Argument(help="A stance file (YAML); see docs/stance-files.md.")
    ] = None,
    robot: Annotated[str | None, typer.Option(help="A known robot instead of a file.")] = None,
    urdf: Annotated[Path | None, typer.Option(help="A URDF file instead of a known robot.")] = None,
    feet: Annotated[str | None, typer.Option(help="Foot frames of the robot, comma-separated.")] = None,
    slope: Annotated[float, typer.Option(help="Slope under the robot that rises along +x [deg].")] = 0.0,
    mu: Annotated[float | None, typer.Option(help="Friction of every contact (robot: 0.6).")] = None,
    lift: Annotated[str | None, typer.Option(help="Contacts that are in the air, comma-separated.")] = None,
    tol: Annotated[float, typer.Option(help="Largest gap of the regions [m].")] = 1e-3,
    out: Annotated[Path, typer.Option(help="Parent of the new folder for the picture.")] = Path("runs"),
    picture: Annotated[bool, typer.Option("--picture/--no-picture", help="Draw the regions.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Draw where the centre of mass and the zero-moment point may be, and say where they differ and why.

    Exit code 0, or 2 for bad input; `surefoot check` is the command that judges.
    """
    from surefoot.cli.stance_input import asked
    from surefoot.equilibrium.comparison import compare_regions

    real_number("--tol", tol, low=1e-9, high=1.0)
    question = asked(file, robot, urdf, feet, slope, mu, lift).question
    if not len(question.stance):
        raise ProblemError("the stance has no contacts: there is no region to draw")
    found = compare_regions(question.stance, question.com, question.mass, tol)
    inside = found.com.contains(question.com)
    facts: dict[str, Any] = {
        "name": question.name,
        "com_inside": inside,
        "com": question.com,
        "com_region": _region_facts(found.com),
        "zmp_region": None if found.zmp is None else _region_facts(found.zmp),
        "support_polygon": found.support,
        "differences": list(found.sentences),
        "picture": None,
    }
    folder, facts["note"] = picture_folder(out, "region") if picture else (None, "")
    if folder is not None:
        from surefoot.viz.stance_plots import draw_regions

        facts["picture"] = str(draw_regions(question, found, folder / "regions.png"))
    if as_json:
        print(to_json(facts))
    else:
        _print(facts)
    return 0


def _region_facts(region: Any) -> dict[str, Any]:
    return {
        "corners": region.inner,
        "area": region.area,
        "gap": region.gap,
        "height": region.height,
        "force_limit": region.force_limit,
    }


def _print(facts: dict[str, Any]) -> None:
    from rich.table import Table

    from surefoot.equilibrium.region import polygon_area

    console = plain_console()
    word = "inside" if facts["com_inside"] else "outside"
    style = "bold green" if facts["com_inside"] else "bold red"
    console.print(f"{facts['name']}: the centre of mass is {word} its region", style=style, soft_wrap=True)
    table = Table("region", "area [cm²]", "corners", "gap [mm]")
    for name, key in (("centre of mass", "com_region"), ("zero-moment point", "zmp_region")):
        row = facts[key]
        if row is not None:
            area, count = f"{1e4 * row['area']:.1f}", str(len(row["corners"]))
            table.add_row(name, area, count, f"{1e3 * row['gap']:.3f}")
    support = facts["support_polygon"]
    table.add_row("support polygon", f"{1e4 * polygon_area(support):.1f}", str(len(support)), "0")
    console.print(table)
    for sentence in facts["differences"]:
        console.print(sentence, soft_wrap=True, highlight=False)
    if facts["picture"]:
        console.print(f"picture: {facts['picture']}", soft_wrap=True, highlight=False)
    if facts["note"]:
        console.print(facts["note"], soft_wrap=True, highlight=False)
