# %% [markdown]
# # Can it stand?
#
# A Go2 on a slope of 20 degrees, friction 0.6. `place` bends the legs so that the feet are on the ground
# and the weight is over them; the answer is a verdict with forces, or with a proof that there are none.

# %%
import surefoot as sf

robot = sf.load_robot("go2")
slope = sf.SlopeTerrain(20.0)
q = sf.place(robot, slope)
stance = robot.stance(q, mu=0.6, terrain=slope)
verdict = sf.can_stand(stance, robot.com(q), robot.mass)
print(verdict)
print(verdict.forces.reshape(4, 3).round(1) + 0.0)

# %% [markdown]
# How much friction does it need, and how hard may one push it downhill?

# %%
needed = sf.friction_needed(stance, robot.com(q), robot.mass)
print(f"friction needed: {needed:.3f}")
print(f"a push downhill: {verdict.largest_disturbance([-1, 0, 0, 0, 0, 0]):.1f} N")

# %% [markdown]
# On ice it cannot, and that comes with a proof: a motion that gravity drives and no force of the cones
# works against. `verify` checks it with two products of matrices.

# %%
ice = robot.stance(q, mu=0.2, terrain=slope)
slides = sf.can_stand(ice, robot.com(q), robot.mass)
print(slides)
print("proof:", slides.certificate.round(3) + 0.0, "checked:", slides.verify())
assert verdict
assert not slides
assert verdict.verify()
assert slides.verify()

# %% [markdown]
# Each force in its cone, coloured by the friction that it uses:

# %%
verdict
