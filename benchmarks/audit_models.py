"""What the audit says of other people's MuJoCo models: every model under the folders that are given.

    python -m benchmarks.audit_models PATH ... [--seconds 4] [--cones] [--iterations 100] [--step 5e-4]
        [--quick]

A model with a keyframe is held there by joint control and marches on the spot; one without gets seeded
random controls within their range, as an untrained policy gives them; ``--policy NETWORK --spec YAML`` lets a
learned policy walk it. Meshes are left out (their files may be missing), a plane is put under a model that
has no ground. ``--cones`` runs each with both cones and every condim of its contacts; ``--quick`` runs models
of our own. Nothing of a model is kept.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.base.errors import SurefootError
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.motion.control.controller import RobotState
from surefoot.worlds.mujoco.mujoco_world import import_mujoco

STIFF, DAMPED = 8.0, 0.25
"""Joint control: stiffness over m g [m/rad], damping over that [s]."""
WAVE, RATE = 0.12, 2.0
"""Of the march on the spot [rad, Hz]."""
ABOVE = 0.005
"""Height over the ground from which a policy's robot is let go [m]: its feet may be larger than ours."""
OWN = {
    "crate": "<body name='crate' pos='0 0 .1'><freejoint/><geom type='box' size='.2 .2 .1' mass='5'/></body>",
    "hopper": (
        "<body pos='0 0 .6'><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/>"
        "<joint axis='0 1 0'/><geom type='capsule' fromto='0 0 -.2 0 0 .2' size='.05'/><body pos='0 0 -.2'>"
        "<joint name='hip' axis='0 1 0' damping='1' armature='.01' frictionloss='.1'/>"
        "<geom type='capsule' fromto='0 0 0 .1 0 -.3' size='.04'/></body></body>"
    ),
}
"""Models of our own, for ``--quick``."""


@dataclass(frozen=True)
class StrangerVerdict:
    """What came of one model.

    Attributes
    ----------
    name, cone, condim
        Of the model; its cone; largest dimension of its contacts.
    verdict, reason
        Of the audit, and its first symptom or the reason why it cannot tell.
    """

    name: str
    cone: str
    condim: int
    verdict: str
    reason: str


def own_models() -> Iterator[tuple[str, Any]]:
    """Yield name and model of our own."""
    mujoco = import_mujoco()
    for name, body in OWN.items():
        motor = "<actuator><motor joint='hip' ctrlrange='-1 1'/></actuator>" if "'hip'" in body else ""
        text = f"<worldbody><geom type='plane' size='9 9 1'/>{body}</worldbody>{motor}"
        option = "<option timestep='.001'/>"
        yield name, mujoco.MjModel.from_xml_string(f"<mujoco model='{name}'>{option}{text}</mujoco>")


def models_under(paths: Sequence[Path]) -> Iterator[tuple[str, Any]]:
    """Yield name and model of every .xml below the paths that compiles and has a root that moves freely."""
    from surefoot.worlds.mujoco.record_tree import BodyTree

    mujoco = import_mujoco()
    files = sorted(f for path in paths for f in ([path] if path.is_file() else path.rglob("*.xml")))
    for file in files:
        try:
            spec = mujoco.MjSpec.from_file(str(file))
            for geom in [g for g in spec.geoms if g.type == mujoco.mjtGeom.mjGEOM_MESH]:
                spec.delete(geom)
            for mesh in list(spec.meshes):
                spec.delete(mesh)
            grounds = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD)
            if not any(g.type in grounds for g in spec.geoms):
                spec.worldbody.add_geom(type=grounds[0], size=[0, 0, 0.05])
            model = spec.compile()
            if BodyTree(mujoco, model, None).free is not None:
                yield file.stem, model
        except (ValueError, SurefootError):
            continue  # no model of its own: a part of others, or without its meshes


def lift_out_of_the_ground(model: Any, data: Any) -> None:
    """Lift a model whose keyframe stands in the ground until its deepest contact just touches."""
    mujoco = import_mujoco()
    mujoco.mj_forward(model, data)
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)[0]
    data.qpos[model.jnt_qposadr[free] + 2] -= min(0.0, data.contact.dist.min(initial=0.0))


def recorded(model: Any, seconds: float, seed: int = 0) -> sf.Log:
    """Return the log of a model that marches about its keyframe, or flails."""
    mujoco, rng = import_mujoco(), np.random.default_rng(seed)
    data, held = mujoco.MjData(model), model.nkey > 0
    if held:
        mujoco.mj_resetDataKeyframe(model, data, 0)
        lift_out_of_the_ground(model, data)
    joints = model.actuator_trnid[:, 0]
    at, dof = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
    goal, control = data.qpos[at].copy(), data.ctrl.copy()
    sign = np.where(np.arange(model.nu) % 2 == 0, 1.0, -1.0)
    gain = STIFF * float(model.body_subtreemass[0]) * 9.81 / max(model.nu, 1)
    low, high = np.where(model.actuator_ctrllimited[:, None], model.actuator_ctrlrange, [[-1.0, 1.0]]).T
    servo = model.actuator_biastype != mujoco.mjtBias.mjBIAS_NONE
    with sf.record(model, data) as log:
        for _ in range(round(seconds / model.opt.timestep / (1 if held else 4))):  # an unstable one is reset
            wave = WAVE * sign * np.sin(2.0 * np.pi * RATE * data.time)
            if held:
                torque = gain * (goal + wave - data.qpos[at]) - gain * DAMPED * 0.1 * data.qvel[dof]
                data.ctrl[:] = np.where(servo, control + wave, torque / model.actuator_gear[:, 0])
            else:
                data.ctrl[:] = rng.uniform(low, high)
            np.clip(data.ctrl, low, high, out=data.ctrl)
            mujoco.mj_step(model, data, 1 if held else 4)
    return log


def walked(model: Any, seconds: float, policy: sf.Policy) -> sf.Log:
    """Return the log of a model that a learned policy walks, in the model's own loop."""
    mujoco, robot = import_mujoco(), policy.robot
    data, q = mujoco.MjData(model), sf.place(robot, sf.FlatTerrain(), policy.posture)
    joints = [model.joint(name) for name in robot.joint_names]
    at, dof = (np.array([getattr(j, key)[0] for j in joints]) for key in ("qposadr", "dofadr"))
    drives = [int(np.flatnonzero(model.actuator_trnid[:, 0] == j.id)[0]) for j in joints]
    servo = model.actuator_biastype[drives] != mujoco.mjtBias.mjBIAS_NONE
    data.qpos[:7], data.qpos[at] = [*q[:2], q[2] + ABOVE, q[6], *q[3:6]], q[7:]
    policy.reset()
    with sf.record(model, data) as log:
        while data.time < seconds:
            q[:7] = data.qpos[[0, 1, 2, 4, 5, 6, 3]]
            q[7:] = data.qpos[at]
            base = rotation_from_quaternion(q[3:7]).T @ data.qvel[:3]
            v = np.concatenate([base, data.qvel[3:6], data.qvel[dof]])
            command = policy.step(RobotState(q, v, data.time))
            targets = q[7:] if command.joint_targets is None else command.joint_targets.positions
            data.ctrl[drives] = np.where(servo, targets, command.torques / model.actuator_gear[drives, 0])
            mujoco.mj_step(model, data)
    return log


def judged(name: str, model: Any, seconds: float, policy: sf.Policy | None = None) -> StrangerVerdict:
    """Run a model and audit its log."""
    mujoco = import_mujoco()
    cone = "pyramid" if model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL else "round"
    log = recorded(model, seconds) if policy is None else walked(model, seconds, policy)
    report = sf.audit_log(log)
    reason = report.reason or (str(report.symptoms[0]) if report.symptoms else "")
    return StrangerVerdict(name, cone, int(model.geom_condim.max()), report.verdict, reason)


def measure(
    models: Iterator[tuple[str, Any]],
    seconds: float,
    cones: bool,
    iterations: int | None = None,
    step: float | None = None,
    policy: sf.Policy | None = None,
) -> Iterator[StrangerVerdict]:
    """Yield what came of every model, as shipped or with each cone and condim."""
    for name, model in models:
        if iterations is not None:
            model.opt.iterations, model.opt.ls_iterations = iterations, max(iterations, 50)
        model.opt.timestep = step or model.opt.timestep
        yield judged(name, model, seconds, policy)
        if not cones:
            continue
        touching = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
        for cone in (0, 1):
            for condim in (1, 3, 4, 6):
                model.opt.cone = cone
                model.geom_condim[touching] = condim
                yield judged(name, model, seconds, policy)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*", type=Path)
    parser.add_argument("--seconds", type=float, default=4.0)
    parser.add_argument("--cones", action="store_true")
    parser.add_argument("--quick", action="store_true", help="models of our own, half a second each")
    parser.add_argument("--iterations", type=int, default=None, help="of the solver, where a model has few")
    parser.add_argument("--step", type=float, default=None, help="in place of the model's own [s]")
    parser.add_argument("--policy", type=Path, default=None, help="a network that walks the models")
    parser.add_argument("--spec", type=Path, default=None, help="its description")
    given = parser.parse_args(arguments)
    policy = None if given.policy is None else sf.Policy(given.policy, given.spec)
    models = own_models() if given.quick else models_under(given.models)
    seconds, rows = 0.5 if given.quick else given.seconds, []
    print("| model | cone | condim | verdict | first symptom, or reason |\n|---|---|---|---|---|")
    for one in measure(models, seconds, given.cones, given.iterations, given.step, policy):
        rows.append(one)
        print(f"| {one.name} | {one.cone} | {one.condim} | {one.verdict} | {one.reason[:110]} |", flush=True)
    counts = {v: sum(r.verdict == v for r in rows) for v in ("lawful", "broken", "cannot tell")}
    print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()), f"of {len(rows)}")


if __name__ == "__main__":
    main()
