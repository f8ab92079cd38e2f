"""Small dense algebra inside kernels, each piece once: a call into LAPACK would take longer than the work.

Every public kernel here is tested against NumPy. Sizes decide which file serves:

=================  =====================================================================================
`six`              vectors and symmetric matrices of six, as scalars in registers
`cholesky`         definite matrices of up to some dozens of unknowns, in the lower triangle
`elimination`      systems of a few dozen unknowns, solved once
`orthogonal`       Gram-Schmidt and reflections: rows to orthonormal form, their rank
`projection`       the nearest point of a truncated friction cone, and its generalised Jacobian
`points`           from twists to velocities of points, contact Jacobians
`rotations`        the rotation vector between two frames
`vectors`          cross and dot products
`line_search`      where a derivative along a step has all but vanished
=================  =====================================================================================
"""
