"""Moved, see below; these names work for one release."""

from surefoot.deprecation import moved

__getattr__ = moved(__name__, {"Log": "surefoot.log", "read_log": "surefoot.log"})
