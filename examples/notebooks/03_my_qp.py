# %% [markdown]
# # My QP
#
# A balance controller shares a wrench among the feet: least squares over forces within friction.
# `Stance.halfspaces` has the rows for any solver of quadratic programs, all numbers finite: friction
# pyramids, bounds, and rows for a foot in the air.

# %%
import numpy as np
from scipy.optimize import minimize

import surefoot as sf

robot = sf.load_robot("go2")
q = sf.place(robot, sf.FlatTerrain())
stance = robot.stance(q, mu=0.6, normal_min=5.0)
com, weight = robot.com(q), robot.mass * 9.81
rows = stance.halfspaces(facets=8)
print("rows of the inequalities:", rows.A.shape)

# %% [markdown]
# Hold the weight and push forward with 20 N. SciPy's solver is here because it comes with the package;
# DAQP, OSQP, PIQP and others take the same `P`, `c`, `rows.A` and `rows.b`.

# %%
wanted = np.array([20.0, 0.0, weight, 0.0, 0.0, 0.0])
G = stance.grasp_map(com)
P, c = G.T @ G + 1e-4 * np.eye(12), -G.T @ wanted
friction = {"type": "ineq", "fun": lambda f: rows.b - rows.A @ f, "jac": lambda f: -rows.A}
found = minimize(
    lambda f: 0.5 * f @ P @ f + c @ f, np.tile([0.0, 0.0, weight / 4], 4), jac=lambda f: P @ f + c,
    constraints=friction, method="SLSQP", options={"ftol": 1e-12, "maxiter": 500},
)  # fmt: skip
forces = found.x.reshape(4, 3)
print(forces.round(1) + 0.0)
print("missed of the wrench:", np.abs(G @ found.x - wanted).max().round(2))
assert np.all(sf.FrictionCone(0.6).contains(forces, tol=1e-6))

# %% [markdown]
# The same on exact cones, in microseconds, for a loop of a thousand calls a second:

# %%
distributor = sf.ForceDistributor(mu=0.6, normal_min=5.0)
exact = distributor.solve(G, wanted)
print("largest difference:", np.abs(exact - forces).max().round(1), "N")

# %% [markdown]
# A push of 150 N is more than the friction of the feet can give together, and a least-squares program
# misses it in silence. Ask first:

# %%
print(sf.can_stand(stance, com, robot.mass, external_wrench=[-150.0, 0, 0, 0, 0, 0]))
verdict = sf.can_stand(stance, com, robot.mass, external_wrench=[-20.0, 0, 0, 0, 0, 0])
print(verdict)
verdict
