"""Newton's method on the dual of a strongly convex program over friction cones, for three forms of it.

`method` is the algorithm, on one page. A form says how the unknowns are kept and the linear algebra is done;
`distribution_memory` is the memory of `wrench_distribution` and what uses it:

===========  ==========================================================================================
`wrench_distribution` six dual unknowns, as scalars: the force distribution of a microsecond
`dense`      any number of them, one dense matrix: the convex law, and `rows`, limits beside the cones
`horizon`    six dual unknowns per step of a horizon, coupled by the motion: model-predictive control
===========  ==========================================================================================
"""

from surefoot.contact.solvers.dual_newton import distribution_memory as distribution_memory
