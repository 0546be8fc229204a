"""The newest odometry of one body."""

from __future__ import annotations

from collections.abc import Callable

from tethernet_control.settings import ControlParameters
from tethernet_control.step_guard import StampGuard

from .conversions import MessageError, Vector, finite
from .serialized_odometry import serialized_odometry_values


class NewestOdometry:
    """Keeps the newest sample; what is older, not finite or makes no sense is dropped and told."""

    def __init__(
        self,
        name: str,
        control: ControlParameters,
        drop: Callable[[str, str], None],
        position: Vector | None = None,
    ):
        """Args:
        name: of the odometry, for what is told.
        control: says which stamps can be.
        drop: told (name, why) of every sample that is dropped.
        position: where the body is before anything is heard [m], if that is known.
        """
        self.stamp_ns = -1
        """Of the newest sample, finite or not [ns]; -1 before any."""
        self.position = position
        """[m], of the newest finite sample."""
        self.velocity: Vector = (0.0, 0.0, 0.0)
        """[m/s], frame launch, likewise."""
        self.data: bytes | None = None
        """The whole serialized nav_msgs/Odometry, likewise."""
        self._name, self._drop = name, drop
        self._clock = StampGuard(control)

    def take(self, data: bytes) -> bool:
        """Take one serialized nav_msgs/Odometry.

        Returns:
            True when its stamp is newer, or its clock was set anew: time has gone on, even where the numbers are not
            finite and the last good ones stand.
        """
        try:
            stamp_ns, position, velocity = serialized_odometry_values(data)
        except MessageError as error:
            self._drop(self._name, str(error))
            return False
        if not self._clock.take(stamp_ns).good:
            if stamp_ns != self.stamp_ns:  # else it is latched and told again
                self._drop(self._name, self._clock.why(stamp_ns))
            return False
        self.stamp_ns = stamp_ns
        if finite(*position, *velocity):
            self.position, self.velocity, self.data = position, velocity, data
        else:
            self._drop(self._name, "not finite; the last good one stands")
        return True
