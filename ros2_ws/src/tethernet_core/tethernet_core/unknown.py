"""Numbers of a tethernet_msgs/CaptureAssessment that may not be known: a flag in the message, NaN in a program.

No message carries NaN, so that whatever is not finite on the wire is a fault; in a program NaN is how a number says
that it is none. Without ROS: also for messages that are read from a bag.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeVar

Assessment = TypeVar("Assessment")
"""A tethernet_msgs/CaptureAssessment, as rclpy or a reader of bags makes it."""

FIELDS = {
    "hull_valid": ("cqi", "hull_volume", "hull_area"),
    "cqi_all_valid": ("cqi_all",),
    "distance_valid": ("mouth_area", "net_debris_distance"),
    "prediction_valid": ("predicted_cqi", "predicted_locked_pairs", "predicted_capture_probability"),
    "cqi_error_valid": ("cqi_error",),
    "locked_pairs_error_valid": ("locked_pairs_error",),
}
"""Fields of the message that are known when a flag says so, by that flag."""


def fill(message: object, numbers: Mapping[str, float]) -> None:
    """Write numbers into a message, each with its flag; those that are not known become 0.

    Args:
        message: tethernet_msgs/CaptureAssessment.
        numbers: every field of :data:`FIELDS`, NaN where it is not known.
    """
    for flag, names in FIELDS.items():
        values = [float(numbers[name]) for name in names]
        known = all(map(math.isfinite, values))
        setattr(message, flag, known)
        for name, value in zip(names, values, strict=True):
            setattr(message, name, value if known else 0.0)


def restore(message: Assessment) -> Assessment:
    """The message itself, with NaN in the fields that are not known; one without flags, from an old bag, as it is."""
    for flag, names in FIELDS.items():
        if not getattr(message, flag, True):
            for name in names:
                setattr(message, name, math.nan)
    return message
