from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from surefoot.base.numerics.rotations import log_between


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-7, 0.3, 2.0, 3.1, np.pi - 1e-7, np.pi])
def test_the_rotation_vector_is_scipys(angle: float) -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        B = Rotation.random(random_state=rng).as_matrix()
        A = Rotation.from_rotvec(angle * axis).as_matrix() @ B
        out = np.empty(3)
        log_between(A, B, out)
        assert np.allclose(Rotation.from_rotvec(out).as_matrix() @ B, A, atol=1e-8)
        assert np.linalg.norm(out) == pytest.approx(angle, abs=1e-7)
