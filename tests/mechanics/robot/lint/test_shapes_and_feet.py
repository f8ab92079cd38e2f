"""Rules on shapes and feet, each at the border of what it takes for a fault, on shapes of coal."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import coal
import numpy as np
import pinocchio
import pytest
from scipy.spatial.transform import Rotation

from surefoot.mechanics.robot.lint.facts import ShapeFacts
from surefoot.mechanics.robot.lint.shapes import largest_size, lowest_point, vertices
from tests.mechanics.robot.lint.facts_by_hand import joint, link, offences, places, subject

TURN = Rotation.from_euler("xyz", [0.4, -0.7, 1.1]).as_matrix()


def surface(kind: str) -> tuple[Any, np.ndarray]:
    """Return a shape of coal and many points of its surface."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 361), np.linspace(0, np.pi, 181))
    ball = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1).reshape(-1, 3)
    ends = np.array([0.0, 0.0, 0.25])
    signs = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(-1, 3)
    ring = np.column_stack([0.1 * np.cos(u[0]), 0.1 * np.sin(u[0]), 0.0 * u[0]])
    return {
        "sphere": (coal.Sphere(0.1), 0.1 * ball),
        "box": (coal.Box(0.2, 0.4, 0.6), signs * [0.1, 0.2, 0.3]),
        "ellipsoid": (coal.Ellipsoid(0.1, 0.2, 0.3), ball * [0.1, 0.2, 0.3]),
        "capsule": (coal.Capsule(0.1, 0.5), np.vstack([0.1 * ball + ends, 0.1 * ball - ends])),
        "cylinder": (coal.Cylinder(0.1, 0.5), np.vstack([ring + ends, ring - ends])),
    }[kind]


@pytest.mark.parametrize("kind", ["sphere", "box", "ellipsoid", "capsule", "cylinder"])
def test_the_lowest_point_is_that_of_the_surface(kind: str) -> None:
    shape, points = surface(kind)
    for turn in (TURN, TURN @ TURN, Rotation.from_euler("x", np.pi - 0.3).as_matrix()):
        place = pinocchio.SE3(turn, np.array([3.0, 2.0, 1.5]))
        lowest = (points @ turn.T)[:, 2].min() + 1.5
        assert lowest_point(shape, place) == pytest.approx(lowest, abs=4e-5)
    assert largest_size(shape) == pytest.approx(np.ptp(points, axis=0).max(), abs=4e-5)
    assert vertices(shape) is None


def test_a_mesh_reaches_as_low_as_its_vertices_and_a_plane_nowhere() -> None:
    corners = np.random.default_rng(0).normal(size=(5, 3))
    place = pinocchio.SE3(TURN, np.array([3.0, 2.0, 1.5]))
    for listed in (lambda: corners, corners):
        mesh = SimpleNamespace(num_vertices=5, vertices=listed, vertex=lambda k: corners[k])
        if not callable(listed):
            del mesh.vertices
        assert lowest_point(mesh, place) == pytest.approx((corners @ TURN.T)[:, 2].min() + 1.5)
    assert lowest_point(SimpleNamespace(num_vertices=0, vertices=lambda: np.zeros((0, 3))), place) is None
    assert lowest_point(coal.Halfspace(), place) is None


@pytest.mark.parametrize(
    ("format", "collides", "of_foot", "described", "severity", "what"),
    [
        ("urdf", True, False, False, "", "its collision shape is left out"),
        ("urdf", False, True, False, "note", "it is not drawn"),
        ("urdf", True, True, False, "error", "its collision shape is left out"),
        ("urdf", True, True, True, "", "its collision shape is left out"),
        ("mjcf", False, False, True, "error", "MuJoCo refuses the file without it"),
    ],
)
def test_a_missing_mesh_is_as_grave_as_what_it_is_for(
    format: str, collides: bool, of_foot: bool, described: bool, severity: str, what: str
) -> None:
    shapes = [
        ShapeFacts("calf", "mesh", (1.0, 1.0, 1.0), collides, "x.stl"),
        ShapeFacts("calf", "mesh", (1.0, 1.0, 1.0), collides, "y.stl", Path("y.stl")),
        ShapeFacts("calf", "box", (1.0, 1.0, 1.0), collides),
    ]
    robot = SimpleNamespace(foot_names=["calf" if of_foot else "foot"])
    about = subject(format=format, shapes=shapes, robot=robot, described=described)
    assert offences("mesh-missing", about) == [("link calf", "x.stl", f"no such file; {what}", severity)]
    if not of_foot:
        about.robot = None
        assert len(offences("mesh-missing", about)) == 1


@pytest.mark.parametrize(
    ("kind", "size", "value", "severity"),
    [
        ("box", (0.0, 1.0, 1.0), "box (0, 1, 1)", "error"),
        ("box", (1.0, -1.0, 1.0), "box (1, -1, 1)", "error"),
        ("box", (1.0, 1.0, 1.0), "", ""), ("mesh", (1.0, -1.0, 1.0), "", ""),
        ("mesh", (1.0, 0.0, 1.0), "mesh scale (1, 0, 1)", "error"),
        ("sphere", (0.0,), "sphere (0)", "warning"),
        ("sphere", (-1.0,), "sphere (-1)", "error"), ("box", (math.nan, 0.0, 1.0), "", ""),
    ],
)  # fmt: skip
def test_sizes_are_above_zero(kind: str, size: tuple[float, ...], value: str, severity: str) -> None:
    """Scales of meshes may mirror them, and a sphere of nothing is a point in a URDF."""
    why = "some engines take it for a point, others refuse it" if severity == "warning" else "no shape has it"
    for collides, told in ((True, severity), (False, "warning")):
        shapes = [ShapeFacts("calf", kind, size, collides)]
        found = [("link calf", value, why, told)] * bool(value)
        assert offences("shape-empty", subject(shapes=shapes)) == found
        if severity == "warning" and collides:
            (other,) = offences("shape-empty", subject(shapes=shapes, format="mjcf"))
            assert other[2:] == ("no shape has it", "error")


def test_a_shape_twenty_times_the_reach_is_in_millimetres() -> None:
    """Beside a reach of 0.5 m."""
    shapes = [
        ShapeFacts("a", "box", (1.0, 10.1, 1.0), True), ShapeFacts("b", "box", (1.0, 9.9, 1.0), True),
        ShapeFacts("c", "box", (1.0, 10.1, 1.0), False), ShapeFacts("d", "mesh", (99.0,), True),
        ShapeFacts("e", "plane", (99.0,), True), ShapeFacts("f", "box", (math.inf,), True),
        ShapeFacts("g", "box", (), True),
    ]  # fmt: skip
    joints, links = [joint("neck", length=0.5, child="head")], [link("head")]
    why = "20.2 times the reach of the robot; is it in millimetres?"
    assert offences("shape-unlike-robot", subject(joints, links, shapes=shapes)) == [
        ("link a", "box of 10.1 m", why, ""), ("link c", "box of 10.1 m", why, "warning"),
    ]  # fmt: skip
    assert not offences("shape-unlike-robot", subject(shapes=shapes))


def chain(*places: tuple[Any, int, float], joints: int = 6) -> Any:
    """Return a robot of joints in a row at the origin, with (shape, joint, height) each on a frame."""
    model = pinocchio.Model()
    above = 0
    for k in range(joints):
        above = model.addJoint(above, pinocchio.JointModelRY(), pinocchio.SE3.Identity(), f"j{k + 1}")
        frame = pinocchio.Frame(f"l{k + 1}", above, 0, pinocchio.SE3.Identity(), pinocchio.FrameType.BODY)
        model.addFrame(frame)
    geometry = pinocchio.GeometryModel()
    for k, (shape, of, height) in enumerate(places):
        place = pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, height]))
        frame = model.getFrameId(f"l{of}") if of else 0
        geometry.addGeometryObject(pinocchio.GeometryObject(f"s{k}", of, frame, place, shape))
    return SimpleNamespace(
        model=model, data=model.createData(), nominal=np.zeros(joints), collision=geometry, floating=True,
        feet=[],
    )  # fmt: skip


NECK = ([joint("neck", length=0.5, child="head")], [link("head")])
"""A joint and a link that make a reach of half a metre."""


@pytest.mark.parametrize(
    ("first", "second", "depth", "found"),
    [
        (1, 5, 6e-3, True), (1, 5, 4e-3, False), (1, 4, 6e-3, False), (5, 1, 6e-3, True), (1, 6, 6e-3, True),
        (0, 5, 6e-3, False), (2, 2, 6e-3, False),
    ],
)  # fmt: skip
def test_links_more_than_three_joints_apart_are_not_in_each_other(
    first: int, second: int, depth: float, found: bool
) -> None:
    """Balls of 0.1 m: a hundredth of the reach is 5 mm."""
    robot = chain((coal.Sphere(0.1), first, 0.0), (coal.Sphere(0.1), second, 0.2 - depth))
    told = [(f"links of j{first} and j{second}", "6 mm deep", "in each other in the nominal pose", "")]
    assert offences("self-collision", subject(*NECK, robot=robot)) == told * found


def test_the_deepest_of_two_links_shapes_is_told() -> None:
    balls = [(coal.Sphere(0.1), 1, 0.0), (coal.Sphere(0.1), 6, 0.19), (coal.Sphere(0.1), 6, 0.17)]
    for places_ in (balls, balls[::-1]):
        (found,) = offences("self-collision", subject(*NECK, robot=chain(*places_)))
        assert found[1] == "30 mm deep"
    assert not offences("self-collision", subject(*NECK))
    branch = chain((coal.Sphere(0.1), 1, 0.0), (coal.Sphere(0.1), 2, 0.1), joints=2)
    assert not offences("self-collision", subject(*NECK, robot=branch))


@pytest.mark.parametrize(
    ("height", "of_foot", "described", "severity"),
    [
        (0.094, False, False, "warning"), (0.096, False, False, None), (0.094, True, False, ""),
        (0.094, True, True, "warning"),
    ],
)  # fmt: skip
def test_a_shape_five_millimetres_below_the_ground_is_in_it(
    height: float, of_foot: bool, described: bool, severity: str | None
) -> None:
    robot = chain((coal.Sphere(0.1), 3, height), (coal.Sphere(0.1), 3, 0.3), (coal.Sphere(0.1), 0, 0.0))
    robot.feet = [SimpleNamespace(frame=robot.model.getFrameId("l3" if of_foot else "l5"))]
    robot.sphere_bottoms = lambda q: pinocchio.forwardKinematics(robot.model, robot.data, q)
    about = subject(*NECK, robot=robot, described=described)
    why = "in the nominal pose, in which the feet stand on it"
    told = [("link l3", "6 mm in the ground", why, severity)] * (severity is not None)
    assert offences("body-in-ground", about) == told
    for key, value in (("floating", False), ("feet", [])):
        about.robot = SimpleNamespace(**(vars(robot) | {key: value}))
        assert not offences("body-in-ground", about)


def feet(*given: tuple[str, float, float, bool]) -> Any:
    """Return a robot with feet of a name, a radius, a height, and flat or not, of two spheres each."""
    each = [
        SimpleNamespace(name=n, size=(r, r), radius=r, flat=flat, centres=[0, 1], size_words=f"radius {r:g}")
        for n, r, _, flat in given
    ]
    heights = [z for *_, low, _ in given for z in (low + 0.01, low)]
    return SimpleNamespace(feet=each, floating=True, nominal=None, sphere_bottoms=lambda q: heights)


@pytest.mark.parametrize(
    ("radius", "flat", "severity"),
    [(0.0222, False, ""), (0.0218, False, None), (0.02, True, "error"), (0.0222, True, "error")],
)
def test_a_foot_differs_from_its_twin_by_a_tenth(radius: float, flat: bool, severity: str | None) -> None:
    """And by 0.1 mm more."""
    robot = feet(("left", 0.02, 0.0, False), ("middle", 0.5, 0.0, True), ("right", radius, 0.0, flat))
    told = [("foot right", f"radius {radius:g}", "left has radius 0.02", severity)] * (severity is not None)
    assert offences("feet-differ", subject(*NECK, robot=robot)) == told
    robot.feet = robot.feet[2:]
    assert not offences("feet-differ", subject(*NECK, robot=robot))


@pytest.mark.parametrize(
    ("height", "value"),
    [(0.011, "11 mm above the others"), (0.009, ""), (-0.011, "11 mm below the others"), (-0.009, "")],
)
def test_a_foot_ten_millimetres_off_the_others_does_not_stand(height: float, value: str) -> None:
    robot = feet(("a", 0.02, 0.0, False), ("b", 0.02, 0.0, False), ("c", 0.02, height, False))
    told = [("foot c", value, "in the nominal pose, in which all should stand", "")] * bool(value)
    assert offences("feet-differ", subject(*NECK, robot=robot)) == told
    robot.floating = False
    assert not offences("feet-differ", subject(*NECK, robot=robot))


def test_small_robots_feet_are_measured_by_their_reach() -> None:
    """A fiftieth of a reach of 0.1 m is 2 mm, twice that 4 mm."""
    small = ([joint("neck", length=0.1, child="head")], [link("head")])
    robot = feet(("a", 0.02, 0.0, False), ("b", 0.02, 0.0, False), ("c", 0.02, 4.1e-3, False))
    assert places("feet-differ", subject(*small, robot=robot)) == ["foot c"]


def test_a_floating_robot_without_feet_is_told_of_its_first_eight_ends() -> None:
    robot, ends = SimpleNamespace(floating=True, feet=[]), [f"e{k}" for k in range(9)]
    why = "rules on feet and legs did not run; its limbs end in e0, e1, e2, e3, e4, e5, e6, e7"
    assert offences("feet-unknown", subject(robot=robot, ends=ends)) == [("robot", "no feet named", why, "")]
    for quiet in (None, SimpleNamespace(floating=False, feet=[]), SimpleNamespace(floating=True, feet=["a"])):
        assert not offences("feet-unknown", subject(robot=quiet))
