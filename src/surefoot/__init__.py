"""Surefoot: the contact layer for legged robots.

Names are loaded on first use, so that importing the package costs nothing. What is public, and where it
lives, stands in `__init__.pyi` and nowhere else.
"""

from __future__ import annotations

from surefoot.base.faces import face

__version__ = "0.1.0"

__getattr__, __dir__ = face(__name__, __file__, "__version__")
