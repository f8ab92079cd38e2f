"""Many environments at once: their contacts side by side as the columns of one log, the laws the audit's own.

A law that looks at each contact alone, or at the contacts of one robot, is the same arithmetic for one robot
and for thousands. Forces are divided by each robot's weight first, so that all have one threshold.
"""
