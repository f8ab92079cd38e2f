"""Lets this room's files import each other by name, as `python tests/adversary/hunt.py` does."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
