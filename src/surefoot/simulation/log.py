"""Moved: see `surefoot.log`; these names work for one release."""

from surefoot.moved import moved

__getattr__ = moved(__name__, dict.fromkeys(("Log", "read_log"), "surefoot.log"))
