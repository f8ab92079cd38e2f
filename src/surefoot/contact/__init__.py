"""Which contact forces are possible, and the solvers for them; nothing here knows a robot.

Begin with `cones` (one convex set a file) and `problem` (u = G λ + g as plain data, its residuals and its
proofs); `sets` are contacts of other kinds than points, `laws` what relates force, gap and velocity.
`solvers` find forces and never judge them, `batch` takes many problems at once, `derivative` is that of a
solution. `files` reads and writes problems, `translation` puts contact parameters of one simulator into
another's words. Other wings import what stands in `__init__.pyi` and nothing else.
"""

from __future__ import annotations

from surefoot.base.faces import face

__getattr__, __dir__ = face(__name__, __file__)
