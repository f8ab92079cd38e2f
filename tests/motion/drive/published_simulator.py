"""Unitree's own Python simulator beside `surefoot drive`, without its window, under its own Cyclone DDS.

Run by tests as ``python published_simulator.py MUJOCO SDK DOMAIN RATE SECONDS [lockstep]``, the folders of
unitree_mujoco and unitree_sdk2_python, by an interpreter that has cyclonedds 0.10.2, mujoco, numpy, pygame.
Robot, scene and bridge are the published ones; what is ours is the loop around `mj_step`, which the published
program shares with its viewer. In lockstep a state is said and its command waited for before each step, else
the bridge's threads keep their own time. At the end it prints where the robot is, and how high it was.
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


class NoThread:
    """Stands for the bridge's timers where somebody else keeps the time."""

    def __init__(self, **_):
        pass

    def Start(self):
        """Do nothing."""


def published(simulator, sdk, domain, rate):
    """Return the published bridge's module and the configuration that it reads."""
    package = types.ModuleType("unitree_sdk2py")  # its own face imports cameras as well, which need OpenCV
    package.__path__ = [os.path.join(sdk, "unitree_sdk2py")]
    sys.modules["unitree_sdk2py"] = package
    folder = os.path.join(simulator, "simulate_python")
    sys.path.insert(0, folder)
    os.chdir(folder)
    config = importlib.import_module("config")
    config.ROBOT, config.DOMAIN_ID, config.SIMULATE_DT = "go2", domain, 1.0 / rate
    config.ROBOT_SCENE = "../unitree_robots/go2/scene.xml"
    return importlib.import_module("unitree_sdk2py_bridge"), config


def main(simulator, sdk, domain, rate, seconds, lockstep):
    """Run the simulator, and say what became of the robot."""
    import mujoco

    module, config = published(simulator, sdk, domain, rate)
    from unitree_sdk2py.core.channel import ChannelFactoryInitialize

    model = mujoco.MjModel.from_xml_path(config.ROBOT_SCENE)
    model.opt.timestep = config.SIMULATE_DT
    data = mujoco.MjData(model)
    lie = [0.0, 1.36, -2.65] * 4
    data.qpos[2], data.qpos[7:19] = 0.12, lie
    mujoco.mj_forward(model, data)
    ChannelFactoryInitialize(domain, "lo")
    answered = threading.Event()
    if lockstep:
        module.RecurrentThread = NoThread
        handler = module.UnitreeSdk2Bridge.LowCmdHandler

        def handle(self, message):
            handler(self, message)
            answered.set()

        module.UnitreeSdk2Bridge.LowCmdHandler = handle
    bridge = module.UnitreeSdk2Bridge(model, data)
    highest, heard = 0.0, False
    while data.time < seconds:
        begin = time.perf_counter()
        if lockstep:
            answered.clear()
            bridge.PublishLowState()
            came = answered.wait(PATIENCE if heard else 0.2)
            if heard and not came:  # the drive has ended
                break
            heard = came
            if not heard:
                continue
        mujoco.mj_step(model, data)
        highest = max(highest, float(data.qpos[2]))
        left = config.SIMULATE_DT - (time.perf_counter() - begin)
        if not lockstep and left > 0.0:
            time.sleep(left)
    print(json.dumps({"place": data.qpos[:3].tolist(), "highest": highest}), flush=True)
    os._exit(0)  # the bridge's threads never end by themselves


if __name__ == "__main__":
    said = sys.argv[1:]
    main(said[0], said[1], int(said[2]), float(said[3]), float(said[4]), "lockstep" in said)
