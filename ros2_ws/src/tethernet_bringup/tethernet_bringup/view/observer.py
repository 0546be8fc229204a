"""Puts together what a mission looks like, from what its nodes say, over ROS or in a bag.

It takes plain numbers and, for messages of many fields, whatever has these fields: rclpy's messages and those that a
reader of bags makes. Nothing here knows ROS.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tethernet_bringup.recorder.timeline import Timeline
from tethernet_bringup.view.snapshot import UNKNOWN, Event, Pose, Snapshot
from tethernet_core.mission import Phase
from tethernet_core.shown import shown
from tethernet_core.system import System

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time
    from geometry_msgs.msg import Point

    from tethernet_msgs.msg import CaptureAssessment, MissionState, MuStatus

DEBRIS, CHASER = "debris", "chaser"
_SECOND_NS = 1_000_000_000
_STAGE_FINAL, _STAGE_HELD = 2, 3
_BAD_PHASES = (Phase.MISSED, Phase.ABORTED)


class Observer:
    """What is known of a mission by now."""

    def __init__(self, system: System):
        """Args:
        system: that is flown.
        """
        self.system = system
        """That is flown."""
        units = system.unit_count
        self._measured, self._thrusts, self._aiming = (np.full((units, 3), UNKNOWN) for _ in range(3))
        self._true: np.ndarray | None = None
        self._errors, self._fuel = np.full(units, UNKNOWN), np.full(units, UNKNOWN)
        self._knots: np.ndarray | None = None
        self._center: np.ndarray | None = None
        self._locked: np.ndarray | None = None
        self._bodies: dict[str, Pose] = {}
        self._planned: np.ndarray | None = None
        self._closing = np.zeros((0, 3))
        self._distance = self._cqi = self._pairs = UNKNOWN
        self._phase: Phase | None = None
        self._launch_ns = 0
        self._held_asked = False
        self._told: set[int] = set()
        self._events: list[Event] = []
        self._timeline = Timeline()

    @property
    def newest_ns(self) -> int:
        """Time of what is shown [ns]: the net's newest stamp, or that of any odometry where nothing measures the net; 0
        before the first. One stamp that is far off moves it as little as it moves the time of a recording.
        """
        return self._timeline.now or 0

    @property
    def launched(self) -> bool:
        """Whether the launch has been heard of: times before it are 0."""
        return self._launch_ns > 0

    @property
    def news(self) -> bool:
        """Whether something has happened since the last snapshot that is told in words."""
        return bool(self._events)

    @property
    def ended(self) -> bool:
        """Whether all has been told that will be: the mission is over, and judged if it came to that."""
        if self._phase is None or not self._phase.over:
            return False
        last = _STAGE_HELD if self._held_asked and self._phase == Phase.COMPLETE else _STAGE_FINAL
        return self._phase == Phase.ABORTED or last in self._told

    def net(
        self, stamp_ns: int, center: npt.ArrayLike, knots: np.ndarray, units: np.ndarray, locked: npt.ArrayLike
    ) -> None:
        """The net was measured.

        Args:
            stamp_ns: when [ns].
            center: centre of mass of its nodes [m], shape (3,).
            knots: positions of the nodes [m], shape (N, 3).
            units: of the units, where whatever measures the net sees them [m], shape (M, 3).
            locked: which closing pairs hold, shape (R,).

        Raises:
            ValueError: where it is another system's net.
        """
        net = self.system.net
        if knots.shape != (net.node_count, 3) or units.shape != self._measured.shape:
            raise ValueError(f"{len(knots)} nodes and {len(units)} units; allowed: those of {self.system.name}")
        if np.shape(locked) != (self.system.closing.max_locked_pairs,):
            raise ValueError(f"{np.size(locked)} closing pairs; allowed: those of {self.system.name}")
        self._center, self._knots, self._true = np.asarray(center, float), knots, units
        self._locked = np.asarray(locked, bool)
        self._timeline.tell(stamp_ns or None, clock=True)

    def unit(self, mu: int, stamp_ns: int, position: npt.ArrayLike) -> None:
        """The odometry of unit ``mu``, from 1: its position [m] at a time [ns]."""
        self._measured[mu - 1] = position
        self._timeline.tell(stamp_ns or None, clock=False)

    def body(self, name: str, stamp_ns: int, position: npt.ArrayLike, attitude: npt.ArrayLike) -> None:
        """The odometry of debris or chaser: position [m] and quaternion x y z w at a time [ns]."""
        self._bodies[name] = Pose(np.asarray(position, float), np.asarray(attitude, float))
        self._timeline.tell(stamp_ns or None, clock=False)

    def thrust(self, mu: int, force: npt.ArrayLike) -> None:
        """The force that unit ``mu`` is commanded [N]."""
        self._thrusts[mu - 1] = force

    def status(self, mu: int, message: MuStatus) -> None:
        """The account of the controller of unit ``mu``."""
        if message.aiming_source:
            self._aiming[mu - 1] = _xyz(message.aiming_point)
        self._errors[mu - 1], self._fuel[mu - 1] = message.tracking_error, message.fuel

    def assessment(self, message: CaptureAssessment) -> None:
        """What the assessor measured; numbers that are not known are NaN, see :mod:`tethernet_core.unknown`."""
        self._cqi, self._pairs = message.cqi, float(message.locked_pairs)
        self._distance = message.net_debris_distance
        if message.stage in (_STAGE_FINAL, _STAGE_HELD) and message.stage not in self._told:
            self._told.add(message.stage)
            held = message.stage == _STAGE_HELD
            good = message.held if held else message.captured
            self._tell(_nanoseconds(message.header.stamp), message.hold_verdict if held else message.verdict, not good)

    def state(self, message: MissionState) -> None:
        """The mission's state, at every change.

        Raises:
            ValueError: for a phase that there is not, or the state of another system's mission.
        """
        phase = Phase(message.phase)
        if message.mu_count != self.system.unit_count:
            raise ValueError(f"{message.mu_count} units; allowed: those of {self.system.name}")
        self._launch_ns = _nanoseconds(message.launch_time) or self._launch_ns
        self._held_asked = message.hold_duration > 0.0
        place = np.array(_xyz(message.debris_position))
        if place.any():
            self._planned = place
        points = np.array([_xyz(point) for point in message.closing_points]).reshape(-1, 3)
        self._closing = np.unique(points, axis=0)
        if phase != self._phase:
            self._phase = phase
            began = {Phase.DEPLOYING: message.launch_time, Phase.CLOSING: message.closing_time}
            time_ns = _nanoseconds(began.get(phase, message.header.stamp))
            reason = f": {message.reason}" if message.reason else ""
            self._tell(time_ns, f"{phase.name}{reason}", phase in _BAD_PHASES)

    def snapshot(self) -> Snapshot:
        """What the mission looks like now, and what has happened since the last call."""
        events, self._events = tuple(self._events), []
        units = self._measured if self._true is None else self._true
        debris = self._bodies.get(DEBRIS)
        distance = self._distance
        if self._center is not None and debris is not None:
            distance = math.dist(self._center, debris.position)
        aims = self._phase in (None, Phase.WAITING, Phase.ARMED, Phase.DEPLOYING)
        return Snapshot(
            time_ns=self._since_launch(self.newest_ns),
            units=np.array(units, float),
            thrusts=self._thrusts.copy(),
            aiming_points=self._aiming.copy() if aims else np.zeros((0, 3)),
            tracking_errors=self._errors.copy(),
            fuel=self._fuel.copy(),
            closing_points=self._closing,
            knots=self._knots,
            locked=self._locked,
            debris=debris,
            chaser=self._bodies.get(CHASER),
            planned_debris=self._planned,
            distance=distance,
            cqi=self._cqi,
            locked_pairs=self._pairs if self._locked is None else float(np.count_nonzero(self._locked)),
            events=events,
        )

    def _tell(self, time_ns: int, text: str, warning: bool) -> None:
        self._events.append(Event(self._since_launch(time_ns), shown(text), warning))

    def _since_launch(self, time_ns: int) -> int:
        return max(0, time_ns - self._launch_ns) if self.launched else 0


def _xyz(point: Point | Any) -> tuple[float, float, float]:
    return point.x, point.y, point.z


def _nanoseconds(stamp: Time | Any) -> int:
    return int(stamp.sec) * _SECOND_NS + int(stamp.nanosec)
