"""52.4: a planar arm, three frames, and contact in the forward dynamics."""

from __future__ import annotations

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near

PROPERTIES = Properties()
holds = PROPERTIES.holds


def _arm(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    n = int(rng.integers(1, 5))
    return rng.uniform(0.1, 0.6, n), rng.uniform(-np.pi, np.pi, n)


def _joints(lengths: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return joints and tip as complex numbers turned one into the next."""
    place, heading, out = 0j, 1 + 0j, [0j]
    for length, angle in zip(lengths, angles, strict=True):
        heading *= np.exp(1j * angle)
        place += length * heading
        out.append(place)
    return np.array(out)


@holds("52.4.1", "the tip is at the end of the links, each turned from the last")
def _check_tip(answer: Answer, rng: np.random.Generator) -> None:
    lengths, angles = _arm(rng)
    end = _joints(lengths, angles)[-1]
    near(answer.numbers((2,), "tip", lengths, angles), [end.real, end.imag], "the tip")


@holds("52.4.1", "the Jacobian agrees with small turns of each joint")
def _check_columns(answer: Answer, rng: np.random.Generator) -> None:
    lengths, angles = _arm(rng)
    h, columns = 1e-6, []
    for step in h * np.eye(len(angles)):
        way = (_joints(lengths, angles + step)[-1] - _joints(lengths, angles - step)[-1]) / (2 * h)
        columns.append([way.real, way.imag])
    found = answer.numbers((2, len(angles)), "jacobian", lengths, angles)
    near(found, np.array(columns).T, "the Jacobian", 1e-5)


@holds("52.4.1", "torques are the force's moments about the joints")
def _check_moments(answer: Answer, rng: np.random.Generator) -> None:
    lengths, angles = _arm(rng)
    force = rng.normal(size=2) * 30
    joints = _joints(lengths, angles)
    arms = joints[-1] - joints[:-1]
    right = arms.real * force[1] - arms.imag * force[0]
    near(answer.numbers((len(angles),), "torques", lengths, angles, force), right, "the vector of torques")


def _rotation(rng: np.random.Generator) -> np.ndarray:
    found, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return found if np.linalg.det(found) > 0 else found[:, [1, 0, 2]]


def _foot(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    return (
        rng.normal(size=(6, int(rng.integers(3, 9)))),
        _rotation(rng),
        rng.normal(size=3) * 3,
        rng.normal(size=3),
    )


@holds("52.4.2", "in world axes a velocity has the same length and turns back into foot axes")
def _check_aligned(answer: Answer, rng: np.random.Generator) -> None:
    local, R, _, _ = _foot(rng)
    n = local.shape[1]
    found, v = answer.numbers((6, n), "aligned", local, R), rng.normal(size=n)
    near(R.T @ (found[:3] @ v), local[:3] @ v, "the linear velocity, turned back")
    near(R.T @ (found[3:] @ v), local[3:] @ v, "the angular velocity, turned back")


@holds("52.4.2", "WORLD is the velocity of the foot's material at the world's origin")
def _check_world(answer: Answer, rng: np.random.Generator) -> None:
    local, R, p, _ = _foot(rng)
    n, dt = local.shape[1], 1e-6
    v = rng.normal(size=n)
    found = answer.numbers((6, n), "world", local, R, p)
    spin = R @ local[3:] @ v
    near(found[3:] @ v, spin, "the angular velocity")
    # move the foot for a moment: where does the material go that was at the origin?
    angle = np.linalg.norm(spin) * dt
    axis = spin / np.linalg.norm(spin)
    arm = -p
    turned = (
        arm * np.cos(angle) + np.cross(axis, arm) * np.sin(angle) + axis * (axis @ arm) * (1 - np.cos(angle))
    )
    moved = (p + dt * (R @ local[:3] @ v) + turned) / dt
    near(found[:3] @ v, moved, "the velocity at the origin", 1e-4)


@holds("52.4.2", "the power of a force is that of its torques")
def _check_power(answer: Answer, rng: np.random.Generator) -> None:
    local, R, _, force = _foot(rng)
    v = rng.normal(size=local.shape[1])
    torques = answer.numbers((local.shape[1],), "contact_torques", local, R, force)
    near(torques @ v, (R.T @ force) @ (local[:3] @ v), "the power of the torques")


def _system(rng: np.random.Generator, copies: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n, m = int(rng.integers(6, 12)), int(rng.integers(1, 4))
    root = rng.normal(size=(n, n))
    J = rng.normal(size=(m, n))
    return root @ root.T + n * np.eye(n), np.vstack([J, J[:1]]) if copies else J, rng.normal(size=n) * 5


@holds("52.4.3", "M a = M free + Jᵀ f, whatever the damping")
def _check_motion(answer: Answer, rng: np.random.Generator) -> None:
    M, J, free = _system(rng, copies=False)
    a, f = answer.several(2, "constrained", M, J, free, rng.choice([0.0, rng.uniform(0.001, 0.1)]))
    a, f = np.ravel(np.asarray(a, float)), np.ravel(np.asarray(f, float))
    expect(a.shape == free.shape and f.shape == (len(J),), f"the shapes are {a.shape} and {f.shape}")
    near(M @ (a - free), J.T @ f, "M (a - free)")


@holds("52.4.3", "a Jacobian of full rank needs no damping: the contact holds exactly")
def _check_holds_exactly(answer: Answer, rng: np.random.Generator) -> None:
    M, J, free = _system(rng, copies=False)
    a, _ = answer.several(2, "constrained", M, J, free, 0.0)
    left = np.abs(J @ np.ravel(np.asarray(a, float))).max()
    expect(
        left < 1e-5 * max(1.0, float(np.abs(free).max())), f"J a is {left:.3g} with full rank and no damping"
    )
    expect(not answer.truth("needs_damping", J), "it says that a Jacobian of full rank needs damping")


@holds("52.4.3", "what damping costs: J a = -damping f, also where two rows are the same")
def _check_cost_of_damping(answer: Answer, rng: np.random.Generator) -> None:
    M, J, free = _system(rng, copies=bool(rng.integers(2)))
    damping = 10.0 ** rng.uniform(-4, -1)
    a, f = (np.ravel(np.asarray(x, float)) for x in answer.several(2, "constrained", M, J, free, damping))
    expect(np.isfinite(a).all() and np.isfinite(f).all(), "it is not finite")
    near(J @ a, -damping * f, "J a", 2e-3)


@holds("52.4.3", "two contacts that say the same need damping")
def _check_rank(answer: Answer, rng: np.random.Generator) -> None:
    _, J, _ = _system(rng, copies=True)
    expect(answer.truth("needs_damping", J), "it says that a Jacobian with a row twice needs none")
