"""`surefoot region`: CoM region, support polygon and ZMP region side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console

from surefoot.app.cli import options
from surefoot.app.cli.console import say, say_verdict, show, table
from surefoot.app.cli.extras import draw_into
from surefoot.app.cli.stance_input import StanceOptions
from surefoot.base.errors import ProblemError


def region(
    *,
    stance: StanceOptions,
    out: options.PictureOut = Path("runs"),
    picture: options.Picture = True,
    as_json: options.AsJson = False,
) -> int:
    """Draw where the centre of mass and the zero-moment point may be, beside the support polygon.

    Exit code 0, or 2 for bad input; `surefoot check` is the command that judges.
    """
    from surefoot.mechanics.statics.com_region import com_region, support_polygon, zmp_region

    question = stance.case().question
    if not len(question.stance):
        raise ProblemError("the stance has no contacts: there is no region to draw")
    contacts, com = question.stance, question.com
    standing, support = com_region(contacts, question.mass), support_polygon(contacts)
    zmp = None  # where its plane would go through the centre of mass
    if abs(com[2] - float(contacts.positions[:, 2].mean())) > 1e-6:
        zmp = zmp_region(contacts, com, question.mass)
    facts: dict[str, Any] = {
        "name": question.name,
        "com_inside": standing.contains(com),
        "com": com,
        "com_region": _region_facts(standing),
        "zmp_region": None if zmp is None else _region_facts(zmp),
        "support_polygon": support,
        "picture": None,
    }

    def draw(folder: Path) -> Path:
        from surefoot.app.viz.stance_plots import draw_regions

        return draw_regions(question, standing, zmp, support, folder / "regions.png")

    facts["picture"], facts["note"] = draw_into(picture, out, "region", draw)
    show(facts, as_json, _print)
    return 0


def _region_facts(region: Any) -> dict[str, Any]:
    sizes = {key: getattr(region, key) for key in ("area", "gap", "height", "force_limit")}
    return {"corners": region.inner, **sizes}


def _print(console: Console, facts: dict[str, Any]) -> None:
    from surefoot.mechanics.statics.region import polygon_area

    word = "inside" if facts["com_inside"] else "outside"
    say_verdict(console, f"{facts['name']}: the centre of mass is {word} its region", facts["com_inside"])
    support = facts["support_polygon"]
    named = (("centre of mass", facts["com_region"]), ("zero-moment point", facts["zmp_region"]))
    sizes = [(name, r["area"], r["corners"], f"{1e3 * r['gap']:.3f}") for name, r in named if r is not None]
    sizes.append(("support polygon", polygon_area(support), support, "0"))
    rows = [(name, f"{1e4 * area:.1f}", str(len(corners)), gap) for name, area, corners, gap in sizes]
    console.print(table(("region", "area [cm²]", "corners", "gap [mm]"), rows, left=4))
    picture = f"picture: {facts['picture']}" if facts["picture"] else ""
    say(console, picture, facts["note"])
