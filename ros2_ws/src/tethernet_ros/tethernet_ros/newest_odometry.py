"""The newest odometry of one body."""

from __future__ import annotations

from tethernet_core.settings import ControlParameters
from tethernet_core.step_guard import StampGuard
from tethernet_ros.conversions import Vector
from tethernet_ros.serialized import OdometrySample
from tethernet_ros.well_formed import MessageError


class NewestOdometry:
    """Keeps the newest sample; those whose stamps cannot follow on it are refused."""

    def __init__(self, control: ControlParameters, position: Vector | None = None):
        """Args:
        control: says which stamps can be.
        position: where the body is before anything is heard [m], if that is known.
        """
        self.sample: OdometrySample | None = None
        """The newest; None before any."""
        self._position = position
        self._clock = StampGuard(control)

    @property
    def stamp_ns(self) -> int:
        """Of the newest sample [ns]; -1 before any."""
        return -1 if self.sample is None else self.sample.stamp_ns

    @property
    def position(self) -> Vector | None:
        """[m]."""
        return self._position if self.sample is None else self.sample.position

    @property
    def velocity(self) -> Vector:
        """[m/s], frame launch; zero before any."""
        return (0.0, 0.0, 0.0) if self.sample is None else self.sample.velocity

    def take(self, sample: OdometrySample) -> bool:
        """Take one sample.

        Returns:
            True when it is newer, or its clock was set anew; false when it is latched and told again.

        Raises:
            MessageError: when its stamp cannot follow on the newest's.
        """
        if not self._clock.take(sample.stamp_ns).good:
            if sample.stamp_ns == self.stamp_ns:
                return False
            raise MessageError(self._clock.why(sample.stamp_ns))
        self.sample = sample
        return True
