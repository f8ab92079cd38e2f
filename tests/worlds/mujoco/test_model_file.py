"""The binary model beside a recording: written once, as it was at the start, and read with care."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.worlds.mujoco.model_file import HEADER, read_model_file

mujoco = pytest.importorskip("mujoco")
BOX = (
    "<mujoco><worldbody><geom name='floor' type='plane' size='9 9 1' friction='{mu}'/>"
    "<body name='box' pos='0 0 .1'><freejoint/><geom name='skin' type='box' size='.1 .1 .1' "
    "friction='{mu}'/></body></worldbody></mujoco>"
)


def recorded(mu: float = 0.5, changed: float | None = None) -> Any:
    """Return a recording of ten steps of a box, whose loop changes its friction in the sixth."""
    model = mujoco.MjModel.from_xml_string(BOX.format(mu=mu))
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        for step in range(10):
            if changed is not None and step == 5:
                model.geom_friction[:, 0] = changed
            mujoco.mj_step(model, data)
    return log


def test_the_model_is_beside_the_log_as_it_was_at_the_start(tmp_path: Path) -> None:
    log = recorded(0.5, 0.9)
    assert log.save(tmp_path / "run.npz") == tmp_path / "run.npz"
    read = read_model_file(tmp_path / "run.mjb")
    assert read.geom_friction[:, 0].tolist() == [0.5, 0.5]
    assert sf.read_log(tmp_path / "run.npz").facts["source_version"] == mujoco.__version__
    assert log.save(tmp_path / "alone.npz", model=False).exists()
    assert not (tmp_path / "alone.mjb").exists()


def test_another_model_is_never_overwritten(tmp_path: Path) -> None:
    recorded().save(tmp_path / "run.mcap")
    recorded().save(tmp_path / "run.npz")  # the same model: it may stay
    (tmp_path / "run.npz").unlink()
    content = (tmp_path / "run.mjb").read_bytes()
    with pytest.raises(ProblemError, match=r"run\.mjb exists already, and holds another model"):
        recorded(0.7).save(tmp_path / "run")
    assert not (tmp_path / "run.npz").exists()
    assert (tmp_path / "run.mjb").read_bytes() == content


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda _: b"", "no binary model"),
        (lambda _: b"PK\3\4" + bytes(60), "no binary model"),
        (lambda good: good[: len(good) // 2], "damaged"),
        (lambda good: struct.pack("<4i", *HEADER.unpack(good[:16])[:3], 337) + good[16:], "another version"),
    ],
    ids=["empty", "archive", "cut", "version"],
)
def test_what_is_no_model_of_this_version_is_refused(tmp_path: Path, spoil: Any, said: str) -> None:
    recorded().save(tmp_path / "run.npz")
    path = tmp_path / "spoilt.mjb"
    path.write_bytes(spoil((tmp_path / "run.mjb").read_bytes()))
    with pytest.raises(ProblemError, match=said):
        read_model_file(path)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=r"none\.mjb cannot be read"):
        read_model_file(tmp_path / "none.mjb")


def test_states_go_to_the_order_of_mujoco_and_back() -> None:
    """A free body, a ball joint and a hinge, beside a body that is not the robot's."""
    from surefoot.worlds.mujoco.record_tree import BodyTree

    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='crate'><freejoint/><geom size='.1'/></body>"
        "<body name='trunk' pos='0 0 1'><freejoint/><geom size='.1'/><body><joint type='ball'/>"
        "<geom size='.1' pos='.2 0 0'/><body><joint name='knee'/><geom size='.1' pos='0 .2 0'/></body></body>"
        "</body></worldbody></mujoco>"
    )
    tree, rng = BodyTree(mujoco, model, "trunk"), np.random.default_rng(1)
    qpos, qvel = rng.normal(size=(4, model.nq)), rng.normal(size=(4, model.nv))
    for at in (3, 10, 14):
        qpos[:, at : at + 4] /= np.linalg.norm(qpos[:, at : at + 4], axis=1, keepdims=True)
    again, rates = np.zeros_like(qpos), np.zeros_like(qvel)
    again[:, tree.other_places], rates[:, tree.other_dofs] = qpos[:, :7], qvel[:, :6]
    tree.fill_mujoco(*tree.pinocchio(qpos, qvel), again, rates)
    np.testing.assert_allclose(again, qpos, atol=1e-12)
    np.testing.assert_allclose(rates, qvel, atol=1e-12)
