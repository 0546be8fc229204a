"""Which times a recorded message gets.

rosbag2 logs the wall-clock time at which a message arrived. In lock-step that is noise: a mission of 40 s is flown in
5 s, and twice never alike. Here the publish time is the stamp in the message, and so is the log time, by which
readers order and players play: the same seed gives the same times in the bag, played back it takes as long as the
mission took, and messages of one control tick carry one time.

A message whose stamp cannot be on the mission's clock (none, 0 for not set, or far from the rest: a driver that stamps
with the wall clock) is logged at the mission's newest time, or it would stretch the bag over decades and stop every
player. Its publish time stays what its publisher said, if anything. The mission's time is that of /clock, and where no
simulator runs, that of the odometry.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tethernet_core.step_guard import StepGuard

if TYPE_CHECKING:
    from tethernet_bringup.bags.message_definitions import InstalledType

FARTHEST_NS = 60_000_000_000
"""A stamp farther than this from the mission's time is on another clock [ns]; nodes of a mission are never a minute
apart."""

_AGREEING = 40
"""Stamps off the mission's time that must agree in succession before it is another one: five of each of 8 MUs."""

_STAMP = struct.Struct("<iI")
_LENGTH = struct.Struct("<I")
_ENCAPSULATION_BYTES = 4
_SECOND_NS = 1_000_000_000


@dataclass(frozen=True)
class StampReader:
    """Finds the stamp in a serialized message (CDR, little-endian: all that ROS 2 runs on)."""

    offset: int | None
    """Where it is [B]; None for types without."""
    in_array: bool = False
    """Whether it is in the first element of an array, which may be empty."""

    @classmethod
    def of(cls, kind: InstalledType) -> StampReader:
        """The reader for a message type."""
        return cls(kind.stamp_offset, kind.stamp_in_array)

    def __call__(self, data: bytes) -> int | None:
        """The stamp [ns], None where there is none: no field, not set (0), or before the clock's zero."""
        offset = self.offset
        if offset is None or len(data) < offset + 8:
            return None
        if self.in_array and not _LENGTH.unpack_from(data, _ENCAPSULATION_BYTES)[0]:
            return None
        seconds, nanoseconds = _STAMP.unpack_from(data, offset)
        stamp = seconds * _SECOND_NS + nanoseconds
        return stamp if stamp and seconds >= 0 else None


class Timeline:
    """Keeps the mission's time and gives each message its log time."""

    def __init__(self) -> None:
        self.now: int | None = None
        """The mission's newest time [ns]; None before anything told it."""
        self._has_clock = False
        self._guard = StepGuard(FARTHEST_NS, _AGREEING)

    def tell(self, stamp: int | None, *, clock: bool) -> None:
        """Take a stamp of a topic that tells the mission's time.

        Args:
            stamp: [ns].
            clock: whether it is /clock, which then overrules the odometry.
        """
        if stamp is None:
            return
        if clock and not self._has_clock:
            self._has_clock = True
            self._guard = StepGuard(FARTHEST_NS, _AGREEING)
        if clock or not self._has_clock:
            self._guard.take(stamp)
            self.now = self._guard.newest

    def log_time(self, stamp: int | None) -> int | None:
        """When a message is logged [ns]; None while the mission has no time yet.

        Args:
            stamp: of the message [ns], if it has one.
        """
        now = self.now
        if now is None or stamp is None or not -FARTHEST_NS <= stamp - now <= FARTHEST_NS:
            return now
        return stamp
