"""One picture of an answer, in a file."""

from __future__ import annotations

from pathlib import Path
from pkgutil import resolve_name
from typing import Any

from surefoot.app.viz.drawings import VIZ, drawing_of, figure_of
from surefoot.app.viz.style import save
from surefoot.base.errors import ProblemError
from surefoot.base.text_files import path_of


def picture(answer: Any, path: Path | str = "picture.png", **options: Any) -> Path:
    """Draw an answer into a new file and return its path.

    Parameters
    ----------
    answer
        What has a method `plot`: a cone, a stance, a verdict, a solution, a log, an audit's report ...
    path
        Of the file; its suffix says which kind: .png, .svg or .pdf; of a certified motion .html as well, of
        what moves or stands .rrd and .viser, scenes of rerun and viser.
    **options
        Of the picture of this kind, as docs/pictures.md lists them.

    Raises
    ------
    ProblemError
        For what has no picture, an option that its picture has not, or a file that exists already.
    MissingExtra
        If matplotlib, or the viewer of a scene, is not installed.
    """
    drawing = drawing_of(answer)
    place = path_of(path)
    if place.exists():
        raise ProblemError(f"{place} exists already")
    kinds = (*KINDS, *([".html"] if drawing.page else []), *(SCENES if drawing.scene else ()))
    if place.suffix not in kinds:
        raise ProblemError(f"a picture is one of {', '.join(kinds)}, got {place.suffix or place.name!r}")
    if place.suffix == ".html":
        return Path(resolve_name(f"{VIZ}.{drawing.page}")(answer, place))
    if place.suffix in SCENES:
        return Path(resolve_name("surefoot.app.lab.scene_files:write_scene")(answer, place, **options))
    return save(figure_of(answer, **options), place)


KINDS = (".png", ".svg", ".pdf")
"""Suffixes of files of pictures."""
SCENES = (".rrd", ".viser")
"""Suffixes of scenes in space and time, which rerun and viser show."""
