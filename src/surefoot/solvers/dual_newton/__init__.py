"""Newton's method on the dual of a strongly convex program over friction cones, for three forms of it.

`method` is the algorithm, on one page. A form says how the unknowns are kept and the linear algebra is done:

===========  ==========================================================================================
`wrench`     six dual unknowns, as scalars: the force distribution of a microsecond (`work` is its memory)
`dense`      any number of them, one dense matrix: the convex law, and `rows`, limits beside the cones
`horizon`    six dual unknowns per step of a horizon, coupled by the motion: model-predictive control
===========  ==========================================================================================
"""
