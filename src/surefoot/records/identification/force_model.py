"""Forces on a foot without a sensor in it, from angles and torques of a leg that a force sensor calibrated.

Statics, f = J⁻ᵀ (M v̇ + h - τ), miss what joints keep to themselves. What a joint gives its link is

    τ_leg = τ + k τ + b + s τ³ - (c + μ |τ|) z - I q̈ + r(q),    ż = (q̇ - |q̇| z) / length        (Dahl [1]_)

an error k of the motor's constant, an offset b, a constant that changes with the current (s), friction c,
more of it under load (μ), with its hysteresis, the inertia I of the rotor, and the ripple r that repeats with
the motor's turn (`ripple`). The sensor is turned and has
an offset. All of it is linear but the hysteresis' length and the sensor's delay, which are searched. Where
the sensor's axes disagree about a joint (a bent rail, a foot that rolls) each keeps coefficients of its own,
drawn towards the rigid body's statics by a ridge (hardly, where the joint itself is asked for). Intervals are
quantiles of errors in parts of the recording that a fit did not see [2]_, wider where their fits disagree.

References
----------
.. [1] P. Dahl, "A solid friction model", Aerospace Corporation TOR-0158(3107-18)-1, 1968.
.. [2] J. Lei, M. G'Sell, A. Rinaldo, R. Tibshirani, L. Wasserman, "Distribution-free predictive inference for
   regression", JASA 2018 (intervals from errors that the fit did not see).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy import stats

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, count_of
from surefoot.base.numerics.phases import debounced
from surefoot.mechanics import Robot
from surefoot.records.identification.leg_motion import (
    QUICK,
    SMOOTH,
    STEADY,
    LegLog,
    LegMotion,
    leg_motion,
    read_leg_log,
)
from surefoot.records.identification.torque_ripple import ripple_lines

TERMS = {
    "gain": "-", "offset": "N m", "friction": "N m", "loaded": "-", "cubic": "1/(N m)²", "inertia": "kg m²",
}  # fmt: skip
"""What a joint keeps to itself, and its units."""
LENGTHS = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02)
"""Lengths of the hysteresis that are tried [rad]."""
LATEST = 0.01
"""Longest delay between torques and sensor that is tried, either way [s]."""
RIDGE, FREE = 0.01, 1e-5
"""Weights of the rigid body's statics against the recording, per standard deviation of a term: for forces,
which other motions ask for too, and for what a joint has."""
SLOW = 0.5
"""Window [s] of what is no ripple."""
PARTS = 10
"""Parts of the recording that are left out, one after the other."""
TOUCHING, LASTING = 2.0, 0.01
"""A foot touches that is pushed by more than this [N] for longer than this [s]."""
SOON, SAME_POSE = 1.0, 0.01
"""Time [s], or difference of angles [rad], within which a recording goes on where another one ended."""
SLIPPING = 0.3
"""Speed that no rail can give a foot on the ground [m/s]."""


@dataclass(frozen=True, repr=False)
class FootForces(Drawn):
    """Forces on the foot, row by row.

    Attributes
    ----------
    time
        (T,) [s].
    forces, low, high
        (T, 3) what the sensor would read, its own axes [N], and the 95 % interval of each.
    vertical
        (T,) force along the sensor's axis that is nearest to the world's z, upwards positive [N].
    contact
        (T,) whether the foot touches.
    touchdowns
        (n,) times at which it begins to [s].
    friction_used
        (T,) horizontal over vertical force [-]; NaN where it does not touch.
    """

    time: FloatArray
    forces: FloatArray
    low: FloatArray
    high: FloatArray
    vertical: FloatArray
    contact: BoolArray
    touchdowns: FloatArray
    friction_used: FloatArray

    def __repr__(self) -> str:
        return f"FootForces({len(self.time)} rows, {len(self.touchdowns)} touchdowns)"

    def __str__(self) -> str:
        most = float(np.nanmax(np.linalg.norm(self.forces, axis=1), initial=0.0))
        span = float(self.time[-1] - self.time[0]) if len(self.time) else 0.0
        downs = count_of(len(self.touchdowns), "touchdown")
        return f"Forces on a foot over {span:.4g} s, at most {most:.4g} N, {downs}."


@dataclass(frozen=True, repr=False)
class ForceModel(Drawn):
    """Joint friction, motor constants, inertia and a sensor's axes of one leg, found with a force sensor.

    Attributes
    ----------
    robot
        The leg, loaded with ``fixed_base=True``; its base may run on rails that nobody measures.
    axes, offset
        (3, 3) from world axes to the sensor's [-], and (3,) what it reads at no force [N].
    delay
        How much later than the torques the sensor tells [s].
    length
        Of the hysteresis of friction [rad].
    lines
        How often the motor's ripple repeats per radian, joint by joint [1/rad].
    coefficients, parts
        (3, m) by sensor axis, of `TERMS` in their units, joint by joint and world axis, of the ripple's sines
        and cosines [N m], then an offset [N]; (PARTS, 3, m) the same without one part of the recording each.
    noise, drift, rms
        (3,) [N] standard deviations of what the fit leaves over and of the offset from part to part, and the
        rms of errors in parts that a fit did not see.
    scale
        (3,) 95 % quantile of these errors over what noise and the disagreement of the parts' fits give [-].
    joints
        {joint: {term: (value, low, high)}}: what each keeps to itself and 95 % intervals [units of `TERMS`].
    ends
        (2, 1 + k) time [s] and pose [rad] at the recording's ends.
    notes
        What was found, a line each.
    """

    robot: Robot
    axes: FloatArray
    offset: FloatArray
    delay: float
    length: float
    lines: tuple[tuple[float, ...], ...]
    coefficients: FloatArray
    parts: FloatArray
    noise: FloatArray
    drift: FloatArray
    rms: FloatArray
    scale: FloatArray
    joints: dict[str, dict[str, tuple[float, float, float]]]
    ends: FloatArray = field(default_factory=lambda: np.zeros((2, 1)))
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        rms = np.round(self.rms, 2).tolist()
        return f"ForceModel({self.robot.name!r}, {len(self.joints)} joints, rms={rms} N)"

    def __str__(self) -> str:
        found = "; ".join(
            f"{joint}: " + ", ".join(f"{term} {value:.3g}" for term, (value, _, _) in [*terms.items()][:3])
            for joint, terms in [*self.joints.items()][:3]
        )
        rms = ", ".join(f"{one:.2g}" for one in self.rms)
        return f"Forces of {self.robot.name}: errors of {rms} N (rms, not seen by the fit); {found}."

    @classmethod
    def fit(cls, robot: Robot, log: LegLog | str | Path) -> ForceModel:
        """Return the model that a recording with a force sensor gives.

        Parameters
        ----------
        robot
            The leg, loaded with ``fixed_base=True``.
        log
            With a sensor: a CSV file, see `read_leg_log`, or what it returns.

        Raises
        ------
        ProblemError
            If the log has no sensor, does not fit the robot, or the leg moves too little to tell.
        """
        log = log if isinstance(log, LegLog) else read_leg_log(log)
        if log.sensor is None:
            raise ProblemError("a fit needs a force sensor: columns NAME_x, NAME_y and NAME_z [N]")
        motion = leg_motion(robot, log)
        statics, reading = _statics(motion, log), log.sensor
        turn = _axes(statics, reading)
        still = statics @ turn.T

        def left(X: FloatArray, late: int = 0) -> FloatArray:
            target, X = reading - _later(still, late), _later(X, late)
            return np.asarray(target - X @ _ridge(X, target).T)

        lines = _ripple(motion, log, left(_terms(motion, log, LENGTHS[len(LENGTHS) // 2])) @ turn)
        tried = {length: _terms(motion, log, length, lines) for length in LENGTHS}
        length = min(LENGTHS, key=lambda one: (left(tried[one]) ** 2).sum())
        most = round(LATEST / log.dt)
        late = min(range(-most, most + 1), key=lambda rows: (left(tried[length], rows) ** 2).sum())
        X, target = _later(tried[length], late), reading - _later(still, late)
        model = cls._fit(robot, motion.joints, X, target, turn, length, lines, late * log.dt)
        return dataclasses.replace(model, ends=_ends(log), notes=model._findings(motion, log))

    @classmethod
    def _fit(
        cls, robot: Robot, joints: tuple[str, ...], X: FloatArray, left: FloatArray, turn: FloatArray,
        length: float, lines: tuple[tuple[float, ...], ...], delay: float,
    ) -> ForceModel:  # fmt: skip
        """Return the model of what statics leave over (T, 3), by terms (T, m), for all parts but one each."""
        cuts = np.linspace(0, len(left), PARTS + 1).astype(int)
        whole, free, unseen = _ridge(X, left), _ridge(X, left, FREE), np.empty_like(left)
        fits, others = [], []
        for a, b in pairwise(cuts):
            seen, target = (np.delete(values, slice(a, b), axis=0) for values in (X, left))
            fits.append(_ridge(seen, target))
            others.append(_ridge(seen, target, FREE))
            unseen[a:b] = left[a:b] - X[a:b] @ fits[-1].T
        parts, noise = np.array(fits), (left - X @ whole.T).std(axis=0)
        # The mean error of a part that its fit did not see wanders by more than noise and doubt explain: the
        # rest is drift of the sensor.
        doubt = _doubt(X, parts, noise)
        wandering = np.add.reduceat(unseen, cuts[:-1]) ** 2 / np.diff(cuts)[:, None] ** 2
        known = np.add.reduceat(doubt**2 - noise**2, cuts[:-1]) / np.diff(cuts)[:, None]
        return cls(
            robot, turn, whole[:, -1], delay, length, lines, whole, parts, noise,
            np.sqrt(np.maximum(0.0, (wandering - known).mean(axis=0))),
            np.sqrt((unseen**2).mean(axis=0)), np.quantile(np.abs(unseen) / doubt, 0.95, axis=0),
            _joint_terms(free, np.array(others), X, turn, joints),
        )  # fmt: skip

    def _findings(self, motion: LegMotion, log: LegLog) -> tuple[str, ...]:
        """Return what was found about the log, a line each."""
        axis, up = self.vertical_axis
        named = ", ".join(f"{a} is {b}" for a, b in zip(log.names, motion.joints, strict=True))
        return (
            f"joints: {named}; {', '.join(motion.rails) or 'none'} not measured",
            f"{log.sensor_name}_{'xyz'[axis]} is {'up' if up > 0 else 'down'}, "
            f"{np.degrees(np.arccos(min(1.0, abs(self.axes[axis, 2])))):.1f} deg off the vertical; "
            "offsets " + ", ".join(f"{x:.2f}" for x in self.offset) + " N",
            f"the sensor is {1e3 * self.delay:.0f} ms later than the torques; "
            f"friction turns within {1e3 * self.length:g} mrad",
            "ripple of the motors per radian: "
            + "; ".join(", ".join(map(str, n)) or "none" for n in self.lines),
            "errors on parts that the fit did not see: " + ", ".join(f"{x:.2f}" for x in self.rms) + " N rms",
        )

    @property
    def vertical_axis(self) -> tuple[int, float]:
        """The sensor's axis nearest to the world's z, and 1 where it points up, -1 where down [-]."""
        axis = int(np.argmax(np.abs(self.axes[:, 2])))
        return axis, float(np.sign(self.axes[axis, 2]))

    def estimate(self, log: LegLog | str | Path) -> FootForces:
        """Return the forces on the foot in a recording of the same leg; a sensor in it is not looked at.

        Raises
        ------
        ProblemError
            If the log does not fit the robot.
        """
        log = log if isinstance(log, LegLog) else read_leg_log(log)
        motion = leg_motion(self.robot, log)
        if len(motion.joints) != len(self.lines):
            raise ProblemError(f"the model is of {', '.join(self.joints)}, the log of {', '.join(log.names)}")
        late = round(self.delay / log.dt)
        X = _later(_terms(motion, log, self.length, self.lines), late)
        forces = _later(_statics(motion, log) @ self.axes.T, late) + X @ self.coefficients.T
        axis, up = self.vertical_axis
        vertical = up * forces[:, axis]
        doubt = _doubt(X, self.parts, self.noise)
        half = np.hypot(self.scale * doubt, stats.t.ppf(0.975, PARTS - 1) * self.drift)
        if not self._goes_on(log):  # the sensor may have been zeroed anew
            half = np.hypot(half, self.offset)
        touch = (vertical > TOUCHING) & (motion.slip < SLIPPING)
        contact = debounced(log.time, touch, LASTING)
        begins = 1 + np.flatnonzero(~contact[:-1] & contact[1:])
        begins = begins[log.time[begins] - log.time[0] > LASTING]  # what is cut is no touchdown
        side = np.delete(forces, axis, axis=1)
        used = np.where(contact, np.linalg.norm(side, axis=1) / np.where(contact, vertical, 1.0), np.nan)
        return FootForces(
            log.time, forces, forces - half, forces + half, vertical, contact, log.time[begins], used
        )

    def _goes_on(self, log: LegLog) -> bool:
        """Return whether a recording is the rest of the fitted one, by its clock or its first pose."""
        first, last = _ends(log)
        apart = min(abs(first[0] - self.ends[1, 0]), abs(last[0] - self.ends[0, 0]))
        return bool(apart < SOON or np.abs(first - self.ends[1])[1:].max() < SAME_POSE)


def _statics(motion: LegMotion, log: LegLog) -> FloatArray:
    """Return (T, 3) forces on the foot [N] by the rigid body, world axes."""
    return np.asarray(np.einsum("tij,tj->ti", motion.lever, motion.needed - log.smooth(log.tau, QUICK)))


def _axes(f: FloatArray, y: FloatArray) -> FloatArray:
    """Return (3, 3) the sensor's axes: the rotation that carries statics (T, 3) to readings (T, 3) best."""
    f, y = f - f.mean(axis=0), y - y.mean(axis=0)
    U, _, V = np.linalg.svd(y.T @ f)
    return np.asarray(U @ np.diag([1.0, 1.0, np.linalg.det(U @ V)]) @ V)


def _ripple(motion: LegMotion, log: LegLog, left: FloatArray) -> tuple[tuple[float, ...], ...]:
    """Return the lines of each joint's ripple in forces (T, 3) that a model leaves over, world axes."""
    torque = np.einsum("tji,ti->tj", np.linalg.pinv(motion.lever), left)
    torque, speed = torque - log.smooth(torque, SLOW), log.smooth(log.q, SMOOTH, 1)
    series = zip(log.q.T, speed.T, torque.T, strict=True)
    return tuple(tuple(ripple_lines(q, v, tau, PARTS)) for q, v, tau in series)


def _terms(
    motion: LegMotion, log: LegLog, length: float, lines: tuple[tuple[float, ...], ...] = ()
) -> FloatArray:
    """Return (T, m) forces [N] for one unit of each term of each joint along each world axis, and ones."""
    tau, step = log.smooth(log.tau, QUICK), log.smooth(log.q, STEADY, 1) * log.dt
    z, faded = np.zeros_like(step), np.exp(-np.abs(step) / length)
    for t in range(1, len(step)):  # Dahl's equation, exact over a row of constant speed
        to = np.sign(step[t])
        z[t] = to + (z[t - 1] - to) * faded[t]
    a = log.smooth(log.q, QUICK, 2)
    terms = np.stack([-tau, -np.ones_like(tau), z, np.abs(tau) * z, -(tau**3), a], axis=2)
    columns = [np.einsum("tij,tjn->tjni", motion.lever, terms).reshape(len(tau), -1)]
    for j, own in enumerate(lines):
        for n in own:
            columns += [motion.lever[:, :, j] * wave(n * log.q[:, [j]]) for wave in (np.sin, np.cos)]
    return np.column_stack([*columns, np.ones(len(tau))])


def _ridge(X: FloatArray, y: FloatArray, weight: float = RIDGE) -> FloatArray:
    """Return (3, m) coefficients of readings (T, 3) by terms (T, m), drawn to zero but the last."""
    # Ridge in units in which every term varies by one; the sensor's offset, the last one, is not drawn to
    # zero.
    size = X.std(axis=0)
    size[size < 1e-9] = 1.0
    scaled = X / size
    pull = weight * len(X) * np.eye(X.shape[1])
    pull[-1, -1] = 0.0
    return np.asarray((np.linalg.solve(scaled.T @ scaled + pull, scaled.T @ y) / size[:, None]).T)


def _doubt(X: FloatArray, parts: FloatArray, noise: FloatArray) -> FloatArray:
    """Return (T, 3) standard deviations of forces [N], by the jackknife over parts of the recording."""
    spread = np.einsum("tm,pim->tpi", X, parts - parts.mean(axis=0))
    return np.asarray(np.sqrt(noise**2 + (PARTS - 1) / PARTS * (spread**2).sum(axis=1)))


def _ends(log: LegLog) -> FloatArray:
    """Return (2, 1 + k) time [s] and pose [rad] of the first row and the last."""
    return np.column_stack([log.time, log.q])[[0, -1]]


def _later(values: FloatArray, rows: int) -> FloatArray:
    """Return (T, ...) values that many rows later."""
    return values[np.clip(np.arange(len(values)) - rows, 0, len(values) - 1)] if rows else values


def _joint_terms(
    whole: FloatArray, parts: FloatArray, X: FloatArray, turn: FloatArray, names: tuple[str, ...]
) -> dict[str, dict[str, tuple[float, float, float]]]:
    """Return each joint's terms with intervals: the sensor's axes turned back, weighted by what they see."""
    shape = (len(names), len(TERMS), 3)
    count = int(np.prod(shape))
    weight = X[:, :count].var(axis=0).reshape(shape) + 1e-300

    def of(C: FloatArray) -> FloatArray:
        seen = np.einsum("ic,i...c->...c", turn, C[:, :count].reshape(3, *shape))
        return np.asarray((weight * seen).sum(axis=2) / weight.sum(axis=2))

    value, others = of(whole), np.array([of(part) for part in parts])
    spread = np.sqrt((PARTS - 1) / PARTS * ((others - others.mean(axis=0)) ** 2).sum(axis=0))
    half = stats.t.ppf(0.975, PARTS - 1) * spread
    return {
        name: {
            term: (float(value[j, n]), float(value[j, n] - half[j, n]), float(value[j, n] + half[j, n]))
            for n, term in enumerate(TERMS)
        }
        for j, name in enumerate(names)
    }
