"""What an audit of many environments says."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from surefoot.base.arrays import IntArray, whole_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, check_name, count_of
from surefoot.records.audit.auditor import audit_log
from surefoot.records.audit.batch.environments import Environments
from surefoot.records.audit.batch.exploits import Exploit
from surefoot.records.audit.batch.law_found import LawFound
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.report import AuditReport, Judgement
from surefoot.records.log import Log


@dataclass(frozen=True, repr=False)
class BatchReport(Drawn):
    """The audit of many environments; ``report["friction"].share`` is (N,).

    Attributes
    ----------
    verdicts
        (N,) "lawful", "broken" or "cannot tell", as `audit_log` says of each alone.
    reasons
        (N,) why one cannot tell; empty for other verdicts.
    laws
        Name to what was found.
    exploits
        What a policy gets of it, the most frequent first.
    coverage
        Law to the number of episodes in which it could not be judged, and why, for those that were not
        judged in all.
    notes
        What was assumed.
    episodes
        Number of them.
    rows, dt
        Rows of each environment, and the time between them [s].
    kept
        Logs of some environments, the worst ones, where the rows of all are not kept.
    """

    verdicts: tuple[Judgement, ...]
    reasons: tuple[str, ...]
    laws: dict[str, LawFound]
    exploits: tuple[Exploit, ...]
    coverage: dict[str, str]
    notes: tuple[str, ...]
    episodes: int
    rows: int
    dt: float
    kept: dict[int, Log] = field(default_factory=dict, repr=False, compare=False)
    limits: AuditLimits = field(default=LIMITS, repr=False)
    _given: Environments | None = field(default=None, repr=False, compare=False)

    def __getitem__(self, law: str) -> LawFound:
        check_name("law", law, self.laws)
        return self.laws[law]

    def __len__(self) -> int:
        return len(self.verdicts)

    def __repr__(self) -> str:
        told = ", ".join(f"{count} {verdict}" for verdict, count in self._counts.items())
        return f"BatchReport({count_of(len(self), 'environment')}: {told})"

    def __str__(self) -> str:
        told = ", ".join(f"{count} {verdict}" for verdict, count in self._counts.items())
        why = Counter(reason for reason in self.reasons if reason)
        unsure = f"; cannot tell since {why.most_common(1)[0][0]}" if why else ""
        first = f"; first of all {self.exploits[0]}" if self.exploits else ""
        size = f"{count_of(len(self), 'environment')}, {count_of(self.episodes, 'episode')}"
        return f"{size}: {told}{unsure}{first}."

    @property
    def _counts(self) -> Counter[str]:
        return Counter(self.verdicts)

    @property
    def unlawful(self) -> IntArray:
        """(k,) numbers of the environments in which a law is broken."""
        return np.flatnonzero([verdict == "broken" for verdict in self.verdicts])

    def worst(self, law: str = "", most: int = 5) -> IntArray:
        """Return the environments (k,) that break a law in most of their rows, or any, the worst first."""
        laws = [self[law]] if law else [one for one in self.laws.values() if one.law]
        share = np.max([one.share for one in laws], axis=0)
        order = np.argsort(-share, kind="stable")[:most]
        return np.asarray(order[share[order] > 0.0])

    def log(self, environment: int) -> Log:
        """Return the log of an environment.

        Raises
        ------
        ProblemError
            If there is no such environment, or its rows were not kept.
        """
        number = whole_number("environment", environment)
        if number >= len(self):
            raise ProblemError(f"environment must be below {len(self)}, got {number}")
        if self._given is not None:
            return self._given.log(number)
        if number not in self.kept:
            known = ", ".join(map(str, self.kept)) or "no environment"
            raise ProblemError(f"rows are kept of {known}, not of environment {number}")
        return self.kept[number]

    def without_rows(self, most: int = 3) -> BatchReport:
        """Return the report with the rows of no more than the worst environments, as logs."""
        kept = {k: self.log(k) for k in self.worst(most=most).tolist()} if self._given is not None else {}
        return replace(self, kept={**kept, **self.kept}, _given=None)

    def audit(self, environment: int) -> AuditReport:
        """Return the whole audit of one environment, with its symptoms and story."""
        return audit_log(self.log(environment), limits=self.limits)

    def lines(self) -> list[str]:
        """Return a line for each exploit, and one for each law that was not judged everywhere."""
        return [*map(str, self.exploits), *(f"{law}: {why}" for law, why in self.coverage.items())]
