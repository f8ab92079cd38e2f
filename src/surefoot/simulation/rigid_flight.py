"""Moved to `surefoot.stepping.flight`."""

from surefoot.deprecation import moved

_NAMES = ("Control", "Flight", "Shape", "fly", "follow_shape")
__getattr__ = moved(__name__, dict.fromkeys(_NAMES, "surefoot.stepping.flight"))
