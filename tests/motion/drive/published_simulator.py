"""Unitree's own Python simulator beside `surefoot drive`, without its window, under its own Cyclone DDS.

Run by tests as ``python published_simulator.py MUJOCO SDK DOMAIN RATE SECONDS ROBOT [lockstep] [band]
[straps]``, the folders of unitree_mujoco and unitree_sdk2_python, by an interpreter that has cyclonedds
0.10.2, mujoco, numpy, pygame. Robot, scene, bridge and elastic band are the published ones; what is ours is
the loop around `mj_step`, which the published program shares with its viewer, and straps, which hold the
trunk level beside the band. In lockstep a state is said and its command waited for before each step, else
the bridge's threads keep their own time. It ends when commands have come and come no more, or after so many
seconds, and prints where the robot is, how high it was, how low its lowest geom came, and how many steps
took half as long again as they should.
"""

import importlib
import json
import os
import sys
import threading
import time
import types

PATIENCE = 10.0
"""Silence of the drive in lockstep after which the simulator ends [s]."""


GONE = 1.0
"""Silence of the drive in real time after which the simulator ends [s]: the last torques were to damp it."""


class NoThread:
    """Stands for the bridge's timers where somebody else keeps the time."""

    def __init__(self, **_):
        pass

    def Start(self):
        """Do nothing."""


def published(simulator, sdk, domain, rate, robot):
    """Return the published bridge's module and the configuration that it reads."""
    package = types.ModuleType("unitree_sdk2py")  # its own face imports cameras as well, which need OpenCV
    package.__path__ = [os.path.join(sdk, "unitree_sdk2py")]
    sys.modules["unitree_sdk2py"] = package
    folder = os.path.join(simulator, "simulate_python")
    sys.path.insert(0, folder)
    os.chdir(folder)
    config = importlib.import_module("config")
    config.ROBOT, config.DOMAIN_ID, config.SIMULATE_DT = robot, domain, 1.0 / rate
    config.ROBOT_SCENE = f"../unitree_robots/{robot}/scene.xml"
    return importlib.import_module("unitree_sdk2py_bridge"), config


class Hanging:
    """The published elastic band, and straps that turn the trunk back to level."""

    def __init__(self, module, model, straps):
        self.band, self.straps = module.ElasticBand(), straps
        name = (
            "torso_link"
            if any(model.body(i).name == "torso_link" for i in range(model.nbody))
            else "base_link"
        )
        self.body = model.body(name).id
        weight = 9.81 * sum(model.body_mass)
        self.band.length = max(self.band.length, 1.5 - weight / self.band.stiffness)  # feet off the ground
        self.stiffness, self.damping = 0.3 * weight, 0.03 * weight

    def pull(self, data):
        """Hold the robot for the next step."""
        data.xfrc_applied[self.body, :3] = self.band.Advance(data.qpos[:3], data.qvel[:3])
        if self.straps:
            up = data.xmat[self.body].reshape(3, 3)[:, 2]
            turn = data.xmat[self.body].reshape(3, 3) @ data.qvel[3:6]
            tilt = [up[1], -up[0], 0.0]  # up x z: the turn that brings it back
            data.xfrc_applied[self.body, 3:] = [
                self.stiffness * a - self.damping * w for a, w in zip(tilt, turn, strict=True)
            ]


def begin(model, data, robot, hung):
    """Lay the robot down, or let it hang from where its band holds it."""
    import mujoco

    if robot == "go2":
        data.qpos[7:19] = [0.0, 1.36, -2.65] * 4
    if hung is not None:
        data.qpos[2] = (
            hung.band.point[2] - hung.band.length - 9.81 * sum(model.body_mass) / hung.band.stiffness
        )
    else:
        data.qpos[2] = 0.12
    mujoco.mj_forward(model, data)


def lowest_geom(model, data):
    """Return how high the lowest point of the robot is, by the spheres around its geoms, at most [m]."""
    low = 1e9
    for i in range(model.ngeom):
        if model.geom_bodyid[i] and model.geom_contype[i]:
            low = min(low, data.geom_xpos[i, 2] - model.geom_rbound[i])
    return float(low)


def main(simulator, sdk, domain, rate, seconds, robot, how):
    """Run the simulator, and say what became of the robot."""
    import mujoco

    module, config = published(simulator, sdk, domain, rate, robot)
    from unitree_sdk2py.core.channel import ChannelFactoryInitialize

    model = mujoco.MjModel.from_xml_path(config.ROBOT_SCENE)
    model.opt.timestep = config.SIMULATE_DT
    data, lockstep = mujoco.MjData(model), "lockstep" in how
    hung = Hanging(module, model, "straps" in how) if "band" in how else None
    begin(model, data, robot, hung)
    ChannelFactoryInitialize(domain, "lo")
    answered, last = threading.Event(), [None]
    if lockstep:
        module.RecurrentThread = NoThread
    handler = module.UnitreeSdk2Bridge.LowCmdHandler

    def handle(self, message):
        handler(self, message)
        last[0] = time.perf_counter()
        answered.set()

    module.UnitreeSdk2Bridge.LowCmdHandler = handle
    bridge = module.UnitreeSdk2Bridge(model, data)
    highest, lowest, late, heard = 0.0, 1e9, 0, False
    while data.time < seconds and not (last[0] and time.perf_counter() - last[0] > GONE):
        start = time.perf_counter()
        if lockstep:
            answered.clear()
            bridge.PublishLowState()
            came = answered.wait(PATIENCE if heard else 0.2)
            if heard and not came:  # the drive has ended
                break
            heard = came
            if not heard:
                continue
        if hung is not None:
            hung.pull(data)
        mujoco.mj_step(model, data)
        highest, lowest = max(highest, float(data.qpos[2])), min(lowest, lowest_geom(model, data))
        left = config.SIMULATE_DT - (time.perf_counter() - start)
        if not lockstep and left > 0.0:
            time.sleep(left)
        late += time.perf_counter() - start > 1.5 * config.SIMULATE_DT
    print(
        json.dumps({"place": data.qpos[:3].tolist(), "highest": highest, "lowest": lowest, "late": late}),
        flush=True,
    )
    os._exit(0)  # the bridge's threads never end by themselves


if __name__ == "__main__":
    said = sys.argv[1:]
    main(said[0], said[1], int(said[2]), float(said[3]), float(said[4]), said[5], said[6:])
