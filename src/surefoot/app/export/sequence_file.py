"""Contact sequences as JSON, version 1; `contact_sequence.schema.json` beside this file is its schema."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.app.export.sequence import ContactSequence, SequencePhase
from surefoot.base.arrays import FloatArray, finite_array, of_kind
from surefoot.base.errors import ProblemError, located, shown, writing
from surefoot.base.text_files import path_of, read_json
from surefoot.contact import Sole
from surefoot.mechanics.stance import Contact, PointContact, SoleContact, Stance

if TYPE_CHECKING:
    from surefoot.app.export.sequence_keys import Contact as ContactKeys
    from surefoot.app.export.sequence_keys import Friction, HalfSpaces, Patch, Phase

FORMAT, VERSION = "surefoot.contact-sequence", 1
SCHEMA = Path(__file__).with_name("contact_sequence.schema.json")
"""The JSON schema of the file."""
ORTHONORMAL = 1e-6
"""How far a rotation may be from one."""
SAME = 1e-9
"""How far half-spaces in a file may be from those of their contact, relative to the largest entry."""


def sequence_to_dict(sequence: ContactSequence) -> dict[str, Any]:
    """Return a sequence as what JSON holds; floats are written so that they read back the same."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "robot": sequence.robot,
        "mass": sequence.mass,
        "frames": list(sequence.frames),
        "friction": {"facets": sequence.facets, "fit": sequence.fit},
        "phases": [_phase_entry(sequence, k) for k in range(len(sequence.phases))],
    }


def sequence_from_dict(content: Any) -> ContactSequence:
    """Return the sequence that parsed JSON stands for.

    Raises
    ------
    ProblemError
        Naming the entry at fault.
    """
    from surefoot.app.export.sequence_keys import Sequence
    from surefoot.base.file_models import read_as

    if isinstance(content, dict) and {"format", "version"} <= content.keys():
        found = content["format"], content["version"]
        if found != (FORMAT, VERSION) or isinstance(found[1], bool):  # True == 1
            told = f"{shown(found[0])} version {shown(found[1])}"
            raise ProblemError(f"a contact sequence has the format {FORMAT!r} version {VERSION}, got {told}")
    top = read_as(Sequence, content)
    friction = top["friction"]
    phases = [_phase(f"phases[{k}]", given, friction) for k, given in enumerate(top["phases"])]
    who = top.get("robot", ""), top.get("mass", 0.0)
    return ContactSequence(phases, top["frames"], *who, friction["facets"], friction["fit"])


def write_sequence(sequence: ContactSequence, path: Path | str) -> Path:
    """Write a sequence to a new JSON file and return its path.

    Raises
    ------
    ProblemError
        If the file exists already: nothing is overwritten.
    WriteError
        If it cannot be written.
    """
    of_kind("sequence", sequence, ContactSequence)
    target = path_of(path)
    text = json.dumps(sequence_to_dict(sequence), indent=1, allow_nan=False) + "\n"
    if target.exists():
        raise ProblemError(f"{target} exists already")
    with writing(target), target.open("x", encoding="utf-8") as stream:
        stream.write(text)
    return target


def read_sequence(path: Path | str) -> ContactSequence:
    """Read a sequence.

    Raises
    ------
    ProblemError
        If the file cannot be read, is no JSON, or says something that no sequence can be; naming the entry.
    """
    source = path_of(path)
    content = read_json(source)
    with located(source):
        return sequence_from_dict(content)


def _phase_entry(sequence: ContactSequence, number: int) -> dict[str, Any]:
    """Return a phase with its contacts, cones and forces."""
    phase, at, contacts = sequence.phases[number], 0, []
    for contact in phase.stance:
        rows = Stance([contact]).halfspaces(sequence.facets, sequence.fit)
        force = None if phase.forces is None else phase.forces[at : at + contact.dim].tolist()
        at += contact.dim
        patch: dict[str, Any] | None = None
        if isinstance(contact, SoleContact):
            sole = contact.sole
            patch = {"length": sole.length, "width": sole.width}
            if sole.length is None:
                patch = {"corners": sole.corners.tolist()}
        contacts.append(
            {
                "frame": contact.name,
                "position": contact.position.tolist(),
                "rotation": contact.rotation_world_contact.tolist(),
                "mu": contact.mu,
                "normal_min": contact.normal_min,
                "normal_max": contact.normal_max if math.isfinite(contact.normal_max) else None,
                "patch": patch,
                "halfspaces": {"A": rows.A.tolist(), "b": rows.b.tolist()},
                "force": force,
            }
        )
    return {"duration": phase.duration, "contacts": contacts}


def _phase(where: str, given: Phase, friction: Friction) -> SequencePhase:
    """Return a phase; errors name the entry."""
    found = [_contact(f"{where}.contacts[{k}]", one, friction) for k, one in enumerate(given["contacts"])]
    stated = [force for _, force in found if force is not None]
    if stated and len(stated) < len(found):
        raise ProblemError(f"{where}: either all contacts have a force or none has one")
    with located(where):
        stance = Stance([contact for contact, _ in found])
        return SequencePhase(given["duration"], stance, np.concatenate(stated) if stated else None)


def _contact(where: str, given: ContactKeys, friction: Friction) -> tuple[Contact, FloatArray | None]:
    """Return a contact and the force that it is meant to carry."""
    with located(where):
        turn = finite_array("rotation", given["rotation"], (3, 3))
        large = np.abs(turn).max() > 1.0 + ORTHONORMAL  # whose products might overflow
        if large or np.abs(turn.T @ turn - np.eye(3)).max() > ORTHONORMAL or np.linalg.det(turn) < 0.0:
            raise ProblemError("rotation must be a rotation: orthonormal, right-handed")
        high = given.get("normal_max")
        options: dict[str, Any] = {
            "position": given["position"], "normal": (0.0, 0.0, 1.0),
            "name": given["frame"], "normal_min": given.get("normal_min", 0.0),
            "normal_max": math.inf if high is None else high,
        }  # fmt: skip
        patch = given.get("patch")
        contact: Contact
        if patch is None:
            contact = PointContact(mu=given["mu"], **options)
        else:
            contact = SoleContact(sole=_sole(patch, given["mu"]), **options)
        contact.rotation_world_contact = turn  # as written, to the last bit
        _check_rows(contact, given.get("halfspaces"), friction)
        force = given.get("force")
        return contact, None if force is None else finite_array("force", force, (contact.dim,))


def _sole(patch: Patch, mu: float) -> Sole:
    """Return the sole of a patch: its length and width, or its corners."""
    told = sorted(patch)
    if told == ["corners"]:
        return Sole.of_corners(finite_array("patch.corners", patch["corners"], (None, 2)), mu)
    if told != ["length", "width"]:
        raise ProblemError(f"a patch has length and width, or corners; got {', '.join(told) or 'neither'}")
    return Sole(patch["length"], patch["width"], mu)


def _check_rows(contact: Contact, given: HalfSpaces | None, friction: Friction) -> None:
    """Refuse half-spaces that are not those of the contact: a file that says two things says nothing."""
    if given is None:
        return
    rows = Stance([contact]).halfspaces(friction["facets"], friction["fit"])
    A = finite_array("halfspaces.A", given["A"], (None, contact.dim))
    b = finite_array("halfspaces.b", given["b"], (None,))
    for name, have, own in (("A", A, rows.A), ("b", b, rows.b)):
        if have.shape != own.shape or np.abs(have - own).max(initial=0.0) > SAME * (1.0 + np.abs(own).max()):
            raise ProblemError(f"halfspaces.{name} is not that of its mu, bounds, facets and fit")
