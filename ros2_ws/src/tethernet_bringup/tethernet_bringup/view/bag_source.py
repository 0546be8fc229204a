"""Snapshots of a recorded mission, tick by tick. Messages are decoded by the definitions in the bag, without ROS 2."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from tethernet_bringup.analysis.decoder import Decoder
from tethernet_bringup.bags.reader import BagReader
from tethernet_bringup.view.observer import CHASER, DEBRIS, Observer
from tethernet_bringup.view.snapshot import Snapshot
from tethernet_core.system import System
from tethernet_core.unknown import restore
from tethernet_ros import topics

if TYPE_CHECKING:
    from nav_msgs.msg import Odometry

    from tethernet_msgs.msg import NetState

_SECOND_NS = 1_000_000_000
MOST_HZ = 20.0
"""Pictures for a second of the mission: every tick of the shipped control period."""

Taker = Callable[[Any, int], None]


class BagSource:
    """A bag as a sequence of snapshots."""

    def __init__(self, bag: BagReader, system: System):
        """Args:
        bag: whole or torn.
        system: that was flown.
        """
        self._bag = bag
        self._decode = Decoder()
        self._observer = observer = Observer(system)
        self._takers: dict[str, Taker] = {
            topics.NET_STATE: self._net,
            topics.DEBRIS_ODOMETRY: lambda message, stamp: observer.body(DEBRIS, stamp, *_pose(message)),
            topics.CHASER_ODOMETRY: lambda message, stamp: observer.body(CHASER, stamp, *_pose(message)),
            topics.MISSION_STATE: lambda message, _: observer.state(message),
            topics.CAPTURE_ASSESSMENT: lambda message, _: observer.assessment(restore(message)),
        }
        self._moving = {topics.NET_STATE, topics.DEBRIS_ODOMETRY, topics.CHASER_ODOMETRY}
        """Topics of which a newer stamp tells that a tick is over."""
        for mu in range(1, system.unit_count + 1):
            self._add_unit(mu)
        self.unused = 0
        """Messages of the mission's topics that could not be used: damaged, or of another system."""

    def snapshots(self) -> Iterator[Snapshot]:
        """Go through the bag once.

        Yields:
            The mission as it was before each next tick, and at its end.

        Raises:
            BagError: when the bag cannot be read.
        """
        observer, shown_ns, period_ns = self._observer, 0, round(_SECOND_NS / MOST_HZ)
        for message in self._bag.messages(self._takers.__contains__):
            try:
                decoded = self._decode(self._bag.topics[message.topic].message_type, message.data)
                # A message without a stamp was sent before its node knew the time.
                stamp = _nanoseconds(decoded) or message.log_time
                if message.topic in self._moving and stamp > observer.newest_ns >= shown_ns + period_ns:
                    # Before the launch all is at time 0: the last of it is enough.
                    shown_ns = observer.newest_ns
                    if observer.launched:
                        yield observer.snapshot()
                self._takers[message.topic](decoded, stamp)
            except (ValueError, AttributeError):
                self.unused += 1
        if observer.newest_ns:
            yield observer.snapshot()

    def _add_unit(self, mu: int) -> None:
        observer = self._observer
        self._moving.add(topics.mu_odometry(mu))
        self._takers |= {
            topics.mu_odometry(mu): lambda m, stamp: observer.unit(mu, stamp, _xyz(m.pose.pose.position)),
            topics.mu_thrust(mu): lambda m, _: observer.thrust(mu, _xyz(m.wrench.force)),
            topics.mu_status(mu): lambda m, _: observer.status(mu, m),
        }

    def _net(self, message: NetState, stamp: int) -> None:
        knots, units = (
            np.asarray(values, np.float32).reshape(-1, 3) for values in (message.knot_positions, message.mu_positions)
        )
        self._observer.net(stamp, _xyz(message.center_of_mass), knots, units, message.locked)


def _pose(message: Odometry) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
    turn = message.pose.pose.orientation
    return _xyz(message.pose.pose.position), (turn.x, turn.y, turn.z, turn.w)


def _xyz(point: Any) -> tuple[float, float, float]:
    return point.x, point.y, point.z


def _nanoseconds(message: Any) -> int:
    return int(message.header.stamp.sec) * _SECOND_NS + int(message.header.stamp.nanosec)
