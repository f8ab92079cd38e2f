"""The audit of many environments in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray, of_kind, whole_number
from surefoot.base.cores import cores
from surefoot.base.errors import ProblemError
from surefoot.records.audit.batch.batch_report import BatchReport
from surefoot.records.audit.batch.environments import Environments, read_environments
from surefoot.records.audit.batch.exploits import BEYOND_ACTUATORS, find_exploits
from surefoot.records.audit.batch.joint_work import JOINT_ARRAYS, JOINT_WORK, judge_joints, read_joints
from surefoot.records.audit.batch.law_found import LawFound
from surefoot.records.audit.batch.side_by_side import SIDE_BY_SIDE, Found, judge, reward_shares
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.report import Judgement
from surefoot.records.log.from_arrays import host_array

BLOCK = 1 << 16
"""Contacts times rows that are judged at once: their arrays stay in a processor's cache."""


def audit_batch(
    arrays: Mapping[str, Any],
    dt: float,
    mu: Any = None,
    *,
    mass: Any = None,
    done: Any = None,
    reward: Any = None,
    facts: Mapping[str, Any] | None = None,
    feet: Sequence[str] = (),
    limits: AuditLimits = LIMITS,
    threads: int | None = None,
) -> BatchReport:
    """Judge the laws of contact over many environments at once, as `audit_log` judges each alone.

    Parameters
    ----------
    arrays
        Channel to (T, N, ...) numbers of NumPy, JAX or Torch: ``forces`` (T, N, contacts, 3) [N] in contact
        axes; where they are known ``gaps`` (T, N, contacts) [m], ``contact_velocities`` (also ``velocities``)
        (T, N, contacts, 3) [m/s], ``normals``, ``contact_positions`` (also ``positions``), ``mu`` (T, N).
        For joint work ``joint_velocities`` and ``torques`` (T, N, joints), ``energy`` (T, N) [J], kinetic,
        potential and of springs, with the fact ``effort_limits``.
    dt
        Time between rows [s].
    mu
        Friction: a number, (N,), (N, contacts) or (T, N), where no array has it.
    mass
        Of each robot: a number or (N,) [kg]. Without it no environment is called lawful.
    done
        (T, N) True in the last row of an episode: no law reaches into the next.
    reward
        (T, N) of every step: exploits then say which share of it came from their rows.
    facts
        Of all environments, see `log_from_arrays`: ``terrain`` "flat", ``sinking``, ...
    feet
        Names of the contacts.
    limits
        What is judged by.
    threads
        How many at most; None for the cores.

    Returns
    -------
    BatchReport
        Verdict of each environment; of each law the share of rows, the worst value and its instant.

    Raises
    ------
    ProblemError
        For shapes that do not fit, names that are no channel, numbers that cannot be.

    Examples
    --------
    >>> import numpy as np
    >>> forces = np.zeros((100, 3, 4, 3)) + [0.0, 0.0, 40.0]
    >>> forces[50, 1, 2, 0] = 70.0
    >>> gaps, velocities = np.zeros((100, 3, 4)), np.zeros((100, 3, 4, 3))
    >>> arrays = {"forces": forces, "gaps": gaps, "velocities": velocities}
    >>> report = audit_batch(arrays, 0.01, mu=0.8, mass=16.3)
    >>> report.verdicts
    ('lawful', 'broken', 'lawful')
    >>> law = report["friction"]
    >>> law.share.tolist(), float(law.worst[1]), float(law.instant[1]), int(law.contact[1])
    ([0.0, 0.01, 0.0], 1.75, 0.5, 2)
    """
    of_kind("arrays", arrays, Mapping)
    of_contacts = {name: array for name, array in arrays.items() if name not in JOINT_ARRAYS}
    given = read_environments(of_contacts, dt, mu, mass, done, facts, feet)
    joints = read_joints(arrays, given.facts.get("effort_limits"), (given.rows, given.count))
    paid = None if reward is None else _reward(reward, given)
    workers = cores() if threads is None else max(1, whole_number("threads", threads, low=1))
    blocks = _blocks(given)

    def judge_block(block: IntArray) -> list[tuple[IntArray, Found]]:
        return [(block[which], found) for which, found in judge(given, given.episodes[block], limits, paid)]

    with ThreadPoolExecutor(workers) as pool:
        parts = [part for several in pool.map(judge_block, blocks) for part in several]
    balance = None if joints is None else judge_joints(joints, given, limits)
    return _report(given, _join(parts, len(given.episodes)), limits, paid, balance)


def _reward(reward: Any, given: Environments) -> FloatArray:
    """Return the reward (T, N)."""
    paid = np.asarray(host_array("reward", reward), dtype=np.float64)
    if paid.shape != (given.rows, given.count):
        raise ProblemError(f"reward must have shape ({given.rows}, {given.count}), got {paid.shape}")
    return paid


def _blocks(given: Environments) -> list[IntArray]:
    """Return numbers of episodes that are judged at once: of one length, so many that they fit a cache."""
    lengths = given.episodes[:, 2] - given.episodes[:, 1]
    out: list[IntArray] = []
    for length in np.unique(lengths).tolist():
        same = np.flatnonzero(lengths == length)
        size = max(1, BLOCK // (length * given.points))
        out += [same[k : k + size] for k in range(0, len(same), size)]
    return out


def _join(parts: list[tuple[IntArray, Found]], episodes: int) -> Found:
    """Return what was found in all episodes, in their order."""
    order = np.argsort(np.concatenate([which for which, _ in parts]), kind="stable")

    def arrays(name: str) -> Any:
        return np.concatenate([getattr(found, name) for _, found in parts])[order]

    reasons = [reason for _, found in parts for reason in found.reasons]
    coverage = [one for _, found in parts for one in found.coverage]
    return Found(
        arrays("rows"), arrays("value"), arrays("limit"), arrays("row"), arrays("contact"), arrays("reward"),
        [reasons[k] for k in order], [coverage[k] for k in order],
    )  # fmt: skip


def _report(
    given: Environments, found: Found, limits: AuditLimits, reward: FloatArray | None,
    balance: tuple[LawFound, BoolArray] | None,
) -> BatchReport:  # fmt: skip
    """Return what the episodes' findings, and the energy balance of joints, are of each environment."""
    verdicts, reasons = _verdicts(given, found, limits)
    owner, starts = given.episodes[:, 0], np.flatnonzero(np.diff(given.episodes[:, 0], prepend=-1))
    over = np.where(np.isfinite(found.value), found.value - found.limit, -np.inf)
    laws = {}
    for c, check in enumerate(SIDE_BY_SIDE):
        # of an environment's episodes the one whose limit is exceeded by most
        order = np.lexsort((-over[:, c], owner))
        worst = order[starts]
        laws[check.name] = LawFound(
            check.name, check.unit, check.law, np.add.reduceat(found.rows[:, c], starts) / given.rows,
            found.value[worst, c], found.limit[worst, c], given.dt * found.row[worst, c],
            found.contact[worst, c],
        )  # fmt: skip
    paid = reward_shares(found, reward)
    if balance is not None:
        laws[JOINT_WORK], rows = balance
        if paid and reward is not None:
            paid[BEYOND_ACTUATORS] = float(np.nansum(reward[rows]) / np.nansum(reward))
    return BatchReport(
        verdicts, reasons, laws, find_exploits(laws, paid), _coverage(found), given.notes,
        len(given.episodes), given.rows, given.dt, {}, limits, given,
    )  # fmt: skip


def _verdicts(
    given: Environments, found: Found, limits: AuditLimits
) -> tuple[tuple[Judgement, ...], tuple[str, ...]]:
    """Return the verdict of each environment, the worst of its episodes', and why one cannot tell.

    An episode too short to say anything is not asked where another is long enough.
    """
    law = np.array([check.law for check in SIDE_BY_SIDE])
    broken = np.asarray((found.rows[:, law] > 0).any(axis=1)).tolist()
    length = (given.episodes[:, 2] - given.episodes[:, 1]).tolist()
    mine: list[list[int]] = [[] for _ in range(given.count)]
    for k, environment in enumerate(given.episodes[:, 0].tolist()):
        mine[environment].append(k)
    verdicts: list[Judgement] = []
    reasons: list[str] = []
    for several in mine:
        told = [k for k in several if broken[k] or length[k] >= limits.records.least_rows] or several
        reason = next((found.reasons[k] for k in told if found.reasons[k]), "")
        wrong = any(broken[k] for k in told)
        verdicts.append("broken" if wrong else "cannot tell" if reason else "lawful")
        reasons.append("" if wrong else reason)
    return tuple(verdicts), tuple(reasons)


def _coverage(found: Found) -> dict[str, str]:
    """Return in how many episodes laws could not be judged, and why."""
    out: dict[str, dict[str, int]] = {}
    for one in found.coverage:
        for law, why in one.items():
            if why:
                out.setdefault(law, {}).setdefault(why, 0)
                out[law][why] += 1
    many = len(found.coverage)
    return {
        law: "; ".join(
            why if count == many else f"{why} ({count} of {many} episodes)" for why, count in all.items()
        )
        for law, all in out.items()
    }
