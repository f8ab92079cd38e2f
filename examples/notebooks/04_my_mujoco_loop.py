# %% [markdown]
# # My MuJoCo loop
#
# Keep your loop. `sf.record` watches every step of your data and gives back a log; the audit says which law
# of contact it broke.

# %%
import mujoco

import surefoot as sf

model = mujoco.MjModel.from_xml_string("""<mujoco><option timestep="0.002"/><worldbody>
  <geom name="floor" type="plane" size="5 5 1" friction="0.5" solref="0.005 1"/>
  <body name="sledge" pos="0 0 0.1"><freejoint/>
    <geom name="hull" type="box" size="0.2 0.2 0.1" mass="5" friction="0.5" solref="0.005 1"/></body>
</worldbody></mujoco>""")
data = mujoco.MjData(model)
data.qvel[0] = 1.0
with sf.record(model, data) as log:
    for _ in range(300):
        mujoco.mj_step(model, data)

print(log)
print("forces (rows, contacts, 3):", log["forces"].shape)

# %% [markdown]
# It slides and stops. Was that lawful? A verdict names what was judged, and what was not.

# %%
report = sf.audit_log(log)
print(report)
for finding in report.symptoms:
    print(f"{finding.name}: {finding.cure}")

# %% [markdown]
# A hand that nobody logged: something lifts the sledge while the log says that nothing does. The audit
# finds the row.

# %%
mujoco.mj_resetData(model, data)
with sf.record(model, data) as lifted:
    for step in range(300):
        if step == 150:
            data.qvel[2] += 1.0  # a jump of the velocity that no force explains
        mujoco.mj_step(model, data)
lie = sf.audit_log(lifted)
print(lie.verdict)
for violation in lie.violations[:3]:
    print(f"{violation.law} at {violation.start:.2f} s: {violation.value:.3g} {violation.unit}")

# %% [markdown]
# The log of the first run, as a picture:

# %%
log
