"""Pinocchio's model of a URDF file, and what its parser complains about."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from surefoot.base.errors import ModelError
from surefoot.mechanics.robot.parser_output import parser_output


def parse_urdf(path: Path, root: Sequence[Any], text: str = "") -> Any:
    """Return the model of a URDF file; what its parser complains about is an error, never an output.

    The parser goes on without an inertia that it cannot read, so complaints count even if there is a model.
    `text` is read instead of what the file has, if there is any.
    """
    import pinocchio

    model, why = None, ""
    with parser_output() as said:
        try:
            read = pinocchio.buildModelFromXML if text else pinocchio.buildModelFromUrdf
            model = read(text or str(path), *root)
        except (ValueError, RuntimeError) as error:
            why = str(error)
    errors = [line.removeprefix("Error:").strip() for line in said if line.startswith("Error:")]
    if model is None or errors:
        reason = "; ".join(dict.fromkeys(errors)) or why
        raise ModelError(f"{path} is not a URDF that Pinocchio can read: {reason}")
    mass = float(pinocchio.computeTotalMass(model))
    if root and not 0.0 < mass < math.inf:
        raise ModelError(f"{path} describes no robot that can move: its total mass is {mass:g} kg")
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        span = slice(joint.idx_q, joint.idx_q + joint.nq)
        low, high = model.lowerPositionLimit[span], model.upperPositionLimit[span]
        if (low > high).any():
            raise ModelError(f"{path}: joint {name} has its lower limit above its upper one, {low} > {high}")
    return model
