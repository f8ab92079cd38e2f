# %% [markdown]
# # A cone
#
# The ground pushes and never pulls, and its push stays inside a cone: Coulomb's law. A force `[x, y, z]`,
# with z along the normal of the ground, is possible where `hypot(x, y) <= mu * z`.

# %%
import numpy as np

import surefoot as sf

cone = sf.FrictionCone(mu=0.6)
forces = np.array([[3.0, 0.0, 10.0], [8.0, 0.0, 10.0], [0.0, 0.0, -1.0]])
for force, inside, margin in zip(forces, cone.contains(forces), cone.margin(forces), strict=True):
    print(force, "inside" if inside else "outside", f"{abs(margin):.2f} N from the border")

# %% [markdown]
# What the ground cannot give has a nearest force that it can: the projection. For the force that pulls it
# is none at all.

# %%
for force, nearest in zip(forces, cone.project(forces), strict=True):
    print(force, "->", nearest.round(2) + 0.0)

# %% [markdown]
# A quadratic program wants planes in place of a round cone. A pyramid inside of it promises nothing that
# the ground cannot give, and gives some of the friction up; one around it does the opposite. Both say how
# much.

# %%
for facets in (4, 8, 16):
    inner, outer = (cone.polyhedral(facets, fit) for fit in ("inner", "outer"))
    lost, gained = 100 * inner.fit_error.radial, 100 * outer.fit_error.radial
    print(f"{facets:2d} sides: inside gives up {lost:4.1f} %, around it overshoots by {gained:4.1f} %")
assert np.all(cone.contains(cone.polyhedral(8).rays, tol=1e-9))

# %% [markdown]
# The rows `A @ force <= 0` go into any solver, `rays` span the same pyramid. The last value of a cell draws
# itself.

# %%
pyramid = cone.polyhedral(facets=8, fit="inner")
print(pyramid.halfspaces.shape, pyramid.rays.shape)
pyramid
