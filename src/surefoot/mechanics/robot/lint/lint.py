"""The lint of a robot's model: its file read as it stands, and as what loading makes of it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import ModelError, ProblemError, mujoco_line, needs, one_line
from surefoot.mechanics.robot import catalog
from surefoot.mechanics.robot.lint.facts import Fault, ModelFacts
from surefoot.mechanics.robot.lint.finding import Lint
from surefoot.mechanics.robot.lint.mjcf_facts import mjcf_facts
from surefoot.mechanics.robot.lint.rules import apply_rules
from surefoot.mechanics.robot.lint.softness import find_sinking
from surefoot.mechanics.robot.lint.subject import Subject
from surefoot.mechanics.robot.lint.urdf_facts import urdf_facts
from surefoot.mechanics.robot.mjcf import is_mjcf
from surefoot.mechanics.robot.model_size import check_size
from surefoot.mechanics.robot.parser_output import parser_output

WORLDS = {
    "urdf": "Surefoot's worlds, on firm ground (MuJoCo, exact contact and others; --world)",
    "mjcf": "MuJoCo with the file's own contacts and actuators, or --world rigid on exact contact",
}
"""Format of a file to where its robot walks."""


def lint_robot(robot: Any, source: Path, described: bool) -> Lint:
    """Return the lint of a robot that was loaded from a file.

    Parameters
    ----------
    robot
        The Robot.
    source
        Its file.
    described
        Whether its feet's shapes are the catalogue's.
    """
    subject = _read(source)
    subject.robot, subject.described = robot, described
    subject.ends = limb_ends(robot)
    return Lint(robot.name, WORLDS[subject.facts.format], apply_rules(subject))


def lint_file(path: Path, refusal: str) -> Lint:
    """Return the lint of a file whose robot does not load, for the reason given."""
    subject = _read(path)
    subject.refusal = refusal
    return Lint(path.stem, WORLDS[subject.facts.format], apply_rules(subject))


def limb_ends(robot: Any) -> list[str]:
    """Return the names of the frames at the last joint of each limb; of its link's alone if there is none."""
    model = robot.model
    inner = {int(parent) for parent in model.parents}
    ends: dict[int, list[str]] = {}
    for frame in model.frames:
        if frame.type.name in ("BODY", "OP_FRAME") and int(frame.parentJoint) not in inner:
            ends.setdefault(int(frame.parentJoint), []).append(str(frame.name))
    return [name for names in ends.values() for name in names[1:] or names]


def _read(path: Path) -> Subject:
    """Return the subject of a file; one that cannot be read has that as its only fact."""
    try:
        check_size(path)
        return _read_mjcf(path) if is_mjcf(path) else _read_urdf(path)
    except (ModelError, ProblemError) as error:
        return _unreadable(path, one_line(error))


def _unreadable(path: Path, why: str) -> Subject:
    facts = ModelFacts(path, "mjcf" if is_mjcf(path) else "urdf")
    facts.faults.append(Fault("file-unreadable", f"file {path.name}", "cannot be read", why))
    return Subject(facts)


def _read_urdf(path: Path) -> Subject:
    try:
        root = ET.parse(path).getroot()
    except (ET.ParseError, OSError, ValueError, LookupError) as error:
        return _unreadable(path, f"it is not XML: {one_line(error)}")
    if root.tag != "robot":
        return _unreadable(path, f"its first tag is <{root.tag}>, neither <robot> nor <mujoco>")
    folders: list[Path] = [*path.resolve().parents]
    try:
        data = catalog.robots_folder()
        folders += [data, data.parent.parent] if data in path.resolve().parents else []
    except ImportError:
        pass
    return Subject(urdf_facts(path, root, folders))


def _read_mjcf(path: Path) -> Subject:
    """Return the subject of an MJCF file: parsed by MuJoCo, and compiled if it can be."""
    with needs("mujoco", "sim"):
        import mujoco
    compiled = None
    with parser_output():
        try:
            spec = mujoco.MjSpec.from_file(str(path))
        except (ValueError, OSError) as error:
            return _unreadable(path, mujoco_line(error))
        try:
            compiled = spec.compile()
        except (ValueError, OSError):  # what it leaves of the spec does not answer any more
            spec = mujoco.MjSpec.from_file(str(path))
    facts = mjcf_facts(mujoco, path, spec, compiled)
    subject = Subject(facts, compiled=compiled, mujoco=mujoco)
    if compiled is not None and np.isfinite(compiled.body_mass).all():
        with parser_output():
            subject.sinking = find_sinking(mujoco, spec, compiled)
    return subject
