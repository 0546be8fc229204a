"""What a mission's recording holds: every topic of the design, with its type and how it is published."""

from __future__ import annotations

import re
from dataclasses import dataclass

from tethernet_bringup.bags.errors import BagError
from tethernet_bringup.bags.message_definitions import installed_type
from tethernet_core.parameters import ParameterError
from tethernet_core.shown import SHORT, shown
from tethernet_ros import topics

_EVERY_TICK_DEPTH = 100
_STATE_DEPTH = 10
_LONGEST_NAME = 200
"""[characters]; the middleware takes a few more."""


@dataclass(frozen=True)
class RecordedTopic:
    """One topic to record."""

    name: str
    type_name: str
    """Such as nav_msgs/msg/Odometry."""
    latched: bool = False
    """Whether its publishers keep samples for late joiners."""
    depth: int = _EVERY_TICK_DEPTH
    """How many samples its publishers keep."""
    tells_time: bool = False
    """Whether its stamps are the mission's time, see :mod:`tethernet_bringup.recorder.timeline`."""
    shared: bool = False
    """Whether several nodes may publish on it; then their counters mix and say nothing about lost messages."""


def mission_topics(mu_count: int) -> list[RecordedTopic]:
    """All topics of a mission.

    Args:
        mu_count: number of units; each has three topics of its own.
    """
    result = [
        RecordedTopic(topics.CLOCK, "rosgraph_msgs/msg/Clock", tells_time=True),
        RecordedTopic(topics.MISSION_STATE, "tethernet_msgs/msg/MissionState", latched=True),
        RecordedTopic(topics.PLANNER_HEARTBEAT, "std_msgs/msg/Header"),
        RecordedTopic(topics.DEBRIS_ODOMETRY, "nav_msgs/msg/Odometry", latched=True, tells_time=True),
        RecordedTopic(topics.CHASER_ODOMETRY, "nav_msgs/msg/Odometry", latched=True),
        RecordedTopic(topics.NET_STATE, "tethernet_msgs/msg/NetState"),
        RecordedTopic(topics.NET_MARKERS, "visualization_msgs/msg/MarkerArray"),
        RecordedTopic(topics.NET_POINTS, "sensor_msgs/msg/PointCloud2"),
        RecordedTopic(topics.TF, "tf2_msgs/msg/TFMessage", shared=True),
        RecordedTopic(topics.DIAGNOSTICS, "diagnostic_msgs/msg/DiagnosticArray", shared=True),
        RecordedTopic(topics.SIM_STATUS, "tethernet_msgs/msg/SimStatus", latched=True, depth=_STATE_DEPTH),
        RecordedTopic(topics.CAPTURE_ASSESSMENT, "tethernet_msgs/msg/CaptureAssessment", latched=True),
    ]
    for mu in range(1, mu_count + 1):
        result += (
            RecordedTopic(topics.mu_odometry(mu), "nav_msgs/msg/Odometry", tells_time=True),
            RecordedTopic(topics.mu_thrust(mu), "geometry_msgs/msg/WrenchStamped"),
            RecordedTopic(topics.mu_status(mu), "tethernet_msgs/msg/MuStatus", latched=True, depth=_STATE_DEPTH),
        )
    return result


def wanted_topics(mu_count: int, extra: str) -> list[RecordedTopic]:
    """All topics to record; every type is installed.

    Args:
        mu_count: number of units.
        extra: see :func:`extra_topics`.

    Raises:
        ParameterError: naming the topic that cannot be recorded, and why.
    """
    topics_ = mission_topics(mu_count) + extra_topics(extra)
    known: set[str] = set()
    for topic in topics_:
        if topic.name in known:
            raise ParameterError(f"extra_topics: {topic.name} is recorded already")
        known.add(topic.name)
        try:
            installed_type(topic.type_name)
        except BagError as error:
            raise ParameterError(f"cannot record {topic.name}: {error}") from error
    return topics_


def extra_topics(text: str) -> list[RecordedTopic]:
    """Topics that a user wants recorded as well.

    Args:
        text: "NAME TYPE" or "NAME TYPE latched", several with commas between them; may be empty.

    Raises:
        ParameterError: naming the entry that cannot be meant.
    """
    result = []
    for entry in filter(None, (part.strip() for part in text.split(","))):
        words = entry.split()
        if len(words) not in {2, 3} or not _is_topic(*words[:2]) or words[2:] not in ([], ["latched"]):
            raise ParameterError(
                f"extra_topics: {shown(repr(entry), SHORT)} cannot be read; allowed: '/NAME PACKAGE/msg/TYPE' or "
                "'/NAME PACKAGE/msg/TYPE latched', several with commas between them"
            )
        result.append(RecordedTopic(words[0], words[1], latched=len(words) == 3, shared=True))
    return result


def _is_topic(name: str, type_name: str) -> bool:
    """Whether these can be a topic's name and type, to ROS 2."""
    return (
        len(name) <= _LONGEST_NAME
        and re.fullmatch(r"(/[A-Za-z_][A-Za-z0-9_]*)+", name) is not None
        and re.fullmatch(r"[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*", type_name) is not None
    )
