# %% [markdown]
# # MuJoCo that sticks
#
# MuJoCo's contacts are soft by design: what should rest creeps. A block lies on a slope of 20 degrees with
# friction 0.5, more than the tangent of the slope, so that Coulomb's law holds it for ever.

# %%
import mujoco
import numpy as np

import surefoot as sf

SLOPE = """<mujoco><option cone="elliptic" timestep="0.002" gravity="{x} 0 {z}"/><worldbody>
  <geom type="plane" size="9 9 1" friction="0.5"/>
  <body pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="2" friction="0.5"/></body>
</worldbody></mujoco>"""
angle = np.radians(20.0)
text = SLOPE.format(x=9.81 * np.sin(angle), z=-9.81 * np.cos(angle))
model = mujoco.MjModel.from_xml_string(text)


def slide(step, seconds=4.0):
    """Return how far the block has gone down the slope, over time [mm]."""
    data = mujoco.MjData(model)
    gone = []
    for _ in range(round(seconds / model.opt.timestep)):
        step(data)
        gone.append(1000 * data.qpos[0])
    return np.array(gone)


soft = slide(lambda data: mujoco.mj_step(model, data))
print(f"MuJoCo: {soft[-1]:.2f} mm in 4 s, and on at {(soft[-1] - soft[1000]) / 2:.2f} mm/s")

# %% [markdown]
# One line puts Coulomb's law in place of the soft contacts; collision, motors, sensors and integrators stay
# MuJoCo's. Each step is certified.

# %%
stepper = sf.MujocoStepper(model)
exact = slide(stepper.step)
print(f"exact:  {exact[-1]:.6f} mm, last step {stepper.certificate.status.value}")
assert abs(exact[-1]) < 1e-3 < soft[-1]

# %% [markdown]
# A loop that you do not want to edit runs in a context that takes over `mj_step`:

# %%
with sf.exact_contact() as used:
    again = slide(lambda data: mujoco.mj_step(model, data), seconds=0.2)
print(f"{used.steps} steps taken over")

# %%
import matplotlib.pyplot as plt

time = model.opt.timestep * np.arange(1, len(soft) + 1)
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.plot(time, soft, label="MuJoCo's soft contact")
axes.plot(time, exact, label="Coulomb's law")
axes.set(xlabel="time [s]", ylabel="down the slope [mm]", title="A block that should rest")
axes.legend()
plt.show()
