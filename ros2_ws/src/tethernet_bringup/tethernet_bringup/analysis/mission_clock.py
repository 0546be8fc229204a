"""Which time of the mission each message of a bag belongs to, whatever its recorder took for the time of recording.

Our recorder logs a message at its stamp; rosbag2 logs the wall clock at its arrival, or the simulated time as it knew
it then. So the time of a message is its stamp, wherever that is on the mission's clock. For a message without a stamp,
with none set, or with one of another clock, it is the newest time of the mission that had been recorded before it.

Assumptions and limitations: the mission's clock is that of /clock; where that is not recorded, the one that most
messages are stamped by, times that are less than a minute apart being on one clock. What two messages were recorded
after another is told by their log times.
"""

from __future__ import annotations

from array import array
from bisect import bisect_right

import numpy as np
import numpy.typing as npt

from tethernet_bringup.analysis.decoder import Decoder
from tethernet_bringup.bags.reader import BagReader
from tethernet_bringup.recorder.timeline import FARTHEST_NS
from tethernet_ros import topics


class MissionClock:
    """Tells the mission's time of messages.

    Args:
        log_times_ns: of the messages that tell the time, shape (n,) [ns].
        stamps_ns: of the same, shape (n,) [ns]; some may be on other clocks.
    """

    def __init__(self, log_times_ns: npt.ArrayLike, stamps_ns: npt.ArrayLike):
        log_times, stamps = np.asarray(log_times_ns, np.int64), np.asarray(stamps_ns, np.int64)
        on_it = _largest_cluster(stamps)
        log_times, stamps = log_times[on_it], stamps[on_it]
        order = np.lexsort((stamps, log_times))
        self._log_times: list[int] = log_times[order].tolist()
        self._newest: list[int] = np.maximum.accumulate(stamps[order]).tolist()
        self._first = int(stamps.min(initial=np.iinfo(np.int64).max)) - FARTHEST_NS
        self._last = int(stamps.max(initial=np.iinfo(np.int64).min)) + FARTHEST_NS

    def time_ns(self, stamp_ns: int | None, log_time_ns: int) -> int:
        """The mission's time of a message [ns].

        Args:
            stamp_ns: as its publisher set it; None where there is none, 0 where none was set.
            log_time_ns: when it was recorded, by whatever clock; taken as it is where nothing tells the mission's time.
        """
        if stamp_ns and self._first <= stamp_ns <= self._last:
            return stamp_ns
        if not self._log_times:
            return log_time_ns
        return self._newest[max(bisect_right(self._log_times, log_time_ns) - 1, 0)]


def mission_clock(bag: BagReader, decode: Decoder) -> MissionClock:
    """The clock of the mission in a bag, which is read once for it, or twice where /clock was not recorded.

    Raises:
        BagError: when it cannot be read.
    """
    log_times, stamps = _stamped(bag, decode, topics.CLOCK)
    if not stamps:
        log_times, stamps = _stamped(bag, decode, None)
    return MissionClock(log_times, stamps)


def _stamped(bag: BagReader, decode: Decoder, topic: str | None) -> tuple[array[int], array[int]]:
    """Log times and stamps of all messages that have one, or of one topic's."""
    log_times, stamps = array("q"), array("q")
    for message in bag.messages(lambda name: topic in (None, name)):
        stamp = decode.stamp_ns(bag.topics[message.topic].message_type, message.data)
        if stamp:
            log_times.append(message.log_time)
            stamps.append(stamp)
    return log_times, stamps


def _largest_cluster(stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Which times belong to the largest group without a gap of more than a minute, shape (n,)."""
    if not len(stamps):
        return np.zeros(0, bool)
    ordered = np.sort(stamps)
    begins = np.concatenate([[0], np.flatnonzero(np.diff(ordered) > FARTHEST_NS) + 1])
    ends = np.append(begins[1:], len(ordered))
    largest = int(np.argmax(ends - begins))
    return (stamps >= ordered[begins[largest]]) & (stamps <= ordered[ends[largest] - 1])
