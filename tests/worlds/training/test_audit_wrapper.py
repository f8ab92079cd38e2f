"""Wrapped environments of gymnasium: the same to the last bit, every episode audited, no lie among them."""

from __future__ import annotations

import copy
import gc
import pickle
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.records import BatchReport
from surefoot.worlds.mujoco.episode.contact_recorder import ContactRecorder
from surefoot.worlds.training.episode_info import info_of

gymnasium = pytest.importorskip("gymnasium")
mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.filterwarnings("ignore:.*:DeprecationWarning", "ignore::UserWarning")
BALL = (
    "<mujoco><option timestep='.002'/><worldbody><geom type='plane' size='5 5 1'/>"
    "<body pos='0 0 {height}'><freejoint/><geom name='skin' size='.1' mass='1'/></body></worldbody></mujoco>"
)
KEYS = {
    "verdict", "reason", "broken", "exploit", "share", "worst", "limit", "instant", "contact", "paid", "rows",
    "rate",
}  # fmt: skip


class Ball(gymnasium.Env):  # type: ignore[misc]
    """A ball that rests on the ground, or what a test makes of it; an episode has `length` steps."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (13,), np.float64)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)

    def __init__(self, length: int = 20, height: float = 0.1, how: str = "python") -> None:
        self.model = mujoco.MjModel.from_xml_string(BALL.format(height=height))
        self.data = mujoco.MjData(self.model)
        self.length, self.how, self.count = length, how, 0

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)
        self.count = 0
        return self._seen(), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.count += 1
        if self.how == "c":
            from mujoco import rollout

            state = np.zeros(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
            mujoco.mj_getState(self.model, self.data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
            rollout.rollout(self.model, self.data, state[None], nstep=5)
        elif self.how == "halves":
            for _ in range(5):
                mujoco.mj_step1(self.model, self.data)
                mujoco.mj_step2(self.model, self.data)
        else:
            mujoco.mj_step(self.model, self.data, nstep=5)
        if self.how == "nan" and self.count == 10:
            self.data.qvel[0] = np.nan
        return self._seen(), 1.0, self.count >= self.length, False, {}

    def _seen(self) -> Any:
        return np.concatenate([self.data.qpos, self.data.qvel])


def audits(env: Any, episodes: int = 1, seed: int = 0) -> list[dict[str, Any]]:
    """Return what is told of some episodes under random actions."""
    env.action_space.seed(seed)
    env.reset(seed=seed)
    out: list[dict[str, Any]] = []
    while len(out) < episodes:
        *_, terminated, truncated, info = env.step(env.action_space.sample())
        if terminated or truncated:
            out.append(info["audit"])
            assert "audit" not in env.reset()[1]
        else:
            assert "audit" not in info
    return out


@pytest.mark.parametrize("name", ["Ant-v5", "Humanoid-v5", "Hopper-v5", "Walker2d-v5", "HalfCheetah-v5"])
def test_results_are_those_of_the_plain_environment_to_the_last_bit(name: str) -> None:
    """Observations, rewards, ends, infos and the whole state, over several episodes."""
    plain, wrapped = gymnasium.make(name), sf.rl.AuditWrapper(gymnasium.make(name))
    plain.action_space.seed(3)
    assert np.array_equal(plain.reset(seed=3)[0], wrapped.reset(seed=3)[0])
    for _ in range(150):
        action = plain.action_space.sample()
        one, two = plain.step(action), wrapped.step(action)
        assert np.array_equal(one[0], two[0])
        assert one[1:4] == two[1:4]
        told = two[4].pop("audit", None)
        assert one[4].keys() == two[4].keys()
        assert all(np.array_equal(one[4][key], two[4][key]) for key in one[4])
        states = []
        for env in (plain, wrapped):
            core, spec = env.unwrapped, mujoco.mjtState.mjSTATE_INTEGRATION
            states.append(np.zeros(mujoco.mj_stateSize(core.model, spec)))
            mujoco.mj_getState(core.model, core.data, states[-1], spec)
        assert np.array_equal(*states)
        if one[2] or one[3]:
            assert set(told) == KEYS
            assert told["rate"] == pytest.approx(1.0)
            assert np.array_equal(plain.reset()[0], wrapped.reset()[0])
    wrapped.close()


@pytest.mark.parametrize("name", ["Humanoid-v5", "Walker2d-v5"])
def test_what_is_proven_is_what_the_audit_says(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Forty episodes, once by the proof where it holds, once by the audit's own functions alone."""
    kept: list[BatchReport] = []

    def told(report: BatchReport, rate: float) -> dict[str, Any]:
        kept.append(report)
        return info_of(report, rate)

    monkeypatch.setattr("surefoot.worlds.training.audit_wrapper.info_of", told)
    env = sf.rl.AuditWrapper(gymnasium.make(name))
    fast = audits(env, 40)
    monkeypatch.setattr(ContactRecorder, "prove", lambda *_: None)
    slow = audits(env, 40)
    for one, two in zip(fast, slow, strict=True):
        assert {key: str(one[key]) for key in KEYS} == {key: str(two[key]) for key in KEYS}
    assert {"lawful"} < {one["verdict"] for one in fast}
    thrown = 0
    for mine, audited in zip(kept[:40], kept[40:], strict=True):
        assert [one.name for one in mine.exploits] == [one.name for one in audited.exploits]
        assert [one.reward for one in mine.exploits] == pytest.approx(
            [one.reward for one in audited.exploits]
        )
        for sign in ("throw", "spike"):
            a, b = mine.laws[sign], audited.laws[sign]
            for part in ("share", "worst", "limit", "instant", "contact"):
                where = (sign, part)
                assert getattr(a, part) == pytest.approx(getattr(b, part), rel=1e-9, nan_ok=True), where
        thrown += bool(mine.laws["throw"].share[0] > 0.0 and not mine.kept)
    assert thrown > 3  # told by the proof


def test_every_substep_is_a_row_however_it_is_made() -> None:
    """Rows, rate and verdict of a ball that rests."""
    for how in ("python", "halves"):
        told = audits(sf.rl.AuditWrapper(Ball(how=how)))[0]
        assert told["verdict"] == "lawful", how
        assert told["rows"] == 100
        assert told["rate"] == pytest.approx(1.0)


def test_steps_that_c_makes_are_told_as_a_rate() -> None:
    """One of five is judged, and the episode is never called lawful."""
    told = audits(sf.rl.AuditWrapper(Ball(how="c")))[0]
    assert told["rate"] == pytest.approx(0.2)
    assert told["rows"] == 20
    assert told["verdict"] == "cannot tell"
    assert "missing" in told["reason"]


def test_a_state_that_is_lost_is_no_lawful_episode() -> None:
    """MuJoCo resets what is not finite: the episode says so."""
    told = audits(sf.rl.AuditWrapper(Ball(how="nan")))[0]
    assert told["verdict"] != "lawful"
    assert "reset" in told["reason"] or told["broken"]


def test_an_episode_that_is_given_up_is_audited_by_the_reset() -> None:
    """And one that has not begun is not, however often it is reset."""
    env = sf.rl.AuditWrapper(Ball())
    assert "audit" not in env.reset()[1]
    assert "audit" not in env.reset()[1]
    for _ in range(7):
        env.step(np.zeros(1))
    told = env.reset()[1]["audit"]
    assert (told["verdict"], told["rows"]) == ("lawful", 35)
    assert "audit" not in env.reset()[1]


def test_truncation_ends_an_episode() -> None:
    """A time limit inside the wrapper; one outside shows at the reset."""
    told = audits(sf.rl.AuditWrapper(gymnasium.wrappers.TimeLimit(Ball(length=10**6), 12)))[0]
    assert told["rows"] == 60
    env = gymnasium.wrappers.TimeLimit(sf.rl.AuditWrapper(Ball(length=10**6)), 12)
    env.reset()
    while not env.step(np.zeros(1))[3]:
        pass
    assert env.reset()[1]["audit"]["rows"] == 60


def test_nothing_touches_and_too_few_rows() -> None:
    """One cannot tell, and why."""
    assert audits(sf.rl.AuditWrapper(Ball(height=50.0)))[0]["reason"] == "nothing ever touches"
    told = audits(sf.rl.AuditWrapper(gymnasium.make("InvertedPendulum-v5")))[0]
    assert told["verdict"] == "cannot tell"


def test_a_law_that_is_broken_is_named_with_its_share_of_the_return() -> None:
    """A ball on ground without damping gains energy from it: MuJoCo's own touches give back more."""
    env = sf.rl.AuditWrapper(Ball(length=200, height=0.4))
    env.unwrapped.model.geom_solref[:] = [-20000.0, -0.0]
    env.unwrapped.model.opt.timestep = 0.004
    told = audits(env)[0]
    assert told["broken"] == "restitution"
    assert told["exploit"] == "energy from touches"
    assert told["contact"] == "skin"
    assert 0.0 < told["paid"] < 1.0
    assert told["worst"] > told["limit"] > 0.0
    assert env.report.log(0)["forces"].shape == (1000, 1, 3)
    assert "restitution" in sf.audit_log(env.report.log(0)).laws_broken


def test_long_episodes_are_judged_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory is bounded, and nothing is lost."""
    monkeypatch.setattr("surefoot.worlds.mujoco.episode.contact_recorder.MEMORY", 1)
    env = sf.rl.AuditWrapper(Ball(length=400))
    told = audits(env)[0]
    assert (told["verdict"], told["rows"]) == ("lawful", 2000)
    assert env.report.episodes > 1


@pytest.mark.parametrize("mode", list(gymnasium.vector.AutoresetMode))
@pytest.mark.parametrize("workers", ["sync", "async"])
def test_vector_environments_in_all_their_modes(workers: str, mode: Any) -> None:
    """Each environment's audit at the end of each of its episodes, by its own mask, and at no other time."""
    makers = [lambda n=n: sf.rl.AuditWrapper(Ball(length=n)) for n in (6, 9)]
    kind = gymnasium.vector.SyncVectorEnv if workers == "sync" else gymnasium.vector.AsyncVectorEnv
    envs = kind(makers, autoreset_mode=mode)
    envs.reset(seed=0)
    found: list[tuple[int, int]] = []
    for _ in range(20):
        *_, ended, _, infos = envs.step(envs.action_space.sample())
        told = infos.get("final_info", infos) if mode.value == "SameStep" else infos
        mask = told.get("_audit", np.zeros(2, dtype=bool))
        assert np.array_equal(mask, ended)
        for k in np.flatnonzero(mask).tolist():
            assert told["audit"]["verdict"][k] == "lawful"
            found.append((k, int(told["audit"]["rows"][k])))
        if mode.value == "Disabled" and ended.any():
            envs.reset(options={"reset_mask": ended})
    envs.close()
    assert set(found) == {(0, 30), (1, 45)}
    assert len(found) >= 4


def test_a_vector_environment_is_wrapped_where_it_stands() -> None:
    """Synchronous ones are; workers are told how it is done."""
    envs = gymnasium.vector.SyncVectorEnv([lambda: Ball(length=5)] * 2)
    assert sf.rl.AuditWrapper(envs) is envs
    envs.reset()
    for _ in range(5):
        infos = envs.step(envs.action_space.sample())[-1]
    assert infos["_audit"].all()
    envs.close()
    other = gymnasium.vector.AsyncVectorEnv([lambda: Ball(length=5)] * 2)
    with pytest.raises(sf.SurefootError, match="wrappers="):
        sf.rl.AuditWrapper(other)
    other.close()


def test_copies_and_pickles_watch_their_own_data() -> None:
    """A copy in the middle of an episode has not seen its beginning, and says so."""
    env = sf.rl.AuditWrapper(Ball())
    env.reset()
    for _ in range(5):
        env.step(np.zeros(1))
    for twin in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert twin.unwrapped.data is not env.unwrapped.data
        for _ in range(15):
            *_, done, _, info = twin.step(np.zeros(1))
        assert done
        assert (info["audit"]["verdict"], info["audit"]["rows"]) == ("cannot tell", 75)
        assert "first steps" in info["audit"]["reason"]
        twin.close()
    for _ in range(15):
        info = env.step(np.zeros(1))[-1]
    assert (info["audit"]["verdict"], info["audit"]["rows"]) == ("lawful", 100)


@pytest.mark.long
def test_closed_environments_leave_mujocos_functions_as_they_were() -> None:
    """The last one puts them back; a recording beside it is none the worse."""
    gc.collect()  # environments of other tests
    before = mujoco.mj_step
    one, two = sf.rl.AuditWrapper(Ball()), sf.rl.AuditWrapper(Ball())
    assert mujoco.mj_step is not before
    core = one.unwrapped
    with sf.record(core.model, core.data) as log:
        told = audits(one)[0]
    assert told["rows"] == 100 == len(log)
    one.close()
    assert mujoco.mj_step is not before
    two.close()
    two.close()
    assert mujoco.mj_step is before


def test_what_is_no_mujoco_environment_is_one_line() -> None:
    """It says what it takes."""
    with pytest.raises(sf.SurefootError, match=r"AuditWrapper takes an environment with MuJoCo's \.model"):
        sf.rl.AuditWrapper(gymnasium.make("CartPole-v1"))
