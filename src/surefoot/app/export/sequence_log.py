"""Contact sequences from what there is: a log of a run, a plan, or a mode schedule and a stance."""

from __future__ import annotations

import numpy as np

from surefoot.app.export.sequence import ContactSequence, SequencePhase
from surefoot.base.arrays import BoolArray, FloatArray, of_kind, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.loaded import loaded_feet
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.stance import PointContact, Stance
from surefoot.motion.gaits.contact_schedule import SAME_TIME, ContactSchedule
from surefoot.records import Log
from surefoot.records.log.snapshot import contact_names

SHORTEST = 0.02
"""Changes of contact that last less than this are left out [s]."""


def sequence_from_log(log: Log, facets: int = 8) -> ContactSequence:
    """Return the contacts of a run or a plan: phases, mean places, mean forces.

    Parameters
    ----------
    log
        With forces, contact_positions, normals and mu, and the facts feet, contact_foot, mass and dt.
    facets
        Of the pyramids.

    Returns
    -------
    ContactSequence
        Frames are the feet's names where a foot touches in one point; the points of a sole are
        "FOOT:0", "FOOT:1", ...

    Raises
    ------
    ProblemError
        If the log does not tell what is needed.
    """
    of_kind("log", log, Log)
    for needed in ("feet", "contact_foot"):
        log.fact(needed)
    mass, dt, names = float(log.fact("mass")), float(log.fact("dt")), tuple(contact_names(log))
    forces: FloatArray = np.asarray(log["forces"])
    on = loaded_feet(forces[:, :, 2], mass * GRAVITY)
    starts = _phase_starts(on, max(1, round(SHORTEST / dt)))
    phases = []
    for begin, end in zip(starts, [*starts[1:], len(on)], strict=True):
        rows = slice(begin, end)
        points = np.flatnonzero(on[begin:end].mean(axis=0) > 0.5)
        touching = [
            PointContact(
                log["contact_positions"][rows, k].mean(axis=0),
                _mean_normal(log["normals"][rows, k]),
                float(np.mean(log["mu"][rows])),
                names[k],
            )
            for k in points
        ]
        meant = np.concatenate([forces[rows, k].mean(axis=0) for k in points]) if len(points) else None
        phases.append(SequencePhase((end - begin) * dt, Stance(touching), meant))
    return ContactSequence(phases, names, str(log.facts.get("robot", "")), mass, facets)


def sequence_from_schedule(
    schedule: ContactSchedule, stance: Stance, span: tuple[float, float], mass: float = 0.0
) -> ContactSequence:
    """Return the phases of a gait or a mode schedule, each foot where a stance has it.

    Parameters
    ----------
    schedule
        Of as many feet as the stance has contacts, in their order.
    stance
        Every foot on the ground.
    span
        First and last time [s].
    mass
        Of the robot [kg].

    Raises
    ------
    ProblemError
        If the numbers of feet differ, or the span is empty.

    Examples
    --------
    >>> from surefoot.motion.gaits.library import named_gait
    >>> feet = [PointContact((x, y, 0.0), name=n) for n, x, y in
    ...         (("FL", 0.2, 0.1), ("FR", 0.2, -0.1), ("RL", -0.2, 0.1), ("RR", -0.2, -0.1))]
    >>> trot = named_gait("flying_trot", 4)
    >>> [phase.names for phase in sequence_from_schedule(trot, Stance(feet), (0.0, trot.period)).phases]
    [('FL', 'RR'), (), ('FR', 'RL'), ()]
    """
    if schedule.feet != len(stance.contacts):
        sizes = f"the schedule has {schedule.feet} feet, the stance {len(stance.contacts)} contacts"
        raise ProblemError(sizes)
    start, end = (real_number("span", t, low=-1e9, high=1e9) for t in span)
    if not start < end:
        raise ProblemError(f"span must be a first and a later last time [s], got {start:g} and {end:g}")
    phases: list[SequencePhase] = []
    now = start
    while now < end - SAME_TIME:
        down = schedule.contacts([now])[0]
        until = min(end, *(schedule.phase(foot, now)[2] for foot in range(schedule.feet)))
        kept = [c for c, touches in zip(stance.contacts, down, strict=True) if touches]
        phases.append(SequencePhase(until - now, Stance(kept)))
        now = until
    return ContactSequence(phases, stance.names, "", mass)


def _phase_starts(on: BoolArray, least: int) -> list[int]:
    """Return the rows at which the touching points change for at least so many rows."""
    changes = [0, *(np.flatnonzero((on[1:] != on[:-1]).any(axis=1)) + 1).tolist()]
    kept = [0]
    for begin, end in zip(changes, [*changes[1:], len(on)], strict=True):
        same = bool((on[begin] == on[kept[-1]]).all())
        if begin > 0 and end - begin >= least and not same:
            kept.append(begin)
    return kept


def _mean_normal(normals: FloatArray) -> FloatArray:
    """Return the direction of the sum of unit vectors (T, 3)."""
    total = normals.sum(axis=0)
    return np.asarray(total / np.linalg.norm(total))
