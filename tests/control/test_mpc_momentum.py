"""The cost of angular momentum in plans: against Clarabel and optimality, in sign, scale and effect."""

import numpy as np
import pytest

from surefoot.cones import FrictionCone
from surefoot.control.mpc import BodyReference, BodyState, ConvexMpc, MpcMomentum, MpcWeights
from surefoot.errors import ProblemError
from surefoot.spatial import rotation_about, rotation_from_normal

SKEW = np.array([[0.1, 0.01, -0.02], [0.01, 0.25, 0.015], [-0.02, 0.015, 0.3]])
FEET = np.array([[0.2, 0.14, 0.0], [0.2, -0.14, 0.0], [-0.2, 0.14, 0.0], [-0.2, -0.14, 0.0]])
TROT = np.array([[1, 0, 0, 1]] * 5 + [[0, 1, 1, 0]] * 5, dtype=bool)
BOUND = MpcMomentum(bound=(0.05, 0.08, 0.06), beyond=300.0)
BOTH = MpcMomentum(
    weight=(20.0, 10.0, 5.0), reference=(0.05, -0.1, 0.02), bound=(0.06, 0.08, 0.04), beyond=80.0
)
COST = MpcMomentum(weight=(30.0, 20.0, 10.0), reference=(0.1, 0.0, -0.05))


def setting(seed, tilt=0.3):
    """Return inputs of `solve` on a slope, a body off its reference and turning."""
    rng = np.random.default_rng(seed)
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    ref = BodyReference.cruise([0, 0, 0.3], 0.7, (0.5, 0.1), 0.4, normal=normal)
    state = BodyState(
        rotation_about([0.6, 0.8, 0.0], 0.1) @ ref.rotation[0], ref.position[0] + 0.02 * rng.normal(size=3),
        ref.linear_velocity[0] + 0.3 * rng.normal(size=3), ref.angular_velocity[0] + rng.normal(size=3),
    )  # fmt: skip
    ground = rotation_from_normal(normal)
    feet = ref.position[0] + (FEET - [0.0, 0.0, 0.3]) @ ref.rotation[0].T
    return state, ref, feet, TROT, np.array([ground] * 4)


def make(term, inertia=SKEW, **changes):
    values = {"mu": 0.5, "normal_min": 2.0, "normal_max": 300.0, "tol": 1e-6, "max_iterations": 1000}
    return ConvexMpc(15.0, inertia, weights=MpcWeights(momentum=term), **{**values, **changes})


def heading_of(ref):
    middle = ref.rotation[len(ref.rotation) // 2]
    yaw = np.arctan2(middle[1, 0], middle[0, 0])
    return rotation_about([0.0, 0.0, 1.0], yaw)


def momenta(mpc, given, forces):
    """Return (N, 3) momenta along the heading's axes, marched step by step from the model's words."""
    state, ref, feet, contacts, frames = given
    lag, slip, w = state.position - ref.position[0], state.linear_velocity - ref.linear_velocity[0], None
    w, out = state.angular_velocity, []
    for k in range(mpc.horizon):
        centre = 0.5 * (ref.position[k] + ref.position[k + 1]) + lag
        centre = centre + 0.1 * (1.0 - np.exp(-(k + 0.5) * mpc.dt / 0.1)) * slip
        world = np.einsum("nij,nj->ni", frames, forces[k])
        moment = np.cross(feet - centre, world)[contacts[k]].sum(axis=0)
        w = w + mpc.dt * np.linalg.solve(ref.rotation[k] @ mpc.inertia @ ref.rotation[k].T, moment)
        R = ref.rotation[k + 1]
        out.append(heading_of(ref).T @ (R @ mpc.inertia @ R.T @ w))
    return np.array(out)


def affine(mpc, given, program):
    """Return A (3 N, 3 c) and b so that the momenta are A f + b, from one march per unit force."""
    full = np.zeros((mpc.horizon, 4, 3))
    b, columns = momenta(mpc, given, full).ravel(), []
    for k, i in zip(program.step, program.foot, strict=True):
        for a in range(3):
            full[k, i, a] = 1.0
            columns.append(momenta(mpc, given, full).ravel() - b)
            full[k, i, a] = 0.0
    return np.array(columns).T, b


@pytest.mark.parametrize("term", [COST, BOUND, BOTH])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_projected_gradients_do_not_move_the_forces(term, seed):
    """Optimality read off the cones, the condensed tracking cost and momenta marched step by step."""
    mpc, given = make(term), setting(seed)
    plan, program = mpc.solve(*given), mpc.program(*given)
    assert plan.solved
    H, g = program.condensed()
    A, b = affine(mpc, given, program)
    f = plan.forces[program.step, program.foot]
    h = (A @ f.ravel() + b).reshape(-1, 3)
    excess = h - np.clip(h, -np.array(term.bound), term.bound)
    assert (term is COST) == (not excess.any())  # the bounds bite
    pull = np.array(term.weight) * (h - term.reference) + term.beyond * excess
    slope = (H @ f.ravel() + g + A.T @ pull.ravel()).reshape(-1, 3)
    largest = np.linalg.eigvalsh(H)[-1] + (max(term.weight) + term.beyond) * np.linalg.norm(A, 2) ** 2
    moved = f - slope / largest
    again = np.array([FrictionCone(0.5).project(m) for m in moved])
    assert ((again[:, 2] > 2.0) & (again[:, 2] < 300.0)).all()
    assert np.abs(again - f).max() <= 1e-6


def test_without_a_term_nothing_changes():
    given = setting(4)
    plain, mpc = make(None), make(MpcMomentum())
    for _ in range(3):
        a, b = plain.solve(*given), mpc.solve(*given)
        assert np.array_equal(a.forces, b.forces)
        assert a.error == b.error
        assert a.iterations == b.iterations


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"weight": (1.0, -1.0, 0.0)}, "weight must be >= 0"),
        ({"weight": (1.0, 2.0)}, "weight"),
        ({"reference": (np.nan, 0.0, 0.0)}, "reference"),
        ({"bound": (1.0, 0.0, 1.0)}, "cannot turn back"),
        ({"bound": (1.0, np.nan, 1.0)}, "bound"),
        ({"bound": "none"}, "bound"),
        ({"beyond": -1.0}, "beyond"),
    ],
)
def test_what_is_no_momentum_term_is_refused(values, word):
    with pytest.raises(ProblemError, match=word):
        MpcMomentum(**values)
