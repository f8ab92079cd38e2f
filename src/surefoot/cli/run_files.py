"""Write what a run leaves: log, summary, plots, film and report, into one new folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from surefoot.cli.output import to_json
from surefoot.errors import SurefootError, WriteError
from surefoot.robot import Robot
from surefoot.simulation.log import Log
from surefoot.stance import Terrain

PARTS = "log.parts"
"""Folder that the log's rows go to during a run; log.npz takes its place at the end."""
CAPTIONS = {
    "normal_forces": "Normal forces",
    "cone_use": "Every force inside the cross-section of its cone",
    "base": "Base",
    "pressure": "Centre of pressure in the soles (amber while pushed)",
    "torques": "Joint torques",
    "step_times": "Controller step",
    "velocity": "Velocity",
    "footfalls": "Footfalls",
    "cone_over_time": "Use of the cones over time",
    "path": "Path",
}


class Written:
    """What a run leaves, file by file; a full disk costs the files that do not fit, and no others.

    Attributes
    ----------
    notes
        One line for each file that could not be written.
    """

    def __init__(self) -> None:
        self.notes: list[str] = []

    def attempt(self, path: Path, write: Callable[[], object]) -> bool:
        """Write a file and return True, or note why it is not there; no half file stays."""
        try:
            write()
        except WriteError as error:
            self.notes.append(str(error))
        except OSError as error:
            self.notes.append(str(WriteError(path, error)))
            path.unlink(missing_ok=True)
        else:
            return True
        return False


def write_film(
    log: Log, robot: Robot, terrain: Terrain, folder: Path, progress: Callable[[float], None] | None
) -> tuple[Path | None, str]:
    """Return the film's path or None, and one line that says why there is none.

    A run must not be lost for want of an OpenGL: whatever goes wrong here is told, not raised.
    """
    from surefoot.viz.video import write_video

    path = folder / "film.mp4"
    try:
        return write_video(log, robot, terrain, path, progress=progress), ""
    except SurefootError as error:
        return None, str(error)
    except OSError as error:
        path.unlink(missing_ok=True)
        return None, str(WriteError(path, error))
    except KeyboardInterrupt:
        return None, "no video: interrupted"


def write_plots(
    log: Log, folder: Path, draw: Callable[[Log, Path], list[Path]] | None = None
) -> tuple[list[Path], str]:
    """Return the plots' paths, and one line that says why there are none; `draw` is that of a stand."""
    from surefoot.viz.plots import draw_run

    try:
        return (draw or draw_run)(log, folder), ""
    except SurefootError as error:
        return [], str(error)
    except OSError as error:
        return [], str(WriteError(folder, error))


def write_summary(summary: dict[str, Any], folder: Path) -> Path:
    """Write summary.json into the folder and return its path."""
    path = folder / "summary.json"
    path.write_text(to_json(summary) + "\n", encoding="utf-8")
    return path


def picture_sections(plots: Sequence[Path], video: Path | None) -> list[tuple[str, str]]:
    """Return the report's sections for a film and plots."""
    from surefoot.viz.report import film, paragraph, picture

    sections = []
    if video is not None:
        note = paragraph("Arrows: ground forces as the world reports them; amber: the push.")
        sections.append(("Film", film(video) + note))
    sections += [(CAPTIONS.get(p.stem, p.stem.replace("_", " ")), picture(p)) for p in plots]
    return sections
