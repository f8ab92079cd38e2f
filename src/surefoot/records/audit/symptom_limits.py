"""Limits of the symptoms of an audit."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting
from surefoot.records.audit.limit_sources import RIVALS, VARIED


@dataclass(frozen=True)
class FitLimits(Settings):
    """Limits of models of how a force may differ from the true one."""

    spread: float = setting(
        0.02,
        "-",
        "scatter of directions (one less their mean resultant) that is more than one place",
        low=0.0,
        tuned=VARIED + "6.667e-06 to 0.06",
    )
    loaded: float = setting(
        0.005,
        "m g",
        "normal force below which the use of friction is noise",
        low=0.0,
        tuned=VARIED + "0.005 to 0.15",
    )
    outside: float = setting(
        1.01, "-", "use of the cone from which a force is outside it", low=0.0, tuned=VARIED + "1 to 1.03"
    )
    corner: float = setting(
        1.01,
        "-",
        "reach over a pyramid's corner up to which forces may fill it",
        low=0.0,
        tuned=VARIED + "1.003 to 31",
    )
    edge_high: float = setting(
        1.005,
        "-",
        "distance of forces from the axis, over that of the edge, up to which they are on it",
        low=0.0,
        tuned=VARIED + "1.005 to 1.015",
    )
    edge_low: float = setting(
        0.98,
        "-",
        "distance of forces from the axis, over that of the edge, from which they are on it",
        low=0.0,
        tuned=VARIED + "0.98 to 0.9933",
    )
    phase_step: float = setting(
        0.25,
        "deg",
        "step between the turns of a pyramid that are tried",
        low=1e-3,
        tuned=VARIED + "0.001 to 0.75",
    )
    least_points: int = setting(
        3, "-", "forces outside the cone without which no pyramid is fitted", low=1, tuned=VARIED + "1 to 7"
    )


@dataclass(frozen=True)
class BodyLimits(Settings):
    """Limits of symptoms of the robot as a whole."""

    held: float = setting(
        0.3, "m g", "unexplained force from which a body is held up", low=0.0, tuned=VARIED + "0.01 to 0.3"
    )
    touching: float = setting(
        0.001,
        "m",
        "gap up to which the lowest foot touches the ground",
        low=0.0,
        tuned=VARIED + "0.0003333 to 0.03",
    )
    mass_time: float = setting(
        0.2,
        "s",
        "shortest time of a wrong motion that shows another mass",
        low=0.0,
        tuned=VARIED + "0.006667 to 0.6",
    )
    mass_upright: float = setting(
        0.9,
        "-",
        "share of the mean missing force that is vertical where the mass is wrong",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.9 to 0.9967",
    )
    mass_spread: float = setting(
        0.6,
        "-",
        "scatter of the missing force over its mean where the mass is wrong",
        low=0.0,
        tuned=VARIED + "0.2 to 18",
    )
    held_rows: int = setting(
        5, "-", "repeated rows from which a state is held", low=1, tuned=VARIED + "4 to 9"
    )
    teleport_share: float = setting(
        0.8,
        "-",
        "share of the squared slips of positions that two rows have in a jump",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.02667 to 0.8",
    )
    jump_force: float = setting(
        2.0,
        "m g",
        "unexplained force of one row that is a jump of the velocity",
        low=0.0,
        tuned=VARIED + "0.06667 to 6",
    )
    jump_share: float = setting(
        0.9,
        "-",
        "share of the squared unexplained force that two rows have in a jump",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.7 to 1",
    )
    jump_logged: float = setting(
        0.5,
        "-",
        "part of that force by which a logged force may change, which is a blow otherwise",
        low=0.0,
        tuned=VARIED + "0.01667 to 0.5",
    )


@dataclass(frozen=True)
class ContactLimits(Settings):
    """Limits of symptoms of contact itself."""

    starts_deepest: float = setting(
        0.99,
        "-",
        "depth of the first row over the deepest in a log that starts in the ground",
        low=0.0,
        tuned=VARIED + "0.7 to 0.9967",
    )
    starts_left: float = setting(
        0.5, "-", "depth of the last row over the deepest in such a log", low=0.0, tuned=VARIED + "0.5 to 0.5"
    )
    excess: float = setting(
        1.001,
        "-",
        "friction needed over the ground's from which it is too much",
        low=0.0,
        tuned=VARIED + "1 to 1.003",
    )
    air_gap: float = setting(
        0.001, "m", "gap from which a contact is in the air", low=0.0, tuned=VARIED + "3.333e-07 to 0.003"
    )
    air_normal: float = setting(
        0.005,
        "m g",
        "normal force up to which a contact in the air carries nothing",
        low=0.0,
        tuned=VARIED + "0.001667 to 0.15",
    )
    air_share: float = setting(
        0.5,
        "-",
        "share of the rows with friction in the air",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.1667 to 0.5",
    )
    push_off_depth: float = setting(
        0.001,
        "m",
        "depth from which a foot is thrown out of the ground",
        low=0.0,
        tuned=VARIED + "3.333e-05 to 0.003",
    )
    push_off_work: float = setting(
        0.0002, "m g m", "work that such a foot wins", low=0.0, tuned=VARIED + "6.667e-08 to 0.006"
    )
    push_off_speed: float = setting(
        0.05, "m/s", "speed at which such a foot leaves", low=0.0, tuned=VARIED + "0.001667 to 0.15"
    )
    skating_free: float = setting(
        0.1,
        "-",
        "normal force over its largest, below which a foot that chatters is free",
        low=0.0,
        tuned=VARIED + "3.333e-05 to 0.3",
    )
    skating_way: float = setting(
        0.002, "m", "way of a foot that skates", low=0.0, tuned=VARIED + "6.667e-05 to 0.006"
    )
    skating_share: float = setting(
        0.3, "-", "share of that way that is gone while free", low=0.0, high=1.0, tuned=VARIED + "0.01 to 0.3"
    )
    blow_rows: int = setting(6, "-", "rows up to which a blow is one step's", low=1, tuned=VARIED + "2 to 26")


@dataclass(frozen=True)
class MeasuredLimits(Settings):
    """Limits of symptoms of what was measured."""

    at_stop: float = setting(
        0.01,
        "rad, m",
        "distance from the end of a joint's range at which it is at its stop",
        low=0.0,
        tuned=RIVALS + "0.003333 to 0.01",
    )
    stop_share: float = setting(
        0.3,
        "-",
        "share of the rows in which a joint is at its stop",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0.3 to 0.3",
    )
    flat: float = setting(
        0.01,
        "m g",
        "standard deviation of a force that no scale makes constant",
        low=0.0,
        tuned=VARIED + "0.0003333 to 0.03",
    )
    explained: float = setting(
        0.9,
        "-",
        "share of the mismatch that a mirror, the other sign, a factor, a constant or another foot's force "
        "must explain to be named; and of other feet's mismatch a turn",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0 to 0.9667",
    )
    turn: float = setting(
        3.0, "deg", "turn of forces that is a wrong frame", low=0.0, tuned=VARIED + "0.1 to 9"
    )
    turn_share: float = setting(
        0.8,
        "-",
        "share of the mismatch that a turn explains",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.02667 to 0.8",
    )
    turn_amiss: float = setting(
        0.01,
        "m g",
        "mismatch of other feet below which they do not speak for a turn",
        low=0.0,
        tuned=VARIED + "0.0003333 to 0.03",
    )
    reversed_pull: float = setting(
        0.05,
        "m g",
        "mean pull at all contacts together from which forces are reversed where joint torques are not known",
        low=0.0,
        tuned=VARIED + "1.667e-05 to 0.15",
    )
    scale_least: float = setting(
        0.02, "-", "least factor of forces that is a scale", low=0.0, tuned=VARIED + "0.0006667 to 0.06"
    )
    scale_change: float = setting(
        0.02, "-", "least difference of that factor from one", low=0.0, tuned=VARIED + "0.0006667 to 0.06"
    )
    bias_flies: float = setting(
        0.1,
        "-",
        "share of the rows in the air from which a constant is told from a factor",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0.03333 to 1",
    )
    delay_most: float = setting(
        0.08, "s", "largest shift in time that is tried", low=0.0, tuned=VARIED + "0.02667 to 2.4"
    )
    delay_share: float = setting(
        0.8,
        "-",
        "share of the mismatch that a shift explains",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.02667 to 0.8",
    )
    delay_rows: int = setting(3, "-", "least shift", low=1, tuned=VARIED + "1 to 7")
    dropout_load: float = setting(
        0.04, "m g", "true force from which a foot carries", low=0.0, tuned=VARIED + "0.001333 to 0.12"
    )
    dropout_share: float = setting(
        0.7,
        "-",
        "share of the rows in which a foot carries and reports nothing",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.7 to 0.7",
    )
    frozen_share: float = setting(
        0.7,
        "-",
        "share of the rows in which no digit changes",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.7 to 0.7",
    )
    frozen_gap: float = setting(
        0.001,
        "m",
        "median gap up to which a frozen force is that of a foot on the ground",
        low=0.0,
        tuned=VARIED + "3.333e-07 to 0.03",
    )
    clipped_share: float = setting(
        0.3, "-", "share of the rows at the largest value", low=0.0, high=1.0, tuned=VARIED + "0.01 to 0.9"
    )
    clipped_below: float = setting(
        0.01,
        "m g",
        "true force below a clipped one that rounding and smoothing allow",
        low=0.0,
        tuned=RIVALS + "3.333e-06 to 0.03",
    )
    phantom_gap: float = setting(
        0.001, "m", "gap from which a foot is in the air", low=0.0, tuned=VARIED + "3.333e-07 to 0.03"
    )
    unloaded: float = setting(
        0.03, "m g", "true force below which a leg carries nothing", low=0.0, tuned=RIVALS + "0.001 to 0.09"
    )
    phantom_air: float = setting(
        0.5,
        "-",
        "share of the rows in which a foot is in the air and its leg carries nothing",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0.5 to 0.5",
    )
    dead_share: float = setting(
        0.9,
        "-",
        "share of the rows in which a dead joint has no torque",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0.7 to 0.9",
    )
    torques_body: float = setting(
        0.02,
        "m g",
        "unexplained force on the body below which the forces explain its motion",
        low=0.0,
        tuned=VARIED + "0.0006667 to 0.06",
    )
