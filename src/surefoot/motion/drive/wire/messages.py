"""Unitree's low-level messages for cyclonedds, written after the layouts that Unitree publishes.

Names, order and types of the fields are the wire's. ``unitree_go`` is for quadrupeds (Go2, B2),
``unitree_hg`` for humanoids (G1). Units: angles [rad], speeds [rad/s], torques [N m], ticks of 1 ms;
quaternions are (w, x, y, z). This module needs the extra ``wire``.
"""

from __future__ import annotations

from typing import Any

from surefoot.base.errors import needs
from surefoot.motion.drive.wire.packed import HEADER

with needs("cyclonedds", "wire"):
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.annotations import autoid, final
    from cyclonedds.idl.types import array, float32, int16, int32, uint8, uint16, uint32

FAMILY = "{}.msg.dds_.{}"


def structure(family: str, name: str, **fields: Any) -> Any:
    """Return the message class of a family and name with typed fields, in order."""
    return autoid("sequential")(final(make_idl_struct(name, FAMILY.format(family, name), fields)))


def message(family: str, name: str, **fields: Any) -> Any:
    """Return such a class for a topic: its messages stay the bytes of the wire, see `PackedMessage`."""
    kind = structure(family, name, **fields)
    kind.serialize, kind.deserialize = _bytes, classmethod(_of_bytes)
    return kind


def _bytes(self: Any, **_: Any) -> bytes:
    """Return what a message carries."""
    data: bytes = self.data
    return data


def _of_bytes(kind: Any, data: bytes) -> Any:
    """Return a message that carries bytes; ones of another encoding are encoded anew."""
    carrier = kind.__new__(kind)
    if data[:2] != HEADER[:2]:
        data = kind.__idl__.serialize(kind.__idl__.deserialize(data), use_version_2=False)
    carrier.data = data
    return carrier


def _imu(family: str, temperature: Any) -> Any:
    return structure(
        family, "IMUState_", quaternion=array[float32, 4], gyroscope=array[float32, 3],
        accelerometer=array[float32, 3], rpy=array[float32, 3], temperature=temperature,
    )  # fmt: skip


def _motor_command(family: str, reserve: Any) -> Any:
    return structure(
        family, "MotorCmd_", mode=uint8, q=float32, dq=float32, tau=float32, kp=float32, kd=float32,
        reserve=reserve,
    )  # fmt: skip


GO, HG = "unitree_go", "unitree_hg"
_HEADER = {
    "head": array[uint8, 2], "level_flag": uint8, "frame_reserve": uint8, "sn": array[uint32, 2],
    "version": array[uint32, 2], "bandwidth": uint16,
}  # fmt: skip
GO_MOTOR_STATE = structure(
    GO, "MotorState_", mode=uint8, q=float32, dq=float32, ddq=float32, tau_est=float32, q_raw=float32,
    dq_raw=float32, ddq_raw=float32, temperature=uint8, lost=uint32, reserve=array[uint32, 2],
)  # fmt: skip
GO_BATTERY_STATE = structure(
    GO, "BmsState_", version_high=uint8, version_low=uint8, status=uint8, soc=uint8, current=int32,
    cycle=uint16, bq_ntc=array[uint8, 2], mcu_ntc=array[uint8, 2], cell_vol=array[uint16, 15],
)  # fmt: skip
GO_BATTERY_COMMAND = structure(GO, "BmsCmd_", off=uint8, reserve=array[uint8, 3])
GO_STATE = message(
    GO, "LowState_", **_HEADER, imu_state=_imu(GO, uint8), motor_state=array[GO_MOTOR_STATE, 20],
    bms_state=GO_BATTERY_STATE, foot_force=array[int16, 4], foot_force_est=array[int16, 4], tick=uint32,
    wireless_remote=array[uint8, 40], bit_flag=uint8, adc_reel=float32, temperature_ntc1=uint8,
    temperature_ntc2=uint8, power_v=float32, power_a=float32, fan_frequency=array[uint16, 4],
    reserve=uint32, crc=uint32,
)  # fmt: skip
GO_COMMAND = message(
    GO, "LowCmd_", **_HEADER, motor_cmd=array[_motor_command(GO, array[uint32, 3]), 20],
    bms_cmd=GO_BATTERY_COMMAND, wireless_remote=array[uint8, 40], led=array[uint8, 12],
    fan=array[uint8, 2], gpio=uint8, reserve=uint32, crc=uint32,
)  # fmt: skip
HG_MOTOR_STATE = structure(
    HG, "MotorState_", mode=uint8, q=float32, dq=float32, ddq=float32, tau_est=float32,
    temperature=array[int16, 2], vol=float32, sensor=array[uint32, 2], motorstate=uint32,
    reserve=array[uint32, 4],
)  # fmt: skip
HG_STATE = message(
    HG, "LowState_", version=array[uint32, 2], mode_pr=uint8, mode_machine=uint8, tick=uint32,
    imu_state=_imu(HG, int16), motor_state=array[HG_MOTOR_STATE, 35], wireless_remote=array[uint8, 40],
    reserve=array[uint32, 4], crc=uint32,
)  # fmt: skip
HG_COMMAND = message(
    HG, "LowCmd_", mode_pr=uint8, mode_machine=uint8, motor_cmd=array[_motor_command(HG, uint32), 35],
    reserve=array[uint32, 4], crc=uint32,
)  # fmt: skip
