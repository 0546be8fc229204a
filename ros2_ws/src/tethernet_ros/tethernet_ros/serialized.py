"""Messages read from their serialized bytes: what comes in is bytes until it has been looked at.

The three that arrive at every control tick are read without building the message in Python: a nav_msgs/Odometry takes
80 microseconds, a third of all that a controller does for one sample, because of two covariance matrices that it does
not look at. The layout of the bytes is fixed by the message's definition and by CDR, the encoding that DDS prescribes.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple, TypeVar

from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Header

from tethernet_core import rotation
from tethernet_core.bounds import FARTHEST_M, FASTEST_M_S, FASTEST_RAD_S
from tethernet_core.rotation import Quaternion
from tethernet_ros.conversions import Vector
from tethernet_ros.topics import FRAME
from tethernet_ros.well_formed import Message, MessageError, check_stamp

Kind = TypeVar("Kind", bound=Message)

_IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)
_LITTLE_ENDIAN_CDR = b"\x00\x01"
_ORIGIN = 4  # [bytes] the encapsulation header; alignment counts from behind it
_HEAD = struct.Struct("<iII")  # stamp, length of frame_id with its NUL
_LENGTH = struct.Struct("<I")
_POSE = struct.Struct("<7d")
_TWIST = struct.Struct("<6d")
_FORCE = struct.Struct("<3d")
_TWIST_OFFSET = 8 * (7 + 36)  # [bytes] pose and its covariance
_ODOMETRY_NUMBERS = 8 * (7 + 36 + 6 + 36)  # [bytes] pose, twist, and their covariances
_WRENCH_NUMBERS = 8 * 6  # [bytes]


class OdometrySample(NamedTuple):
    """What an odometry message says."""

    stamp_ns: int
    """[ns]."""
    position: Vector
    """[m], frame launch."""
    velocity: Vector
    """[m/s], frame launch: nav_msgs has it in the child's frame, here it is turned."""
    attitude: Quaternion
    """Unit quaternion x y z w, child to launch."""
    linear: Vector
    """The velocity as the message has it, in the child's frame [m/s]."""
    angular: Vector
    """Angular rate in the child's frame [rad/s]."""


class ThrustCommand(NamedTuple):
    """What a thrust command says."""

    stamp_ns: int
    """Of the odometry it answers [ns]."""
    force: Vector
    """[N], frame launch."""


def decoded(data: bytes, kind: type[Kind]) -> Kind:
    """A message from its bytes.

    Raises:
        MessageError: when the bytes are no such message: cut short, or of another type.
    """
    try:
        message: Kind = deserialize_message(data, kind)
    except Exception as error:  # the middleware's own class, which is private, or MemoryError for a forged length
        raise MessageError(f"{len(data)} bytes that are no {kind.__name__}") from error
    return message


def odometry_sample(data: bytes, child: str | None = None) -> OdometrySample:
    """What a serialized nav_msgs/Odometry says.

    Args:
        data: the message.
        child: the frame of the body that it must be of; None for any.

    Raises:
        MessageError: for another frame or body, a stamp that is no time, numbers that are not finite or beyond all
            measure, a quaternion that is no attitude, or bytes that are no odometry.
    """
    data = _native(data, Odometry)
    try:
        stamp_ns, offset = _head(data, Odometry)
        begin, length = offset + _LENGTH.size, _LENGTH.unpack_from(data, offset)[0]
        offset = _aligned(begin + length, 8)
        x, y, z, qx, qy, qz, qw = _POSE.unpack_from(data, offset)
        vx, vy, vz, wx, wy, wz = _TWIST.unpack_from(data, offset + _TWIST_OFFSET)
        complete = len(data) >= offset + _ODOMETRY_NUMBERS
    except struct.error:
        complete = False
    if not complete:
        raise _cut_short(data, Odometry)
    if child is not None and data[begin : begin + length - 1] != child.encode():
        other = data[begin : begin + length - 1].decode(errors="replace")
        raise MessageError(f"Odometry of child frame {other[:40]!r}; allowed: {child!r}")
    position, linear, angular, attitude = (x, y, z), (vx, vy, vz), (wx, wy, wz), (qx, qy, qz, qw)
    check_bounds(position, FARTHEST_M, "position", "m")
    check_bounds(linear, FASTEST_M_S, "velocity", "m/s")
    check_bounds(angular, FASTEST_RAD_S, "angular rate", "rad/s")
    velocity = linear
    if attitude != _IDENTITY:  # the usual case costs one comparison and keeps the bits
        try:
            velocity = rotation.turned(rotation.unit(attitude), linear)
        except ValueError as error:
            raise MessageError(str(error)) from error
    return OdometrySample(stamp_ns, position, velocity, attitude, linear, angular)


def thrust_command(data: bytes) -> ThrustCommand:
    """What a serialized geometry_msgs/WrenchStamped commands; its torque is not looked at.

    Raises:
        MessageError: for another frame, a stamp that is no time, numbers that are not finite, or other bytes.
    """
    data = _native(data, WrenchStamped)
    try:
        stamp_ns, offset = _head(data, WrenchStamped)
        offset = _aligned(offset, 8)
        force = _FORCE.unpack_from(data, offset)
        complete = len(data) >= offset + _WRENCH_NUMBERS
    except struct.error:
        complete = False
    if not complete:
        raise _cut_short(data, WrenchStamped)
    if not math.isfinite(force[0] * 0.0 + force[1] * 0.0 + force[2] * 0.0):
        raise MessageError(f"force ({_numbers(force)}) N; allowed: finite numbers")
    return ThrustCommand(stamp_ns, force)


def header_stamp(data: bytes) -> int:
    """The stamp of a serialized std_msgs/Header [ns].

    Raises:
        MessageError: for another frame, a stamp that is no time, or other bytes.
    """
    data = _native(data, Header)
    try:
        return _head(data, Header)[0]
    except struct.error:
        raise _cut_short(data, Header) from None


def check_bounds(values: Vector, limit: float, name: str, unit: str) -> None:
    """Check that all numbers are within ``-limit`` to ``limit``.

    Raises:
        MessageError: when one is not, or is NaN; names them.
    """
    x, y, z = values
    if not (-limit <= x <= limit and -limit <= y <= limit and -limit <= z <= limit):  # also catches NaN
        raise MessageError(f"{name} ({_numbers(values)}) {unit}; allowed: finite, within {limit:g} {unit}")


def _native(data: bytes, kind: type[Message]) -> bytes:
    """The same message as this machine writes it."""
    return data if data[:2] == _LITTLE_ENDIAN_CDR else serialize_message(decoded(data, kind))


def _head(data: bytes, kind: type[Message]) -> tuple[int, int]:
    """Stamp [ns] of the header that the message begins with, checked, and where the next field of 4 bytes would be."""
    seconds, nanoseconds, length = _HEAD.unpack_from(data, _ORIGIN)
    stamp_ns = check_stamp(seconds, nanoseconds)
    begin = _ORIGIN + _HEAD.size
    frame = data[begin : begin + length - 1] if 0 < length <= len(data) else b""
    if frame != _FRAME:
        check_frame(frame.decode(errors="replace"), kind)
    return stamp_ns, _aligned(begin + length, 4)


_FRAME = FRAME.encode()


def check_frame(frame: str, kind: type) -> None:
    """Check that a message is in frame launch.

    Raises:
        MessageError: when it is in another.
    """
    if frame != FRAME:
        raise MessageError(f"{kind.__name__} in frame {frame[:40]!r}; allowed: {FRAME!r}")


def _cut_short(data: bytes, kind: type) -> MessageError:
    return MessageError(f"{len(data)} bytes that are no {kind.__name__}")


def _aligned(offset: int, size: int) -> int:
    return offset + (_ORIGIN - offset) % size


def _numbers(values: Vector) -> str:
    return ", ".join(f"{value:g}" for value in values)
