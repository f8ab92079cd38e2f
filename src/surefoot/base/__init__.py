"""Checks, errors, text, compiled kernels and small algebra: no physics, and no wing below it.

Read `errors` for what is raised and `arrays` for how numbers from outside are checked; `spatial` is the one
home of conventions of sign and order, `kernels` the decorator of compiled functions (how they are compiled
and kept on disk is `compilation`'s), `numerics` the dense algebra that kernels share. Other wings import
these modules themselves: this wing has no list of names.
"""
