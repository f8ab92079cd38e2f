"""State in, command out: controllers that stand and walk, planners, learned policies, a real robot's loop.

Begin with `state` (what is known of a robot at one step) and `control` (what a controller is, model-
predictive and whole-body control); `gaits` say which feet are on the ground when, `estimation` and `ground`
find out where the robot and the ground are. `standing` and `walking` are the controllers, `planning` finds
motions through contact, `policy` runs networks, `drive` is the loop between a controller and motors. Other
wings import what stands in `__init__.pyi` and nothing else.
"""

from __future__ import annotations

from surefoot.base.faces import face

__getattr__, __dir__ = face(__name__, __file__)
