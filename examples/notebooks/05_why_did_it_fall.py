# %% [markdown]
# # Why did it fall?
#
# A Go2 trots in MuJoCo. At 1.2 s the ground turns to ice and nobody tells the controller. The log knows
# what happened; the audit writes the paragraph that a person would write, from the log alone.

# %%
import surefoot as sf

robot, ground = sf.load_robot("go2"), sf.FlatTerrain()


def walk(ice, seconds):
    """Return the log of a trot at 0.4 m/s on ground that may turn to ice."""
    controller = sf.WalkingController(robot, sf.VelocityCommand.constant(0.4), "trot", ground)
    world = sf.MujocoWorld(robot, ground, mu=0.6)
    return sf.run(world, controller, sf.Scenario(seconds, mu=0.6, ice=ice))


log = walk([sf.Ice(start=1.2, mu=0.04)], seconds=3.5)
report = sf.audit_log(log)
cause = report.first_cause
print("it", log.facts["outcome"])
print("first cause:", cause.name)

# %% [markdown]
# A cause is what began before the failure and is not refuted. It brings its evidence, what would refute it,
# what would be without it, and what to try.

# %%
print("evidence:", cause.evidence)
print("refuted where:", cause.refuted)
print("without it:", cause.without)
print("try:", cause.remedy)
assert cause.name == "slippery ground"
assert 1.2 <= cause.time <= 1.5

# %% [markdown]
# The same walk without ice has no first cause, whatever it went over:

# %%
calm = sf.audit_log(walk([], seconds=2.0))
print("lawful" if calm.verdict == "lawful" else calm.sentence, "- first cause:", calm.first_cause)
assert calm.first_cause is None

# %% [markdown]
# The story of the fall: the robot at its events, friction, balance and torques over time. After the fall
# the body lies on the ground with contacts that this log does not have, which the law of motion notices.

# %%
report
