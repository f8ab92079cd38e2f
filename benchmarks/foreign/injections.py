"""Faults that several loops share: cut motors, pushes, loads, biased sensors, spoilt logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.foreign.fault import Fault
from benchmarks.foreign.ground import ball, sack
from surefoot.records import Log

Rng = np.random.Generator


def between(rng: Rng, low: float, high: float) -> float:
    """Draw a number."""
    return float(rng.uniform(low, high))


def choice(rng: Rng, values: Sequence[Any]) -> Any:
    """Draw one of some values."""
    return values[int(rng.integers(len(values)))]


def weak_motors(rng: Rng, groups: Sequence[Mapping[str, Sequence[str]]], onset: tuple[float, float]) -> Fault:
    """Return motors that are cut or weakened: the controls zeroed, or the gain of the model reduced.

    Parameters
    ----------
    rng
        Random numbers.
    groups
        What may fail together: actuator to the names of its joint and links.
    onset
        Earliest and latest time [s].
    """
    group, at = choice(rng, groups), between(rng, *onset)
    way = choice(rng, ("controls", "gain"))
    left = 0.0 if way == "controls" else choice(rng, (0.0, 0.1, 0.2))

    def weaken(model: Any, data: Any) -> None:
        if data.time < at:
            return
        for name in group:
            k = model.actuator(name).id
            if way == "controls" and not model.actuator_biasprm[k].any():
                data.ctrl[k] = 0.0
                continue
            if "whole" not in kept:
                kept["whole"] = model.actuator_gainprm.copy(), model.actuator_biasprm.copy()
            gain, bias = kept["whole"]
            model.actuator_gainprm[k] = left * gain[k]
            model.actuator_biasprm[k] = left * bias[k]

    kept: dict[str, Any] = {}
    places = tuple(dict.fromkeys([*group, *(name for names in group.values() for name in names)]))
    words = f"{' and '.join(group)}: {way} at {left:.0%} from {at:.2f} s"
    return Fault("weak actuator", places, at, on_step=weaken, detail=words)


def derated_motors(motors: Sequence[str], places: Sequence[str], limit: float, at: float) -> Fault:
    """Return motors whose limit falls at a time; it begins where one of them reaches it.

    Parameters
    ----------
    motors
        Which, all where there are none.
    places
        Names that count as right.
    limit
        From then on [N m, N].
    at
        The time [s].
    """

    def chosen(model: Any) -> list[int]:
        return [model.actuator(name).id for name in motors] or list(range(model.nu))

    def derate(model: Any, data: Any) -> None:
        if data.time >= at:
            model.actuator_forcerange[chosen(model)] = [-limit, limit]

    def reached(model: Any, data: Any) -> bool:
        return bool(data.time >= at and np.abs(data.actuator_force[chosen(model)]).max() > 0.999 * limit)

    words = f"limit {limit:.3g} from {at:.2f} s"
    return Fault("saturated actuator", tuple(places), on_step=derate, begins=reached, detail=words)


class NextTouchdown:
    """Whether a geom has stood, lifted and touched down again, all after a time."""

    def __init__(self, geom: str, after: float) -> None:
        self.geom, self.after, self.stood, self.lifted = geom, after, False, False

    def __call__(self, model: Any, data: Any) -> bool:
        """Return whether it has, called once after each step."""
        if data.time < self.after:
            return False
        geom = model.geom(self.geom).id
        touches = any(geom in (c.geom1, c.geom2) for c in data.contact[: data.ncon])
        self.stood |= touches
        self.lifted |= self.stood and not touches
        return self.lifted and touches


def push(
    rng: Rng, bodies: Mapping[str, Sequence[str]], impulse: tuple[float, float], onset: tuple[float, float],
    sideways: float = 1.0,
) -> Fault:  # fmt: skip
    """Return a force on a body for 0.05 to 0.3 s.

    Parameters
    ----------
    rng
        Random numbers.
    bodies
        Body to its other names.
    impulse
        Least and largest [N s].
    onset
        Earliest and latest time [s].
    sideways
        Least share of it across x: zero for any direction.
    """
    body, at = choice(rng, list(bodies)), between(rng, *onset)
    lasts, size = between(rng, 0.05, 0.3), between(rng, *impulse)
    angle = choice(rng, (-1.0, 1.0)) * between(rng, np.arcsin(min(sideways, 1.0)), np.pi / 2)
    force = size / lasts * np.array([np.cos(angle), np.sin(angle), 0.0])

    def press(model: Any, data: Any) -> None:
        data.xfrc_applied[model.body(body).id, :3] = force if at <= data.time < at + lasts else 0.0

    words = f"{size:.3g} N s on {body} from {at:.2f} s for {lasts:.2f} s"
    return Fault("push", (body, *bodies[body]), at, on_step=press, detail=words)


def thrown_ball(
    rng: Rng, target: str, names: Sequence[str], mass: float, speed: tuple[float, float],
    onset: tuple[float, float], where: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Fault:  # fmt: skip
    """Return a ball that is thrown at a body from the side.

    Parameters
    ----------
    rng
        Random numbers.
    target, names
        The body and its other names.
    mass, speed
        Of the ball [kg], least and largest [m/s].
    onset
        Earliest and latest time of the throw [s].
    where
        Place on the body that is aimed at, world axes [m].
    """
    at, fast = between(rng, *onset), between(rng, *speed)
    sign, thrown = choice(rng, (-1.0, 1.0)), list[float]()

    def throw(model: Any, data: Any) -> None:
        if data.time < at or thrown:
            return
        thrown.append(data.time)
        joint = model.joint(int(model.body("ball").jntadr[0]))
        q, v = int(joint.qposadr[0]), int(joint.dofadr[0])
        middle = data.xpos[model.body(target).id] + np.asarray(where)
        data.qpos[q : q + 3] = middle + np.array([0.0, sign * 0.5, 0.0])
        flight = 0.4 / fast
        data.qvel[v : v + 3] = 0.0, -sign * fast, 0.5 * 9.81 * flight

    def hits(model: Any, data: Any) -> bool:
        ours = int(model.body_rootid[model.body(target).id])
        geom = model.geom("ball_skin").id
        for c in data.contact[: data.ncon]:
            other = c.geom2 if c.geom1 == geom else c.geom1 if c.geom2 == geom else -1
            if other >= 0 and int(model.body_rootid[model.geom_bodyid[other]]) == ours:
                return True
        return False

    return Fault(
        "push", (target, *names, "ball", "ball_skin"), None, {"extra": ball(mass)}, on_step=throw,
        begins=hits, detail=f"a ball of {mass:.2g} kg at {fast:.2g} m/s, thrown at {at:.2f} s",
    )  # fmt: skip


def load(
    rng: Rng, body: str, names: Sequence[str], mass: tuple[float, float], onset: tuple[float, float],
    above: tuple[float, float, float] | None,
) -> Fault:  # fmt: skip
    """Return a sack that falls onto a body, or mass that it gains.

    Parameters
    ----------
    rng
        Random numbers.
    body, names
        The body and its other names.
    mass
        Least and largest [kg].
    onset
        Earliest and latest time [s].
    above
        Where the sack is let go over the body, world axes [m]; None for gained mass alone.
    """
    at, size = between(rng, *onset), between(rng, *mass)
    if above is None or rng.random() < 0.5:

        def gain(model: Any, data: Any) -> None:
            if data.time >= at and not kept:
                kept.append(True)
                b = model.body(body).id
                model.body_inertia[b] *= 1.0 + size / model.body_mass[b]
                model.body_mass[b] += size

        kept: list[bool] = []
        words = f"{body} gains {size:.2g} kg at {at:.2f} s"
        return Fault("payload", (body, *names), at, on_step=gain, detail=words)
    let_go: list[bool] = []

    def drop(model: Any, data: Any) -> None:
        if data.time >= at and not let_go:
            let_go.append(True)
            joint = model.joint(int(model.body("sack").jntadr[0]))
            q, v = int(joint.qposadr[0]), int(joint.dofadr[0])
            b = model.body(body).id
            data.qpos[q : q + 3] = data.xpos[b] + np.asarray(above)
            data.qvel[v : v + 6] = 0.0
            data.qvel[v : v + 2] = data.subtree_linvel[b][:2] if data.subtree_linvel.any() else 0.0

    def lies(model: Any, data: Any) -> bool:
        skin, ours = model.geom("sack_skin").id, int(model.body_rootid[model.body(body).id])
        for c in data.contact[: data.ncon]:
            if skin in (c.geom1, c.geom2):
                other = c.geom2 if c.geom1 == skin else c.geom1
                if int(model.body_rootid[model.geom_bodyid[other]]) == ours:
                    return True
        return False

    return Fault(
        "payload", (body, *names, "sack", "sack_skin"), None, {"extra": sack(size)}, on_step=drop,
        begins=lies, detail=f"a sack of {size:.2g} kg let go over {body} at {at:.2f} s",
    )  # fmt: skip


def tilt_bias(rng: Rng, base: int, angle: tuple[float, float], places: Sequence[str]) -> Fault:
    """Return a base whose orientation is measured with an offset, from the start or a time on.

    Parameters
    ----------
    rng
        Random numbers.
    base
        Where its position begins in qpos.
    angle
        Least and largest offset [rad].
    places
        Names of the base.
    """
    size = choice(rng, (-1.0, 1.0)) * between(rng, *angle)
    axis, at = choice(rng, (0, 1)), choice(rng, (None, between(rng, 0.6, 1.2)))

    def turn(time: float, q: Any, v: Any) -> None:
        if at is None or time >= at:
            offset = np.array([np.cos(size / 2), 0.0, 0.0, 0.0])
            offset[1 + axis] = np.sin(size / 2)
            q[base + 3 : base + 7] = product(q[base + 3 : base + 7], offset)

    words = f"{('roll', 'pitch')[axis]} measured {size:+.2f} rad off"
    return Fault("sensor bias", tuple(places), at, on_measured=turn, detail=words)


def product(a: Any, b: Any) -> Any:
    """Return the product of quaternions w, x, y, z."""
    w = a[0] * b[0] - a[1:] @ b[1:]
    return np.concatenate([[w], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def joint_bias(
    rng: Rng, joints: Mapping[str, tuple[int, Sequence[str]]], angle: tuple[float, float]
) -> Fault:
    """Return a joint whose angle is measured with an offset, from the start or a time on.

    Parameters
    ----------
    rng
        Random numbers.
    joints
        Joint to its place in qpos and its other names.
    angle
        Least and largest offset [rad].
    """
    name = choice(rng, list(joints))
    size, at = choice(rng, (-1.0, 1.0)) * between(rng, *angle), choice(rng, (None, between(rng, 0.6, 1.2)))
    where, names = joints[name]

    def turn(time: float, q: Any, v: Any) -> None:
        if at is None or time >= at:
            q[where] += size

    words = f"{name} measured {size:+.2f} rad off"
    return Fault("sensor bias", (name, *names), at, on_measured=turn, detail=words)


def self_contact(model: Any, data: Any) -> bool:
    """Return whether two links of one tree touch."""
    for c in data.contact[: data.ncon]:
        a, b = (int(model.body_rootid[model.geom_bodyid[g]]) for g in (c.geom1, c.geom2))
        if a == b and a > 0:
            return True
    return False


def wrong_frame(rng: Rng) -> Fault:
    """Return a logger that writes forces with the other sign, or turned about an axis."""
    way = choice(rng, ("sign", "normal", "axes", "half"))
    angle = between(rng, 0.6, 1.5)

    def spoil(log: Log) -> Log:
        arrays = {name: np.array(array) for name, array in log.arrays.items()}
        f = arrays["forces"]
        sideways = np.abs(f[..., :2]).sum() > 0.1 * np.abs(f[..., 2]).sum()
        if way == "sign":
            f *= -1.0
        elif way == "axes" or (way == "normal" and not sideways):  # z, x, y instead of x, y, z
            f[...] = np.roll(f, 1, axis=-1)
        else:
            turn = angle if way == "normal" else -angle
            c, s = np.cos(turn), np.sin(turn)
            first, second = (0, 1) if way == "normal" else (0, 2)
            x, y = f[..., first].copy(), f[..., second].copy()
            f[..., first], f[..., second] = c * x - s * y, s * x + c * y
        arrays["forces"] = f
        return Log(arrays, dict(log.facts))

    words = {"sign": "other sign", "normal": "turned about the normal", "axes": "axes in another order"}
    return Fault("wrong contact frame", on_log=spoil, detail=words.get(way, "turned about an axis across"))
