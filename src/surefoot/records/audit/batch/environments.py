"""What was measured in many environments: arrays over time and environments, and where episodes end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray, of_kind, positive_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log
from surefoot.records.log.array_names import ALIASES
from surefoot.records.log.channels import CHANNELS
from surefoot.records.log.from_arrays import host_array, log_from_arrays

KNOWN = ("forces", "gaps", "contact_velocities", "contact_positions", "normals", "contact_friction", "mu")
"""Channels that are judged in many environments."""
SHORT = {"velocities": "contact_velocities", "positions": "contact_positions"}
"""Other names of theirs, beside those of `log_from_arrays`."""
UNKNOWN_MASS = "the masses are not told: each is taken from the mean of its forces"
WORLD_AXES = "forces: contact axes are taken to be the world's, as on level ground"


@dataclass(frozen=True)
class Environments:
    """Arrays of N environments over T rows.

    Attributes
    ----------
    arrays
        Channel to (T, N, ...) numbers of any kind; friction is (T, N, p) of each contact.
    dt
        Time between rows [s].
    weights
        (N,) m g [N].
    weighed
        Whether masses were told.
    episodes
        (E, 3) environment, first row and the one after the last; by environment, then by time.
    facts, feet
        Of every environment.
    notes
        What was assumed.
    """

    arrays: dict[str, Any]
    dt: float
    weights: FloatArray
    weighed: bool
    episodes: IntArray
    facts: Mapping[str, Any]
    feet: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @property
    def rows(self) -> int:
        """T."""
        return int(self.arrays["forces"].shape[0])

    @property
    def count(self) -> int:
        """N."""
        return int(self.arrays["forces"].shape[1])

    @property
    def points(self) -> int:
        """Contacts of an environment."""
        return int(self.arrays["forces"].shape[2])

    def log(self, environment: int) -> Log:
        """Return an environment's log, which `audit_log` judges alone."""
        mine = self.episodes[self.episodes[:, 0] == environment]
        facts = dict(self.facts)
        if len(mine) > 1:
            facts["episode_rows"] = mine[:, 1]
        if self.weighed:
            facts["mass"] = float(self.weights[environment]) / GRAVITY
        return self._log(environment, slice(0, self.rows), facts)

    def episode_log(self, episode: IntArray) -> Log:
        """Return the log of an episode (3,), its mass that which is taken."""
        environment, first, end = episode.tolist()
        facts = {**self.facts, "mass": float(self.weights[environment]) / GRAVITY}
        return self._log(environment, slice(first, end), facts)

    def _log(self, environment: int, rows: slice, facts: dict[str, Any]) -> Log:
        arrays = {name: array[rows, environment] for name, array in self.arrays.items()}
        return log_from_arrays(arrays, dt=self.dt, feet=self.feet, facts=facts)

    def columns(self, name: str, episodes: IntArray) -> FloatArray:
        """Return a channel of (n, 3) episodes of one length L, side by side: (L, n, ...)."""
        array, (_, first, end) = self.arrays[name], episodes[0]
        if (episodes[:, 1] == first).all():
            return np.asarray(array[first:end, episodes[:, 0]], dtype=np.float64)
        parts = [array[a:b, k] for k, a, b in episodes.tolist()]
        return np.asarray(np.stack(parts, axis=1), dtype=np.float64)


def read_environments(
    arrays: Mapping[str, Any], dt: float, mu: Any, mass: Any, done: Any, facts: Mapping[str, Any] | None,
    feet: Sequence[str],
) -> Environments:  # fmt: skip
    """Return what `surefoot.audit_batch` was given, checked."""
    of_kind("arrays", arrays, Mapping)
    of_kind("facts", {} if facts is None else facts, Mapping)
    known = dict(facts or {})
    notes: tuple[str, ...] = ()
    fields: dict[str, Any] = {}
    for given, value in arrays.items():
        name = ALIASES.get(given, (SHORT.get(given, given), ""))[0]
        check_name("array", name if name in KNOWN else given, [*KNOWN, *SHORT])
        if name in fields:
            raise ProblemError(f"two arrays are the channel {name}: {', '.join(arrays)}")
        fields[name] = host_array(given, value)
        if ALIASES.get(given, ("", ""))[1]:
            notes = (WORLD_AXES,)
    if "forces" not in fields:
        raise ProblemError(f"arrays must have forces (T, N, contacts, 3), got {', '.join(fields) or 'none'}")
    _check_shapes(fields)
    T, N, points = fields["forces"].shape[:3]
    if mu is not None:
        if {"mu", "contact_friction"} & set(fields):
            raise ProblemError("mu is given as an array and as an argument: give one of them")
        fields["mu"] = host_array("mu", mu)
    if "mu" in fields:
        fields["contact_friction"] = _friction(fields.pop("mu"), (T, N, points))
    step = positive_number("dt", dt, "s")
    if "mass" in known and mass is None:
        mass = known.pop("mass")
    weights = _weights(fields["forces"], mass)
    ends = _ends(done, T, N)
    return Environments(
        fields, step, weights, mass is not None, _episodes(ends), known, tuple(map(str, feet)), notes
    )


def _check_shapes(fields: Mapping[str, Any]) -> None:
    """Raise unless all arrays are (T, N, ...) of the same T, N and contacts."""
    forces = fields["forces"].shape
    if len(forces) != 4 or forces[3] != 3 or 0 in forces:
        one = "; audit_log takes one environment's log" if len(forces) == 3 else ""
        raise ProblemError(f"array forces must have shape (T, N, contacts, 3), got {forces}{one}")
    for name, array in fields.items():
        if name == "mu":
            continue
        wanted = (*forces[:2], *(forces[2] if size == "p" else size for size in CHANNELS[name].shape))
        if array.shape != wanted:
            raise ProblemError(f"array {name} must have shape {wanted}, as forces has, got {array.shape}")


def _friction(mu: Any, shape: tuple[int, int, int]) -> Any:
    """Return friction (T, N, p) of a number, (N,), (N, p) or (T, N) of them, without a copy."""
    T, N, points = shape
    places = {(): mu, (N,): mu[..., None] if mu.ndim == 1 else mu, (N, points): mu}
    if mu.shape == (T, N):
        return np.broadcast_to(mu[..., None], shape)
    if mu.shape in places:
        return np.broadcast_to(places[mu.shape], shape)
    raise ProblemError(
        f"mu must be a number, ({N},), ({N}, {points}) or ({T}, {N}), one an environment, contact or row; "
        f"got the shape {mu.shape}"
    )


def _weights(forces: Any, mass: Any) -> FloatArray:
    """Return m g of every environment (N,), of masses or else of the mean forces [N]."""
    N = forces.shape[1]
    if mass is None:
        with np.errstate(over="ignore", invalid="ignore"):
            total = forces[..., 2].sum(axis=2, dtype=np.float64)
            mean = np.nan_to_num(np.where(np.isfinite(total), total, 0.0).mean(axis=0))
        return np.where(mean > 0.0, mean, GRAVITY)
    masses = np.asarray(host_array("mass", mass), dtype=np.float64)
    if masses.shape not in ((), (N,)) or not (np.isfinite(masses) & (masses > 0.0)).all():
        raise ProblemError(f"mass must be a positive number [kg] or one for each of {N} environments")
    return np.broadcast_to(masses, (N,)) * GRAVITY


def _ends(done: Any, T: int, N: int) -> BoolArray:
    """Return in which rows (T, N) an episode ends."""
    ends = np.zeros((T, N), dtype=bool)
    if done is not None:
        given = host_array("done", done)
        if given.shape != (T, N):
            wanted = f"({T}, {N}), True in the last row of an episode"
            raise ProblemError(f"done must have shape {wanted}, got {given.shape}")
        ends |= given != 0
    ends[-1] = True
    return ends


def _episodes(ends: BoolArray) -> IntArray:
    """Return (E, 3) environment, first row and the one after the last, of rows (T, N) that end an episode."""
    environment, last = np.nonzero(ends.T)
    first = np.where(np.diff(environment, prepend=-1) > 0, 0, np.append(0, last[:-1] + 1))
    return np.stack([environment, first, last + 1], axis=1)
