"""Wrong input on purpose, to every command: one line that names it, exit code 2, nothing written."""

from __future__ import annotations

import importlib.util
import shlex
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.tosses import write_tosses
from surefoot.app.cli.main import main
from surefoot.contact.problem import ContactProblem
from surefoot.motion.planning.planner import task_names
from surefoot.records.identification.tosses import Cube, Tosses
from surefoot.records.log.reading import read_log

STANCE = Path(__file__).parents[3] / "examples" / "stances" / "slope.yaml"
LINK = "<link name='b'><inertial><mass value='{}'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>"
BROKEN = {
    "cut.urdf": "<robot name='a'><link name='b'/><joint",
    "twice.urdf": "<robot name='a'><link name='b'/><link name='b'/></robot>",
    "sdf.urdf": "<?xml version='1.0'?><sdf/>",
    "weightless.urdf": "<robot name='a'><link name='b'/></robot>",
    "words.urdf": f"<robot name='a'>{LINK.format('heavy')}</inertial></link></robot>",
    "negative.urdf": f"<robot name='a'>{LINK.format('-3')}</inertial></link></robot>",
    "crossed.urdf": f"<robot name='a'>{LINK.format(1)}</inertial></link><link name='c'/><joint name='hip' "
    "type='revolute'><parent link='b'/><child link='c'/><axis xyz='0 0 1'/><limit lower='1' upper='-1' "
    "effort='1' velocity='1'/></joint></robot>",
    "empty.urdf": "",
}
BOTH = ("stand solo12 --no-video", "walk solo12 --no-video")
NOT_FINITE = ("nan", "inf", "-inf", "-1")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with files that are not what they are taken for."""
    place = tmp_path_factory.mktemp("wrong")
    for name, text in BROKEN.items():
        (place / name).write_text(text)
    (place / "folder").mkdir()
    (place / "folder.npz").mkdir()
    (place / "noise.dat").write_bytes(np.random.default_rng(0).bytes(400))
    (place / "empty.npz").write_bytes(b"")
    (place / "stance.yaml").write_text(STANCE.read_text())
    (place / "list.yaml").write_text("- 1\n- 2\n")
    (place / "nothing.json").touch()
    (place / "drops.yaml").write_text((STANCE.parents[1] / "sweeps" / "drops.yaml").read_text())
    (place / "loss.yaml").write_text("torque_loss: 0.5\n")
    text = "mass: {}\ncom: [0, 0, 0.4]\nmu: {}\ncontacts:\n  - {{name: a, position: [0, 0, 0]}}\n"
    (place / "heavy.yaml").write_text(text.format("1.0e+300", 0.5))
    (place / "nan.yaml").write_text(text.format(".nan", 0.5))
    (place / "sticky.yaml").write_text(text.format(10, 5000))
    (place / "true.yaml").write_text(text.format("true", 0.5))
    (place / "quoted.yaml").write_text(text.format("'10'", 0.5))
    (place / "typo.yaml").write_text(text.replace("mass", "mas").format(10, 0.5))
    (place / "twice.json").write_text('{"format": 1, "format": 2}')
    states = np.zeros((80, 13))
    states[:, 6] = 1.0
    for name, count, side in (("tosses", 8, 0.05), ("other", 8, 0.06), ("few", 2, 0.05)):
        starts = np.arange(count + 1) * 10
        cube = Cube(half_side=side)
        write_tosses(Tosses(states[: 10 * count], starts, 0.01, cube=cube), place / f"{name}.npz")
    sf.write_problem(ContactProblem(np.eye(3), [0.0, 0.0, -1.0], 0.5), place / "good.npz")
    return place


CASES = [
    *(
        (f"{c} {f}", "unknown robot")
        for c in ("stand", "walk", "model")
        for f in ("''", ".", "GO2", "'go2 '")
    ),
    *(
        (f"{c} {f} --feet b", "surefoot: ")
        for c in ("stand", "walk", "check", "region", "model")
        for f in (*BROKEN, "folder", "''", "noise.dat", "none.urdf")
    ),
    *(
        (f"{c} go2 --feet {f}", "empty name")
        for c in ("stand", "walk", "model")
        for f in ("''", "FL_foot,,RR_foot")
    ),
    ("stand crossed.urdf --feet c", "joint hip has its lower limit above its upper one, [1.] > [-1.]"),
    *((f"{c} --push 99:1,0,0:1", "starts at 99 s, when the run is over") for c in BOTH),
    ("stand solo12 --lift FL:9:10", "--lift 'FL:9:10' starts at 9 s"),
    *((f"{c} --push 1:1e300,0,0:1", "must not exceed") for c in BOTH),
    *((f"{c} --push 1:1,0,0:1e-5", "DURATION >= 0.001 s") for c in BOTH),
    *((f"{c} --duration 0.0001", "--duration must be a number between") for c in BOTH),
    *((f"{c} --seed 1{'0' * 400}", "--seed must be a whole number") for c in BOTH),
    *((f"{c} {o} {n}", o) for c in BOTH for o in ("--mu", "--payload", "--duration") for n in NOT_FINITE),
    *((f"walk solo12 --velocity={n}", "--velocity") for n in ("nan", "inf,0,0", "1,2,3,4", ",,")),
    *(
        (f"{c} --payload {n}", "--payload")
        for c in BOTH
        for n in ("''", "@0,0,0", "1@", "1@a,b,c", "1@0,0,nan")
    ),
    *(
        (f"{c} icub_full{world}", "its joint neck_yaw moves less than 1e-10 kg m²")
        for c in ("stand", "walk")
        for world in ("", " --world rigid")
    ),
    ("walk romeo_full", "its joint RFinger21 moves less than 1e-10 kg m²"),
    ("walk solo12 --gait stand", "gait 'stand' takes no steps"),
    *(
        (f"walk solo12 --scenario {f}", "cannot read the scenario")
        for f in ("folder", "noise.dat", "none.yaml")
    ),
    *(
        (f"{c} {f}", "surefoot: ")
        for c in ("check", "region")
        for f in ("folder", "''", "list.yaml", "nan.yaml", "none.yaml", "noise.dat")
    ),
    *((f"{c} heavy.yaml", "mass must be a number between 0 and 1e+09") for c in ("check", "region")),
    ("check true.yaml", "true.yaml: mass must be a number, got True"),
    ("check quoted.yaml", "quoted.yaml: mass must be a number, got '10'"),
    (
        "check typo.yaml",
        "unknown key 'mas'; valid names: com, contacts, external_wrench, mass, mu, name; did you mean mass",
    ),
    ("export twice.json", "twice.json: the key 'format' stands twice in a mapping"),
    *((f"{c} sticky.yaml", "mu must be a number between 0 and 1000") for c in ("check", "region")),
    *((f"{c} stance.yaml --mu {n}", "--mu must be") for c in ("check", "region") for n in NOT_FINITE),
    *((f"{c} stance.yaml --lift {n}", "") for c in ("check", "region") for n in ("toe", "''")),
    *((f"cone {o} {n}", o) for o in ("--mu",) for n in ("nan", "inf", "1e300")),
    ("cone --facets 1000000", "facets must be up to 1000 (then take the exact cone)"),
    *(
        (f"solve {f}", "surefoot: ")
        for f in ("empty.npz", "noise.dat", "folder.npz", "none.npz", "stance.yaml")
    ),
    *((f"solve good.npz --tol {n}", "--tol") for n in NOT_FINITE),
    *((f"identify {f}", "surefoot: ") for f in ("empty.npz", "noise.dat", "folder.npz", "none.npz")),
    ("identify good.npz", "good.npz holds no tosses: it has no states"),
    ("identify tosses.npz --test other.npz", "other.npz holds tosses of another cube than tosses.npz"),
    ("identify tosses.npz --law hertz", "unknown contact law 'hertz'; valid names: growing-friction, newton"),
    ("identify tosses.npz --model none.urdf", "no URDF file at none.urdf"),
    ("identify tosses.npz --model panda", "a thrown body has a free base"),
    ("identify tosses.npz --rivals ode", "unknown rival 'ode'; valid names: bullet, drake, mujoco"),
    ("identify tosses.npz --seed -1", "--seed must be"),
    ("identify tosses.npz --resamples 1", "--resamples must be"),
    ("identify tosses.npz --out good.npz/x", "cannot write to --out good.npz/x"),
    ("identify few.npz", "a fit needs 8 tosses or more, got 2"),
    ("bench contact --quick --tol 0", "--tol must be"),
    ("bench contact --quick --no-rivals --picture", "--picture is one of --sequences"),
    *((f"bench {b} --out good.npz/x", "cannot write to --out good.npz/x") for b in ("contact", "faults")),
    ("bench rigid --height nan", "--height"),
]

RUNS = [
    ("stand dog", "unknown robot 'dog'; valid names: a1,"),
    ("stand none.urdf --feet a", "no URDF file at"),
    ("stand --feet toe", "unknown foot frame of go2.urdf 'toe'; valid names:"),
    ("stand --push 1:2", "--push '1:2' is not of the form T:FX,FY,FZ:DURATION"),
    ("stand --push 1:a,0,0:1", "--push: 'a' is not a finite number"),
    ("stand --lift FL", "--lift 'FL' is not of the form FOOT:T0:T1"),
    ("stand --lift toe:1:2", "unknown foot of go2 'toe'"),
    ("stand --payload 5@0,0,99", "--payload must be a number between -10 and 10"),
    ("stand panda", "needs a floating base and feet"),
    ("stand bolt", "bolt cannot stand still: 2 point feet span no area to stand on"),
    ("stand romeo", "MuJoCo cannot simulate romeo: what hangs on joint"),
    ("stand --bogus", "No such option"),
    ("plan ball -1", "a number below zero stands behind --"),
    ("plan jump --turn 270", "--turn [deg] must be a number between -180 and 180, got 270"),
    ("stand --duration 0.1 --out good.npz", "cannot write to --out"),
    ("walk --gait hop", "unknown gait for 4 feet 'hop'"),
    ("walk g1 --gait trot", "unknown gait for 2 feet 'trot'; valid names: stand, walk"),
    ("walk --terrain rough:0.5,0.04", "seed must be a whole number"),
    ("walk --terrain stairs:0.08,0", "tread must be positive"),
    ("walk --terrain stairs:0.25,0.3", "steps of 0.25 m, its legs take"),
    ("walk --terrain slope:35", "cannot stand on SlopeTerrain(35) with friction 0.6: 0.70 would be needed"),
    ("walk --commands thoughts", "valid names: targets, torques"),
    ("walk --dropout 1", "is not of the form T:DURATION"),
    ("walk --dropout 99:0.1", "when the run is over"),
    ("walk --dropout 1:-0.1", "T and DURATION must be >= 0"),
    ("walk --planner contact-implicit --commands targets", "takes no --commands"),
    ("walk --view --planner contact-implicit", "--view steers --planner convex, got contact-implicit"),
    *((f"{c} --world moon", "unknown world 'moon'") for c in BOTH),
    *(
        (f"{c} --world drake --{given}", f"--{given} is of --world mujoco or mujoco-exact or rigid")
        for c in BOTH
        for given in ("collision full", "actuators real")
    ),
    *((f"{c} --actuators magic", "valid names: ideal, real") for c in BOTH),
    *((f"{c} --world rigid --collision legs", "valid names: feet, full") for c in BOTH),
    ("walk --planner magic", "contact-implicit"),
    ("walk --planner contact-implicit --gait pace", "--gait"),
    ("walk g1 --planner contact-implicit", "g1"),
    ("bench contact folder", "no contact problems"),
    ("bench contact none", "no such folder"),
    ("bench walk --scene moon", "unknown scene 'moon'; valid names:"),
    ("bench softening --problem cube", "valid names: ball"),
    ("bench stacks --stack moon", "unknown stack 'moon'"),
    ("bench ablation --only moon", "unknown part of walking 'moon'; valid names: brisk"),
    ("bench ablation --vary moon", "unknown setting 'moon'"),
    ("bench ablation --task moon", "unknown task 'moon'"),
    ("bench ablation --value 1", "--value is for --vary"),
    ("drive go2 --interface eth7", "hang it up"),
    ("drive go2 --terrain-knowledge map", "valid names: blind, exact"),
    ("drive --out log.csv", "logs of the format csv can be read, not written"),
    ("drive --out good.npz/log.npz", "cannot write to --out good.npz"),
    *((f"{c} --domain 300", "domain must be a number between 0 and 232") for c in ("drive", "robot")),
    *((f"{c} --velocity 1e9", "--velocity must be a number between") for c in ("drive", "walk")),
    *((f"{c} --mu -1", "--mu must be") for c in ("drive", "robot")),
    *((f"{c} inf", c.split()[-1]) for c in ("drive --duration", "robot --seconds", "lab stand --seconds")),
    *((f"robot {name}", "speaks no language of the wire") for name in ("panda", "ur5")),
    ("sweep drops.yaml --samples 0", "samples must be a whole number >= 1"),
    ("sweep drops.yaml --backend slurm", "unknown backend 'slurm'; valid names: dask, loky, ray, serial"),
    ("sweep drops.yaml --address x:1", "--address is of --backend ray or dask"),
    ("sweep drops.yaml --backend serial --workers 2", "--backend serial has one worker, not 2"),
    ("sweep drops.yaml --workers 0", "workers must be a whole number >= 1, got 0"),
    ("audit good.npz --out good.npz/x", "cannot write to --out"),
    ("robot --terrain stairs:0.1,0.3", "--terrain must be flat or slope:DEG"),
    ("walk --policy-spec list.yaml", "are of a --policy"),
    *((f"{c} --scenario loss.yaml", "a torque loss is of a weak joint") for c in BOTH),
    (
        "bench stacks --stack go2-convex-mpc",
        "set --go2-convex-mpc or SUREFOOT_GO2_CONVEX_MPC to a checkout of",
    ),
    ("bench stacks --resume /nowhere", "no trials.jsonl there"),
    ("bench faults --fault meteor", "unknown fault 'meteor'; valid names: delay"),
]
OTHERS = [
    ("stnd", "No such command 'stnd'"),
    ("check", "Missing argument"),
    ("check stance.yaml --lift tail", "valid names: FL, FR, RL, RR"),
    ("region stance.yaml --lift FL,FR,RL,RR", "no contacts"),
    ("solve good.npz --solver simplex", "unknown solver 'simplex'; valid names:"),
    ("solve good.npz --solver lemke", "takes pyramids only"),
    *((f"cone {o}", "surefoot: ") for o in ("--mu -1", "--facets 2", "--facets a", "--fit x")),
    *(
        (f"audit {f}", "surefoot: ")
        for f in ("empty.npz", "noise.dat", "folder.npz", "none.npz", "stance.yaml", ".")
    ),
    ("worlds drip", "unknown experiment 'drip'"),
    ("worlds --world moon", "unknown world 'moon'"),
    ("worlds --defaults tip", "unknown scene of --defaults 'tip'; valid names: creep on a slope"),
    ("worlds --defaults --world moon", "unknown engine 'moon'"),
    *((f"worlds drop --dt {n}", "--dt must be between") for n in ("0", "nan")),
    ("plan ball --out /dev/null", "cannot write to --out"),
    *(
        (f"translate {words}", "surefoot: ")
        for words in (
            "nobody mujoco",
            "physical nobody stiffness=1 damping=0",
            "physical bullet stiffness=1",
            "physical bullet stiffness damping=1",
            "physical bullet stiffness=1 stiffness=2 damping=1",
            "physical bullet stiffness=1e4 damping=1 --dt -1",
            "physical bullet stiffness=1e4 damping=1 --prove",
            "physical mujoco stiffness=1e4 damping=1 --mass -1",
            "mujoco physical solref=0.02",
        )
    ),
]
NEEDS = {"plan": "casadi", "lab": "viser", "robot": "cyclonedds", "drive": "cyclonedds", "sweep": "pyarrow"}
PLAN = [
    ("plan fly", "valid names: " + ", ".join(sorted(task_names()))),
    ("plan jump 99", "distance [m]"),
    ("plan g1 jump", "four feet"),
    ("plan jump --terrain stairs:0.1,0.3", "too near an edge"),
    ("plan jump 0.5 --over 0.3", "over must be a gap"),
    ("plan backflip --turn 30", "takes no turn"),
    ("plan jump --execute gazebo", "mujoco"),
    ("plan ball --execute mujoco", "--execute is of robots on legs"),
    ("plan ball --feet a", "it takes no --feet"),
    ("plan panda jump", "panda is bolted down"),
    ("plan jump --start nothing.json", "start must have shape (19,), got (0,)"),
    ("plan hopper 7", "hopper takes a number from -1 to 1, its distance [m], got 7"),
]
LAB = [
    ("lab stand panda --port 0", "two feet or more"),
    ("lab stand --port 70000", "--port must be from 0 to 65535, got 70000"),
    ("lab stand --host no.such.host.invalid --port 0", "is no address of this machine"),
    ("lab audit nothing.npz --port 0", "nothing.npz"),
    ("lab cone go2 --port 0", "lab cone takes no subject"),
    ("lab stand --robot go2 --port 0", "lab stand takes no --robot"),
    ("lab audit --port 0", "lab audit needs a log"),
    ("lab plan --port 0", "lab plan needs a plan or a task"),
    ("lab plan good.npz 0.3 --port 0", "a saved plan takes no number, got 0.3"),
    ("lab plan good.npz --port 0", "good.npz"),
    ("lab nothing --port 0", "unknown page 'nothing'; valid names: audit, cone, plan, push, stand"),
]
ALL = [*CASES, *RUNS, *OTHERS, *PLAN, *LAB]


@pytest.mark.parametrize(("line", "words"), ALL, ids=[line[:60] for line, _ in ALL])
def test_it_is_named_in_one_line(
    line: str, words: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    extra = NEEDS.get(line.split()[0])
    if extra is not None and importlib.util.find_spec(extra) is None:
        pytest.skip(f"{extra} is not installed")
    monkeypatch.chdir(folder)
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert main(shlex.split(line)) == 2
    out = capfd.readouterr()
    assert words in out.err
    assert out.err.count("\n") == 1
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == before


@pytest.mark.long
def test_a_robot_that_gets_nowhere_did_not_walk(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = ["--mu", "0", "--duration", "3", "--no-video", "--no-report", "--out", str(tmp_path)]
    assert main(["walk", "go2", *options]) == 1
    assert "did not follow its command" in capfd.readouterr().out


def test_what_mujoco_warns_of_is_a_line_of_ours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    options = ["--push", "0.1:99999,0,0:0.05", "--duration", "0.2", "--no-video", "--no-report"]
    assert main(["stand", "solo12", *options]) == 1
    out = capfd.readouterr()
    assert "MuJoCo: " in out.out
    assert out.err == ""
    assert [path.name for path in tmp_path.iterdir()] == ["runs"]


def test_the_shortest_run_is_judged(tmp_path: Path) -> None:
    options = ["--duration", "0.1", "--no-video", "--no-report", "--json", "--out", str(tmp_path)]
    assert main(["stand", "solo12", *options]) == 0
    assert len(read_log(next(tmp_path.rglob("log.npz")))) == 100
