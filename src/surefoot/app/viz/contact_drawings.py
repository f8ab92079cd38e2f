"""Drawings of contact problems and their answers on given axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.app.viz.style import BAD, FOOT_COLOURS, FORCE, MUTED, draw_friction_circle, friction_colour
from surefoot.base.arrays import per_contact
from surefoot.base.errors import ProblemError
from surefoot.contact.batch.solving import BatchSolution
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Certified, ContactSolution, Status

_TINY = 1e-300
_NAMED = 12
"""More contacts than this are drawn without their numbers."""


def draw_problem(problem: ContactProblem, axes: Any) -> None:
    """Draw how strongly each contact's force moves each contact: the sizes of the blocks of G."""
    G = np.asarray(problem.G, dtype=np.float64)
    count = problem.contacts
    if G.shape != (3 * count, 3 * count):
        raise ProblemError("a picture shows problems of contacts with three rows each")
    blocks = np.linalg.norm(G.reshape(count, 3, count, 3), axis=(1, 3))
    largest = max(float(blocks.max(initial=0.0)), _TINY)
    image = axes.imshow(
        blocks / largest, cmap="Blues", vmin=0.0, vmax=1.0, interpolation="nearest", aspect="equal"
    )
    axes.grid(visible=False)
    axes.set(xlabel="force of contact", ylabel="velocity of contact", title=str(problem).partition(":")[0])
    step = max(1, count // 8)
    axes.set(xticks=range(0, count, step), yticks=range(0, count, step))
    axes.figure.colorbar(image, ax=axes, label="coupling, as a share of the largest", shrink=0.85)


def draw_forces(answer: Certified, axes: Any, mu: ArrayLike | None = None) -> None:
    """Draw every contact's friction as a share of its cone: the unit circle is the cone's border.

    Areas of dots go with the normal forces; crosses are contacts without a force.

    Parameters
    ----------
    answer, axes
        What is drawn where.
    mu
        Friction of all contacts, or (n,) of each; needed where the answer does not know its problem.
    """
    forces = answer.forces
    if mu is None:
        if not isinstance(answer, ContactSolution):
            raise ProblemError("the answers of a ContactSolver do not know their friction: plot(mu=...)")
        mu = answer.problem.mu
    mu = per_contact("mu", mu, len(forces))
    if forces.ndim != 2 or forces.shape[1] != 3:
        raise ProblemError("a picture shows answers of contacts with three rows each")
    draw_friction_circle(axes, FOOT_COLOURS[0])
    largest = max(float(forces[:, 2].max(initial=0.0)), _TINY)
    on = forces[:, 2] > 1e-9 * largest
    limit = np.where(np.isfinite(mu), mu, 1.0) * forces[:, 2]
    used = forces[:, :2] / np.maximum(limit, _TINY)[:, None]
    used[~on | ~(mu > 0.0)] = 0.0
    share = np.linalg.norm(used, axis=1)
    colours = [friction_colour(s) for s in share[on]]
    axes.scatter(*used[on].T, s=20.0 + 160.0 * forces[on, 2] / largest, c=colours, alpha=0.75, lw=0)
    axes.plot(*used[~on].T, "x", color=MUTED, ms=6)
    if len(forces) <= _NAMED:
        for k in np.flatnonzero(on):
            axes.annotate(str(k), used[k], xytext=(5, 5), textcoords="offset points", fontsize=8)
    slides = int(np.count_nonzero(share[on] > 0.999))
    title = f"{answer.status.name}: {int(on.sum())} of {len(forces)} press, {slides} at the border"
    axes.set(xlim=(-1.2, 1.2), ylim=(-1.2, 1.2), title=title)
    axes.set(xlabel=r"$f_x\,/\,\mu f_z$", ylabel=r"$f_y\,/\,\mu f_z$")


def draw_batch(batch: BatchSolution, axes: Any) -> None:
    """Draw how accurately the problems of a batch were solved, by how they ended."""
    exponents = np.log10(np.maximum(np.where(np.isfinite(batch.residual), batch.residual, 1.0), 1e-17))
    statuses = [status for status in Status if np.any(batch.status == status)]
    groups = [exponents[batch.status == status] for status in statuses]
    colours = [
        FOOT_COLOURS[2] if status is Status.SOLVED else BAD if status is Status.INFEASIBLE else FORCE
        for status in statuses
    ]
    bins = np.linspace(-17.0, max(0.0, float(exponents.max(initial=0.0))), 35)
    labels = [f"{s.name}: {len(g)}" for s, g in zip(statuses, groups, strict=True)]
    axes.hist(groups, bins=bins, stacked=True, color=colours, label=labels)
    axes.xaxis.set_major_formatter(lambda x, _: f"$10^{{{x:.0f}}}$")
    axes.set(xlabel="velocity error, relative", ylabel="problems", title=f"{len(exponents)} problems")
    axes.legend(fontsize=8)
