"""Optional packages: asked for before any work, all that are missing named at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path

from surefoot.app.cli.output import new_run_folder
from surefoot.app.cli.robots import is_file
from surefoot.base.errors import MissingExtra, WriteError

_EXTRA_OF = {
    "pin": "robot", "example-robot-data": "robot", "mujoco": "sim", "imageio": "sim",
    "imageio-ffmpeg": "sim", "matplotlib": "viz", "clarabel": "qp", "qpsolvers": "qp",
    "viser": "lab", "drake": "drake", "pybullet": "bullet", "jax": "jax", "mujoco-mjx": "mjx",
    "pyarrow": "sweep", "joblib": "sweep", "ray": "scale", "distributed": "scale",
    "cyclonedds": "wire",
}  # fmt: skip
_MODULE_OF = {"pin": "pinocchio", "imageio-ffmpeg": "imageio_ffmpeg"}
FILM = ("mujoco", "imageio", "imageio-ffmpeg")
"""What a film needs."""


def missing(packages: Iterable[str]) -> MissingExtra | None:
    """Return the error that names those of the packages that are not installed, None if all are."""
    absent = [p for p in packages if not _installed(p)]
    return MissingExtra(absent, [_EXTRA_OF[p] for p in absent]) if absent else None


def require(packages: Iterable[str], wanted: Iterable[str] = ()) -> None:
    """Raise if a package is not installed.

    Parameters
    ----------
    packages
        Without which the command cannot work.
    wanted
        Without which it would leave something out. They are named, too, when one of the others is
        missing, so that a single installation is enough.

    Raises
    ------
    MissingExtra
        Naming all that is missing.
    """
    needed = missing(packages)
    if needed is not None:
        also = missing(wanted)
        raise needed if also is None else MissingExtra.of([needed, also])


def robot_packages(name: str | None) -> tuple[str, ...]:
    """Return what loading a robot needs: a known name (or None, the default one), or a file's path."""
    if (name or "").lower().endswith(".xml"):
        return "pin", "mujoco"
    return ("pin",) if is_file(name) or "/" in (name or "") else ("pin", "example-robot-data")


def draw_into(
    wanted: bool, parent: Path, name: str, draw: Callable[[Path], object]
) -> tuple[str | None, str]:
    """Draw into a new folder below `parent`; return what `draw` returns as text, and why there is no picture.

    The first is None where nothing was drawn, the second empty unless Matplotlib is missing or the disk full.
    """
    error = missing(["matplotlib"]) if wanted else None
    if error is not None:
        return None, f"no picture: {error}"
    if not wanted:
        return None, ""
    folder = new_run_folder(parent, name)
    try:
        return str(draw(folder)), ""
    except OSError as full:
        return None, f"no picture: {WriteError(folder, full)}"


def _installed(package: str) -> bool:
    """Tell whether a package is there; some have no module of their name, Drake may live elsewhere."""
    if package == "drake":  # in an interpreter of its own
        from surefoot.worlds.drake import drake_python

        return drake_python.present()
    if package in ("example-robot-data", "mujoco-mjx"):
        try:
            distribution(package)
        except PackageNotFoundError:
            return False
        return True
    return find_spec(_MODULE_OF.get(package, package)) is not None
