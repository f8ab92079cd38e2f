"""Several bodies that touch each other, against closed forms."""

from __future__ import annotations

import math
import resource

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.collision import Box, Capsule, Sphere
from surefoot.worlds.rigid.rigid_world import RigidWorld
from surefoot.worlds.rigid.scene import Body, Scene, SceneWorld
from tests.moving import advance

CUBE = Box((0.2, 0.2, 0.2))
RADIUS = 0.05
BALL = Sphere(RADIUS)


def turned(axis, degrees):
    """The quaternion (x, y, z, w) of a turn."""
    half = math.radians(degrees) / 2.0
    return (*(math.sin(half) * np.array(axis, dtype=float)).tolist(), math.cos(half))


def run(world, steps):
    advance(world, steps)
    assert world.unsolved == 0
    assert world.worst_residual <= 1e-8
    return world


def forces(world):
    """The force on each body from each other [N]."""
    out: dict[tuple[str, str], np.ndarray] = {}
    for touch in world.touches():
        out[touch.body, touch.other] = out.get((touch.body, touch.other), np.zeros(3)) + touch.force
    return out


def test_a_stack_of_five_stands_still_and_carries_its_weight():
    masses = [1.0, 2.0, 3.0, 4.0, 5.0]
    bodies = [Body(f"b{k}", CUBE, m, (0, 0, 0.1 + 0.2 * k)) for k, m in enumerate(masses)]
    world = SceneWorld(Scene(bodies))
    start = world.q_v()[0]
    run(world, 500)
    assert np.abs(world.q_v()[0] - start).max() < 1e-9
    found = forces(world)
    for k in range(5):
        below = "ground" if k == 0 else f"b{k - 1}"
        expected = [0.0, 0.0, GRAVITY * sum(masses[k:])]
        np.testing.assert_allclose(found[f"b{k}", below], expected, atol=1e-4)
    assert world.contact_work() <= 1e-12


@pytest.mark.parametrize("degrees", [12.0, 15.0])
@pytest.mark.parametrize("mu", [0.22, 0.26])
def test_a_stack_on_a_slope_slides_beyond_the_friction_angle(degrees, mu):
    slope = sf.SlopeTerrain(degrees)
    normal, turn = slope.normal([0.0, 0.0]), turned((0, 1, 0), -degrees)
    bodies = [Body(f"b{k}", CUBE, 1.0 + k, tuple(normal * (0.1 + 0.2 * k)), turn) for k in range(2)]
    world = run(SceneWorld(Scene(bodies), slope, mu=mu), 200)
    a = math.radians(degrees)
    expected = max(0.0, GRAVITY * (math.sin(a) - mu * math.cos(a))) * world.time
    for name in ("b0", "b1"):
        assert abs(np.linalg.norm(world.twist(name)[0]) - expected) < 1e-7


def test_a_box_slides_on_a_plank_until_both_move_alike():
    """Momentum is kept on ice; the slide is v² / (2 mu g (1 + m / M))."""
    m, M, mu, v = 1.0, 3.0, 0.4, 1.5
    plank = Body("plank", Box((3.0, 0.3, 0.1)), M, (0, 0, 0.05), friction=mu)
    block = Body("block", Box((0.2, 0.2, 0.1)), m, (-1.0, 0, 0.15), velocity=(v, 0, 0), friction=mu)
    world = run(SceneWorld(Scene([plank, block]), mu=0.0), 700)
    for name in ("plank", "block"):
        np.testing.assert_allclose(world.twist(name)[0], [v * m / (m + M), 0, 0], atol=1e-8)
    slid = world.pose("block").position[0] - world.pose("plank").position[0] + 1.0
    assert abs(slid - v**2 / (2.0 * mu * GRAVITY * (1.0 + m / M))) < v * world.dt


def test_friction_of_a_pair_is_made_by_the_rule():
    for rule, expected in (("physx-min", 0.2), ("mujoco", 0.4), ("drake", 2 * 0.08 / 0.6), ("physx", 0.3)):
        table = Body("table", Box((3.0, 1.0, 0.1)), fixed=True, friction=0.4)
        block = Body("block", CUBE, 1.0, (0, 0, 0.15), velocity=(1, 0, 0), friction=0.2)
        world = run(SceneWorld(Scene([table, block], combine=rule)), 50)
        assert abs(world.twist("block")[0][0] - (1.0 - expected * GRAVITY * world.time)) < 1e-8


def row(n):
    """Balls in a row on ice that touch, the first 0.1 m apart from the others."""
    bodies = [
        Body(
            f"s{k}",
            BALL,
            1.0,
            (2.0 * RADIUS * k - (0.1 if k == 0 else 0.0), 0, RADIUS),
            velocity=(1.0 if k == 0 else 0.0, 0, 0),
            friction=0.0,
            restitution=1.0,
        )
        for k in range(n)
    ]
    world = SceneWorld(Scene(bodies), mu=0.0)
    energy = world.energy()
    run(world, 250)
    return [float(world.twist(f"s{k}")[0][0]) for k in range(n)], world.energy() - energy


@pytest.mark.parametrize("n", [2, 3, 5])
def test_newtons_law_for_all_contacts_at_once_is_no_cradle(n):
    """All balls that were at rest leave together: energy and momentum are kept, yet no cradle does it."""
    speeds, change = row(n)
    np.testing.assert_allclose(speeds, [2.0 / n - 1.0] + [2.0 / n] * (n - 1), atol=1e-6)
    assert abs(change) < 1e-6


@pytest.mark.parametrize("on_table", [False, True])
def test_a_sliding_ball_rolls_at_five_sevenths_of_its_speed(on_table):
    lift = 0.3 if on_table else 0.0
    bodies = [Body("ball", Sphere(0.1), 1.0, (0, 0, 0.1 + lift), velocity=(1, 0, 0))]
    if on_table:
        bodies.append(Body("table", Box((4.0, 1.0, 0.3)), fixed=True, position=(0, 0, 0.15)))
    world = run(SceneWorld(Scene(bodies), mu=0.3), 200)
    velocity, spin = world.twist("ball")
    np.testing.assert_allclose(velocity, [5.0 / 7.0, 0, 0], atol=1e-6)
    np.testing.assert_allclose(spin, [0, 50.0 / 7.0, 0], atol=1e-5)


@pytest.mark.parametrize("on_table", [False, True])
def test_a_capsule_comes_to_lie(on_table):
    lift = 0.2 if on_table else 0.0
    bodies = [Body("capsule", Capsule(0.05, 0.3), 2.0, (0, 0, 0.12 + lift), turned((0, 1, 0), 80.0))]
    if on_table:
        bodies.insert(0, Body("table", Box((1.0, 1.0, 0.2)), 20.0, (0, 0, 0.1)))
    world = run(SceneWorld(Scene(bodies)), 1200)
    pose, under = world.pose("capsule"), "table" if on_table else "ground"
    assert abs(pose.position[2] - 0.05 - lift) < 1e-5
    assert abs(pose.rotation[2, 2]) < 1e-5
    assert abs(forces(world)["capsule", under][2] - 2.0 * GRAVITY) < 1e-5
    assert sum(t.body == "capsule" for t in world.touches()) == 2


def test_a_log_lies_between_two_others():
    """Each carries m g / (2 cos 30°) along its normal, without friction."""
    lying, mu = turned((0, 1, 0), 90.0), 0.0
    log = Capsule(0.05, 0.3)
    bodies = [
        Body("left", log, position=(0, -0.05, 0.05), orientation=lying, fixed=True),
        Body("right", log, position=(0, 0.05, 0.05), orientation=lying, fixed=True),
        Body("top", log, 1.0, (0, 0, 0.05 + 0.05 * math.sqrt(3.0)), lying),
    ]
    world = run(SceneWorld(Scene(bodies), mu=mu), 300)
    assert abs(world.pose("top").position[1]) < 1e-9
    for side in ("left", "right"):
        assert abs(np.linalg.norm(forces(world)["top", side]) - GRAVITY / math.sqrt(3.0)) < 1e-6


def test_go2_stands_on_a_box_with_its_front_feet():
    robot = sf.load_robot("go2")
    q, feet = robot.nominal, robot.foot_positions()
    box = Body("step", Box((0.3, 0.6, 0.02)), 5.0, (feet[0, 0], 0, 0.01))
    scene = Scene([box], robot)
    world = SceneWorld(scene)
    start, _ = scene.start()
    start[2] += 0.021
    world.reset(start)
    for _ in range(600):
        now, v = world.q_v()
        world.step(60.0 * (q[7:] - now[7:19]) - 2.0 * v[6:18])
    assert world.unsolved == 0
    found = forces(world)
    ground = sum(f for (_, other), f in found.items() if other == "ground")
    assert abs(ground[2] - (robot.mass + 5.0) * GRAVITY) < 1.0
    on_box = sum(np.linalg.norm(f) for pair, f in found.items() if "step" in pair and "ground" not in pair)
    assert on_box > 50.0
    assert scene.joints == 12 == len(scene.joint_names)


def test_a_rigid_world_knows_a_scene():
    scene = Scene([Body("a", CUBE, 1.0, (0, 0, 0.1)), Body("b", BALL, 1.0, (0, 0, 0.25))])
    world = RigidWorld(scene)
    advance(world, 5, np.zeros(0))
    assert {(t.body, t.other) for t in world.touches()} == {("a", "ground"), ("b", "a")}
    assert world.contacts().forces.shape == (0, 3)
    with pytest.raises(ProblemError, match="without smoothing"):
        world.derivative(smoothing=1e-3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Scene([]), "can move"),
        (lambda: Scene([Body("a", CUBE, fixed=True)]), "can move"),
        (lambda: Scene([Body("a", CUBE), Body("a", BALL)]), "names of their own"),
        (lambda: Scene([Body("ground", CUBE)]), "something else is"),
        (lambda: Scene([Body("a", CUBE)], combine="sum"), "unknown rule 'sum'"),
        (lambda: Body("a", CUBE, 0.0), "mass"),
        (lambda: Body("a", CUBE, position=(0, 0, np.nan)), "position"),
        (lambda: Body("a", CUBE, orientation=(0, 0, 0, 2)), "unit quaternion"),
        (lambda: Body("a", CUBE, fixed=True, velocity=(1, 0, 0)), "cannot move"),
        (lambda: Scene([Body("a", CUBE, friction=-1.0)]), "friction"),
        (lambda: Scene([Body("a", CUBE, restitution=1.5)]), "restitution"),
        (lambda: Scene([Body("a", CUBE)]).pose("b"), "unknown body 'b'"),
    ],
)
def test_wrong_scenes_are_told(make, words):
    with pytest.raises(ProblemError, match=words):
        make()


def many(count, gap=0.3, low=1.0):
    places = np.stack(np.unravel_index(np.arange(count), (10, 10, 10)), axis=1) * gap + [0.0, 0.0, low]
    return [
        Body(f"s{k}", BALL, 1.0, tuple(p), velocity=(0.1 * (k % 3), 0.0, 0.0)) for k, p in enumerate(places)
    ]


def test_a_thousand_spheres_fall_in_little_memory():
    world = SceneWorld(Scene(many(1000)))
    start, before = world.energy(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    advance(world, 20)
    assert abs(world.energy() - start) < 1e-9 * abs(start)
    assert abs(world.pose("s999").position[2] - 3.7 + 0.5 * GRAVITY * 0.02**2) < 1e-9
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 3e5  # [kB]; a joint tree takes 1e10


def test_a_layer_of_many_spheres_lies_as_each_would_alone():
    bodies = [Body(f"s{k}", BALL, 1.0 + k, (0.11 * k, 0.0, RADIUS)) for k in range(80)]
    world = run(SceneWorld(Scene(bodies)), 20)
    found = forces(world)
    for k in range(80):
        np.testing.assert_allclose(found[f"s{k}", "ground"], [0.0, 0.0, GRAVITY * (1.0 + k)], atol=1e-6)


def test_a_row_that_touches_passes_a_push_on_between_many():
    """Pairs that get their slots when they come near carry what those of few bodies carry."""
    near = [Body(f"s{k}", BALL, 1.0, (0.1 * k, 0, RADIUS), velocity=(-float(k), 0, 0)) for k in range(3)]
    far = [Body(f"f{k}", BALL, 1.0, (0.0, 1.0 + 0.3 * k, RADIUS)) for k in range(70)]
    few, many_bodies = (run(SceneWorld(Scene(bodies), mu=0.3), 30) for bodies in (near, near + far))
    for k in range(3):
        pose, other = few.pose(f"s{k}"), many_bodies.pose(f"s{k}")
        np.testing.assert_allclose(pose.position, other.position, atol=1e-9)
        np.testing.assert_allclose(pose.rotation, other.rotation, atol=1e-9)


@pytest.mark.long
def test_bodies_with_many_contacts_are_told_to_the_solver_and_carry_their_weights(monkeypatch):
    """Of 36 stacks of two the velocities are fewer than the contacts' rows; single stacks need none of it."""
    asked = []

    def solve(problem, *args, **options):
        asked.append(problem)
        return sf.solve(problem, *args, **options)

    monkeypatch.setattr("surefoot.mechanics.dynamics.impacts.solve", solve)
    cube = Box((0.1, 0.1, 0.1))
    bodies = [
        Body(f"{i}-{j}-{k}", cube, 1.0 + k, (0.2 * i, 0.2 * j, 0.05 + 0.1 * k))
        for i in range(6)
        for j in range(6)
        for k in range(2)
    ]
    world = SceneWorld(Scene(bodies))
    advance(world, 3)
    many, alone = asked[-1], SceneWorld(Scene(bodies[:2]))
    assert many.contacts == 288
    assert (many.factor @ many.factor.T).toarray() == pytest.approx(many.G, abs=1e-12)
    ground = sum(touch.force[2] for touch in world.touches() if touch.other == "ground")
    assert ground == pytest.approx(36 * 3.0 * GRAVITY, rel=1e-6)
    advance(alone, 3)
    assert asked[-1].factor is None
