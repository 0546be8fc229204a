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
    "mcqi_valid": ("mcqi",),
    "load_share_valid": ("max_load_share",),
    "contact_force_valid": ("max_contact_force",),
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
    """The message itself, with NaN in the fields that are not known; in one from an old bag fields stay as they are
    that had no flag, and are NaN that there were none of.
    """
    for flag, names in FIELDS.items():
        for name in names:
            if not (getattr(message, flag, True) and hasattr(message, name)):
                setattr(message, name, math.nan)
    return message


def answer(message: object, name: str) -> bool | None:
    """A yes or no of the message that may not be known: None where its flag says so, or an old bag has no such.

    Args:
        message: tethernet_msgs/CaptureAssessment.
        name: of the field: enclosed or held.
    """
    return bool(getattr(message, name)) if getattr(message, f"{name}_valid", False) else None
