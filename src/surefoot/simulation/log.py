"""Moved, see below; these names work for one release."""

from surefoot.moved import moved

__getattr__ = moved(
    __name__, {"Log": ("surefoot.log", "surefoot.log.Log"), "read_log": ("surefoot.log", "surefoot.read_log")}
)
