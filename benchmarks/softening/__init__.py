"""Ways to soften complementarity on five small problems: who finds the motion, at what cost, and why."""
