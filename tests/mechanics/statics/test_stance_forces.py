"""Contact forces of a stance for one wrench, points and patches."""

import numpy as np

import surefoot as sf


def test_distribute_points():
    feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
    stance = sf.Stance([sf.PointContact(p, mu=0.6, normal_max=200.0) for p in feet])
    w = np.array([20.0, -10.0, 160.0, 2.0, 1.0, 0.5])
    f = sf.distribute(stance, w, about=[0, 0, 0.3])
    assert f.shape == (4, 3)
    np.testing.assert_allclose(stance.grasp_map([0, 0, 0.3]) @ f.ravel(), w, atol=0.05)
    assert stance.cone().contains(f.ravel())


def test_distribute_patches_keeps_the_bounds_of_the_sum():
    left = sf.SoleContact(
        [0, 0.1, 0], sf.Sole(0.2, 0.1, mu=0.7), name="left", normal_min=50.0, normal_max=180.0
    )
    right = sf.SoleContact([0, -0.1, 0], sf.Sole(0.2, 0.1, mu=0.7), name="right", normal_max=400.0)
    point = sf.PointContact([0.4, 0.0, 0.2], normal=[-1.0, 0, 0], mu=0.5, name="hand", normal_max=60.0)
    for contacts in ([left, right], [left, point, right]):
        stance = sf.Stance(contacts)
        for w in ([10.0, 5.0, 330.0, 3.0, -6.0, 1.0], [0, 0, 330.0, 40.0, 0, 0], [0, 0, 20.0, 0, 0, 0]):
            x = sf.distribute(stance, w, about=[0, 0, 0.8], force_weight=1e-6)
            assert x.shape == (stance.dim,)
            for contact, part in zip(stance.contacts, stance.slices, strict=True):
                assert contact.cone.margin(x[part]) >= -1e-6
                normal = x[part][2]
                assert contact.normal_min - 1e-8 <= normal <= contact.normal_max + 1e-8
    x = sf.distribute(sf.Stance([left, right]), [10.0, 5.0, 330.0, 3.0, -6.0, 1.0], about=[0, 0, 0.8])
    wrench = sf.Stance([left, right]).grasp_map([0, 0, 0.8]) @ x
    np.testing.assert_allclose(wrench, [10.0, 5.0, 330.0, 3.0, -6.0, 1.0], atol=0.2)
