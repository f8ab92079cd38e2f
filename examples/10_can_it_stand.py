"""Can it stand here? A verdict with a proof, the friction it needs, and where its weight may be.

Run: python examples/10_can_it_stand.py
"""

import numpy as np

import surefoot as sf


def quadruped_on(degrees, mu):
    """Four feet on a slope that rises along +x."""
    ground = sf.SlopeTerrain(degrees)
    feet = {"FL": (0.2, 0.15), "FR": (0.2, -0.15), "RL": (-0.2, 0.15), "RR": (-0.2, -0.15)}
    return sf.Stance(
        [sf.PointContact([*p, ground.height(p)], ground.normal(p), mu, name) for name, p in feet.items()]
    )


def report(title, stance, com, mass):
    verdict = sf.can_stand(stance, com, mass)
    needed = sf.friction_needed(stance, com, mass)
    print(f"{title}: {verdict}, friction needed {needed:.3f}")
    assert verdict.verify()
    if verdict:
        push = verdict.largest_disturbance([-1.0, 0, 0, 0, 0, 0])
        print(f"  it withstands a push of {push:.1f} N downhill")
    else:
        way = verdict.certificate[:3] / np.linalg.norm(verdict.certificate[:3])
        print(f"  no forces hold it: no force works against the motion {way.round(3) + 0.0}")
    return verdict


com, mass = [0.0, 0.0, 0.3], 15.0
assert report("20 deg, mu 0.6", quadruped_on(20, 0.6), com, mass)
assert not report("35 deg, mu 0.6", quadruped_on(35, 0.6), com, mass)

# A hand on a wall lets the centre of mass leave the support polygon.
feet = [sf.SoleContact([0.0, y, 0.0], sf.Sole(0.2, 0.1, mu=0.6)) for y in (0.1, -0.1)]
hand = sf.PointContact([0.5, 0.2, 1.0], [-1.0, 0.0, 0.0], mu=0.5, heading=[0, 0, 1], normal_max=80.0)
alone, leaning = sf.Stance(feet), sf.Stance([*feet, hand])
for title, stance in (("two feet", alone), ("and a hand", leaning)):
    region = sf.com_region(stance, mass=35.0, tol=1e-3)
    reach = region.inner[:, 0].max()
    print(
        f"{title}: the centre of mass may be as far forward as {reach:.3f} m, in {1e4 * region.area:.0f} cm^2"
    )
assert not sf.can_stand(alone, [0.15, 0.0, 0.9], 35.0)
assert sf.can_stand(leaning, [0.15, 0.0, 0.9], 35.0)

# All wrenches of the two feet as half-spaces, for a planner.
cone = sf.wrench_cone(alone, about=[0, 0, 0.9], facets=4)
print(f"wrench cone: {len(cone.halfspaces)} half-spaces from {len(cone.rays)} rays")
assert cone.contains([0.0, 0.0, 35.0 * 9.81, 0.0, 0.0, 0.0])
