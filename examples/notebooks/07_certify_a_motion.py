# %% [markdown]
# # Certify a motion
#
# Somebody retargets a motion to a humanoid and trains a policy on it for days. Whether any forces of the
# ground and any torques of its motors could make that motion is known within a second, frame by frame.

# %%
import numpy as np

import surefoot as sf

robot = sf.load_robot("g1")
q = np.tile(robot.nominal, (60, 1))  # it stands still for two seconds,
q[20:40, 2] += 0.05  # and hangs 5 cm above the ground in between
motion = sf.read_motion(q, robot, fps=30, order="depth", quaternion="xyzw")
report = sf.certify_motion(robot, motion)
print(report)
for part in report.segments:
    print(f"{part.start:.2f} to {part.end:.2f} s: {part.cause}; {part.cure}")

# %% [markdown]
# "Impossible" comes with a proof, which NumPy can check: what the best forces leave is a direction in which
# no contact can push.

# %%
proof = report.certificate(30)
left = proof.residual
onto = np.einsum("dci,d->ci", proof.maps, left)  # what a newton of each contact has of it
assert (onto[:, 2] + proof.mu * np.hypot(onto[:, 0], onto[:, 1]) <= 1e-9 * np.linalg.norm(left)).all()
missing = proof.needed @ left / np.linalg.norm(left)
print(f"{missing:.2f} of the weight is missing in frame 30")

# %% [markdown]
# And it can be mended: the nearest motion that forces exist for.

# %%
mended = sf.repair_motion(report)
print(mended)
assert mended.report.verdict == "possible"

# %%
report
