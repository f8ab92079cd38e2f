# %% [markdown]
# # A walk
#
# A Go2 trots up a slope in MuJoCo and is pushed from the side. Every force of the ground is accounted for.

# %%
import numpy as np

import surefoot as sf

robot, ground = sf.load_robot("go2"), sf.SlopeTerrain(10.0)
controller = sf.WalkingController(robot, sf.VelocityCommand.constant(0.4), "trot", ground)
push = sf.Push(start=1.5, force=(0.0, 80.0, 0.0), duration=0.1)
world = sf.MujocoWorld(robot, ground, mu=0.6)
log = sf.run(world, controller, sf.Scenario(3.0, mu=0.6, pushes=[push]))
print(log)

# %% [markdown]
# How well did it walk, and was it lawful? The controller asks for forces inside the cones, to the last
# step.

# %%
summary = sf.summarise_walk(log)
print(f"{summary.outcome}: {summary.distance:.1f} m at {summary.velocity.forward.measured:.1f} m/s")
for foot in summary.feet:
    print(f"{foot.name}: {foot.footfalls} footfalls, down {100 * foot.duty:.0f} % of the time")
report = sf.audit_log(log)
print(report)
assert summary.success
assert report.verdict == "lawful"
assert np.all(sf.FrictionCone(0.6).contains(log["forces_commanded"], tol=1e-6))

# %% [markdown]
# The gait as it was planned:

# %%
sf.named_gait("trot")

# %% [markdown]
# And the walk as it was: height and speed, forces, friction and torques. With `log.save("walk.npz")` the
# command `surefoot lab audit walk.npz` shows it in a browser, and `surefoot walk go2 --velocity 0.4
# --terrain slope:10` films one.

# %%
log
