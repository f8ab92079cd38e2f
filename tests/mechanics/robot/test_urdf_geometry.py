"""Where a URDF's meshes are looked for, and which shapes are left where some are not there."""

from __future__ import annotations

from pathlib import Path

import pinocchio
import pytest

from surefoot.mechanics.robot.urdf_geometry import mesh_file, urdf_geometry

COLLISION, VISUAL = pinocchio.GeometryType.COLLISION, pinocchio.GeometryType.VISUAL
TETRAHEDRON = """solid t
{}endsolid t
""".format(
    "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners)
        + "endloop\nendfacet\n"
        for corners in (
            ((0, 0, 0), (0, 1, 0), (1, 0, 0)), ((0, 0, 0), (1, 0, 0), (0, 0, 1)),
            ((0, 0, 0), (0, 0, 1), (0, 1, 0)), ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        )
    )
)  # fmt: skip


def write(path: Path, text: str = TETRAHEDRON) -> Path:
    """Write a file and the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def test_a_mesh_is_found_beside_the_file_then_in_the_folders(tmp_path: Path) -> None:
    robot, packages = tmp_path / "robot" / "a.urdf", tmp_path / "packages"
    far = write(packages / "m" / "x.stl")
    assert mesh_file("m/x.stl", robot, [tmp_path, packages]) == far
    near = write(robot.parent / "m" / "x.stl")
    assert mesh_file("m/x.stl", robot, [packages]) == near
    assert mesh_file("m", robot, [packages]) is None  # a folder is no mesh
    assert mesh_file("m/y.stl", robot, [packages]) is None


@pytest.mark.parametrize("prefix", ["", "file://", "package://", "model://"])
def test_a_full_path_is_itself_or_nothing(prefix: str, tmp_path: Path) -> None:
    mesh = write(tmp_path / "x.stl")
    assert mesh_file(f"{prefix}{mesh}", Path("a.urdf"), []) == mesh
    assert mesh_file(f"{prefix}{mesh}.gone", Path("a.urdf"), [tmp_path]) is None


@pytest.mark.parametrize("scheme", ["package", "model"])
def test_a_package_is_found_by_its_folder_or_unpacked_up_to_three_folders_above(
    scheme: str, tmp_path: Path
) -> None:
    robot = tmp_path / "a" / "b" / "c" / "d" / "e" / "robot.urdf"
    word = f"{scheme}://dog/meshes/x.stl"
    write(tmp_path / "a" / "meshes" / "x.stl")
    assert mesh_file(word, robot, []) is None
    for above in ("a/b", "a/b/c", "a/b/c/d", "a/b/c/d/e"):
        mesh = write(tmp_path / above / "meshes" / "x.stl")
        found = mesh_file(word, robot, [])
        assert found is not None
        assert found.resolve() == mesh.resolve()
        mesh.unlink()
    own = write(tmp_path / "packages" / "dog" / "meshes" / "x.stl")
    write(robot.parent / "meshes" / "x.stl")
    assert mesh_file(word, robot, [tmp_path / "packages"]) == own
    assert mesh_file("meshes/dog/../y.stl", robot, []) is None


def test_a_package_s_name_alone_and_a_plain_path_are_not_unpacked(tmp_path: Path) -> None:
    robot = tmp_path / "sub" / "robot.urdf"
    write(tmp_path / "sub" / "x.stl")
    write(tmp_path / "y.stl")
    assert mesh_file("dog/x.stl", robot, []) is None
    assert mesh_file("package://y.stl", robot, []) is None
    assert mesh_file("package://dog/x.stl", robot, []) == tmp_path / "sub" / "x.stl"


def shape(tag: str, mesh: str) -> str:
    inner = f'<mesh filename="{mesh}"/>' if mesh else '<sphere radius="0.1"/>'
    return f"<{tag}><geometry>{inner}</geometry></{tag}>"


def robot_file(path: Path, first: str, second: str) -> Path:
    """Write a robot of two links, hip between them, with shapes."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    )
    return write(
        path,
        f'<robot name="r"><link name="a">{inertial}{first}</link><link name="b">{inertial}{second}</link>'
        '<joint name="hip" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="inf" velocity="1"/></joint></robot>',
    )


def names(path: Path, kind: object, folders: list[Path]) -> tuple[list[str], dict[str, list[str]]]:
    """Return the shapes that a file has, and the meshes that it lacks by link."""
    finite = path.with_name("finite.urdf")
    finite.write_text(path.read_text().replace('"inf"', '"9"'))
    model = pinocchio.buildModelFromUrdf(str(finite))
    geometry, missing = urdf_geometry(model, path, kind, folders)
    return sorted(str(item.name) for item in geometry.geometryObjects), missing


def test_a_missing_mesh_costs_its_own_shapes_alone(tmp_path: Path) -> None:
    write(tmp_path / "here.stl")
    first = shape("collision", "gone.stl") + shape("collision", "") + shape("collision", "gone.stl")
    second = shape("collision", "here.stl") + shape("collision", "lost.stl") + shape("collision", "gone.stl")
    path = robot_file(tmp_path / "r.urdf", first + shape("visual", "unseen.stl"), second)
    found, missing = names(path, COLLISION, [])
    assert found == ["a_0", "b_0"]
    assert missing == {"a": ["gone.stl"], "b": ["gone.stl", "lost.stl"]}
    assert names(path, VISUAL, []) == ([], {"a": ["unseen.stl"]})


def test_a_mesh_that_cannot_be_read_is_left_out_like_one_that_is_not_there(tmp_path: Path) -> None:
    write(tmp_path / "here.stl")
    write(tmp_path / "bad.obj", "no mesh")
    shapes = shape("collision", "here.stl") + shape("collision", "bad.obj")
    path = robot_file(tmp_path / "r.urdf", shapes, shape("collision", "") + shape("collision", "bad.obj"))
    found, missing = names(path, COLLISION, [])
    assert found == ["a_0", "b_0"]
    bad = str((tmp_path / "bad.obj").resolve())
    assert missing == {"a": [bad], "b": [bad]}


def test_a_whole_file_lacks_nothing(tmp_path: Path) -> None:
    write(tmp_path / "packages" / "dog" / "here.stl")
    own = robot_file(tmp_path / "r.urdf", shape("collision", "package://dog/here.stl"), "")
    text = own.read_text().replace('"inf"', '"9"')
    own.write_text(text)
    assert names(own, COLLISION, [tmp_path / "packages"]) == (["a_0"], {})


@pytest.mark.parametrize("text", ["<robot", "\udce4"])
def test_what_is_no_file_of_shapes_has_none(text: str, tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    geometry, missing = urdf_geometry(pinocchio.Model(), path, COLLISION, [])
    assert (geometry.ngeoms, missing) == (0, {})
