"""Which function draws which class of answers, and how: on whose axes, in which size."""

from __future__ import annotations

import inspect
import io
import sys
from collections.abc import Callable
from pkgutil import resolve_name
from typing import Any, NamedTuple

from surefoot.app.viz.style import blank_figure, house_style
from surefoot.base.errors import ProblemError, check_name, shown

VIZ = "surefoot.app.viz"


class PictureKind(NamedTuple):
    """How one class of answers is drawn.

    Attributes
    ----------
    function
        "module:function" in `surefoot.app.viz`, called with the answer and axes; with the answer and an empty
        figure, where the picture has panels of its own.
    size
        Of a figure of its own [inches].
    space
        Whether its own axes are three-dimensional.
    panels
        Whether it has panels of its own, and so takes no axes.
    page
        "module:function" that writes a page about it into a new file; empty for none.
    scene
        Whether rerun and viser can show it, see `surefoot.app.lab.scenes`.
    """

    function: str
    size: tuple[float, float] = (6.0, 4.2)
    space: bool = False
    panels: bool = False
    page: str = ""
    scene: bool = False


DRAWINGS = {
    "contact.FrictionCone": PictureKind("cone_drawings:draw_friction_cone", (4.6, 4.4), space=True),
    "contact.FrictionPyramid": PictureKind("cone_drawings:draw_friction_pyramid", (4.6, 4.4), space=True),
    "contact.PolyhedralCone": PictureKind("cone_drawings:draw_polyhedral_cone", (4.8, 4.4)),
    "contact.Sole": PictureKind("cone_drawings:draw_sole", (6.0, 3.8)),
    "contact.ContactProblem": PictureKind("contact_drawings:draw_problem", (5.2, 4.4)),
    "contact.Certified": PictureKind("contact_drawings:draw_forces", (4.8, 4.6)),
    "contact.BatchSolution": PictureKind("contact_drawings:draw_batch", (6.0, 3.6)),
    "mechanics.Robot": PictureKind("stance_plots:draw_robot", (5.2, 4.8), space=True),
    "mechanics.Stance": PictureKind("stance_plots:draw_stance", (5.2, 4.8), space=True, scene=True),
    "mechanics.Verdict": PictureKind("stance_plots:draw_verdict", (5.6, 5.0), space=True, scene=True),
    "mechanics.Region": PictureKind("stance_plots:draw_region", (5.0, 4.4)),
    "mechanics.StanceCone": PictureKind("cone_drawings:draw_stance_cone", (4.8, 4.4)),
    "mechanics.Verdicts": PictureKind("outcome_plots:draw_verdicts", (6.0, 3.6)),
    "motion.ContactSchedule": PictureKind("gait_drawings:draw_gait", (6.4, 2.4)),
    "motion.Plan": PictureKind("plan_plots:draw_phases", (7.0, 2.8), scene=True),
    "records.Log": PictureKind("log_drawings:draw_log", (8.0, 6.4), panels=True, scene=True),
    "records.AuditReport": PictureKind("story_plots:draw_panels_of_story", (9.0, 7.0), panels=True),
    "records.BatchReport": PictureKind("batch_plots:draw_broken_laws", (6.4, 3.6)),
    "records.MotionReport": PictureKind(
        "motion_plots:draw_panels_of_motion", (9.0, 6.0), panels=True, page="motion_plots:write_motion_page"
    ),
    "records.Motion": PictureKind("motion_strip:draw_strip", (8.0, 2.6), scene=True),
    "records.Repair": PictureKind("outcome_plots:draw_repair", (6.4, 3.4)),
    "records.ContactTimes": PictureKind("outcome_plots:draw_contact_times", (6.4, 2.4)),
    "records.ForceEstimate": PictureKind("stance_plots:draw_estimate", (5.2, 4.8), space=True),
    "records.ForceModel": PictureKind("fit_plots:draw_force_model", (6.0, 4.2)),
    "records.FootForces": PictureKind("fit_plots:draw_foot_forces", (6.4, 3.2)),
    "records.RobotFit": PictureKind("fit_plots:draw_robot_fit", (6.0, 3.0)),
    "records.TossFit": PictureKind("toss_plots:draw_fit", (5.6, 3.8)),
    "app.ContactSequence": PictureKind("outcome_plots:draw_sequence", (6.4, 2.4)),
    "worlds.ReplayReport": PictureKind("outcome_plots:draw_replay", (6.4, 3.2)),
    "worlds.TransferReport": PictureKind("outcome_plots:draw_transfer", (7.4, 3.0)),
    "worlds.SweepResult": PictureKind("sweep_plots:draw_survival", (9.0, 5.4), panels=True),
}
"""Wing and class to its drawing; derived classes are drawn as the nearest class that has one."""


def drawing_of(answer: object) -> PictureKind:
    """Return how an answer is drawn.

    Raises
    ------
    ProblemError
        For what has no picture, with the names of what has one.
    """
    for one in type(answer).__mro__:
        wing = one.__module__.split(".")[1] if one.__module__.startswith("surefoot.") else ""
        if drawing := DRAWINGS.get(f"{wing}.{one.__name__}"):
            return drawing
    kinds = ", ".join(name.partition(".")[2] for name in DRAWINGS)
    raise ProblemError(f"there is no picture of {shown(answer)}; there are of {kinds}")


def plot(answer: Any, axes: Any = None, **options: Any) -> Any:
    """Draw an answer on axes, or in a figure of its own, and return the axes; see `surefoot.base.drawn`."""
    drawing = drawing_of(answer)
    if axes is None:
        return _compose(answer, drawing, _open_figure(drawing.size), options)
    if drawing.panels:
        raise ProblemError(
            f"the picture of this {type(answer).__name__} has panels of its own: call plot() without axes"
        )
    if not hasattr(axes, "add_patch"):
        raise ProblemError(f"axes must be Matplotlib's, as plt.gca() is, got {shown(axes)}")
    function = _function(drawing, options)
    with house_style():
        function(answer, axes, **options)
    return axes


def png_of(answer: Any) -> bytes:
    """Return an answer's picture as the bytes of a PNG file."""
    figure = figure_of(answer)
    out = io.BytesIO()
    with house_style():
        figure.savefig(out, format="png", dpi=100)
    return out.getvalue()


def figure_of(answer: Any, **options: Any) -> Any:
    """Return a new figure, never one of pyplot's, with an answer's picture."""
    drawing = drawing_of(answer)
    figure = blank_figure(drawing.size)
    _compose(answer, drawing, figure, options)
    return figure


def _compose(answer: Any, drawing: PictureKind, figure: Any, options: dict[str, Any]) -> Any:
    """Draw into an empty figure and return its axes, an array of them for a picture of several panels."""
    import numpy as np

    function = _function(drawing, options)
    with house_style():
        if drawing.panels:
            function(answer, figure, **options)
            return np.array(figure.axes, dtype=object)
        axes = figure.add_subplot(projection="3d" if drawing.space else None)
        function(answer, axes, **options)
    return axes


def _function(drawing: PictureKind, options: dict[str, Any]) -> Callable[..., None]:
    """Return a drawing's function, or refuse options that it does not have."""
    function: Callable[..., None] = resolve_name(f"{VIZ}.{drawing.function}")
    known = [*inspect.signature(function).parameters][2:]
    for name in options:
        check_name("option of this picture", name, known)
    return function


def _open_figure(size: tuple[float, float]) -> Any:
    """Return an empty figure: pyplot's where that is loaded, so that its `show` finds it."""
    if "matplotlib.pyplot" not in sys.modules:
        return blank_figure(size)
    import matplotlib.pyplot as plt

    with house_style():
        return plt.figure(figsize=size, layout="constrained")
