"""Unitree's low-level messages, written after the layouts that Unitree publishes.

Names, order and types of the fields are the wire's. ``unitree_go`` is for quadrupeds (Go2, B2),
``unitree_hg`` for humanoids (G1). Units: angles [rad], speeds [rad/s], torques [N m], ticks of 1 ms;
quaternions are (w, x, y, z). No DDS is needed here: `surefoot.motion.drive.wire.dds_types` makes its types.

Whole numbers of eight bits are ``byte``. That is what ``uint8`` is to Cyclone DDS 0.10, which Unitree's SDK
and its robots run; the ``uint8`` of a newer one is a kind of type unknown to it, and a process that discovers
it ends with a segmentation fault. The bytes on the wire are the same.
"""

from __future__ import annotations

from dataclasses import dataclass

BYTE, UINT16, INT16, UINT32, INT32, FLOAT32 = "byte", "uint16", "int16", "uint32", "int32", "float32"
"""Types of numbers, as IDL names them."""


@dataclass(frozen=True)
class Structure:
    """The class of a message, or of a part of one.

    Attributes
    ----------
    family, name
        As in the IDL module of the message.
    fields
        Name, type and how many of it, None for one that is no array, in order.
    """

    family: str
    name: str
    fields: tuple[tuple[str, str | Structure, int | None], ...]


def structure(family: str, name: str, **fields: str | Structure | tuple[str | Structure, int]) -> Structure:
    """Return the structure of a family and name with typed fields, in order; (type, n) is an array of n."""
    rows = ((key, kind if isinstance(kind, tuple) else (kind, None)) for key, kind in fields.items())
    return Structure(family, name, tuple((key, *kind) for key, kind in rows))


def _imu(family: str, temperature: str) -> Structure:
    return structure(
        family, "IMUState_", quaternion=(FLOAT32, 4), gyroscope=(FLOAT32, 3), accelerometer=(FLOAT32, 3),
        rpy=(FLOAT32, 3), temperature=temperature,
    )  # fmt: skip


def _motor_command(family: str, reserve: str | tuple[str, int]) -> Structure:
    return structure(
        family, "MotorCmd_", mode=BYTE, q=FLOAT32, dq=FLOAT32, tau=FLOAT32, kp=FLOAT32, kd=FLOAT32,
        reserve=reserve,
    )  # fmt: skip


GO, HG = "unitree_go", "unitree_hg"
_HEADER: dict[str, str | Structure | tuple[str | Structure, int]] = {
    "head": (BYTE, 2), "level_flag": BYTE, "frame_reserve": BYTE, "sn": (UINT32, 2), "version": (UINT32, 2),
    "bandwidth": UINT16,
}  # fmt: skip
GO_MOTOR_STATE = structure(
    GO, "MotorState_", mode=BYTE, q=FLOAT32, dq=FLOAT32, ddq=FLOAT32, tau_est=FLOAT32, q_raw=FLOAT32,
    dq_raw=FLOAT32, ddq_raw=FLOAT32, temperature=BYTE, lost=UINT32, reserve=(UINT32, 2),
)  # fmt: skip
GO_BATTERY_STATE = structure(
    GO, "BmsState_", version_high=BYTE, version_low=BYTE, status=BYTE, soc=BYTE, current=INT32,
    cycle=UINT16, bq_ntc=(BYTE, 2), mcu_ntc=(BYTE, 2), cell_vol=(UINT16, 15),
)  # fmt: skip
GO_BATTERY_COMMAND = structure(GO, "BmsCmd_", off=BYTE, reserve=(BYTE, 3))
GO_STATE = structure(
    GO, "LowState_", **_HEADER, imu_state=_imu(GO, BYTE), motor_state=(GO_MOTOR_STATE, 20),
    bms_state=GO_BATTERY_STATE, foot_force=(INT16, 4), foot_force_est=(INT16, 4), tick=UINT32,
    wireless_remote=(BYTE, 40), bit_flag=BYTE, adc_reel=FLOAT32, temperature_ntc1=BYTE,
    temperature_ntc2=BYTE, power_v=FLOAT32, power_a=FLOAT32, fan_frequency=(UINT16, 4),
    reserve=UINT32, crc=UINT32,
)  # fmt: skip
GO_COMMAND = structure(
    GO, "LowCmd_", **_HEADER, motor_cmd=(_motor_command(GO, (UINT32, 3)), 20),
    bms_cmd=GO_BATTERY_COMMAND, wireless_remote=(BYTE, 40), led=(BYTE, 12), fan=(BYTE, 2), gpio=BYTE,
    reserve=UINT32, crc=UINT32,
)  # fmt: skip
HG_MOTOR_STATE = structure(
    HG, "MotorState_", mode=BYTE, q=FLOAT32, dq=FLOAT32, ddq=FLOAT32, tau_est=FLOAT32,
    temperature=(INT16, 2), vol=FLOAT32, sensor=(UINT32, 2), motorstate=UINT32, reserve=(UINT32, 4),
)  # fmt: skip
HG_STATE = structure(
    HG, "LowState_", version=(UINT32, 2), mode_pr=BYTE, mode_machine=BYTE, tick=UINT32,
    imu_state=_imu(HG, INT16), motor_state=(HG_MOTOR_STATE, 35), wireless_remote=(BYTE, 40),
    reserve=(UINT32, 4), crc=UINT32,
)  # fmt: skip
HG_COMMAND = structure(
    HG, "LowCmd_", mode_pr=BYTE, mode_machine=BYTE, motor_cmd=(_motor_command(HG, UINT32), 35),
    reserve=(UINT32, 4), crc=UINT32,
)  # fmt: skip
