# Written by `make stubs` from the .msg files; see typings/README.md.
from typing import Any, ClassVar

from geometry_msgs.msg import TransformStamped

class TFMessage:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    transforms: list[TransformStamped]
    def __init__(
        self,
        *,
        transforms: list[TransformStamped] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
