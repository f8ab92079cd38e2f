"""What a scene's file is given, told by viewers that stand in for rerun's and viser's own."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from surefoot.app.lab import scene_files
from surefoot.app.lab.drawing import Arrows, Ball, Label, Lines, Mesh, Shape
from surefoot.app.lab.scene_files import write_scene
from surefoot.base.errors import ProblemError

PLACE = (1.0, 2.0, 3.0)
FACES = np.array([[0, 1, 2]])
CORNERS = np.eye(3)


class Rerun(ModuleType):
    """A stand-in for rerun that keeps what is logged: (time, name, kind, what it is made of)."""

    def __init__(self) -> None:
        super().__init__("rerun")
        self.logged: list[tuple[float, str, str, dict[Any, Any]]] = []
        self.calls: list[tuple[Any, ...]] = []
        self.time = np.nan
        for kind in ("Mesh3D", "Transform3D", "LineStrips3D", "Arrows3D", "Points3D", "Clear", "Quaternion"):
            setattr(self, kind, self._kind(kind))

    def _kind(self, kind: str) -> Any:
        def make(*given: Any, **named: Any) -> SimpleNamespace:
            return SimpleNamespace(kind=kind, parts={**dict(enumerate(given)), **named})

        return make

    def RecordingStream(self, name: str) -> Any:
        self.calls.append(("stream", name))
        calls = {
            key: lambda *given, key=key: self.calls.append((key, *given))
            for key in ("save", "flush", "disconnect")
        }
        return SimpleNamespace(set_time=self._set_time, log=self._log, **calls)

    def _set_time(self, line: str, duration: float) -> None:
        assert line == "time"
        self.time = duration

    def _log(self, name: str, what: Any) -> None:
        self.logged.append((self.time, name, what.kind, what.parts))


Frames = list[tuple[float, Mapping[str, Shape]]]


def rerun_of(frames: Frames, monkeypatch: pytest.MonkeyPatch) -> Rerun:
    """Return what rerun is given of frames."""
    viewer = Rerun()
    monkeypatch.setitem(sys.modules, "rerun", viewer)
    monkeypatch.setattr(scene_files, "frames_of", lambda answer, robot, terrain: iter(frames))
    assert write_scene(None, Path("scene.rrd")) == Path("scene.rrd")
    return viewer


def mesh(**other: Any) -> Mesh:
    known: dict[str, Any] = {"vertices": CORNERS, "faces": FACES, "colour": (1, 2, 3)}
    return Mesh(**{**known, **other})


def test_a_recording_is_of_surefoot_in_its_file_and_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = rerun_of([], monkeypatch).calls
    assert calls == [("stream", "surefoot"), ("save", "scene.rrd"), ("flush",), ("disconnect",)]


def test_a_surface_is_logged_once_and_its_place_whenever_it_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    frames: Frames = [
        (0.0, {"/a": mesh(opacity=0.5)}),
        (0.1, {"/a": mesh(opacity=0.5)}),
        (0.2, {"/a": mesh(opacity=0.5, position=PLACE)}),
        (0.3, {"/a": mesh(opacity=0.5, position=PLACE, wxyz=(0.1, 0.2, 0.3, 0.4))}),
        (0.4, {"/a": mesh(colour=(9, 9, 9), position=PLACE, wxyz=(0.1, 0.2, 0.3, 0.4))}),
        (
            0.5,
            {"/a": mesh(vertices=2.0 * CORNERS, colour=(9, 9, 9), position=PLACE, wxyz=(0.1, 0.2, 0.3, 0.4))},
        ),
    ]
    logged = rerun_of(frames, monkeypatch).logged
    assert [(time, name, kind) for time, name, kind, _ in logged] == [
        (0.0, "/a", "Mesh3D"), (0.0, "/a", "Transform3D"), (0.2, "/a", "Transform3D"),
        (0.3, "/a", "Transform3D"), (0.4, "/a", "Mesh3D"), (0.5, "/a", "Mesh3D"),
    ]  # fmt: skip
    surface, place, _, turned, coloured, bent = (parts for *_, parts in logged)
    assert surface["albedo_factor"] == [1, 2, 3, 128]
    assert coloured["albedo_factor"] == [9, 9, 9, 255]
    np.testing.assert_array_equal(surface["vertex_positions"], CORNERS)
    np.testing.assert_array_equal(bent["vertex_positions"], 2.0 * CORNERS)
    np.testing.assert_array_equal(surface["triangle_indices"], FACES)
    assert place["translation"] == (0.0, 0.0, 0.0)
    assert place["quaternion"].parts == {"xyzw": [0.0, 0.0, 0.0, 1.0]}
    assert turned["translation"] == PLACE
    assert turned["quaternion"].parts == {"xyzw": [0.2, 0.3, 0.4, 0.1]}


def test_what_is_missing_from_a_frame_is_cleared_and_logged_anew_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    frames: Frames = [(0.0, {"/a": mesh()}), (0.1, {}), (0.2, {}), (0.3, {"/a": mesh()})]
    logged = rerun_of(frames, monkeypatch).logged
    assert [(time, kind) for time, _, kind, _ in logged] == [
        (0.0, "Mesh3D"), (0.0, "Transform3D"), (0.1, "Clear"), (0.3, "Mesh3D"), (0.3, "Transform3D"),
    ]  # fmt: skip
    assert logged[2][1] == "/a"
    assert logged[2][3] == {"recursive": True}


def test_lines_arrows_balls_and_labels_stand_where_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = np.array([[[0.0, 0.0, 1.0], [0.0, 0.5, 2.0]]])
    shapes: dict[str, Shape] = {
        "/lines": Lines(ends, (1, 2, 3)),
        "/arrows": Arrows(ends, (4, 5, 6), 0.02, PLACE),
        "/ball": Ball(np.array(PLACE), 0.3, (7, 8, 9)),
        "/label": Label(np.array(PLACE), "foot"),
    }
    lines, arrows, ball, label = rerun_of([(0.0, shapes)], monkeypatch).logged
    assert [kind for _, _, kind, _ in (lines, arrows, ball, label)] == [
        "LineStrips3D", "Arrows3D", "Points3D", "Points3D",
    ]  # fmt: skip
    np.testing.assert_array_equal(lines[3][0], ends)
    assert lines[3]["colors"] == [(1, 2, 3)]
    np.testing.assert_array_equal(arrows[3]["origins"], [[1.0, 2.0, 4.0]])
    np.testing.assert_array_equal(arrows[3]["vectors"], [[0.0, 0.5, 1.0]])
    assert (arrows[3]["colors"], arrows[3]["radii"]) == ([(4, 5, 6)], [0.02])
    np.testing.assert_array_equal(ball[3][0], [PLACE])
    assert (ball[3]["radii"], ball[3]["colors"]) == ([0.3], [(7, 8, 9)])
    np.testing.assert_array_equal(label[3][0], [PLACE])
    assert label[3]["labels"] == ["foot"]
    assert 0.0 < label[3]["radii"][0] < 0.01


def test_a_scene_that_fails_leaves_no_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "scene.rrd"
    path.write_text("half")

    def frames() -> Iterator[Any]:
        yield 0.0, {}
        raise ProblemError("no more")

    monkeypatch.setitem(sys.modules, "rerun", Rerun())
    monkeypatch.setattr(scene_files, "frames_of", lambda *_: frames())
    with pytest.raises(ProblemError, match="no more"):
        write_scene(None, path)
    assert not path.exists()
    with pytest.raises(ProblemError, match="no more"):
        write_scene(None, path)  # where there is none, as well


class Viser(ModuleType):
    """A stand-in for viser: what is shown and waited for, in order."""

    def __init__(self) -> None:
        super().__init__("viser")
        self.calls: list[Any] = []
        record = SimpleNamespace(
            insert_sleep=lambda time: self.calls.append(round(time, 9)), serialize=lambda: b"scene"
        )

        def server(**options: Any) -> Any:
            self.calls.append(options)
            stop = lambda: self.calls.append("stop")  # noqa: E731
            return SimpleNamespace(get_scene_serializer=lambda: record, scene=None, stop=stop)

        self.ViserServer = server


def viser_of(frames: Any, path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Write frames by a stand-in for viser and return its calls."""
    from surefoot.app.lab import canvas

    viewer = Viser()

    class Canvas:
        def __init__(self, scene: Any, held: Any) -> None:
            assert held("/a", None) is None

        def show(self, shapes: Any) -> None:
            viewer.calls.append(shapes)

    monkeypatch.setitem(sys.modules, "viser", viewer)
    monkeypatch.setattr(canvas, "Canvas", Canvas)
    monkeypatch.setattr(scene_files, "frames_of", lambda *_: iter(frames))
    try:
        write_scene(None, path)
    except ProblemError:
        viewer.calls.append("failed")
    return viewer.calls


def test_viser_waits_from_each_frame_to_the_next_and_is_stopped(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("viser", reason="the canvas draws with it")
    frames = [(0.0, {"a": 1}), (0.5, {"b": 2}), (0.5, {"c": 3}), (0.75, {"d": 4})]
    calls = viser_of(frames, tmp_path / "scene.viser", monkeypatch)
    assert calls[1:] == [{"a": 1}, 0.5, {"b": 2}, {"c": 3}, 0.25, {"d": 4}, "stop"]
    assert calls[0] == {"host": "127.0.0.1", "port": 0, "verbose": False}  # heard by nobody else
    assert (tmp_path / "scene.viser").read_bytes() == b"scene"
    late = viser_of([(0.2, {"a": 1})], tmp_path / "late.viser", monkeypatch)
    assert late[1:] == [0.2, {"a": 1}, "stop"]


def test_viser_is_stopped_where_a_scene_fails(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("viser", reason="the canvas draws with it")

    def frame(number: int) -> Any:
        raise ProblemError(f"no frame {number}")

    assert viser_of(map(frame, range(2)), tmp_path / "scene.viser", monkeypatch)[1:] == ["stop", "failed"]
