"""A robot on the ground: its model, where it touches, whether it can stand there, one step of time.

Begin with `terrain` (height, slope and frames), `stance` (contacts and the map from their forces to one
wrench) and `robot` (on Pinocchio: model, feet, Jacobians). `statics` answers questions to a stance: can it
stand, how much friction does it need, which forces share a wrench. `collision` finds where solids touch;
`dynamics` is one step of time with contact, and its derivative. Other wings import what stands in
`__init__.pyi` and nothing else.
"""

from __future__ import annotations

from surefoot.base.faces import face

__getattr__, __dir__ = face(__name__, __file__)
