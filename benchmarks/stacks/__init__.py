"""One world, one set of tasks, several walking stacks: what each survives, how well, and at what cost.

A stack is whatever turns a robot's state into joint torques each millisecond (`benchmarks.stacks.stack`).
Surefoot's own runs in this process; others run in a process of their own, from a checkout that the user made,
with an interpreter that has what they need (`benchmarks.stacks.peer`). Nothing of theirs is kept here.
"""
