"""The facts of a log: what is said once about a run, and what each must look like."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import IntArray
from surefoot.base.errors import ProblemError, shown


@dataclass(frozen=True)
class Fact:
    """What is said once about a run.

    Attributes
    ----------
    meaning
        One line for people, with the unit.
    shape
        Empty for one value; else numbers and named sizes, see `surefoot.records.log.Channel`.
    text
        Whether it is text and not numbers.
    positive
        Whether it must be positive and finite.
    """

    meaning: str
    shape: tuple[int | str, ...] = ()
    text: bool = False
    positive: bool = False

    def checked(self, name: str, value: Any, sizes: Mapping[str, int]) -> Any:
        """Return a value as text, float, list of texts, or array, or raise `ProblemError`."""
        try:
            array = np.asarray(value, dtype=None if self.text else np.float64)
        except (TypeError, ValueError, OverflowError) as error:
            raise ProblemError(f"the fact {name} must be numbers, got {shown(value)}") from error
        wanted = tuple(sizes.get(s) if isinstance(s, str) else s for s in self.shape)
        fits = array.ndim == len(wanted) and all(
            w in (None, have) and have > 0 for w, have in zip(wanted, array.shape, strict=True)
        )
        if self.text and (array.dtype.kind != "U" and array.size > 0):
            raise ProblemError(f"the fact {name} must be text, got {shown(value)}")
        if not fits:
            shape = f"({', '.join(map(str, self.shape))})"
            raise ProblemError(f"the fact {name} must have shape {shape}, {sizes}, got {array.shape}")
        if self.positive and not ((array > 0.0) & np.isfinite(array)).all():
            raise ProblemError(f"the fact {name} must be positive and finite, got {shown(value)}")
        return array if self.shape and not self.text else array.tolist()


FACTS: dict[str, Fact] = {
    "robot": Fact("name", text=True),
    "kind": Fact("what it did: stand, walk, ...", text=True),
    "world": Fact("what simulated it", text=True),
    "sinking": Fact("how deep the world's own contact lets a loaded foot sink [m]"),
    "step_depth": Fact("how deep a step may find the fastest contact, which it takes back without speed [m]"),
    "sinking_at_most": Fact("how deep all kinetic energy there was would drive a single contact [m]"),
    "creep": Fact("how fast it lets a sticking foot creep [m/s]"),
    "stopping": Fact("on which way its friction stops a foot that lands sliding [m]"),
    "settling": Fact("how long after a hard touchdown its soft contacts swing [s]"),
    "recoil": Fact("how fast its loaded contacts come out of the ground, over their greatest depth [1/s]"),
    "creep_slope": Fact("how fast a sticking foot creeps, over its tangential force in shares of m g [m/s]"),
    "unsolved_steps": Fact("steps whose contacts the world was to solve exactly, and solved softly"),
    "terrain": Fact("the ground, as read_terrain reads it", text=True),
    "mass": Fact("of all that moves: the robot with what it carries [kg]", positive=True),
    "payload": Fact("point mass on the base, part of `mass` [kg]"),
    "payload_position": Fact("where it is in base axes, the origin by default [m]", (3,)),
    "mass_controller": Fact("of the robot, as the controller believes [kg]", positive=True),
    "joint_stiffness": Fact("of the joints' own position control, 0 for none [N m/rad]", ("joints",)),
    "joint_damping": Fact("of the joints' own position control [N m s/rad]", ("joints",)),
    "dt": Fact("length of a step [s]", positive=True),
    "feet": Fact("names of the feet", ("n",), text=True),
    "joints": Fact("names of the joints", ("joints",), text=True),
    "contact_foot": Fact("index of the foot of every contact point", ("p",)),
    "contact_centres": Fact("contact points in their feet's frames [m]", ("p", 3)),
    "sole_corners": Fact("of flat feet whose moments are in the log, in contact frames [m]", ("corners", 2)),
    "sole_contact": Fact("contact point that each of them belongs to", ("corners",)),
    "effort_limits": Fact("largest joint torques [N m]", ("joints",)),
    "speed_limits": Fact("largest joint speeds, of motors those without load [rad/s]", ("joints",)),
    "actuators": Fact("what gives the torques; a log without it has ideal ones", text=True),
    "motor_knee": Fact("share of the largest speed up to which motors give their driving torque"),
    "motor_driving": Fact("that torque over the largest"),
    "armature": Fact("inertia of the rotors as the joints feel it [kg m²]", ("joints",)),
    "viscous_friction": Fact("of the joints [N m s]", ("joints",)),
    "dry_friction": Fact("of the joints [N m]", ("joints",)),
    "link_touches": Fact(
        "what touched beside feet on the ground, a line for each pair", ("touches",), text=True
    ),
    "duration": Fact("of the run as planned [s]"),
    "resumed_at": Fact("time of the kept state from which the run went on [s]"),
    "outcome": Fact("how the run ended, see Ending", text=True),
    "error": Fact("what ended the run or its recording", text=True),
    "wall_time": Fact("real time of the run [s]"),
    "cpu_time": Fact("of its thread, less than real time where the machine was busy [s]"),
    "normal_min": Fact("least normal force that the controller asks of a foot [N]"),
    "normal_max": Fact("largest one [N]"),
    "mu_controller": Fact("friction that the controller believes in"),
    "gait": Fact("name of the gait", text=True),
    "ahead": Fact("where the robot walks ahead, from the x axis of its base, zero by default [rad]"),
    "cone": Fact("of the world's friction: elliptic (round) or pyramidal", text=True),
    "moment_friction": Fact("of contact moments: rolling, rolling, torsional [m]", ("p", 3)),
    "contact_margin": Fact("gap from which the world's contacts push [m]", ("p",)),
    "contact_damping": Fact("rate at which the world's soft friction brakes [1/s]", ("p",)),
    "critically_damped": Fact("1 for contacts that by the world's law do not rebound", ("p",)),
    "velocities": Fact("mean: those of contacts are means while the row's force acts", text=True),
    "gravity": Fact("in world axes, 9.81 downwards by default [m/s²]", (3,)),
    "free_wrenches": Fact("wrenches against which nothing holds the robot's root", ("k", 6)),
    "outside": Fact("what else the model puts on the whole robot, a line each", ("lines",), text=True),
    "contact_with": Fact("what each contact point touches", ("p",), text=True),
    "contact_body": Fact("link of the robot of each contact point", ("p",), text=True),
    "contact_is_foot": Fact("1 where that link is a foot by the model: an end of a limb", ("p",)),
    "contact_other_moves": Fact("1 where what it touches can move", ("p",)),
    "model_bodies": Fact("links of the robot", ("bodies",), text=True),
    "model_parents": Fact("place of each link's parent, -1 for the world", ("bodies",)),
    "model_masses": Fact("of the links [kg]", ("bodies",)),
    "model_inertias": Fact("of the links about their principal axes [kg m²]", ("bodies", 3)),
    "model_centres": Fact("centres of mass in the links' axes [m]", ("bodies", 3)),
    "model_inertia_axes": Fact("principal axes in the links', quaternion w, x, y, z", ("bodies", 4)),
    "model_positions": Fact("of the links in their parents' axes [m]", ("bodies", 3)),
    "model_orientations": Fact("of the links there, quaternion w, x, y, z", ("bodies", 4)),
    "model_joint_kinds": Fact("free, hinge, slide or other, the root's first", ("all_joints",), text=True),
    "model_joint_bodies": Fact("place of the link that each joint moves", ("joints",)),
    "model_joint_axes": Fact("in that link's axes", ("joints", 3)),
    "model_joint_places": Fact("in that link's axes [m]", ("joints", 3)),
    "model_joint_ranges": Fact("stops of the joints [rad, m], infinite without", ("joints", 2)),
    "model_torque_limits": Fact("largest torques of the model's actuators [N m, N]", ("joints",)),
    "model_geoms": Fact("shapes of the robot's links", ("geoms",), text=True),
    "model_geom_bodies": Fact("place of each shape's link", ("geoms",)),
    "model_geom_types": Fact("MuJoCo's number of each shape's kind", ("geoms",)),
    "model_geom_sizes": Fact("of the shapes, as MuJoCo has them [m]", ("geoms", 3)),
    "model_geom_positions": Fact("of the shapes in their links' axes [m]", ("geoms", 3)),
    "model_geom_orientations": Fact("of the shapes there, quaternion w, x, y, z", ("geoms", 4)),
    "model_hull_corners": Fact("of the convex hulls of meshes, in their shapes' axes [m]", ("corners", 3)),
    "model_hull_geoms": Fact("place of the shape that each of these is a corner of", ("corners",)),
    "model_actuators": Fact("names of the model's actuators", ("actuators",), text=True),
    "episode_rows": Fact("first row of every episode, where the state was reset", ("episodes",)),
    "unseen_steps": Fact("places in which time moved without a step that the recorder saw"),
    "change_row": Fact("first row after each change of the model", ("changes",)),
    "change_time": Fact("when the loop changed its model [s]", ("changes",)),
    "change_kind": Fact("what of it: mass, gain, torque limit, friction", ("changes",), text=True),
    "change_name": Fact("whose", ("changes",), text=True),
    "change_factor": Fact("the new number over the old", ("changes",)),
    "source": Fact("file or program that it comes from", text=True),
    "source_version": Fact("which version of it, where files of its own are of one version only", text=True),
    "start": Fact("stamp of its first row in the clock of its source [s]"),
    "mapping": Fact("how its channels were made from the source, YAML", text=True),
    "doubts": Fact("what is not plausible in it, see Log.doubts", ("doubts",), text=True),
    "computed": Fact("channels that its source did not have, and from what", ("lines",), text=True),
    "task": Fact("what a plan does", text=True),
    "method": Fact("which method found it", text=True),
    "status": Fact("whether it is solved, see `surefoot.Status`", text=True),
    "goal": Fact("what was asked for and what is reached", text=True),
    "cost": Fact("of the method's own objective"),
    "law_residual": Fact("largest velocity error of its contact problems"),
    "iterations": Fact("of the optimiser"),
    "search_time": Fact("wall time of the search [s]"),
    "optimum_variables": Fact("of the program whose optimum a plan is", ("variables",)),
    "optimum_bounds": Fact("multipliers of their bounds", ("variables",)),
    "optimum_rows": Fact("multipliers of the program's rows", ("rows",)),
    "end_q": Fact("configuration at the end of the last row", ("nq",)),
    "end_v": Fact("velocity there", ("nv",)),
    "granted_share": Fact("least share of a velocity asked for that a walk granted"),
    "notes": Fact(
        "how a file's feet were read, and what the controller changed in its command", ("lines",), text=True
    ),
}
"""Facts that Surefoot writes and reads by name; a log may hold others."""


def facts_of_rows(facts: Mapping[str, Any], episode: int, first: int, end: int, rows: int) -> dict[str, Any]:
    """Return the facts of one episode of a log.

    Parameters
    ----------
    facts
        Of the whole log.
    episode
        Number of the episode, from 1 on.
    first, end
        Its first row, and that of the next.
    rows
        Of the whole log: only its last episode has its ending.
    """
    out = {name: fact for name, fact in facts.items() if name != "episode_rows"}
    changed = np.atleast_1d(facts.get("change_row", []))
    mine = (changed >= first) & (changed < end)
    for name in ("change_time", "change_kind", "change_name", "change_factor", "change_row"):
        if name in out and not mine.all():
            kept = [value for value, on in zip(np.atleast_1d(out.pop(name)), mine, strict=True) if on]
            out |= {name: kept} if kept else {}
    doubts = out.get("doubts", ())
    lines = [doubts] if isinstance(doubts, str) else list(map(str, doubts))
    title = re.compile(r"episode (\d+): ")
    marks = [(title.match(line), line) for line in lines]
    out["doubts"] = [
        line if mark is None else line[mark.end() :]
        for mark, line in marks
        if mark is None or int(mark[1]) == episode
    ]
    if end < rows:
        out.pop("error", None)
        out["outcome"] = "done"
    return out


def facts_of_selection(facts: Mapping[str, Any], rows: IntArray) -> dict[str, Any]:
    """Return facts whose row numbers are those in a selection, (k,) numbers of rows in their order."""
    out = dict(facts)
    starts = np.atleast_1d(out.pop("episode_rows")).astype(np.int64)
    episode = np.searchsorted(starts, rows, side="right")
    begins = np.flatnonzero(np.diff(episode, prepend=-1))
    if len(begins) > 1:
        out["episode_rows"] = begins
    if "change_row" in out:
        out["change_row"] = np.searchsorted(rows, np.atleast_1d(out["change_row"]))
    return out
