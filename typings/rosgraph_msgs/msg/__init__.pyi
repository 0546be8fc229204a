# Written by `make stubs` from the .msg files; see typings/README.md.
from typing import Any, ClassVar

from builtin_interfaces.msg import Time

class Clock:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    clock: Time
    def __init__(
        self,
        *,
        clock: Time = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
