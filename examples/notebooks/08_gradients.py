# %% [markdown]
# # Gradients
#
# A solved contact problem is a function of all it was given, and `derivative()` is its exact derivative. A
# block is pushed with an impulse along x: with a weak one it sticks, with a strong one it slides.

# %%
import numpy as np

import surefoot as sf

G = np.diag([1.0, 1.0, 0.5])  # inverse mass seen at the contact
solution = sf.solve(sf.ContactProblem(G, [3.0, 0.0, -1.0], mu=0.5))
slope = solution.derivative()
print(solution)
print("mode:", slope.modes[0])

# %% [markdown]
# Forwards: what a change of the friction does to the velocities. Backwards: all that the sliding velocity
# depends on, in one pass.

# %%
print("du / dmu:", slope.jvp(mu=1.0).velocities[0] + 0.0)
back = slope.vjp(velocities=[[1.0, 0.0, 0.0]])
print("d(sliding velocity) / d free velocity:", back.g + 0.0, " / dmu:", back.mu + 0.0)

# %% [markdown]
# The same against differences, for every push from sticking to sliding. At the kink the derivative is
# one-sided, and says so.

# %%
pushes = np.linspace(0.0, 3.0, 61)


def sliding(push):
    """Return the sliding velocity after a push, and its derivative by the friction."""
    solved = sf.solve(sf.ContactProblem(G, [push, 0.0, -1.0], mu=0.5))
    return solved.velocities[0, 0], solved.derivative().jvp(mu=1.0).velocities[0, 0]


speeds, slopes = np.array([sliding(push) for push in pushes]).T
step = 1e-6
more = sf.solve(sf.ContactProblem(G, [3.0, 0.0, -1.0], mu=0.5 + step)).velocities[0, 0]
assert abs((more - speeds[-1]) / step - slopes[-1]) < 1e-5
kink = sf.solve(sf.ContactProblem(G, [1.0, 0.0, -1.0], mu=0.5)).derivative().kinks[0]
print("at a push of 1 it may", " or ".join(sorted(kink.modes)))

# %%
import matplotlib.pyplot as plt

figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.plot(pushes, speeds, label="sliding velocity")
axes.plot(pushes, slopes, label="its derivative by the friction")
axes.set(xlabel="push [m/s]", title="Sticking, and sliding")
axes.legend()
plt.show()
