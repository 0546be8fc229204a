"""What a mission's recording holds: every topic of the design, with its type and how it is published."""

from __future__ import annotations

from dataclasses import dataclass

from tethernet_control.layout import design
from tethernet_control.parameters import ParameterError
from tethernet_control.ros import topics

_EVERY_TICK_DEPTH = 100
_STATE_DEPTH = 10


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
    """Whether its stamps are the mission's time, see :mod:`tethernet_bringup.timeline`."""
    shared: bool = False
    """Whether several nodes may publish on it; then their counters mix and say nothing about lost messages."""


def mission_topics(mu_count: int) -> list[RecordedTopic]:
    """All topics of a mission.

    Args:
        mu_count: 4 or 8.

    Raises:
        ValueError: for an unknown design.
    """
    result = [
        RecordedTopic(topics.CLOCK, "rosgraph_msgs/msg/Clock", tells_time=True),
        RecordedTopic(topics.MISSION_STATE, "tethernet_msgs/msg/MissionState", latched=True, depth=_STATE_DEPTH),
        RecordedTopic(topics.PLANNER_HEARTBEAT, "std_msgs/msg/Header"),
        RecordedTopic(topics.DEBRIS_ODOMETRY, "nav_msgs/msg/Odometry", latched=True, tells_time=True),
        RecordedTopic(topics.CHASER_ODOMETRY, "nav_msgs/msg/Odometry", latched=True),
        RecordedTopic(topics.NET_STATE, "tethernet_msgs/msg/NetState"),
        RecordedTopic(topics.NET_MARKERS, "visualization_msgs/msg/MarkerArray"),
        RecordedTopic(topics.TF, "tf2_msgs/msg/TFMessage", shared=True),
        RecordedTopic(topics.DIAGNOSTICS, "diagnostic_msgs/msg/DiagnosticArray", shared=True),
        RecordedTopic(topics.SIM_STATUS, "tethernet_msgs/msg/SimStatus", latched=True, depth=_STATE_DEPTH),
        RecordedTopic(
            topics.CAPTURE_ASSESSMENT, "tethernet_msgs/msg/CaptureAssessment", latched=True, depth=_STATE_DEPTH
        ),
    ]
    for mu in range(1, design(mu_count).mu_count + 1):
        result += (
            RecordedTopic(topics.mu_odometry(mu), "nav_msgs/msg/Odometry", tells_time=True),
            RecordedTopic(topics.mu_thrust(mu), "geometry_msgs/msg/WrenchStamped"),
            RecordedTopic(topics.mu_status(mu), "tethernet_msgs/msg/MuStatus", latched=True, depth=_STATE_DEPTH),
        )
    return result


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
        if len(words) not in {2, 3} or not words[0].startswith("/") or words[2:] not in ([], ["latched"]):
            raise ParameterError(
                f"extra_topics: {entry!r} cannot be read; allowed: '/NAME PACKAGE/msg/TYPE' or "
                "'/NAME PACKAGE/msg/TYPE latched', several with commas between them"
            )
        result.append(RecordedTopic(words[0], words[1], latched=len(words) == 3, shared=True))
    return result
