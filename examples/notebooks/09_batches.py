# %% [markdown]
# # Batches
#
# A planner has a thousand candidates, a training ten thousand environments: the same questions take arrays.
# Where may the left front foot of a standing quadruped go, when the right hind one is in the air? A grid of
# 2500 places, one answer for each.

# %%
import numpy as np

import surefoot as sf

x, y = np.meshgrid(np.linspace(-0.3, 0.5, 50), np.linspace(-0.3, 0.5, 50))
others = [[0.2, -0.15, 0.0], [-0.2, 0.15, 0.0]]
places = np.zeros((x.size, 3, 3))
places[:, 0, 0], places[:, 0, 1] = x.ravel(), y.ravel()
places[:, 1:] = others
batch = sf.StanceBatch(places, mu=0.6)
com = [0.03, 0.03, 0.3]
verdicts = sf.can_stand_batch(batch, com, mass=15.0)
print(verdicts)
best = int(np.argmax(np.where(verdicts.feasible, verdicts.margin, -np.inf)))
print("most to spare at", places[best, 0, :2].round(2), ":", sf.can_stand(batch[best], com, 15.0))
assert verdicts[0].verify()

# %% [markdown]
# Contact problems go the same way, with a status and a residual each, and with derivatives of all of them
# in one pass back.

# %%
rng = np.random.default_rng(0)
J = rng.normal(size=(1000, 12, 18))  # contact Jacobians of four feet, masses of one
G, g = J @ J.transpose(0, 2, 1), rng.normal(size=(1000, 12))
solved = sf.solve_batch(G, g, mu=0.6, derivative=True)
print(solved)
back = solved.derivative.vjp(velocities=np.ones((1000, 4, 3)))
print("gradients:", back.G.shape, back.g.shape, back.mu.shape)
assert solved.solved.all()
assert back.valid.all()

# %% [markdown]
# Newtons to spare, by the place of the foot; white is where it cannot stand.

# %%
import matplotlib.pyplot as plt

margin = np.where(verdicts.feasible, verdicts.margin, np.nan).reshape(x.shape)
figure, axes = plt.subplots(figsize=(5, 4), layout="constrained")
colours = axes.pcolormesh(x, y, margin, cmap="viridis")
axes.plot(*np.array(others)[:, :2].T, "s", color="black", label="other feet")
axes.plot(*com[:2], "+", color="red", ms=12, label="centre of mass")
axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Where may the left front foot go?")
axes.legend(loc="lower left")
figure.colorbar(colours, label="margin [N]")
plt.show()
