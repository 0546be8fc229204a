# Written by `make stubs` from the .msg files; see typings/README.md.
from typing import Any, ClassVar

from geometry_msgs.msg import PoseWithCovariance, TwistWithCovariance
from std_msgs.msg import Header

class Odometry:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance
    def __init__(
        self,
        *,
        header: Header = ...,
        child_frame_id: str = ...,
        pose: PoseWithCovariance = ...,
        twist: TwistWithCovariance = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
