"""Frames of a model by name, where links and joints may have the same one."""

from __future__ import annotations

from typing import Any


def frame_index(model: Any, name: str) -> int:
    """Return Pinocchio's index of a frame; of a link and a joint of one name, the link's.

    Raises
    ------
    KeyError
        If there is no such frame.
    """
    import pinocchio

    kinds = pinocchio.FrameType
    for kind in (kinds.BODY, kinds.OP_FRAME, kinds.FIXED_JOINT, kinds.JOINT, kinds.SENSOR):
        if model.existFrame(name, kind):
            return int(model.getFrameId(name, kind))
    raise KeyError(name)
