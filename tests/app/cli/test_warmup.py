"""`surefoot warmup` runs every command that compiles, leaves nothing behind, and says what it lacks."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli import commands, warmup
from surefoot.app.cli.main import main
from surefoot.base.compilation.numba_internals import KernelFiles


def test_its_commands_are_commands_and_leave_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answer: Any
) -> None:
    quick = tuple(words for words in warmup.COMMANDS if words.split()[0] not in ("stand", "walk", "plan"))
    assert {"stand", "walk", "plan"} == {words.split()[0] for words in {*warmup.COMMANDS} - {*quick}}
    monkeypatch.setattr(warmup, "COMMANDS", quick)
    monkeypatch.chdir(tmp_path)
    facts = answer("warmup")
    assert len(facts["tasks"]) == len(quick)
    assert facts["size"] > 0
    assert not any(row["skipped"] for row in facts["tasks"])
    assert Path.cwd() == tmp_path
    assert not list(tmp_path.iterdir())


def test_what_lacks_a_package_is_left_out_and_said(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from surefoot.base.errors import MissingExtra

    def lacking(*arguments: object, **options: object) -> None:
        raise MissingExtra("mujoco", "sim")

    monkeypatch.setattr(warmup, "COMMANDS", ("stand go2", "walk go2"))
    real = commands.tree()
    monkeypatch.setattr(
        commands, "tree", lambda: lambda args, **k: real(args=args, **k) if args == ["warmup"] else lacking()
    )
    assert main(["warmup"]) == 0
    assert capfd.readouterr().out.count("mujoco is not installed; run: pip install -e '.[sim]'") == 1


LOADED = """
import sys
from surefoot.app.cli.main import main
from surefoot.base.compilation import numba_internals as cache
main(["warmup", "--json"])
loaded = len(cache._caches)
for words in sys.argv[1:]:
    assert main([*words.split(), *"--no-video --no-report --json --out".split(), "runs"]) in (0, 1), words
    assert len(cache._caches) == loaded, (words, [c._name for c in cache._caches[loaded:]])
"""


@pytest.mark.long
def test_after_it_walks_and_plans_compile_nothing(tmp_path: Path) -> None:
    commands = (
        "walk g1 --velocity 0.3,0,0 --duration 1", "walk go2 --terrain-knowledge blind --duration 1",
        "walk go2 --terrain-knowledge map --terrain rough:2,0.04 --duration 1.5",
        "walk go2 --actuators real --collision full --duration 1 --push 0.6:0,100,0:0.1",
        "walk a1 --commands targets --dropout 0.5:0.05 --duration 1", "plan ball", "plan jump 0.4",
    )  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", LOADED, *commands], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]


OWN_LOOP = """
import mujoco
import surefoot as sf
from surefoot.app.cli.warmup import _record_a_loop, _step_a_loop
from surefoot.base.compilation import numba_internals as cache
_record_a_loop(), _step_a_loop()
loaded = len(cache._caches)
body = "<body pos='0 0 {z}'><freejoint/><geom type='box' size='.1 .1 .1'/></body>"
model = mujoco.MjModel.from_xml_string(
    "<mujoco><worldbody><geom type='plane' size='9 9 1'/>"
    + "".join(body.format(z=0.1 + 0.2 * k) for k in range(3)) + "</worldbody></mujoco>"
)
data = mujoco.MjData(model)
with sf.record(model, data) as log:
    for k in range(50):
        mujoco.mj_step(model, data)
        assert len(cache._caches) == loaded, ("record", [c._name for c in cache._caches[loaded:]])
sf.audit_log(log)
model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
stepper = sf.MujocoStepper(model)
for k in range(50):
    stepper.step(data)
    assert len(cache._caches) == loaded, ("step", [c._name for c in cache._caches[loaded:]])
"""


@pytest.mark.long
def test_after_it_a_recorded_loop_and_exact_steps_compile_nothing() -> None:
    """What `warmup` runs for them is all that another loop needs."""
    assert {"record", "step"} <= set(warmup.COMMANDS)
    done = subprocess.run([sys.executable, "-c", OWN_LOOP], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


def test_an_index_that_names_a_type_which_has_gone_is_that_of_older_code(tmp_path: Path) -> None:
    files = KernelFiles(str(tmp_path), "kernel", "now")
    (tmp_path / "kernel.nbi").write_bytes(pickle.dumps(files._version) + b"csurefoot.arrays\nGone\n.")
    assert files.load("types") is None
    files.save("types", 1)
    assert files._load_index().keys() == {"types"}


EPISODES = """
import numpy as np
import surefoot as sf
from surefoot.app.cli import warmup
from surefoot.app.cli.main import main
from surefoot.base.compilation import numba_internals as cache
warmup.COMMANDS = ("episodes",)
assert main(["warmup", "--json"]) == 0
loaded = len(cache._caches)
import mujoco
from surefoot.worlds.mujoco.episode.episode_audit import EpisodeAudit
model = mujoco.MjModel.from_xml_string(warmup.LOOP.format(integrator="Euler"))
data = mujoco.MjData(model)
audit = EpisodeAudit(mujoco, model, data)
audit.begin()
mujoco.mj_step(model, data, 300)
assert audit.finish()[0].verdicts == ("lawful",)
arrays = {"forces": np.full((300, 3, 4, 3), [0.0, 0.0, 9.0]), "gaps": np.zeros((300, 3, 4))}
sf.audit_batch({**arrays, "velocities": np.zeros((300, 3, 4, 3))}, dt=0.01, mu=0.6, mass=4.0)
assert len(cache._caches) == loaded, [c._name for c in cache._caches[loaded:]]
"""


@pytest.mark.long
def test_after_it_episodes_are_audited_without_a_kernel_more() -> None:
    """In a process of its own: what the audit of a loop and of arrays runs, has been loaded."""
    pytest.importorskip("mujoco")
    done = subprocess.run([sys.executable, "-c", EPISODES], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
