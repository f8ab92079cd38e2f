"""What was recorded: the log of a run, whether it obeyed the laws, what it says of robot and ground.

Begin with `log`: channels over time with units and frames, facts, and the formats of files. `audit`
measures every row against the laws and finds what is wrong with it; it imports neither solvers nor
controllers, so that its judgement is independent of what it judges. `identification` estimates friction,
restitution, bodies and motors from recorded throws and walks. Other wings import what stands in
`__init__.pyi` and nothing else.
"""

from __future__ import annotations

from surefoot.base.faces import face

__getattr__, __dir__ = face(__name__, __file__)
