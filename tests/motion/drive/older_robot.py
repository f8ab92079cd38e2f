"""A robot's side of the wire under another Cyclone DDS, in a process of that one's own interpreter.

Run by tests as ``python older_robot.py MESSAGES.py DOMAIN SECONDS``: says a state without checksum, tick and
modes 200 times a second on `lo`, as Unitree's Python bridge does, and prints how many commands it heard. It
needs nothing but cyclonedds, any version that knows ``uint8``, and the file with the structures of messages.
"""

import json
import runpy
import sys
import time
from functools import cache

from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import autoid, final
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

CONFIG = (
    "<CycloneDDS><Domain Id='any'><General><Interfaces><NetworkInterface name='lo' priority='default' "
    "multicast='default'/></Interfaces></General></Domain></CycloneDDS>"
)
"""As Unitree's SDK configures it: discovery is left to its defaults."""


@cache
def idl_type(structure):
    """Return the type that Unitree's SDK would have: eight bits are `uint8`."""
    fields = {}
    for name, kind, count in structure.fields:
        if hasattr(kind, "fields"):
            one = idl_type(kind)
        else:
            one = getattr(types, "uint8" if kind == "byte" else kind)
        fields[name] = one if count is None else types.array[one, count]
    full = f"{structure.family}.msg.dds_.{structure.name}"
    return autoid("sequential")(final(make_idl_struct(structure.name, full, fields)))


def zeros(structure):
    """Return a message of zeros."""
    values = {}
    for name, kind, count in structure.fields:
        if hasattr(kind, "fields"):
            values[name] = zeros(kind) if count is None else [zeros(kind) for _ in range(count)]
        else:
            zero = 0.0 if kind == "float32" else 0
            values[name] = zero if count is None else [zero] * count
    return idl_type(structure)(**values)


def main(messages, domain, seconds):
    """Speak, listen, and print what was heard."""
    known = runpy.run_path(messages)
    opened = Domain(domain, CONFIG)
    party = DomainParticipant(domain)
    states = DataWriter(party, Topic(party, "rt/lowstate", idl_type(known["GO_STATE"])))
    commands = DataReader(party, Topic(party, "rt/lowcmd", idl_type(known["GO_COMMAND"])))
    state, heard, damping = zeros(known["GO_STATE"]), 0, 0.0
    state.imu_state.quaternion[0], state.imu_state.accelerometer[2] = 1.0, 9.81
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        states.write(state)
        for command in commands.take(16):
            if not hasattr(command, "motor_cmd"):  # a writer that has left
                continue
            heard += 1
            damping = command.motor_cmd[0].kd
        time.sleep(0.005)
    print(json.dumps({"heard": heard, "damping": damping, "mode": 1}))
    del states, commands, party, opened


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
